#include "hull/convex_hull.h"

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

#include <cstdio>

namespace elastin::hull {
namespace {

/// A run of Qhull: what it allocates, and a file for what it says.
struct Qhull {
  qhT state;
  std::FILE* said = std::tmpfile();
  Qhull() { qh_zero(&state, said); }
  Qhull(const Qhull&) = delete;
  ~Qhull() {
    qh_freeqhull(&state, !qh_ALL);
    int left = 0, bytes = 0;
    qh_memfreeshort(&state, &left, &bytes);
    if (said) std::fclose(said);
  }

  std::string first_line_said() {
    char line[200] = "";
    std::rewind(said);
    while (std::fgets(line, sizeof line, said) && (line[0] == '\n' || line[0] == ' ')) continue;
    std::string text = line;
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return text.empty() ? "Qhull failed" : text;
  }
};

}  // namespace

std::string visit_hull(int dimension, const std::vector<double>& points, bool triangulated,
                       const std::function<void(const HullFacet&)>& visit) {
  Qhull qhull;
  if (!qhull.said) return "no temporary file can be opened for Qhull";
  qhT* qh = &qhull.state;
  std::vector<double> copy = points;
  std::string options = triangulated ? "qhull Qt" : "qhull";
  const int count = static_cast<int>(points.size()) / dimension;
  if (qh_new_qhull(qh, dimension, count, copy.data(), False, options.data(), qhull.said, qhull.said))
    return qhull.first_line_said();
  facetT* facet = nullptr;
  FORALLfacets {
    HullFacet found{facet->normal, facet->offset, {}};
    vertexT *vertex = nullptr, **vertexp = nullptr;
    FOREACHvertex_(facet->vertices) found.corners.push_back(qh_pointid(qh, vertex->point));
    visit(found);
  }
  return "";
}

}  // namespace elastin::hull
