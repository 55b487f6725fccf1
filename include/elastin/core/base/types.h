#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

namespace elastin {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using VectorX = Eigen::VectorXd;
/// One column a molecule: positions [m], velocities [m/s] or forces [N], shape 3 × n.
using Positions = Eigen::Matrix3Xd;

}  // namespace elastin

#ifdef ELASTIN_ALIGNMENT  // of an installed Elastin
static_assert(EIGEN_DEFAULT_ALIGN_BYTES == ELASTIN_ALIGNMENT,
              "compiled for other vectors (-march) than Elastin was: Eigen would free what it has not allocated; build "
              "Elastin with the same flags, or take its sources into the project by add_subdirectory");
#endif
