#include "lab/experiment/bubble/bubble.h"

#include <cctype>
#include <filesystem>
#include <fstream>

#include "lab/experiment/keys.h"

namespace elastin::lab {

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

/// A text file beside the scene: a line a point, "5000 Pa, 17 mm"; lines that begin with a letter or # say nothing.
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
               {{"measured", "list of pairs, or file beside the scene", "Pa, m", "> 0", "",
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
