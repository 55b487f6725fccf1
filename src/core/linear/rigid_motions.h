#pragma once
#include <vector>

#include "core/base/dense.h"
#include "elastin/core/forces/tangent.h"

namespace elastin {

/// The motions as a whole that supports and forces leave to each piece of a body that nothing joins to the others: up
/// to three translations and three rotations.
class RigidMotions {
 public:
  /// `motions` and `forces` are room that the caller has no other use for yet.
  RigidMotions(const Tangent& tangent, const std::vector<Support>& supports, Positions& motions, Positions& forces);
  bool empty() const { return pieces_.empty(); }
  /// Of all pieces; a turn about the line on which a piece lies is none.
  int count() const;
  /// Takes them out of the motions [m] of things at these positions [m], both 3 × n.
  void remove_from(const Positions& positions, Positions& motions) const;
  /// Size of what that would take out of vectors.
  double part_of(const Positions& positions, const Positions& vectors) const;

 private:
  using Six = Eigen::Matrix<double, 6, 1>;
  struct Piece {
    std::vector<int> molecules;  ///< none: all
    int size;
    Vector3 middle;
    double per_size;  ///< [1/m]
    Eigen::Matrix<double, 6, Eigen::Dynamic> free;
    MatrixX inverse;  ///< pseudo-inverse of the products of each with each
    int rank;         ///< of these products

    int molecule(int i) const { return molecules.empty() ? i : molecules[i]; }
    /// From the middle, in units of the piece's size.
    Vector3 place(const Vector3& position) const { return (position - middle) * per_size; }
    Vector3 motion(const Six& translation_and_rotation, const Vector3& position) const {
      return translation_and_rotation.head<3>() + translation_and_rotation.tail<3>().cross(place(position));
    }
    void set_place(const Positions& positions);
    void set_motion(const Six& six, const Positions& positions, Positions& motions) const;
    double stiffness(const Tangent& tangent) const;
    double norm(const Positions& vectors) const;
    /// Σ v and Σ y × v of vectors v at places y: (t + w × y) · v = t · v + w · (y × v).
    Six sums_of(const Positions& positions, const Positions& vectors) const;
    VectorX products_with(const Positions& positions, const Positions& vectors) const {
      return free.transpose() * sums_of(positions, vectors);
    }
    void set_inverse(const Positions& positions, Positions& motions);
  };
  void find_free(const Tangent& tangent, const std::vector<Support>& supports, const std::vector<int>& piece_of,
                 Positions& motions, Positions& forces);
  std::vector<Piece> pieces_;  ///< that have any
};

}  // namespace elastin
