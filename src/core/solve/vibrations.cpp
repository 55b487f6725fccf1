#include "elastin/core/solve/vibrations.h"

#include <cmath>
#include <numbers>
#include <numeric>

#include "core/base/dense.h"
#include "core/solve/full_tangent.h"
#include "elastin/core/base/stop.h"
#include "elastin/core/linear/linear_solver.h"

namespace elastin {
namespace {

using Block = MatrixX;  // columns are motions times √mass, 3n long

constexpr int kDenseLimit = 450;  // directions of a body that is solved as a whole
constexpr int kIterationLimit = 200;
constexpr int kMostPieces = 16;    // whose own rigid motions are looked for
constexpr double kSteering = 0.1;  // how far the static solver goes in each step

class ScaledStiffness {
 public:
  ScaledStiffness(Model& model, const State& state)
      : model_(model), tangent_(model, state), root_(model.body().mass.cwiseSqrt()), solver_(make_pcg()) {
    const int n = model.body().size();
    rigid_.resize(3 * n, 0);
    std::vector<int> all(n);
    std::iota(all.begin(), all.end(), 0);
    add_rigid_motions(state.positions, all);
    if (model.body().share) return;
    const BodyFindings found = inspect(model.body());
    if (found.pieces < 2 || found.pieces > kMostPieces) return;
    std::vector<std::vector<int>> pieces(found.pieces);
    for (const int molecule : all) pieces[found.piece_of[molecule]].push_back(molecule);
    for (const std::vector<int>& piece : pieces) add_rigid_motions(state.positions, piece);
  }

  Eigen::Index size() const { return 3 * model_.body().size(); }
  const Block& rigid() const { return rigid_; }

  /// M^-½ K M^-½ of each column, in the free directions.
  Block apply(const Block& block) const {
    Block result(block.rows(), block.cols());
    Positions forces(3, model_.body().size());
    for (Eigen::Index c = 0; c < block.cols(); ++c) {
      tangent_.apply(motion(block.col(c)), forces);
      forces = (forces * root_.cwiseInverse().asDiagonal()).eval();
      keep_free(model_.supports, forces);
      result.col(c) = forces.reshaped();
    }
    return result;
  }

  /// What the static solver makes of each column as a load: near K⁻¹.
  Block steer(const Block& block) const {
    Block result(block.rows(), block.cols());
    for (Eigen::Index c = 0; c < block.cols(); ++c) {
      Positions load = block.col(c).reshaped(3, model_.body().size()) * root_.asDiagonal(), displacement;
      keep_free(model_.supports, load);
      solver_->solve(tangent_, model_.supports, load, kSteering, displacement);
      if (!displacement.allFinite()) displacement = load;
      result.col(c) = (displacement * root_.asDiagonal()).eval().reshaped();
    }
    return result;
  }

  /// Takes out what supports fix, and rigid motions.
  void project(Block& block) const {
    for (Eigen::Index c = 0; c < block.cols(); ++c) {
      Positions free = block.col(c).reshaped(3, model_.body().size());
      keep_free(model_.supports, free);
      block.col(c) = free.reshaped();
    }
    if (rigid_.cols() > 0) block -= product(rigid_, transposed_product(rigid_, block));
  }

  Positions motion(const VectorX& scaled) const {
    return scaled.reshaped(3, model_.body().size()) * root_.cwiseInverse().asDiagonal();
  }

 private:
  /// Of the six of these molecules in space, those that supports leave and that no stiffness resists; orthonormal.
  void add_rigid_motions(const Positions& everywhere, const std::vector<int>& molecules) {
    const int n = model_.body().size();
    const Positions positions = everywhere(Eigen::all, molecules);
    const VectorX mass = model_.body().mass(molecules);
    const Vector3 centre = positions * mass / mass.sum();
    const double reach = std::max((positions.colwise() - centre).colwise().norm().maxCoeff(), 1e-300);
    Block all = Block::Zero(3 * n, 6);
    for (const int i : molecules)
      for (int axis = 0; axis < 3; ++axis) {
        const Vector3 unit = Vector3::Unit(axis);
        all.block<3, 1>(3 * i, axis) = root_[i] * unit;
        all.block<3, 1>(3 * i, 3 + axis) = root_[i] / reach * unit.cross(Vector3(everywhere.col(i) - centre));
      }
    all /= std::sqrt(mass.sum());
    // What they move against the supports, and how much they move at all.
    Block held = all;
    for (Eigen::Index c = 0; c < 6; ++c) {
      Positions free = all.col(c).reshaped(3, n);
      keep_free(model_.supports, free);
      held.col(c) -= free.reshaped();
    }
    const SymmetricEigen moves = symmetric_eigen(transposed_product(all, all));
    Block basis(6, 0);
    for (int k = 0; k < 6; ++k)
      if (moves.values[k] > 1e-10) {
        basis.conservativeResize(6, basis.cols() + 1);
        basis.rightCols(1) = moves.vectors.col(k) / std::sqrt(moves.values[k]);
      }
    const Block moved = product(held, basis), against = transposed_product(moved, moved);
    const SymmetricEigen free = symmetric_eigen(against);
    double stiffest = 0;
    for (int i = 0; i < n; ++i) stiffest = std::max(stiffest, tangent_.diagonal(i).norm() / model_.body().mass[i]);
    for (Eigen::Index k = 0; k < against.cols(); ++k) {
      if (free.values[k] > 1e-12) continue;
      Block motion = product(all, basis * free.vectors.col(k));
      if (apply(motion).norm() > 1e-9 * stiffest) continue;
      for (int round = 0; round < 2 && rigid_.cols() > 0; ++round)
        motion -= product(rigid_, transposed_product(rigid_, motion));
      if (!(motion.norm() > 1e-6)) continue;
      motion /= motion.norm();
      rigid_.conservativeResize(3 * n, rigid_.cols() + 1);
      rigid_.rightCols(1) = motion;
    }
  }

  Model& model_;
  Tangent tangent_;
  VectorX root_;
  std::unique_ptr<LinearSolver> solver_;
  Block rigid_;
};

/// Makes the columns of `block` orthonormal among themselves and to those of `others`, twice over; those that hardly
/// add a direction go. `image` follows.
void orthonormalise(const Block& others, const Block& images, Block& block, Block& image) {
  Eigen::Index kept = 0;
  for (Eigen::Index c = 0; c < block.cols(); ++c) {
    VectorX v = block.col(c), w = image.cols() ? VectorX(image.col(c)) : VectorX();
    const double first = v.norm();
    for (int round = 0; round < 2; ++round)
      for (const auto& [basis, basis_image, count] :
           {std::tuple{&others, &images, others.cols()}, {&block, &image, kept}}) {
        const VectorX part = basis->leftCols(count).transpose() * v;
        v -= basis->leftCols(count) * part;
        if (w.size()) w -= basis_image->leftCols(count) * part;
      }
    const double length = v.norm();
    if (!(length > 1e-8 * first) || !std::isfinite(length)) continue;
    block.col(kept) = v / length;
    if (w.size()) image.col(kept) = w / length;
    ++kept;
  }
  block.conservativeResize(Eigen::NoChange, kept);
  if (image.cols()) image.conservativeResize(Eigen::NoChange, kept);
}

/// Columns that have a part in every direction and never change.
Block fixed_start(Eigen::Index rows, Eigen::Index columns) {
  Block block(rows, columns);
  for (Eigen::Index c = 0; c < columns; ++c)
    for (Eigen::Index r = 0; r < rows; ++r)
      block(r, c) = std::sin(1 + 12.9898 * static_cast<double>(r) + 78.233 * static_cast<double>(c * (r + 1) % 977));
  return block;
}

void add_modes(const ScaledStiffness& op, const VectorX& values, const Block& vectors, Eigen::Index count, double scale,
               Vibrations& found) {
  found.frequencies.resize(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const double value = std::abs(values[k]) < 1e-10 * scale ? 0 : values[k];
    found.frequencies[k] = std::sqrt(value) / (2 * std::numbers::pi);
    found.shapes.push_back(op.motion(vectors.col(k)));
  }
}

void solve_whole(const ScaledStiffness& op, int count, Vibrations& found) {
  Block basis = Block::Identity(op.size(), op.size()), nothing;
  op.project(basis);
  Block none(op.size(), 0);
  orthonormalise(op.rigid(), none, basis, nothing);
  const Block reduced = transposed_product(basis, op.apply(basis));
  const SymmetricEigen eigen = symmetric_eigen((reduced + reduced.transpose()) / 2);
  const Eigen::Index modes = std::min<Eigen::Index>(count, reduced.cols());
  if (modes == 0) return;
  add_modes(op, eigen.values, product(basis, eigen.vectors.leftCols(modes)), modes, eigen.values.cwiseAbs().maxCoeff(),
            found);
}

void solve_by_blocks(const ScaledStiffness& op, int count, double tolerance, const std::function<bool()>& stop,
                     Vibrations& found) {
  const Eigen::Index width = count + std::max(3, count / 2);
  Block x = fixed_start(op.size(), width), nothing, p(op.size(), 0), ap = p;
  op.project(x);
  x = op.steer(x);  // rough it is smooth
  op.project(x);
  const Block none(op.size(), 0);
  orthonormalise(none, none, x, nothing);
  Block ax = op.apply(x);
  VectorX values = VectorX::Zero(x.cols());
  const auto ritz = [&](const Block& s, const Block& as, Eigen::Index olds) {
    const Block reduced = transposed_product(s, as);
    const SymmetricEigen eigen = symmetric_eigen((reduced + reduced.transpose()) / 2);
    const Block best = eigen.vectors.leftCols(std::min(width, s.cols()));
    values = eigen.values.head(best.cols());
    const Eigen::Index news = s.cols() - olds;
    p = product(s.rightCols(news), best.bottomRows(news));
    ap = product(as.rightCols(news), best.bottomRows(news));
    x = product(s, best);
    ax = product(as, best);
  };
  ritz(Block(x), Block(ax), x.cols());
  for (; found.iterations < kIterationLimit; ++found.iterations) {
    if (stop_requested() || (stop && stop())) {
      found.outcome = Outcome::interrupted;
      found.cause = "stopped after " + std::to_string(found.iterations) + " iterations";
      return;
    }
    if (found.iterations % 20 == 19) ax = op.apply(x);
    Block r = ax - x * values.asDiagonal();
    std::vector<Eigen::Index> open;
    bool done = true;
    for (Eigen::Index k = 0; k < x.cols(); ++k)
      if (r.col(k).norm() > tolerance * std::abs(values[k])) {
        open.push_back(k);
        done &= k >= count;
      }
    if (done) break;
    Block w = op.steer(Block(r(Eigen::all, open)));
    op.project(w);
    orthonormalise(x, none, w, nothing);
    const Block aw = op.apply(w);
    Block s(x.rows(), x.cols() + w.cols()), as(s.rows(), s.cols());
    s << x, w;
    as << ax, aw;
    orthonormalise(s, as, p, ap);
    Block all(s.rows(), s.cols() + p.cols()), images(all.rows(), all.cols());
    all << s, p;
    images << as, ap;
    ritz(all, images, x.cols());
  }
  if (found.iterations == kIterationLimit) {
    found.outcome = Outcome::limit_reached;
    found.cause = "the vibrations did not settle within " + std::to_string(kIterationLimit) + " iterations";
  }
  add_modes(op, values, x, std::min<Eigen::Index>(count, x.cols()), values.cwiseAbs().maxCoeff(), found);
}

}  // namespace

Vibrations find_vibrations(Model& model, const State& state, int count, double tolerance,
                           const std::function<bool()>& stop) {
  Vibrations found;
  if (const std::string why = without_full_tangent(model, state.positions); !why.empty()) {
    found.outcome = Outcome::limit_reached;
    found.cause = why;
    return found;
  }
  const ScaledStiffness op(model, state);
  found.rigid_motions = static_cast<int>(op.rigid().cols());
  if (op.size() <= kDenseLimit)
    solve_whole(op, count, found);
  else
    solve_by_blocks(op, count, tolerance, stop, found);
  return found;
}

}  // namespace elastin
