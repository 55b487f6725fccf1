#include "core/solve/modes.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <utility>
#include <vector>

#include "core/base/dense.h"
#include "core/base/disjoint_sets.h"
#include "core/linear/sparse_factor.h"
#include "core/model/incidence.h"
#include "core/model/neighbours.h"
#include "elastin/core/model/parts.h"

namespace elastin {
namespace {

constexpr double kFlat = 1e-6;      ///< of the size: places in single precision are so far from a plane
constexpr double kParallel = 1e-7;  ///< sine below which a direction counts as contained in a subspace

/// Directions of one molecule that are known not to move, as an orthonormal basis.
struct Fixed {
  Matrix3 basis = Matrix3::Zero();
  int count = 0;
  /// Takes a direction in if it is a new one.
  bool add(Vector3 direction) {
    const double size = direction.norm();
    if (count == 3 || size == 0) return false;
    for (int pass = 0; pass < 2; ++pass)
      for (int i = 0; i < count; ++i) direction -= basis.col(i).dot(direction) * basis.col(i);
    if (!(direction.norm() > kParallel * size)) return false;
    basis.col(count++) = direction.normalized();
    return true;
  }
  bool contains(const Vector3& direction) const {
    Vector3 rest = direction;
    for (int i = 0; i < count; ++i) rest -= basis.col(i).dot(direction) * basis.col(i);
    return rest.norm() <= kParallel * direction.norm();
  }
};

/// Motion of a point under each of the six rigid motions about `centre`, lengths measured in `size`.
Eigen::Matrix<double, 3, 6> rigid_rows(const Vector3& position, const Vector3& centre, double size) {
  const Vector3 arm = (position - centre) / size;
  Eigen::Matrix<double, 3, 6> rows;
  rows.leftCols<3>().setIdentity();
  rows.rightCols<3>() << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0;
  return rows;
}

std::vector<Fixed> fixed_by(const std::vector<Support>& supports, Eigen::Index molecules) {
  std::vector<Fixed> fixed(static_cast<std::size_t>(molecules));
  for (const Support& support : supports) {
    const Matrix3 held = Matrix3::Identity() - support.free;
    for (int axis = 0; axis < 3; ++axis)
      if (held.col(axis).norm() > 1e-6) fixed[support.molecule].add(held.col(axis));
  }
  return fixed;
}

/// The motions as a whole of molecules at their rest, about their centre.
struct RigidSpace {
  Vector3 centre;
  double size;
  MatrixX motions;  ///< as columns, of rigid_rows: those that what is fixed leaves free

  RigidSpace(const Positions& rest, const std::vector<Fixed>& fixed)
      : centre(rest.rowwise().mean()), size(std::max((rest.colwise() - centre).colwise().norm().maxCoeff(), 1e-300)) {
    // Rotations about the line of a body on a line move nothing: they are no motion at all.
    Eigen::Matrix<double, 6, 6> held = Eigen::Matrix<double, 6, 6>::Zero(), all = held;
    for (Eigen::Index m = 0; m < rest.cols(); ++m) {
      const auto rows = rigid_rows(rest.col(m), centre, size);
      all += rows.transpose() * rows / static_cast<double>(rest.cols());
      const MatrixX own = fixed[m].basis.leftCols(fixed[m].count).transpose() * rows;
      held += own.transpose() * own;
    }
    const auto null_space = [](const MatrixX& matrix, double scale) -> MatrixX {
      const SymmetricEigen eigen = symmetric_eigen(matrix);
      const int zeros = static_cast<int>((eigen.values.array() < 1e-12 * scale).count());
      return eigen.vectors.leftCols(zeros);
    };
    const MatrixX still = null_space(all, 1);
    motions = null_space(held + product(still, still.transpose()), std::max(1., held.trace()));
  }
};

class Search {
 public:
  Search(const Body& body, const std::vector<Support>& supports, const std::vector<char>& stiff)
      : body_(body), fixed_(fixed_by(supports, body.size())), free_basis_(body.size()) {
    for (int c = 0; c < body.connections.size(); ++c)
      if ((stiff.empty() || stiff[c]) && direction(c).norm() > 0) links_.ends.push_back(body.connections.ends[c]);
    incident_ = connections_of_molecules(body.size(), links_);
  }

  ModeReport run() {
    ModeReport report;
    report.rigid_motions = pin_rigid_motions();
    spread();
    count_the_rest(report);
    return report;
  }

 private:
  Vector3 direction(int c) const {
    const auto& [a, b] = body_.connections.ends[c];
    return body_.rest.col(b) - body_.rest.col(a);
  }
  Vector3 link(int c) const { return body_.rest.col(links_.ends[c][1]) - body_.rest.col(links_.ends[c][0]); }

  /// Holds the rigid motions that the supports leave, at as few molecules as can: the first, one joined to it, one
  /// joined to both. Each pin takes exactly one rigid motion, so the count of other modes stays as it is.
  int pin_rigid_motions() {
    if (body_.size() == 0) return 0;
    auto [centre, size, motions] = RigidSpace(body_.rest, fixed_);
    const int rigid = static_cast<int>(motions.cols());
    for (const int m : pin_order()) {
      if (motions.cols() == 0) break;
      const MatrixX moves = product(rigid_rows(body_.rest.col(m), centre, size), motions);
      const SymmetricEigen squares = symmetric_eigen(transposed_product(moves, moves));
      const Eigen::Index still_free = (squares.values.array() <= 1e-10).count();
      for (Eigen::Index i = moves.cols(); i-- > still_free;) fixed_[m].add(moves * squares.vectors.col(i));
      motions = product(motions, squares.vectors.leftCols(still_free));
    }
    return rigid;
  }

  /// A molecule, then its neighbours (so that a triangle of connections carries the pins on), then everyone else.
  std::vector<int> pin_order() const {
    int first = 0;  // one that is fixed already, if any: it carries furthest
    for (int m = 0; m < body_.size(); ++m)
      if (fixed_[m].count > fixed_[first].count) first = m;
    std::vector<int> order{first};
    std::vector<char> seen(body_.size(), 0);
    seen[first] = 1;
    const auto append = [&](int m) {
      if (!seen[m]) seen[m] = 1, order.push_back(m);
    };
    for (const int c : incident_[first]) {
      const int second = other_end(c, first);
      append(second);
      // Two that are both joined to the first and to each other stand next to one another in the order.
      for (const int d : incident_[second]) {
        const int third = other_end(d, second);
        if (third != first && joined(third, first)) append(third);
      }
    }
    for (int m = 0; m < body_.size(); ++m) append(m);
    return order;
  }

  int other_end(int c, int molecule) const {
    return links_.ends[c][0] == molecule ? links_.ends[c][1] : links_.ends[c][0];
  }
  bool joined(int a, int b) const {
    return std::any_of(incident_[a].begin(), incident_[a].end(), [&](int c) { return other_end(c, a) == b; });
  }

  /// A connection whose one end is known not to move along it fixes the other end along it too.
  void spread() {
    std::deque<int> queue;
    std::vector<char> waiting(body_.size(), 1);
    for (int m = 0; m < body_.size(); ++m) queue.push_back(m);
    while (!queue.empty()) {
      const int m = queue.front();
      queue.pop_front();
      waiting[m] = 0;
      for (const int c : incident_[m]) {
        const int other = other_end(c, m);
        if (fixed_[other].count < 3 && fixed_[m].contains(link(c)) && fixed_[other].add(link(c)) && !waiting[other]) {
          waiting[other] = 1;
          queue.push_back(other);
        }
      }
    }
  }

  /// The free directions of a molecule: along its connections as far as can be, so that groups fall apart.
  void choose_free_basis(int m) {
    Fixed all = fixed_[m];
    for (const int c : incident_[m]) all.add(link(c));
    for (int axis = 0; axis < 3; ++axis) all.add(Vector3::Unit(axis));
    free_basis_[m] = all.basis.rightCols(3 - fixed_[m].count);
  }

  void count_the_rest(ModeReport& report) {
    const int n = body_.size();
    std::vector<int> first_unknown(n + 1, 0);
    for (int m = 0; m < n; ++m) {
      choose_free_basis(m);
      first_unknown[m + 1] = first_unknown[m] + static_cast<int>(free_basis_[m].cols());
    }
    const int unknowns = first_unknown[n];
    if (unknowns == 0) return;
    // One row for each connection: its lengthening by each unknown. Unknowns that share a row belong to one group.
    DisjointSets sets(static_cast<std::size_t>(unknowns));
    std::vector<std::vector<std::pair<int, double>>> rows;
    for (int c = 0; c < links_.size(); ++c) {
      std::vector<std::pair<int, double>> row;
      for (const int side : {0, 1}) {
        const int m = links_.ends[c][side];
        const VectorX part = (side ? 1 : -1) * free_basis_[m].transpose() * link(c).normalized();
        for (int i = 0; i < part.size(); ++i)
          if (std::abs(part[i]) > kParallel) row.push_back({first_unknown[m] + i, part[i]});
      }
      for (std::size_t i = 1; i < row.size(); ++i) sets.join(row[i].first, row[0].first);
      if (!row.empty()) rows.push_back(std::move(row));
    }
    std::map<int, std::pair<std::vector<int>, std::vector<int>>> groups;  // set → unknowns, rows
    for (int u = 0; u < unknowns; ++u) groups[sets.set_of(u)].first.push_back(u);
    for (std::size_t r = 0; r < rows.size(); ++r)
      groups[sets.set_of(rows[r][0].first)].second.push_back(static_cast<int>(r));
    std::vector<int> molecule_of(unknowns);
    for (int m = 0; m < n; ++m)
      for (int u = first_unknown[m]; u < first_unknown[m + 1]; ++u) molecule_of[u] = m;
    for (const auto& [_, group] : groups)
      settle_group(group.first, group.second, rows, molecule_of, first_unknown, report);
  }

  void settle_group(const std::vector<int>& unknowns, const std::vector<int>& row_numbers,
                    const std::vector<std::vector<std::pair<int, double>>>& rows, const std::vector<int>& molecule_of,
                    const std::vector<int>& first_unknown, ModeReport& report) const {
    const int size = static_cast<int>(unknowns.size());
    std::map<int, int> local;
    for (int i = 0; i < size; ++i) local[unknowns[i]] = i;
    constexpr int dense_limit = 400, sparse_limit = 12000;
    ZeroEnergyMode mode;
    if (size <= dense_limit) {
      MatrixX gram = MatrixX::Zero(size, size);
      for (const int r : row_numbers)
        for (const auto& [u, x] : rows[r])
          for (const auto& [v, y] : rows[r]) gram(local[u], local[v]) += x * y;
      const SymmetricEigen eigen = symmetric_eigen(gram);
      const double threshold = 1e-9 * std::max(eigen.values[size - 1], 1e-9);
      mode.count = static_cast<int>((eigen.values.array() <= threshold).count());
      if (mode.count == 0) return;
      // Of the group's own molecules alone: a long chain has as many groups as molecules.
      std::vector<int> own;
      for (const int u : unknowns)
        if (own.empty() || own.back() != molecule_of[u]) own.push_back(molecule_of[u]);
      const auto count = static_cast<Eigen::Index>(own.size());
      Positions motion;
      VectorX reach = VectorX::Zero(count);  // how far a molecule goes in all the group's modes together
      for (int k = 0; k < mode.count; ++k) {
        Positions one = Positions::Zero(3, count);
        Eigen::Index column = 0;
        for (int i = 0; i < size; ++i) {
          const int m = molecule_of[unknowns[i]];
          if (own[column] != m) ++column;
          one.col(column) += eigen.vectors(i, k) * free_basis_[m].col(unknowns[i] - first_unknown[m]);
        }
        if (k == 0) motion = one;
        reach += one.colwise().squaredNorm().transpose();
      }
      std::vector<Eigen::Index> moving;
      for (Eigen::Index column = 0; column < count; ++column)
        if (reach[column] > 1e-12) {
          mode.molecules.push_back(own[column]);
          moving.push_back(column);
        }
      mode.direction = common_direction(motion(Eigen::all, moving), mode);
    } else {
      if (size > sparse_limit) {
        report.counted = false;
        return;
      }
      std::vector<Eigen::Triplet<double>> entries;
      for (const int r : row_numbers)
        for (const auto& [u, x] : rows[r])
          for (const auto& [v, y] : rows[r]) entries.emplace_back(local[u], local[v], x * y);
      for (int i = 0; i < size; ++i)
        entries.emplace_back(i, i, -1e-9);  // Sylvester: negative pivots = modes below this
      Eigen::SparseMatrix<double> gram(size, size);
      gram.setFromTriplets(entries.begin(), entries.end());
      const SparseFactor factor(gram);
      mode.count = factor.negative_pivots();
      if (mode.count == 0) return;
      for (const int u : unknowns)
        if (mode.molecules.empty() || mode.molecules.back() != molecule_of[u]) mode.molecules.push_back(molecule_of[u]);
    }
    mode.text = describe(mode);
    report.zero_energy_modes += mode.count;
    report.modes.push_back(std::move(mode));
  }

  /// The direction in which all molecules of a single mode move alike, or zero; `motion` has a column for each.
  static Vector3 common_direction(const Positions& motion, const ZeroEnergyMode& mode) {
    if (mode.count != 1) return Vector3::Zero();
    const Vector3 first = motion.col(0);
    for (Eigen::Index m = 0; m < motion.cols(); ++m)
      if ((motion.col(m) - first).norm() > 1e-6 * first.norm()) return Vector3::Zero();
    const Vector3 unit = first.normalized();
    int largest = 0;
    unit.cwiseAbs().maxCoeff(&largest);
    return unit[largest] < 0 ? Vector3(-unit) : unit;
  }

  static std::string describe(const ZeroEnergyMode& mode) {
    std::string text = mode.molecules.size() == 1 ? "molecule " : "molecules ";
    constexpr std::size_t shown = 8;
    for (std::size_t i = 0; i < std::min(shown, mode.molecules.size()); ++i)
      text += (i ? ", " : "") + std::to_string(mode.molecules[i]);
    if (mode.molecules.size() > shown) text += " and " + std::to_string(mode.molecules.size() - shown) + " more";
    if (mode.direction == Vector3::Zero())
      return text +
             (mode.count > 1 ? ": " + std::to_string(mode.count) + " independent motions" : ": one joint motion");
    text += mode.molecules.size() == 1 ? " moves along " : " slide together along ";
    for (int axis = 0; axis < 3; ++axis)
      if (mode.direction[axis] > 1 - 1e-9) return text + "xyz"[axis];
    char buffer[64];
    std::snprintf(buffer, sizeof buffer, "(%.3f, %.3f, %.3f)", mode.direction.x(), mode.direction.y(),
                  mode.direction.z());
    return text + buffer;
  }

  const Body& body_;
  Connections links_;  // the connections that count
  Rows incident_;
  std::vector<Fixed> fixed_;
  std::vector<Eigen::Matrix<double, 3, Eigen::Dynamic>> free_basis_;
};

}  // namespace

Vector3 plane_normal(const Body& body) {
  if (!body.parts.empty()) return Vector3::Zero();
  const Positions arms = body.rest.colwise() - Vector3(body.rest.rowwise().mean());
  const SymmetricEigen3 moments = symmetric_eigen3(arms * arms.transpose());
  const Vector3 normal = moments.vectors.col(0);
  const double width = std::sqrt(std::max(0., moments.values[1])), size = arms.colwise().norm().maxCoeff();
  const bool flat = width > kFlat * size && (normal.transpose() * arms).cwiseAbs().maxCoeff() <= kFlat * size;
  return flat ? normal : Vector3(Vector3::Zero());
}

int free_rigid_motions(const Positions& rest, const std::vector<Support>& supports) {
  return rest.cols() == 0 ? 0 : static_cast<int>(RigidSpace(rest, fixed_by(supports, rest.cols())).motions.cols());
}

ModeReport find_zero_energy_modes(const Body& body, const std::vector<Support>& supports,
                                  const std::vector<char>& stiff) {
  ModeReport report = Search(body, supports, stiff).run();
  if (report.zero_energy_modes == 0) return report;
  const Vector3 normal = plane_normal(body);
  if (normal.isZero(0)) return report;
  std::vector<Support> within = supports;
  const Matrix3 in_plane = Matrix3::Identity() - normal * normal.transpose();
  for (int molecule = 0; molecule < body.size(); ++molecule) within.push_back({molecule, in_plane});
  report.out_of_plane = report.zero_energy_modes - Search(body, within, stiff).run().zero_energy_modes;
  return report;
}

namespace {

/// Of all pieces of a body that nothing joins.
int free_rigid_motions(const Body& body, const std::vector<Support>& supports) {
  const DisjointSets pieces = pieces_of(body);
  const std::vector<int> piece_of = pieces.numbers();
  std::vector<std::vector<int>> molecules(static_cast<std::size_t>(pieces.count()));
  std::vector<int> own(piece_of.size());
  for (int molecule = 0; molecule < body.size(); ++molecule) {
    std::vector<int>& piece = molecules[piece_of[molecule]];
    own[molecule] = static_cast<int>(piece.size());
    piece.push_back(molecule);
  }
  std::vector<std::vector<Support>> held(molecules.size());
  for (const Support& support : supports) {
    std::vector<Support>& piece = held[piece_of[support.molecule]];
    piece.push_back(support);
    piece.back().molecule = own[support.molecule];
  }
  int sum = 0;
  for (std::size_t piece = 0; piece < molecules.size(); ++piece)
    sum += elastin::free_rigid_motions(body.rest(Eigen::all, molecules[piece]), held[piece]);
  return sum;
}

}  // namespace

ModeReport find_modes_in_parts(const Body& body, const std::vector<Support>& supports, const std::vector<char>& stiff) {
  if (body.parts.empty()) return find_zero_energy_modes(body, supports, stiff);
  std::vector<PartAlone> soft;
  std::vector<const Part*> parts;
  std::vector<int> uses(static_cast<std::size_t>(body.size()), 0);  // by how many parts
  for (const Part& part : body.parts) {
    if (part.rigid) continue;
    parts.push_back(&part);
    soft.push_back(part_alone(body, part));
    for (const int molecule : soft.back().molecules) ++uses[molecule];
  }
  ModeReport sum;
  sum.rigid_motions = free_rigid_motions(body, supports);
  for (std::size_t number = 0; number < soft.size(); ++number) {
    const PartAlone& alone = soft[number];
    // A skin whose molecules all are another part's, too, is as stiff as that.
    if (std::all_of(alone.molecules.begin(), alone.molecules.end(), [&](int m) { return uses[m] > 1; })) {
      for (const int molecule : alone.molecules) --uses[molecule];
      continue;
    }
    std::vector<int> own(body.size(), -1);
    for (std::size_t i = 0; i < alone.molecules.size(); ++i) own[alone.molecules[i]] = static_cast<int>(i);
    std::vector<Support> held;
    for (Support support : supports)
      if ((support.molecule = own[support.molecule]) >= 0) held.push_back(support);
    std::vector<char> counts;
    if (!stiff.empty())
      for (const int c : alone.connections) counts.push_back(stiff[c]);
    ModeReport report = find_zero_energy_modes(alone.body, held, counts);
    sum.zero_energy_modes += report.zero_energy_modes;
    sum.out_of_plane += report.out_of_plane;
    sum.counted = sum.counted && report.counted;
    for (ZeroEnergyMode& mode : report.modes) {
      mode.text = "body '" + parts[number]->name + "': " + mode.text;
      for (int& molecule : mode.molecules) molecule = alone.molecules[molecule];
      sum.modes.push_back(std::move(mode));
    }
  }
  return sum;
}

}  // namespace elastin
