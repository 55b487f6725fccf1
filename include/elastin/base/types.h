#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

namespace elastin {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using VectorX = Eigen::VectorXd;
/// One column a molecule: places [m], velocities [m/s] or forces [N], shape 3 × n.
using Positions = Eigen::Matrix3Xd;

}  // namespace elastin
