#include "lab/experiment/symmetry.h"

#include "elastin/core/base/error.h"
#include "elastin/core/model/share.h"

namespace elastin::lab {

void fix_in_planes(const Body& body, const std::vector<Vector3>& normals, FixedMolecules& fixed) {
  const double near = 1e-9 * largest_over(body, body.rest.cwiseAbs().maxCoeff());
  for (const Vector3& normal : normals) {
    const VectorX height = body.rest.transpose() * normal;
    if (least_over(body, height.minCoeff()) < -near && largest_over(body, height.maxCoeff()) > near)
      throw InputError("symmetry: the body lies on both sides of one of the planes");
    bool any = false;
    for (int molecule = 0; molecule < body.size(); ++molecule) {
      if (std::abs(height[molecule]) > near) continue;
      any = true;
      Matrix3& free = fixed.try_emplace(molecule, Matrix3::Identity()).first->second;
      free -= (free * normal * normal.transpose()).eval();
    }
    if (!any_over(body, any))
      throw InputError("symmetry: no molecule lies in one of the planes, which go through the origin");
  }
}

}  // namespace elastin::lab
