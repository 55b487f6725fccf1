#include "core/linear/multigrid.h"

#include "core/linear/sparse_factor.h"
#include "core/parallel/parallel.h"

namespace elastin {

/// The coarsest grid.
class Multigrid::CoarsestSolver {
 public:
  explicit CoarsestSolver(const BoxLevel& level) {
    std::vector<Eigen::Triplet<double>> entries;
    double size = 0;
    for (int i = 0; i < level.points(); ++i) size += level.block_to(i, 0).trace() / (3 * level.points());
    for (int i = 0; i < level.points(); ++i)
      for (int n = 0; const int j : level.neighbours(i)) {
        const int number = n++;
        if (j > i || (j == i && number > 0)) continue;  // the factorisation looks at the lower half
        Matrix3 block = level.block_to(i, number);
        // What moves as a whole may be free to; a point in the air certainly is.
        if (j == i) block.diagonal().array() += 1e-9 * size;
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c) entries.emplace_back(3 * i + r, 3 * j + c, block(r, c));
      }
    Eigen::SparseMatrix<double> matrix(3 * level.points(), 3 * level.points());
    matrix.setFromTriplets(entries.begin(), entries.end());
    factor_.compute(matrix);
  }
  bool positive() const { return factor_.positive(); }
  void solve(const BoxLevel::Vectors& b, BoxLevel::Vectors& x) {
    right_ = Eigen::Map<const Eigen::VectorXf>(b.data(), b.size() - 3).cast<double>();
    factor_.solve(right_, spare_, solution_);
    Eigen::Map<Eigen::VectorXf>(x.data(), x.size() - 3) = solution_.cast<float>();
  }

 private:
  SparseFactor factor_;
  VectorX right_, spare_, solution_;
};

namespace {

/// Numbers of a grid's factor over those of its rows up to which it takes no longer than cycles, and products that make
/// it, of a point.
constexpr double kMostFill = 4, kMostProducts = 1.5e4;
/// At least as much more has the factor of the next finer grid.
constexpr double kFillGrows = 1.5;

/// Whether to factorise a grid and not to go on: it is small, or so thin that larger boxes are no fewer by much.
bool is_last(const BoxGrid& grid, const BoxGrid& coarser) {
  constexpr int small = 64, most = 4000;
  return grid.points() <= small || (grid.points() <= most && 4 * coarser.boxes() >= grid.boxes());
}

}  // namespace

Multigrid::Multigrid(const Tangent& tangent, const std::vector<Support>& supports) {
  GridLevel finest = assemble_level(tangent, supports);
  members_ = std::move(finest.members);
  levels_.push_back(std::move(finest.level));
  while (true) {
    BoxGrid::Coarser coarser = levels_.back()->grid().coarser();
    if (is_last(levels_.back()->grid(), coarser.grid)) break;
    levels_.push_back(levels_.back()->coarser(std::move(coarser)));
  }
  drop_levels_below_cheap_factor();
  for (const auto& level : levels_) {
    const BoxLevel::Vectors zero = level->vectors();
    workspaces_.push_back({zero, zero, zero, zero, {}, {}, {}, {}});
  }
}

/// Boxes larger than a thin body is thick are too stiff in bending, and its factors have little fill.
void Multigrid::drop_levels_below_cheap_factor() {
  double fill = 1;
  while (levels_.size() > 1 && kFillGrows * fill <= kMostFill) {
    thin_ = levels_.size() == 2;
    const BoxLevel& level = *levels_[levels_.size() - 2];
    std::vector<std::array<int, 2>> pairs;
    for (int i = 0; i < level.points(); ++i)
      for (const int j : level.neighbours(i))
        if (i < j) pairs.push_back({i, j});
    const FactorCost cost = factor_cost(level.points(), pairs);
    fill = cost.numbers / (9. * static_cast<double>(pairs.size() + level.points()));
    if (fill > kMostFill || cost.products > kMostProducts * level.points()) break;
    levels_.pop_back();
  }
}

Multigrid::~Multigrid() = default;

bool Multigrid::positive() {
  if (!coarsest_) coarsest_ = std::make_unique<CoarsestSolver>(*levels_.back());
  return coarsest_->positive();
}

void Multigrid::cycle(std::size_t number) {
  const BoxLevel& level = *levels_[number];
  LevelWorkspace& own = workspaces_[number];
  auto &b = own.b, &x = own.x, &other = own.other;
  if (number + 1 == levels_.size()) return coarsest_->solve(b, x);
  // Where a cycle makes too little of what is asked of it, another step saves up to a tenth of the cycles.
  const int last = level.steps() + (searches_ ? 1 : 0);
  const auto smooth = [&](int first) {
    for (int i = first; i <= last; ++i) {
      level.smooth(i, b, x, other, own.step);
      std::swap(x, other);
    }
  };
  level.start(b, x, own.step);
  smooth(2);
  // Twice (a W-cycle), but for the coarsest, which is exact: what thin and porous bodies lose from grid to grid, boxes
  // that are thicker than the body being too stiff in bending, does not pile up.
  for (int visit = number + 2 < levels_.size() ? 2 : 1; visit > 0; --visit) {
    level.set_residual(b, x, other);
    LevelWorkspace& coarse = workspaces_[number + 1];
    level.restrict_to(*levels_[number + 1], other, own.of_boxes, coarse.b);
    if (searches_ && number + 2 < levels_.size())
      search_on(number + 1);
    else
      cycle(number + 1);
    level.prolong_from(*levels_[number + 1], coarse.x, x);
    smooth(1);
  }
}

void Multigrid::search() {
  if (searches_) return;
  searches_ = true;
  for (std::size_t number = 1; number + 1 < levels_.size(); ++number) {
    LevelWorkspace& own = workspaces_[number];
    own.found = own.along = own.resisted = levels_[number]->vectors();
  }
}

/// x = A⁻¹ b as a few steps of conjugate gradients with cycles find it, as many as it takes: boxes that are thicker
/// than the body are too stiff in bending, so that a cycle makes far too little of it. b is left as what remains.
void Multigrid::search_on(std::size_t number) {
  constexpr int most = 4;
  constexpr double enough = 0.25;
  const BoxLevel& level = *levels_[number];
  LevelWorkspace& own = workspaces_[number];
  auto &b = own.b, &x = own.x, &found = own.found, &along = own.along, &resisted = own.resisted;
  const auto product = [&](const BoxLevel::Vectors& one, const BoxLevel::Vectors& other) {
    return ordered_sum(level.points(), [&](int i) { return static_cast<double>(one.col(i).dot(other.col(i))); });
  };
  const double first = product(b, b);
  found.setZero();
  double curvature = 0;
  for (int step = 1; step <= most; ++step) {
    cycle(number);
    const double before = step > 1 ? product(x, resisted) / curvature : 0;
    along = x - static_cast<float>(before) * along;
    level.set_residual(b, along, own.other);
    resisted = b - own.other;
    curvature = product(along, resisted);
    if (!(curvature > 0)) break;
    const auto length = static_cast<float>(product(along, b) / curvature);
    found += length * along;
    b -= length * resisted;
    if (product(b, b) <= enough * enough * first) break;
  }
  std::swap(x, found);
}

void Multigrid::add(const Positions& forces, double size, Positions& motion) {
  const BoxGrid& grid = levels_.front()->grid();
  LevelWorkspace& finest = workspaces_.front();
  members_.restrict_to(
      grid, [&](int molecule) -> Eigen::Vector3f { return (forces.col(molecule) / size).cast<float>(); }, of_boxes_,
      finest.b);
  cycle(0);
  members_.prolong_from(grid, finest.x, [&](int molecule, const Eigen::Vector3f& value) {
    motion.col(molecule) += size * value.cast<double>();
  });
}

}  // namespace elastin
