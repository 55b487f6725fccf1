#pragma once
#include <span>
#include <vector>

#include "contact/distance.h"
#include "contact/search.h"
#include "core/geometry/box_tree.h"
#include "core/model/incidence.h"

namespace elastin::contact {

/// What the search looks at; never changes.
struct ContactGeometry {
  const Body& body;
  std::vector<Sample> samples;
  Cells<3> triangles;       ///< of points: molecules and, behind them, the middles of quadrilaterals, as last corners
  Cells<4> quadrilaterals;  ///< with their four triangles each at the end of all
  Positions rest;           ///< of the points
  std::vector<int> piece_of_triangle;
  std::vector<SignedDistance> obstacles;
  int pieces = 0;
  bool spheres = false, self = false;
  double depth = 0;  ///< behind a triangle up to which a sample is pressed in [m]: half the mean side

  /// The molecules of a triangle, or of the quadrilateral that it is a part of.
  std::span<const int> molecules_of(int triangle) const {
    const int others = static_cast<int>(triangles.size() - 4 * quadrilaterals.size());
    if (triangle < others) return triangles[triangle];
    return quadrilaterals[(triangle - others) / 4];
  }
  /// Sets those of the middles.
  void set_middles(Positions& positions) const {
    for (std::size_t q = 0; q < quadrilaterals.size(); ++q) {
      const auto& [a, b, c, d] = quadrilaterals[q];
      positions.col(body.size() + static_cast<Eigen::Index>(q)) =
          (positions.col(a) + positions.col(c) + (positions.col(b) + positions.col(d))) / 4;
    }
  }
  int first_piece() const { return static_cast<int>(obstacles.size()); }
  int first_sphere() const { return first_piece() + pieces; }
  Vector3 position_of(const Sample& sample, const Positions& positions) const {
    Vector3 position = sample.weights[0] * positions.col(sample.molecules[0]);
    for (int k = 1; k < sample.count; ++k) position += sample.weights[k] * positions.col(sample.molecules[k]);
    return position;
  }
  std::array<Vector3, 3> corners_of(int triangle, const Positions& positions) const {
    const auto& [a, b, c] = triangles[triangle];
    return {positions.col(a), positions.col(b), positions.col(c)};
  }
};

/// Pairs that may touch. Those that it leaves out are further apart than the requested distance; it looks again only
/// once something has moved so far that this could be wrong.
class BroadPhase {
 public:
  struct Candidate {
    int sample, target;
    int item;  ///< the triangle of a piece
    // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy 14 takes the comparison's own code for one
    auto operator<=>(const Candidate&) const = default;
  };
  explicit BroadPhase(const ContactGeometry& geometry);
  /// Brings the candidates up to date, sorted, so that no pair with gap < reach is missing. Whether they changed.
  bool update(const Positions& positions, const std::vector<Pose>& poses, double reach);
  const std::vector<Candidate>& candidates() const { return candidates_; }

 private:
  bool still_valid(const Positions& positions, const std::vector<Pose>& poses, double reach) const;
  void refit(const Positions& positions);
  void sort_candidates();
  void visit_obstacle(int node, int obstacle, const Pose& pose, double within);
  void visit_triangles(int node, int other, double within);
  void visit_spheres(int node, double within);
  void visit_sphere_pairs(int node, int other, double within);
  void add_triangle(int sample, int triangle, double within);
  void add_spheres(int first, int second);
  bool joined(const Sample& sample, std::span<const int> molecules) const;
  bool overlap_at_rest(const Sample& sample, int triangle) const;
  double needed(double reach) const { return geometry_.spheres ? reach : std::max(reach, geometry_.depth); }

  const ContactGeometry& geometry_;
  bool within_body_;           ///< whether the body can touch itself at all
  std::vector<int> moving_;    ///< molecules that samples and triangles hang on
  Rows neighbours_;            ///< of each molecule by connections; only if pieces touch themselves
  double skin_ = 0;            ///< [m]
  double searched_reach_ = 0;  ///< the largest reach since candidates were looked for [m]
  BoxTree samples_, triangles_;
  std::vector<Box> sample_boxes_, triangle_boxes_;
  std::vector<int> piece_of_sample_;
  const Positions* now_ = nullptr;  ///< during a look
  // As it was when the candidates were looked for.
  Positions positions_;  ///< of moving_
  std::vector<Pose> poses_;
  std::vector<double> left_out_;  ///< gap of the nearest pair that was left out, one an obstacle [m]
  double left_out_in_body_ = -1;  ///< the same of pairs in the body
  std::vector<Candidate> candidates_, sorted_;
  std::vector<int> starts_;
};

}  // namespace elastin::contact
