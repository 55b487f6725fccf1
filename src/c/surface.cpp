#include "elastin/core/model/embedded_surface.h"

#include "c/handles.h"

struct elastin_surface {
  elastin::EmbeddedSurface surface;
};

using elastin::c::given;
using elastin::c::guarded;

extern "C" elastin_status elastin_surface_make(const elastin_body* body, const double* points, size_t point_count,
                                               const int* triangles, size_t triangle_count, elastin_surface** surface) {
  return guarded([&] {
    given(surface, "surface");
    const elastin::Body& carrier = given(body, "body").body;
    if (point_count > 0) given(points, "points");
    if (triangle_count > 0) given(triangles, "triangles");
    elastin::Positions at = elastin::Positions::Zero(3, static_cast<Eigen::Index>(point_count));
    std::copy_n(points, 3 * point_count, at.data());
    elastin::Cells<3> faces(triangle_count);
    for (std::size_t i = 0; i < triangle_count; ++i) std::copy_n(triangles + 3 * i, 3, faces[i].begin());
    *surface = new elastin_surface{{carrier, at, std::move(faces)}};
  });
}

extern "C" elastin_status elastin_surface_draw(const elastin_surface* surface, const elastin_simulation* simulation,
                                               float* points, float* normals) {
  return guarded([&] {
    const elastin::EmbeddedSurface& drawn = given(surface, "surface").surface;
    const elastin::Positions& positions = given(simulation, "simulation").simulation.positions();
    const auto numbers = static_cast<std::size_t>(3 * drawn.size());
    if (numbers > 0) given(points, "points");
    drawn.draw(positions, {points, numbers}, {normals, normals ? numbers : 0});
  });
}

extern "C" void elastin_surface_free(elastin_surface* surface) { delete surface; }
