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
    for (int i = 0; i < level.points(); ++i) size += level.block_to(i, BoxGrid::kSelf).trace() / (3 * level.points());
    for (int i = 0; i < level.points(); ++i)
      for (int code = 0; code < BoxGrid::kAround; ++code) {
        const int j = level.neighbour(i, code);
        if (j > i || (j == i && code != BoxGrid::kSelf)) continue;  // the factorisation looks at the lower half
        Matrix3 block = level.block_to(i, code);
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
    right_ = Eigen::Map<const Eigen::VectorXf>(b.data(), b.size()).cast<double>();
    factor_.solve(right_, spare_, solution_);
    Eigen::Map<Eigen::VectorXf>(x.data(), x.size()) = solution_.cast<float>();
  }

 private:
  SparseFactor factor_;
  VectorX right_, spare_, solution_;
};

namespace {

/// Whether to factorise a grid and not to go on: it is small, or so thin that larger boxes would be thicker than the
/// body, which makes them far too stiff in bending.
bool is_last(const BoxLevel& level) {
  constexpr int small = 64, most = 4000;
  if (level.points() <= small) return true;
  return level.points() <= most && 4 * level.grid().coarser().boxes() >= level.grid().boxes();
}

}  // namespace

Multigrid::Multigrid(const Tangent& tangent, const std::vector<Support>& supports) {
  GridLevel finest = assemble_level(tangent, supports);
  members_ = std::move(finest.members);
  levels_.push_back(std::move(finest.level));
  while (!is_last(*levels_.back())) levels_.push_back(levels_.back()->coarser());
  for (const auto& level : levels_) {
    const BoxLevel::Vectors zero = BoxLevel::Vectors::Zero(3, level->points());
    workspaces_.push_back({zero, zero, zero});
  }
  coarsest_ = std::make_unique<CoarsestSolver>(*levels_.back());
}

Multigrid::~Multigrid() = default;

bool Multigrid::positive() const { return coarsest_->positive(); }

void Multigrid::cycle(std::size_t number) {
  const BoxLevel& level = *levels_[number];
  auto& [b, x, other] = workspaces_[number];
  if (number + 1 == levels_.size()) return coarsest_->solve(b, x);
  level.start(b, x);
  level.set_residual(b, x, other);
  LevelWorkspace& coarse = workspaces_[number + 1];
  level.restrict_to(*levels_[number + 1], other, coarse.b);
  cycle(number + 1);
  level.prolong_from(*levels_[number + 1], coarse.x, x);
  level.smooth(b, x, other);
  std::swap(x, other);
}

void Multigrid::add(const Positions& forces, double size, Positions& motion) {
  const BoxGrid& grid = levels_.front()->grid();
  LevelWorkspace& finest = workspaces_.front();
  BoxLevel::Vectors &b = finest.b, &x = finest.x;
  b.setZero();
  const int layers = grid.layers(), least = forces.cols() < kMoleculeThreshold ? layers + 1 : 2;
  // Layers touch the points between them: every second at a time.
  for (const int colour : {0, 1})
    parallel_for((layers + 1 - colour) / 2,
                 [&](int half) {
                   const int layer = 2 * half + colour;
                   for (int box = grid.first_box(layer); box < grid.first_box(layer + 1); ++box)
                     for (int at = members_.start[box]; at < members_.start[box + 1]; ++at) {
                       const auto& member = members_.members[at];
                       const auto values = BoxGrid::values_at(member.at);
                       const Eigen::Vector3f force = (forces.col(member.molecule) / size).cast<float>();
                       for (int c = 0; c < 8; ++c) b.col(grid.corners(box)[c]) += values[c] * force;
                     }
                 },
                 least);
  cycle(0);
  parallel_for(
      grid.boxes(),
      [&](int box) {
        Eigen::Matrix<float, 3, 8> corner;
        for (int c = 0; c < 8; ++c) corner.col(c) = x.col(grid.corners(box)[c]);
        for (int at = members_.start[box]; at < members_.start[box + 1]; ++at) {
          const auto& member = members_.members[at];
          const auto values = BoxGrid::values_at(member.at);
          Eigen::Vector3f sum = Eigen::Vector3f::Zero();
          for (int c = 0; c < 8; ++c) sum += values[c] * corner.col(c);
          motion.col(member.molecule) += size * sum.cast<double>();
        }
      },
      1000);
}

}  // namespace elastin
