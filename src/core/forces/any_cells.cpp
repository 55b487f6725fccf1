#include "elastin/core/forces/cells.h"
#include "elastin/core/laws/any_law.h"

namespace elastin::detail {

template <>
ElasticTerms make_any_simplices<3>(const Body& body, const Material& material, const AnyAtWork<3>& at_work) {
  return make_simplices<3>(body, material, AnySolid{at_work});
}

template <>
ElasticTerms make_any_simplices<2>(const Body& body, const Material& material, const AnyAtWork<2>& at_work) {
  return make_simplices<2>(body, material, AnyMembrane{at_work});
}

}  // namespace elastin::detail
