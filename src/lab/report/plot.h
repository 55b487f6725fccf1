#pragma once
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace elastin::lab {

/// Colours of series: `kPlotHues` families, each in `kPlotShades` shades with marks of their own.
inline constexpr int kPlotHues = 16, kPlotShades = 4;

/// One axis of a plot. Values are SI; ticks show them with a prefix, in per cent where the unit is "%".
struct PlotAxis {
  std::string title, unit;
  bool logarithmic = false;
  bool operator==(const PlotAxis&) const = default;
};

struct PlotPoint {
  double x = 0, y = 0;  ///< above 0 on a logarithmic axis
  std::string text;     ///< tooltip; empty = the point has none
};

struct PlotSeries {
  enum class Kind { marks, line, marked_line, dashed, staircase };
  std::string name;  ///< in the legend; empty = not there
  int colour = 0;  ///< hue + kPlotHues × shade, and with the shade the mark's shape; -1, -2, … = grey, of each shape
  Kind kind = Kind::marks;
  std::vector<PlotPoint> points;
};

struct Plot {
  std::string title;
  PlotAxis x, y;
  std::vector<PlotSeries> series;
  double level = std::numeric_limits<double>::quiet_NaN();  ///< of y, to be marked across; NaN = none
  std::string level_text;
};

/// The series of this name, which is added with marks and lines where the plot has none. Valid until another is added.
PlotSeries& series_of(Plot& plot, const std::string& name, int colour);

/// The plot as an SVG, `width` [px] wide. `alone`: a file of its own with title, background and styles; otherwise part
/// of a page whose styles it takes. Points that are not finite, or not above 0 on a logarithmic axis, are left out.
std::string svg_text(const Plot& plot, double width, bool alone);

/// The named plots over each other, in colours of their own; a plot's only series has the plot's name. One plot stays
/// as it is. Throws InputError where their axes differ.
Plot overlaid(const std::vector<std::pair<std::string, Plot>>& plots);

/// What a page needs to draw the same plot again in another range: axes, and the points of each series that svg_text
/// draws, in its order. JSON without "<".
std::string plot_json(const Plot& plot);

/// "#3b82f6": of a series on the page, in and next to plots.
std::string plot_colour(int colour);

/// A text with what HTML, XML and their attributes read as their own made harmless; bytes that no XML may hold go.
std::string escaped(const std::string& text);

}  // namespace elastin::lab
