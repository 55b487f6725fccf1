"""An engine of `elastin compare`: a soft body of Bullet, made by the body.cpp in the request's folder and compiled with the
program below. apt-get install libbullet-dev pkg-config g++ python3"""

import json
import pathlib
import subprocess
import sys

PROGRAM = r"""
#include "body.cpp"
#include <chrono>
#include <cstdio>
#include <cstdlib>

static const struct { int molecule; double x, y, z; } forces[] = {FORCES{-1, 0, 0, 0}};

int main(int, char** words) {
  const btScalar dt = btScalar(std::atof(words[1]));
  const int iterations = std::atoi(words[2]), most_steps = std::atoi(words[3]);
  const double tolerance = std::atof(words[4]);
  btSoftBodyWorldInfo world;
  world.m_gravity.setValue(0, 0, 0);
  world.air_density = 0;
  btSoftBody& body = *make_body(world, dt, iterations);
  body.m_cfg.collisions = 0;
  const int count = body.m_nodes.size();
  double largest = 0;
  for (int i = 0; i < count; ++i)
    for (int axis = 0; axis < 3; ++axis) largest = btMax(largest, std::fabs(double(body.m_nodes[i].m_x[axis])));
  btAlignedObjectArray<btVector3> rest, before;
  for (int i = 0; i < count; ++i) rest.push_back(body.m_nodes[i].m_x), before.push_back(body.m_nodes[i].m_x);
  const auto start = std::chrono::steady_clock::now();
  int steps = 0;
  double energy = 0;
  for (int quiet = 0; steps < most_steps && quiet < 3 && energy >= 0;) {
    for (int i = 0; i < 50; ++i, ++steps) {
      for (const auto* load = forces; load->molecule >= 0; ++load)
        body.addForce(btVector3(btScalar(load->x), btScalar(load->y), btScalar(load->z)), load->molecule);
      body.predictMotion(dt);
      body.solveConstraints();
      body.integrateMotion();
      // Kinetic damping: all that moves is stopped where the kinetic energy has passed a largest value.
      double now = 0;
      for (int p = 0; p < count; ++p)
        if (body.m_nodes[p].m_im > 0) now += body.m_nodes[p].m_v.length2() / body.m_nodes[p].m_im;
      for (int p = 0; p < count && now < energy; ++p) body.m_nodes[p].m_v.setZero();
      energy = now >= energy ? now : now < energy ? 0 : -1;  // not a number: it has become unstable
    }
    double moved = 0, far = 0;
    for (int p = 0; p < count; ++p)
      for (int axis = 0; axis < 3; ++axis) {
        moved = btMax(moved, std::fabs(double(body.m_nodes[p].m_x[axis] - before[p][axis])));
        far = btMax(far, std::fabs(double(body.m_nodes[p].m_x[axis] - rest[p][axis])));
      }
    quiet = moved <= btMax(tolerance * far, largest / (1 << 21)) ? quiet + 1 : 0;  // of single precision
    for (int p = 0; p < count; ++p) before[p] = body.m_nodes[p].m_x;
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("{\"engine\": \"Bullet %d.%02d\", \"iterations\": %d, \"steps\": %d, \"at_rest\": %s, \"seconds_per_step\": %g, "
              "\"cause\": \"%s\", \"positions\": [", btGetVersion() / 100, btGetVersion() % 100, iterations, steps,
              steps < most_steps && energy >= 0 ? "true" : "false", seconds / steps,
              energy >= 0 ? "" : "it became unstable: take smaller time steps");
  for (int p = 0; p < count; ++p) {
    const btVector3& x = body.m_nodes[p].m_x;
    const bool known = std::isfinite(x.length2());
    std::printf("%s[%.9g, %.9g, %.9g]", p ? ", " : "", known ? x.x() : 0., known ? x.y() : 0., known ? x.z() : 0.);
  }
  std::printf("]}\n");
}
"""


def unable(error):
    print(json.dumps({"error": error}))
    sys.exit()


request = json.loads(sys.stdin.readline())
body, folder = request["body"], pathlib.Path(request["folder"])
if not all(all(support["fixed"]) for support in body["supports"]):
    unable("Bullet holds molecules in all directions or in none: write fixed_grip: clamped")
if any(any(support["displacement"]) for support in body["supports"]):
    unable("Bullet gives no reactions: load the body by a force, not by a displacement")
forces = "".join("{%d, %r, %r, %r}, " % (one["molecule"], *one["force"]) for one in body["forces"])
(folder / "program.cpp").write_text(PROGRAM.replace("FORCES", forces))
flags = subprocess.check_output(["pkg-config", "--cflags", "--libs", "bullet"], text=True).split()
subprocess.run(["c++", "-O2", "-w", "program.cpp", "-o", "program", *flags], cwd=folder, check=True)
words = request["dt"], request["iterations"] or 1, request["most_steps"], request["tolerance"]  # its own number is 1
subprocess.run([folder / "program", *map(str, words)], check=True)
