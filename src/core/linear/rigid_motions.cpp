#include "core/linear/rigid_motions.h"

#include <algorithm>
#include <cmath>

#include "core/base/dense.h"
#include "core/linear/sparse_stiffness.h"
#include "core/model/neighbours.h"
#include "core/parallel/parallel.h"
#include "elastin/core/linear/linear_solver.h"

namespace elastin {
namespace {

using Matrix66 = Eigen::Matrix<double, 6, 6>;

/// Of the most that forces resist a piece's motion: what counts as none.
constexpr double kUnresisted = 1e-7;

/// The piece of each molecule, by connections and what loads and contact join now; nothing where all are one.
std::vector<int> separate_pieces(const Tangent& tangent) {
  const Model& model = tangent.model();
  if (model.body().share) return {};
  DisjointSets pieces = pieces_of(model.body());
  if (pieces.count() > 1) tangent.visit_blocks([&](int a, int b, const Matrix3&) { pieces.join(a, b); });
  return pieces.count() > 1 ? pieces.numbers() : std::vector<int>();
}

/// How to combine the candidates that are left, as columns, into those that nothing resists to the least: none where
/// one is left at most, or all are resisted.
Matrix66 axes_without(const Matrix66& resistance, const Matrix66& candidates) {
  Matrix66 matrix = (resistance + resistance.transpose()) / 2;
  const double size = matrix.diagonal().cwiseAbs().maxCoeff();
  int left = 0;
  for (int k = 0; k < 6; ++k) {
    const bool tried = candidates.col(k).isZero(0);
    left += !tried;
    if (!tried) continue;
    matrix.row(k).setZero(), matrix.col(k).setZero();
    matrix(k, k) = size;
  }
  const SymmetricEigen eigen = symmetric_eigen(matrix);
  Matrix66 axes = Matrix66::Zero();
  for (int k = 0; left > 1 && k < 6; ++k)
    if (std::abs(eigen.values[k]) <= kUnresisted * size) axes.col(k) = eigen.vectors.col(k);
  return axes;
}

}  // namespace

RigidMotions::RigidMotions(const Tangent& tangent, const std::vector<Support>& supports, Positions& motions,
                           Positions& forces) {
  const int molecules = tangent.model().body().size();
  const std::vector<int> piece_of = separate_pieces(tangent);
  if (!piece_of.empty()) {
    pieces_.resize(*std::max_element(piece_of.begin(), piece_of.end()) + 1);
    for (int molecule = 0; molecule < molecules; ++molecule) pieces_[piece_of[molecule]].molecules.push_back(molecule);
    for (Piece& piece : pieces_) piece.size = static_cast<int>(piece.molecules.size());
    find_free(tangent, supports, piece_of, motions, forces);
  }
  if (!pieces_.empty()) return;  // else what joins all with all may leave them to the whole
  pieces_.resize(1);
  pieces_[0].size = molecules;
  find_free(tangent, supports, {}, motions, forces);
}

/// Leaves the pieces that have free motions, with these. One product of the stiffness tells about a motion of each
/// piece; they go unlike far, so that none of them moves along with what it pulls at. Loads may resist some motions of
/// a piece and not others: those are tried along the axes of what resists, too.
void RigidMotions::find_free(const Tangent& tangent, const std::vector<Support>& supports,
                             const std::vector<int>& piece_of, Positions& motions, Positions& forces) {
  const Positions& positions = tangent.positions();
  for (Piece& piece : pieces_) piece.set_place(positions);
  // First what no support minds, then what of that no force minds either.
  std::vector<Matrix66> held(pieces_.size(), Matrix66::Zero());
  std::vector<int> counts(pieces_.size(), 0);
  for (const Support& support : supports) {
    const int number = piece_of.empty() ? 0 : piece_of[support.molecule];
    Eigen::Matrix<double, 3, 6> part;
    for (int k = 0; k < 6; ++k) part.col(k) = pieces_[number].motion(Six::Unit(k), positions.col(support.molecule));
    part -= (support.free * part).eval();
    held[number] += part.transpose() * part;
    ++counts[number];
  }
  std::vector<Matrix66> candidates(pieces_.size());
  for (std::size_t number = 0; number < pieces_.size(); ++number) {
    const SymmetricEigen eigen = symmetric_eigen(held[number]);
    for (int k = 0; k < 6; ++k)
      candidates[number].col(k) =
          eigen.values[k] > 1e-12 * std::max(1, counts[number]) ? Six(Six::Zero()) : Six(eigen.vectors.col(k));
    pieces_[number].free.resize(6, 0);
  }
  motions.resize(3, positions.cols()), forces.resize(3, positions.cols());
  std::vector<Matrix66> resistance(pieces_.size(), Matrix66::Zero());
  for (int k = 0; k < 12; ++k) {
    if (k == 6)
      for (std::size_t number = 0; number < pieces_.size(); ++number)
        candidates[number] *= axes_without(resistance[number], candidates[number]);
    if (std::all_of(candidates.begin(), candidates.end(),
                    [&](const Matrix66& own) { return own.col(k % 6).isZero(0); }))
      continue;
    for (std::size_t number = 0; number < pieces_.size(); ++number) {
      const double far = 1 + std::fmod(0.618034 * static_cast<double>(number), 1.);
      pieces_[number].set_motion(far * candidates[number].col(k % 6), positions, motions);
    }
    tangent.apply(motions, forces);
    keep_free(supports, forces);
    for (std::size_t number = 0; number < pieces_.size(); ++number) {
      Piece& piece = pieces_[number];
      auto candidate = candidates[number].col(k % 6);
      if (candidate.isZero(0)) continue;
      if (piece.norm(forces) > 1e-9 * piece.stiffness(tangent) * piece.norm(motions)) {
        if (k < 6) resistance[number].col(k) = candidates[number].transpose() * piece.sums_of(positions, forces);
        continue;
      }
      piece.free.conservativeResize(6, piece.free.cols() + 1);
      piece.free.rightCols(1) = candidate;
      candidate.setZero();
    }
  }
  std::erase_if(pieces_, [](const Piece& piece) { return piece.free.cols() == 0; });
  for (Piece& piece : pieces_) piece.set_inverse(positions, motions);
}

void RigidMotions::Piece::set_place(const Positions& positions) {
  middle = ordered_sum(
               size, [&](int i) -> Vector3 { return positions.col(molecule(i)); }, Vector3::Zero().eval(),
               kMoleculeThreshold) /
           size;
  const double square = largest_of_ranges(
      size,
      [&](int begin, int end) {
        double most = 0;
        for (int i = begin; i < end; ++i) most = std::max(most, (positions.col(molecule(i)) - middle).squaredNorm());
        return most;
      },
      kMoleculeThreshold);
  per_size = square > 0 ? 1 / (2 * std::sqrt(square)) : 1;
}

void RigidMotions::Piece::set_motion(const Six& six, const Positions& positions, Positions& motions) const {
  parallel_for(
      size, [&](int i) { motions.col(molecule(i)) = motion(six, positions.col(molecule(i))); }, kMoleculeThreshold);
}

/// Mean diagonal entry of K over the piece's molecules [N/m], by size.
double RigidMotions::Piece::stiffness(const Tangent& tangent) const {
  if (molecules.empty()) return stiffness_scale(tangent);
  return ordered_sum(
             size, [&](int i) { return std::abs(tangent.diagonal(molecule(i)).trace()) / 3; }, 0., kMoleculeThreshold) /
         size;
}

double RigidMotions::Piece::norm(const Positions& vectors) const {
  if (molecules.empty()) return ordered_norm(vectors);
  return std::sqrt(ordered_sum(
      size, [&](int i) { return vectors.col(molecule(i)).squaredNorm(); }, 0., kMoleculeThreshold));
}

void RigidMotions::Piece::set_inverse(const Positions& positions, Positions& motions) {
  MatrixX products(free.cols(), free.cols());
  for (Eigen::Index i = 0; i < products.cols(); ++i) {
    set_motion(free.col(i), positions, motions);
    products.col(i) = products_with(positions, motions);
  }
  // Of molecules on a line the turn about it moves none: it is no motion to take out.
  inverse = symmetric_pseudoinverse(products);
  rank = static_cast<int>(std::lround(inverse.cwiseProduct(products).sum()));
}

RigidMotions::Six RigidMotions::Piece::sums_of(const Positions& positions, const Positions& vectors) const {
  return ordered_sum_of_blocks<Six>(
      size,
      [&](int begin, int end) {
        Six sum = Six::Zero();
        for (int i = begin; i < end; ++i) {
          const Vector3 v = vectors.col(molecule(i)), y = place(positions.col(molecule(i)));
          sum.head<3>() += v;
          sum.tail<3>() += y.cross(v);
        }
        return sum;
      },
      Six::Zero(), kMoleculeThreshold);
}

void RigidMotions::remove_from(const Positions& positions, Positions& motions) const {
  for (const Piece& piece : pieces_) {
    const Six whole = piece.free * (piece.inverse * piece.products_with(positions, motions));
    parallel_for(
        piece.size,
        [&](int i) {
          const int molecule = piece.molecule(i);
          motions.col(molecule) -= piece.motion(whole, positions.col(molecule));
        },
        kMoleculeThreshold);
  }
}

int RigidMotions::count() const {
  int sum = 0;
  for (const Piece& piece : pieces_) sum += piece.rank;
  return sum;
}

double RigidMotions::part_of(const Positions& positions, const Positions& vectors) const {
  double squares = 0;
  for (const Piece& piece : pieces_) {
    const VectorX products = piece.products_with(positions, vectors);
    squares += std::max(0., products.dot(piece.inverse * products));
  }
  return std::sqrt(squares);
}

}  // namespace elastin
