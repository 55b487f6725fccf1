#include "lab/experiment/bubble/bubble.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include "core/base/dense.h"
#include "core/forces/pressure.h"
#include "core/geometry/rim.h"
#include "core/shapes/surfaces.h"
#include "elastin/core/base/error.h"
#include "elastin/core/forces/tension.h"
#include "lab/experiment/keys.h"
#include "lab/run/common_measures.h"
#include "lab/run/section.h"

namespace elastin::lab {
namespace {

const MeasureList& bubble_measures() {
  using namespace dimension;
  using Role = MeasureRole;
  static const MeasureList list{
      {{"pressure", pressure, "pressure inside over that outside"},
       {"height", length, "height of the pole above the rim"},
       {"cap_radius", length, "radius of the sphere through pole and rim: (a^2 + h^2) / 2h"},
       {"stretch", none, "arc over chord of the cap"},
       {"strain", none, "stretch - 1", Role::strain},
       {"stress", pressure, "true stress of a spherical cap that keeps its volume", Role::stress},
       {"pole_radius", length, "radius of curvature at the pole, fitted to the molecules around it"},
       {"pole_stretch", none, "stretch at the pole, fitted to the molecules around it"},
       {"pole_stress", pressure, "nominal stress at the pole, fitted to the triangles around it"},
       {"measured_height", length, "height as the scene gives it"},
       {"height_misfit", none, "height / measured height - 1"}},
      {{"strain", "stress", true}, {"load", "height", true}}};
  return list;
}

/// Least squares of values by c₀ + c₁ x + c₂ x² (as many terms as given).
VectorX fit(const std::vector<double>& x, const std::vector<double>& values, int terms) {
  const auto rows = static_cast<Eigen::Index>(x.size());
  Eigen::MatrixXd powers(rows, terms);
  for (Eigen::Index row = 0; row < rows; ++row)
    for (int term = 0; term < terms; ++term) powers(row, term) = std::pow(x[row], term);
  return least_squares(powers, Eigen::Map<const VectorX>(values.data(), rows));
}

class Bubble final : public StaticExperiment {
 public:
  Bubble(const Body& body, const BubbleSetup& setup, const Material& material)
      : body_(body), setup_(setup), thickness_(mean_thickness(body, material.thickness)), rim_(rim_of(body.triangles)) {
    if (rim_.empty()) throw InputError("a bubble needs a disc of triangles with a rim to hold");
    for (const int molecule : rim_) centre_ += body.rest.col(molecule) / static_cast<double>(rim_.size());
    for (const auto& triangle : body.triangles) axis_ += area_vector(body.rest, triangle);
    axis_.normalize();
    double nearest = 1e300, furthest = 0;
    for (const int molecule : rim_) {
      const double distance = (body.rest.col(molecule) - centre_).norm();
      nearest = std::min(nearest, distance), furthest = std::max(furthest, distance);
      radius_ += distance / static_cast<double>(rim_.size());
    }
    if (furthest > 1.01 * nearest) throw InputError("a bubble needs a round rim: this one is no circle within 1 %");
    if (((axis_.transpose() * body.rest).array() - axis_.dot(centre_)).abs().maxCoeff() > 1e-6 * radius_)
      throw InputError("a bubble needs a flat disc");
    for (int molecule = 0; molecule < body.size(); ++molecule)
      rest_radius_.push_back((body.rest.col(molecule) - centre_).norm() / radius_);
    pole_ = static_cast<int>(std::min_element(rest_radius_.begin(), rest_radius_.end()) - rest_radius_.begin());
    stiffness_ = material.youngs_modulus * thickness_;
    poissons_ratio_ = material.poissons_ratio;
  }

  std::string name() const override { return "bubble"; }
  MeasureList measures() const override { return bubble_measures(); }
  std::unique_ptr<StaticRig> make_rig(Model& model) const override;
  int load_steps() const override { return static_cast<int>(setup_.pressures.size()); }
  bool stiffened_by_load() const override { return true; }

  std::vector<MainMeasure> main_measures(const Material&, const Measures& measured) const override {
    std::vector<MainMeasure> main{{"height"}, {"pole_stretch"}, {"pole_stress"}, {"pole_radius"}};
    if (std::isfinite(measured.get("height_misfit"))) main.push_back({"height_misfit"});
    return main;
  }

  /// The cap's equal biaxial strain e and tension give an initial guess for E: N₀ = E t e/(1−ν), of size q = e
  /// √(2/(1−ν)).
  std::optional<Identification> identification() const override {
    if (!setup_.identify_degree) return std::nullopt;
    Identification wanted{"height", setup_.heights, *setup_.identify_degree, setup_.identify_up_to, {}};
    for (std::size_t step = 0; step < setup_.heights.size(); ++step) {
      const auto [cap, stretch] = cap_of(setup_.heights[step]);
      const double strain = stretch - 1, tension = setup_.pressures[step] * cap / 2 * stretch;
      wanted.guess.push_back(
          {strain * std::sqrt(2 / (1 - poissons_ratio_)), (1 - poissons_ratio_) * tension / (thickness_ * strain)});
      if (setup_.identify_up_to == 0) wanted.up_to = std::max(wanted.up_to, 1.5 * wanted.guess.back().strain);
    }
    return wanted;
  }

 private:
  friend class BubbleRig;
  struct Cap {
    double radius, stretch;  ///< [m]; arc over chord
  };
  Cap cap_of(double height) const {
    const double half_angle = 2 * std::atan2(height, radius_);
    return {(radius_ * radius_ + height * height) / (2 * height), half_angle / std::sin(half_angle)};
  }

  /// Fits in even powers of the distance from the pole, over the inner 35 % of the rest radius or the three innermost
  /// rings. Where there are too few molecules for that, nothing is measured.
  void add_pole(const Model& model, const Positions& positions, Measures& measures) const {
    const double reach = std::max(0.35, 3.1 * body_.connections.rest_length[0] / radius_);
    const double top = axis_.dot(positions.col(pole_) - centre_);
    std::vector<double> rest2, radial, drop, chord2;
    for (int molecule = 0; molecule < body_.size(); ++molecule) {
      const double rest = rest_radius_[molecule];
      if (rest > reach) continue;
      const Vector3 displacement = positions.col(molecule) - centre_;
      const double along = axis_.dot(displacement), r = (displacement - along * axis_).norm();
      const double below = (top - along) / radius_;
      drop.push_back(below), chord2.push_back(r * r / (radius_ * radius_) + below * below);
      if (molecule != pole_) rest2.push_back(rest * rest), radial.push_back(r / (rest * radius_));
    }
    if (rest2.size() < 12) return;
    const double stretch = fit(rest2, radial, 3)[0];
    measures.set("pole_stretch", stretch);
    measures.set("pole_radius", radius_ / 2 * fit(drop, chord2, 3)[1]);  // on a sphere r² + d² = 2 R d
    std::vector<double> at, tension;
    const std::vector<Matrix3> tensions = triangle_tensions(model, positions);
    for (std::size_t cell = 0; cell < tensions.size(); ++cell) {
      const auto& [a, b, c] = body_.triangles[cell];
      const Vector3 middle = (body_.rest.col(a) + body_.rest.col(b) + body_.rest.col(c)) / 3 - centre_;
      if (middle.norm() > reach * radius_) continue;
      at.push_back(middle.squaredNorm() / (radius_ * radius_)), tension.push_back(tensions[cell].trace() / 2);
    }
    measures.set("pole_stress", fit(at, tension, 3)[0] * stretch / thickness_);
  }

  const Body& body_;
  BubbleSetup setup_;
  double thickness_, stiffness_ = 0, poissons_ratio_ = 0;
  std::vector<int> rim_;
  Vector3 centre_ = Vector3::Zero(), axis_ = Vector3::Zero();
  double radius_ = 0;                // a [m]
  std::vector<double> rest_radius_;  // of each molecule over a
  int pole_ = 0;
};

class BubbleRig final : public StaticRig {
 public:
  BubbleRig(const Bubble& experiment, Model& model)
      : experiment_(experiment), setup_(experiment.setup_), body_(experiment.body_), model_(model) {
    for (const int molecule : experiment_.rim_) model.supports.push_back({molecule, Matrix3::Zero(), Vector3::Zero()});
    auto pressure = std::make_unique<Pressure>(model.body(), constant_pressure(0), experiment_.centre_, true);
    load_ = pressure.get();
    model.add(std::move(pressure));
  }

  void set_load(double factor) override {
    // Load step k of n stands at the factor k/n; on the way between two the pressure grows evenly.
    const double at = factor * static_cast<double>(setup_.pressures.size());
    const int before = std::clamp(static_cast<int>(at), 0, experiment_.load_steps() - 1);
    const double low = before == 0 ? 0 : setup_.pressures[static_cast<std::size_t>(before) - 1];
    pressure_ = low + (at - before) * (setup_.pressures[before] - low);
    load_->set_law(constant_pressure(pressure_));
  }

  /// A flat membrane has no stiffness across: a paraboloid as high as a bubble of this stiffness about is.
  void shape_start(Positions& positions) const override {
    const double height =
        experiment_.radius_ * std::min(0.5, 0.66 * std::cbrt(pressure_ * experiment_.radius_ / experiment_.stiffness_));
    for (int molecule = 0; molecule < body_.size(); ++molecule) {
      const double r = experiment_.rest_radius_[molecule];
      positions.col(molecule) += height * std::max(0., 1 - r * r) * experiment_.axis_;
    }
  }

  Measures measure(const Start&, const State& state, const StaticOptions&, StaticResult& solved) const override {
    const Positions& positions = state.positions;
    Measures measures;
    const double height = experiment_.axis_.dot(positions.col(experiment_.pole_) - body_.rest.col(experiment_.pole_));
    measures.set("pressure", pressure_);
    measures.set("height", height);
    experiment_.add_pole(model_, positions, measures);
    const auto [cap, stretch] = experiment_.cap_of(height);
    measures.set("cap_radius", cap);
    measures.set("stretch", stretch);
    measures.set("strain", stretch - 1);
    measures.set("stress", pressure_ * cap * stretch * stretch / (2 * experiment_.thickness_));
    const auto step = static_cast<std::size_t>(measured_step());
    if (!setup_.heights.empty()) {
      measures.set("measured_height", setup_.heights[step]);
      measures.set("height_misfit", height / setup_.heights[step] - 1);
    }
    add_state(model_, state, solved, std::abs(pressure_) * std::numbers::pi * experiment_.radius_ * experiment_.radius_,
              measures);
    return measures;
  }

 private:
  /// The step whose pressure is on now.
  int measured_step() const {
    const auto& all = setup_.pressures;
    return static_cast<int>(
        std::min_element(all.begin(), all.end(),
                         [&](double a, double b) { return std::abs(a - pressure_) < std::abs(b - pressure_); }) -
        all.begin());
  }

  const Bubble& experiment_;
  const BubbleSetup& setup_;
  const Body& body_;
  Model& model_;
  Pressure* load_ = nullptr;  // owned by the model
  double pressure_ = 0;
};

std::unique_ptr<StaticRig> Bubble::make_rig(Model& model) const { return std::make_unique<BubbleRig>(*this, model); }

}  // namespace

std::unique_ptr<StaticExperiment> make_bubble(const Body& body, const BubbleSetup& setup, const Material& material) {
  return std::make_unique<Bubble>(body, setup, material);
}

namespace {

struct BubbleKeys : BubbleSetup {
  std::optional<double> last_pressure;  ///< [Pa] that equal steps reach
  int load_steps = 1;
  std::optional<int> degree;  ///< of the material that is to be found
};

/// The next of ascending pressures [Pa].
double next_pressure(const Reader& reader, double before) {
  const double pressure = reader.quantity(dimension::pressure, kPositive);
  if (!(pressure > before)) reader.fail("'" + reader.text() + "' is not above the pressure before it");
  return pressure;
}

/// A text file in the scene's folder: a line a point, "5000 Pa, 17 mm"; lines that begin with a letter or # say
/// nothing.
void read_table(const Reader& reader, BubbleSetup& setup) {
  const std::string path = (std::filesystem::path(reader.file_path()).parent_path() / reader.text()).string();
  std::ifstream stream(path);
  if (!stream) reader.fail("'" + reader.text() + "': " + missing_file(path));
  double before = 0;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#' ||
        std::isalpha(static_cast<unsigned char>(line[0])))
      continue;
    const SourceLocation location{path, number, 1};
    const std::size_t comma = line.find(',');
    if (comma == std::string::npos)
      throw InputError(location, "'" + line + "': write \"pressure, height\", with units");
    const auto read = [&](std::string text, const Dimension& dimension, double above) {
      text.erase(text.find_last_not_of(" \t\r") + 1);
      text.erase(0, text.find_first_not_of(" \t"));
      try {
        const Quantity quantity = parse_quantity(text, dimension);
        if (!quantity.has_unit)
          throw InputError("'" + text + "' has no unit; write for example " + unit_examples(dimension));
        if (!(quantity.value > above))
          throw InputError("'" + text + "' must be above " + (above > 0 ? "the line's before" : "0"));
        return quantity.value;
      } catch (const InputError& error) {
        throw InputError(location, error.what());
      }
    };
    setup.pressures.push_back(before = read(line.substr(0, comma), dimension::pressure, before));
    setup.heights.push_back(read(line.substr(comma + 1), dimension::length, 0));
  }
  if (setup.pressures.empty()) reader.fail("'" + reader.text() + "' has no point");
}

/// measured: [[5000 Pa, 17 mm], …] or the name of a file
void read_measured(const Reader& reader, BubbleSetup& setup) {
  if (reader.is_text()) return read_table(reader, setup);
  double before = 0;
  for (const Reader& item : reader.items()) {
    const auto pair = item.items(2);
    before = next_pressure(pair[0], before);
    setup.pressures.push_back(before);
    setup.heights.push_back(pair[1].quantity(dimension::length, kPositive));
  }
  if (setup.pressures.empty()) reader.fail("names no point; write [[pressure, height], ...]");
}

void read_pressures(const Reader& pressure, BubbleKeys& setup, const Frame&) {
  if (pressure.is_text()) {
    setup.last_pressure = pressure.quantity(dimension::pressure, kPositive);
    return;
  }
  double before = 0;
  for (const Reader& item : pressure.items()) setup.pressures.push_back(before = next_pressure(item, before));
  if (setup.pressures.empty()) pressure.fail("names no pressure");
}

std::string too_few_points(const BubbleKeys& setup) {
  if (!setup.identify_degree || static_cast<int>(setup.heights.size()) > *setup.identify_degree) return "";
  if (setup.heights.empty()) return "needs `measured`: [[pressure, height], ...] or a file";
  return "a polynomial of degree " + std::to_string(*setup.identify_degree) + " needs at least " +
         std::to_string(*setup.identify_degree + 1) + " measured points";
}

}  // namespace

ExperimentInfo bubble_row() {
  return with_keys(
      {.name = "bubble",
       .summary = "a flat disc, fixed at its rim, is inflated from one side: height, stretch and stress at the pole",
       .source = "[TP], eqs 18-25",
       .measures = bubble_measures()},
      Keys<BubbleKeys>{
          one_of<BubbleKeys>(
              "key 'pressure' is missing",
              {{{"pressure", "quantity, or list", "Pa", "> 0", "",
                 "the pressure that `load_steps` reach, or one pressure for each step, ascending"},
                read_pressures},
               {{"measured", "list of pairs, or file in the scene's folder", "Pa, m", "> 0", "",
                 "`[pressure, height]`, ascending; a file has one pair in each line, with units"},
                [](const Reader& value, BubbleKeys& setup, const Frame&) { read_measured(value, setup); }}})
              .naming_the_second(),
          load_steps_key(&BubbleKeys::load_steps).refused_for([](const BubbleKeys& setup) {
            return setup.load_steps > 1 && !setup.last_pressure ? "a list of pressures has a load step for each" : "";
          }),
          key::below(
              "identify",
              Keys<BubbleKeys>{key::whole("degree", &BubbleKeys::degree, 0, 6,
                                          "finds the secant modulus E(ε) from the measured heights: degree of the "
                                          "polynomial")
                                   .otherwise("2"),
                               key::quantity("up_to", &BubbleKeys::identify_up_to, dimension::none,
                                             "strain up to which it counts", kPositive)
                                   .otherwise("1.5 × the cap's strain")})
              .then([](const Reader&, BubbleKeys& setup) { setup.identify_degree = setup.degree.value_or(2); })
              .refused_for(too_few_points)},
      [](const ExperimentContext& context, BubbleKeys setup) {
        if (setup.last_pressure)
          for (int step = 1; step <= setup.load_steps; ++step)
            setup.pressures.push_back(*setup.last_pressure * step / setup.load_steps);
        if (context.statics.linear)
          throw InputError("a flat membrane cannot resist pressure under small displacements");
        return make_bubble(context.body, setup, context.material);
      });
}

}  // namespace elastin::lab
