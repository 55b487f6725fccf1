#include "core/solve/modes.h"

#include <Eigen/QR>
#include <catch2/catch.hpp>
#include <random>

#include "support/bodies.h"

using namespace elastin;
using namespace elastin::testing;

namespace {

/// The oracle: free directions minus the rank of the dense matrix of lengthenings, and of the rigid motions alone.
struct Dense {
  int null_space = 0, rigid = 0;
};
Dense count_densely(const Body& body, const std::vector<Support>& supports) {
  const int n = body.size();
  std::vector<Eigen::RowVectorXd> rows;
  for (const auto& [a, b] : body.connections.ends) {
    Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(3 * n);
    const Vector3 u = (body.rest.col(b) - body.rest.col(a)).normalized();
    row.segment<3>(3 * a) = -u.transpose();
    row.segment<3>(3 * b) = u.transpose();
    rows.push_back(row);
  }
  const std::size_t springs = rows.size();
  for (const Support& support : supports)
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(3 * n);
      row.segment<3>(3 * support.molecule) = (Matrix3::Identity() - support.free).row(axis);
      rows.push_back(row);
    }
  Eigen::MatrixXd matrix(static_cast<Eigen::Index>(rows.size()), 3 * n);
  for (std::size_t i = 0; i < rows.size(); ++i) matrix.row(static_cast<Eigen::Index>(i)) = rows[i];
  const auto rank = [](const Eigen::MatrixXd& m) {
    if (m.rows() == 0) return 0;
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(m);
    return static_cast<int>(qr.setThreshold(1e-7).rank());
  };
  Eigen::MatrixXd rigid(3 * n, 6);
  for (int i = 0; i < n; ++i) {
    const Vector3 x = body.rest.col(i);
    rigid.block<3, 3>(3 * i, 0).setIdentity();
    for (int axis = 0; axis < 3; ++axis) rigid.block<3, 1>(3 * i, 3 + axis) = Vector3::Unit(axis).cross(x);
  }
  const Eigen::MatrixXd held = matrix.bottomRows(static_cast<Eigen::Index>(rows.size() - springs));
  return {3 * n - rank(matrix), rank(rigid) - rank(held * rigid)};
}

std::vector<Support> fix_layer(const Body& body, const Matrix3& free) {
  std::vector<Support> supports;
  const double low = body.rest.row(2).minCoeff();
  for (int i = 0; i < body.size(); ++i)
    if (body.rest(2, i) <= low + 1e-9) supports.push_back({i, free, Vector3::Zero()});
  return supports;
}

}  // namespace

TEST_CASE("zero-energy modes equal those of a dense rank count", "[modes][slow]") {
  const Matrix3 held = Matrix3::Zero();
  const Matrix3 sliding = Matrix3::Identity() - Vector3::UnitZ() * Vector3::UnitZ().transpose();
  std::vector<Body> bodies{cubic_lattice({3, 3, 3}, 1, {true, false, false}),
                           cubic_lattice({3, 3, 3}, 1, {true, true, false}),
                           cubic_lattice({4, 3, 2}, 1, {false, true, false}),
                           cubic_lattice({3, 3, 3}, 1, {true, false, true}),
                           cubic_lattice({3, 3, 3}, 1, {false, false, true}),
                           body_centred_lattice({2, 2, 2}, 1, false),
                           face_centred_lattice({2, 2, 2}, 1, false),
                           tetrahedral_block(BlockKind::alternating, {2, 2, 2}, {1, 1, 1}),
                           cubic_lattice({1, 1, 2}, 1, {}),
                           cubic_lattice({1, 1, 5}, 1, {}),
                           cubic_lattice({3, 1, 3}, 1, {true, true, false}),
                           listed_body({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {3, 3, 3}}, {{0, 1}, {1, 2}})};
  // Random graphs: a packing with ever fewer of its connections.
  for (const int keep : {10, 6, 5, 4}) {
    Body body = random_packing({3, 3, 3}, 0.9, 1.4, 5);
    std::mt19937 generator(9);
    std::erase_if(body.connections.ends, [&](const auto&) { return static_cast<int>(generator() % 10) >= keep; });
    body.connections.rest_length.resize(body.connections.ends.size());
    bodies.push_back(body);
  }
  const Matrix3 turn = Eigen::AngleAxisd(0.7, Vector3(1, -2, 0.5).normalized()).toRotationMatrix();
  for (std::size_t i = 0; i < bodies.size(); ++i)
    for (const int support : {0, 1, 2})
      for (const bool turned : {false, true}) {
        Body body = bodies[i];
        std::vector<Support> supports =
            support == 0 ? std::vector<Support>{} : fix_layer(body, support == 1 ? held : sliding);
        if (turned) {
          rotate(body, turn);
          for (Support& s : supports) s.free = turn * s.free * turn.transpose();
        }
        INFO("body " << i << ", support " << support << ", turned " << turned);
        const Dense wanted = count_densely(body, supports);
        const ModeReport report = find_zero_energy_modes(body, supports);
        CHECK(report.counted);
        CHECK(report.rigid_motions == wanted.rigid);
        CHECK(report.zero_energy_modes == wanted.null_space - wanted.rigid);
        int listed = 0;
        for (const auto& mode : report.modes) listed += mode.count;
        CHECK(listed == report.zero_energy_modes);
      }
}

TEST_CASE("of a flat body the modes out of its plane are those that nothing in the plane holds", "[modes]") {
  for (const bool diagonals : {false, true})
    for (const double angle : {0., 0.7}) {
      INFO("diagonals " << diagonals << ", angle " << angle);
      Body body = cubic_lattice({4, 1, 3}, 1, {true, diagonals, false});
      std::vector<Support> supports = fix_layer(body, Matrix3::Zero());
      const Matrix3 turn = Eigen::AngleAxisd(angle, Vector3(1, -2, 0.5).normalized()).toRotationMatrix();
      rotate(body, turn);
      const ModeReport report = find_zero_energy_modes(body, supports);
      // Eight free molecules, and a rotation about the fixed ones; without diagonals two rows slide.
      CHECK(report.rigid_motions == 1);
      CHECK(report.out_of_plane == 7);
      CHECK(report.zero_energy_modes == (diagonals ? 7 : 9));
      CHECK(std::abs(plane_normal(body).dot(turn.col(1))) == Approx(1));
    }
  // As a file in single precision has it, far from the origin.
  Body sheet = cubic_lattice({4, 1, 3}, 1, {true, true, false});
  const std::vector<Support> supports = fix_layer(sheet, Matrix3::Zero());
  rotate(sheet, Eigen::AngleAxisd(0.7, Vector3(1, -2, 0.5).normalized()).toRotationMatrix());
  sheet.rest = (sheet.rest.colwise() + Vector3(7, 11, 13)).cast<float>().cast<double>().eval();
  const ModeReport single = find_zero_energy_modes(sheet, supports);
  CHECK(single.out_of_plane == single.zero_energy_modes);
  CHECK_FALSE(plane_normal(sheet).isZero(0));
  const ModeReport solid = find_zero_energy_modes(cubic_lattice({3, 3, 3}, 1, {true, false, false}), {});
  CHECK(solid.zero_energy_modes > 0);
  CHECK(solid.out_of_plane == 0);
  CHECK(plane_normal(cubic_lattice({1, 1, 5}, 1, {})).isZero(0));  // on a line
}

TEST_CASE("the cubic axis lattice of the paper's Fig. 5: twelve lines of molecules slide", "[modes]") {
  const Body body = cubic_lattice({3, 3, 3}, 0.0075, {true, false, false});
  const ModeReport report = find_zero_energy_modes(body, fix_layer(body, Matrix3::Zero()));
  CHECK(report.zero_energy_modes == 12);
  REQUIRE(report.modes.size() == 12);
  CHECK(report.modes[0].molecules.size() == 3);
  CHECK_THAT(report.modes[0].text, Catch::Contains("slide together along x"));
}

TEST_CASE("springs of constant zero leave what they held", "[modes]") {
  const Body body = cubic_lattice({3, 3, 3}, 1, {true, true, false});
  const auto supports = fix_layer(body, Matrix3::Zero());
  CHECK(find_zero_energy_modes(body, supports).zero_energy_modes == 0);
  std::vector<char> stiff(static_cast<std::size_t>(body.connections.size()), 1);
  for (int c = 0; c < body.connections.size(); ++c) stiff[c] = body.connections.rest_length[c] < 1.1;
  CHECK(find_zero_energy_modes(body, supports, stiff).zero_energy_modes == 12);
}

TEST_CASE("large lattices are settled without a factorisation", "[modes]") {
  const Body body = cubic_lattice({22, 22, 22}, 1, {true, true, false});
  const Matrix3 sliding = Matrix3::Identity() - Vector3::UnitZ() * Vector3::UnitZ().transpose();
  const ModeReport report = find_zero_energy_modes(body, fix_layer(body, sliding));
  CHECK(report.counted);
  CHECK(report.rigid_motions == 3);
  CHECK(report.zero_energy_modes == 0);
}

TEST_CASE("each inner molecule of a straight chain has its two motions across, of any length", "[modes]") {
  // What the chain does not hold: 3 n free directions, n − 1 connections, 5 motions of the whole (none about its line).
  for (const int n : {3, 40001}) {
    std::vector<Vector3> positions;
    std::vector<std::array<int, 2>> pairs;
    for (int i = 0; i < n; ++i) positions.emplace_back(0, 0, i);
    for (int i = 0; i + 1 < n; ++i) pairs.push_back({i, i + 1});
    const ModeReport report = find_zero_energy_modes(listed_body(positions, pairs), {});
    CHECK(report.counted);
    CHECK(report.rigid_motions == 5);
    CHECK(report.zero_energy_modes == 3 * n - (n - 1) - 5);
    CHECK(report.modes.back().molecules.size() == 1);
  }
}
