#include "peers.h"

#ifdef ELASTIN_BENCH_BULLET
#include <BulletSoftBody/btSoftBody.h>

#include <memory>
#include <vector>

#include "measure.h"

namespace bench {

using namespace elastin;

std::string bullet_missing() { return ""; }

std::function<double(int)> make_bullet(const Start& start) {
  struct Soft {
    btSoftBodyWorldInfo world;
    std::unique_ptr<btSoftBody> body;
  };
  const auto soft = std::make_shared<Soft>();
  soft->world.m_gravity.setValue(0, 0, 0);
  std::vector<btVector3> positions;
  std::vector<float> masses;
  for (int i = 0; i < start.body.size(); ++i) {
    const Eigen::Vector3f position = start.positions.col(i).cast<float>();
    positions.emplace_back(position.x(), position.y(), position.z());
    masses.push_back(static_cast<float>(start.body.mass[i]));
  }
  soft->body = std::make_unique<btSoftBody>(&soft->world, start.body.size(), positions.data(), masses.data());
  for (std::size_t c = 0; c < start.body.connections.ends.size(); ++c) {
    const auto& [a, b] = start.body.connections.ends[c];
    soft->body->appendLink(a, b);
    soft->body->m_links[static_cast<int>(c)].m_rl = static_cast<float>(start.body.connections.rest_length[c]);
  }
  soft->body->m_cfg.piterations = 1;
  soft->body->updateLinkConstants();
  return [soft, dt = static_cast<float>(start.dt)](int steps) {
    return seconds_of([&] {
      for (int step = 0; step < steps; ++step) {
        soft->body->predictMotion(dt);
        soft->body->solveConstraints();
        soft->body->integrateMotion();
      }
    });
  };
}

}  // namespace bench

#else

namespace bench {

std::string bullet_missing() { return "skipped: built without it; apt-get install libbullet-dev and build again"; }
std::function<double(int)> make_bullet(const Start&) { return {}; }

}  // namespace bench
#endif
