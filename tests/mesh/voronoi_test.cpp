#include "elastin/mesh/voronoi.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/laws/springs/voronoi.h"
#include "hull/delaunay.h"
#include "support/bodies.h"

using namespace elastin;
using namespace elastin::hull;
using namespace elastin::mesh;
using namespace elastin::testing;

namespace {

const Matrix3 kTurn = Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();

/// Σ A L over the connections.
double face_times_length(const Body& body, const VoronoiCells& cells) {
  return cells.face_area.dot(Eigen::Map<const VectorX>(body.connections.rest_length.data(), cells.face_area.size()));
}

}  // namespace

TEST_CASE("Voronoi cells of a cubic lattice: faces h2 along the axes, a half and a quarter at the surface",
          "[voronoi]") {
  constexpr double h = 0.01;
  Body body = cubic_lattice({4, 3, 5}, h, {true, true, true});
  const Positions grid = body.rest / h;
  const bool turned = GENERATE(false, true);
  if (turned) rotate(body, kTurn);
  const VoronoiCells cells = voronoi_cells(body);
  const auto on_walls = [&](const Vector3& position) -> Eigen::Array3i {
    const Eigen::Array3d high(3, 2, 4);
    return (position.array() < 0.1 || position.array() > high - 0.1).cast<int>();
  };
  for (int c = 0; c < body.connections.size(); ++c) {
    const auto [a, b] = body.connections.ends[c];
    const Vector3 gap = grid.col(b) - grid.col(a);
    // A wall halves the face where it holds both molecules.
    const double walls = (on_walls(grid.col(a)) * on_walls(grid.col(b)) * (gap.array().abs() < 0.5).cast<int>()).sum();
    const double expected = gap.squaredNorm() < 1.5 ? h * h / std::pow(2, walls) : 0;
    REQUIRE(cells.face_area[c] == Approx(expected).margin(1e-9 * h * h));
  }
  const double volume = 3 * 2 * 4 * h * h * h;
  CHECK(cells.volume.sum() == Approx(volume).epsilon(1e-10));
  CHECK(face_times_length(body, cells) == Approx(3 * volume).epsilon(1e-10));
  CHECK(lost_share(body, cells) == Approx(0).margin(1e-10));
  // Σ x A = V I [m³]: the walls balance.
  CHECK((body.rest * cells.surface_area.transpose() / volume - Matrix3::Identity()).norm() < 1e-10);
}

TEST_CASE("inside a body-centred lattice the cells are truncated octahedra", "[voronoi]") {
  // Side of the cube a: 8 hexagons of area 3√3/16 a² to the nearest, 6 squares of a²/8 to the second neighbours; a³/2.
  constexpr double a = 2;
  const Body body = body_centred_lattice({3, 3, 3}, a, true);
  const VoronoiCells cells = voronoi_cells(body);
  int inside = 0;
  for (int c = 0; c < body.connections.size(); ++c) {
    const auto [first, second] = body.connections.ends[c];
    const auto deep = [&](int m) { return ((body.rest.col(m).array() - 3).abs() < 1.9).all(); };
    if (!deep(first) || !deep(second)) continue;
    ++inside;
    const bool nearest = body.connections.rest_length[c] < 0.9 * a;
    REQUIRE(cells.face_area[c] == Approx(nearest ? 3 * std::sqrt(3.) / 16 * a * a : a * a / 8).epsilon(1e-10));
    REQUIRE(cells.volume[first] == Approx(a * a * a / 2).epsilon(1e-10));
  }
  CHECK(inside > 0);
}

TEST_CASE("cells of a packing fill its hull: Σ A L + 3 × what hangs on the walls = 3 V", "[voronoi]") {
  Body body = random_packing({1, 1, 1}, 0.2, 0.3, GENERATE(1, 2));
  body.connections = connections_within(body.rest, 0.8);  // so that all neighbours are joined
  const VoronoiCells cells = voronoi_cells(body);
  double hull = 0;
  for (const auto& cell : delaunay_tetrahedra(body.rest)) hull += signed_volume(body.rest, cell);
  CHECK(cells.volume.sum() == Approx(hull).epsilon(1e-10));
  CHECK(cells.volume.minCoeff() > 0);
  CHECK(cells.surface_area.rowwise().sum().norm() < 1e-10);
  // A cell is made of pyramids over its faces: those over the walls hold x · A of their plane less x · A here.
  const double walls = 3 * hull - body.rest.cwiseProduct(cells.surface_area).sum();
  CHECK(face_times_length(body, cells) + walls == Approx(3 * hull).epsilon(1e-10));
}

TEST_CASE("the voronoi rule has the affine modulus E less what it lost, and is invariant", "[voronoi]") {
  Body body = random_packing({1, 1, 1}, 0.2, 0.3, 1);
  const Material material{.youngs_modulus = 5000, .poissons_ratio = 0.3, .density = 1000, .thickness = 0};
  CHECK(!Voronoi::unsuited(body).empty());
  body.voronoi = voronoi_cells(body);
  const VectorX k = Voronoi{}.constants(body, material);
  const Eigen::Map<const VectorX> length(body.connections.rest_length.data(), body.connections.size());
  const double affine = k.dot(length.cwiseAbs2()) / (6 * body.voronoi->volume.sum());
  CHECK(affine == Approx(5000 * (1 - lost_share(body, *body.voronoi))).epsilon(1e-10));
  CHECK(lost_share(body, *body.voronoi) < 0.03);

  Body other = body;
  rotate(other, kTurn);
  stretch(other, Vector3::Constant(1e-3));
  other.voronoi = voronoi_cells(other);
  CHECK((Voronoi{}.constants(other, material) - 1e-3 * k).norm() < 1e-9 * 1e-3 * k.norm());
}

TEST_CASE("bodies without Voronoi cells say why", "[voronoi]") {
  CHECK(voronoi_cells(sheet(0.001)).problem == "needs a solid body, not a membrane");
  CHECK(voronoi_cells(cubic_lattice({3, 3, 1}, 1, {})).problem == "needs molecules that do not lie in one plane");
  Body bent = tetrahedral_block(BlockKind::kuhn, {2, 2, 2}, {1, 1, 1});
  bent.tetrahedra.resize(24);  // half of the block: a step
  CHECK(voronoi_cells(bent).problem == "needs a convex body");
}
