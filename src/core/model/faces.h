#pragma once
#include <array>
#include <optional>
#include <vector>

#include "core/geometry/tributary.h"
#include "elastin/core/model/body.h"

namespace elastin {

/// Of each triangle that of its part [m], or `whole` where the part has none of its own.
std::vector<double> thicknesses(const Body& body, double whole);

/// Two directions that span the plane across an axis, as columns.
Eigen::Matrix<double, 3, 2> across(const Vector3& axis);

/// The convex hull of the body at rest, seen on a plane: of the whole, whatever this process has of it.
Points2 hull_of_whole(const Body& body, const Eigen::Matrix<double, 3, 2>& plane);
/// The same of some points of each process.
Points2 hull_over(const Body& body, const Points2& own);

/// The molecules at one end of a body.
struct Face {
  std::vector<int> molecules;
  double area = 0;  ///< of their hull, seen along the direction [m²]; 0 where they lie on a line
  /// What part of the area each carries, sum 1: a third of its triangles on the face where the body has tetrahedra (the
  /// consistent load of linear cells), of triangles alone half of the sides next to it times their thickness, else the
  /// part of the hull nearest to it, on a line half of the way to the next ones.
  /// On a process's share of a body 0 for ghosts: the sum over all processes is 1.
  VectorX share;
  /// Mean outward normal, where the end is no plane across the direction and was found by its sides; else zero.
  Vector3 tilted = Vector3::Zero();
};

/// The molecules furthest along `direction` (unit), and those at most `depth` [m] behind them or, where it has one,
/// behind the body's outline. Of a refined body (Body::between) those of the body that it came from, and what lies
/// between two of them. Without a depth those in the end plane, to 1e-6 of the body's length; of a body of cells whose
/// end is no plane across the direction (it is rough, tilted, rounded) the corners of the sides that are its end, see
/// end_sides. Throws InputError if that is the whole body.
Face end_face(const Body& body, const Vector3& direction, double depth);

/// These molecules, ascending, as a face that is seen along `direction` (unit).
Face face_of(const Body& body, std::vector<int> molecules, const Vector3& direction);

/// Of the sides that bound a surface of triangles or quadrilaterals and are in a face of these molecules: length as
/// seen along `direction` times the thickness of the part, or of the whole [m²], shared out as a uniform load along it
/// is: halves, of second order 1/6, 4/6, 1/6. One a molecule.
VectorX side_areas(const Body& body, const std::vector<int>& molecules, const Vector3& direction, double thickness);

/// Middle of a face: mean position of its molecules by share [m].
Vector3 middle_of(const Body& body, const Face& face, const Positions& positions);

/// A solid body in the form of a box.
struct BoxSides {
  std::array<Face, 6> sides;  ///< along −a, +a, −b, +b, −c, +c, the columns of the axes
  Vector3 size;               ///< along the axes [m]
};

/// The sides of a box along `axes` (orthonormal columns), each as end_face gives it. Throws InputError if the body is
/// no box: if the molecules of a side span less than half of it.
BoxSides find_box(const Body& body, const Matrix3& axes, double depth);

/// Axes (orthonormal columns) of a body in the form of a box, however it is turned: x, y, z where its sides lie across
/// them, else those of the longest straight lines between corners of its outline. Nothing where it is no box.
std::optional<Matrix3> box_axes(const Body& body);

/// What bounds a solid body.
struct Surface {
  std::vector<int> molecules;  ///< ascending
  double volume = 0;           ///< inside [m³]
};

/// The surface of the cells where the body has tetrahedra; else the six sides of a box, and its volume. Throws
/// InputError if the body is neither, or if a depth is given where cells say what the surface is.
Surface find_surface(const Body& body, const Matrix3& axes, double depth);

}  // namespace elastin
