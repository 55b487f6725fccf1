#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/named.h"
#include "elastin/contact/obstacle.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"

namespace elastin::contact {
namespace {

struct ShapeRow {
  std::string name;
  std::vector<std::string> sizes;
  std::function<ObstacleShape(const std::vector<double>&)> make;
};

const std::vector<ShapeRow>& rows() {
  static const std::vector<ShapeRow> all{
      {shape::Plane::name, {}, [](const std::vector<double>&) { return shape::Plane{}; }},
      {shape::Box::name,
       {"x", "y", "z"},
       [](const std::vector<double>& s) {
         return shape::Box{{s[0], s[1], s[2]}};
       }},
      {shape::Sphere::name, {"radius"}, [](const std::vector<double>& s) { return shape::Sphere{s[0]}; }},
      {shape::Cylinder::name,
       {"radius", "length"},
       [](const std::vector<double>& s) {
         return shape::Cylinder{s[0], s[1]};
       }},
      {shape::Capsule::name, {"radius", "length"}, [](const std::vector<double>& s) {
         return shape::Capsule{s[0], s[1]};
       }}};
  return all;
}

}  // namespace

ObstacleShape make_shape(const std::string& name, const std::map<std::string, double>& sizes,
                         const std::vector<std::string>& others) {
  const ShapeRow* row = find_named(rows(), name);
  if (!row) {
    std::vector<std::string> allowed = names_of(rows());
    allowed.insert(allowed.end(), others.begin(), others.end());
    throw InputError("obstacle: there is no shape '" + name + "'" + suggestion(name, allowed));
  }
  for (const auto& [key, value] : sizes)
    if (std::find(row->sizes.begin(), row->sizes.end(), key) == row->sizes.end())
      throw InputError("obstacle: a " + name + " has no '" + key + "'" + suggestion(key, row->sizes));
  std::vector<double> values;
  for (const std::string& key : row->sizes) {
    const auto value = sizes.find(key);
    if (value == sizes.end()) throw InputError("obstacle: a " + name + " needs its " + key + " [m]");
    if (!(value->second > 0 && std::isfinite(value->second)))
      throw InputError("obstacle: a " + name + "'s " + key + " of " + number(value->second) +
                       " m is out of range: above 0");
    values.push_back(value->second);
  }
  return row->make(values);
}

}  // namespace elastin::contact
