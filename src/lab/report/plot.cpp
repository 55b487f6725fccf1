#include "lab/report/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "elastin/core/base/error.h"
#include "lab/report/screen.h"

namespace elastin::lab {
namespace {

/// Red, green, blue of families of series; each has shades, and each shade a mark of its own.
constexpr std::array<std::array<int, 3>, kPlotHues> kHues{{{59, 130, 246},
                                                           {245, 158, 11},
                                                           {16, 185, 129},
                                                           {239, 68, 68},
                                                           {139, 92, 246},
                                                           {236, 72, 153},
                                                           {6, 182, 212},
                                                           {132, 204, 22},
                                                           {249, 115, 22},
                                                           {161, 98, 7},
                                                           {100, 116, 139},
                                                           {180, 60, 200},
                                                           {20, 120, 110},
                                                           {210, 190, 20},
                                                           {30, 64, 175},
                                                           {150, 30, 60}}};
/// What a shade is mixed with, and how much of it.
constexpr std::array<std::pair<int, double>, kPlotShades> kShades{{{0, 0}, {255, 0.45}, {0, 0.35}, {150, 0.55}}};
constexpr double kGamma = 2.2;
/// Relative luminance of a colour that has a contrast of 3 : 1 to the paper of the light theme and of the dark one.
/// [WCAG]
constexpr double kDarkest = 0.14, kLightest = 0.29;
constexpr double kFont = 12, kLetter = 7.3;  // px

/// Of the target, so that it is seen on a curve that follows it.
constexpr const char* kInk = "var(--ink)";

constexpr const char* kStyle =
    "svg{--ink:#1b1f27;--faint:#667085;--grid:#e3e6ec;--paper:#fff;font:12px system-ui,sans-serif}"
    "@media(prefers-color-scheme:dark){svg{--ink:#e8eaf0;--faint:#98a1b3;--grid:#2b303b;--paper:#14161c}}"
    "text{fill:var(--faint)}.head,.axis{fill:var(--ink)}.grid{stroke:var(--grid)}";

bool shown(const PlotPoint& point, const Plot& plot) {
  return std::isfinite(point.x) && std::isfinite(point.y) && (!plot.x.logarithmic || point.x > 0) &&
         (!plot.y.logarithmic || point.y > 0);
}

struct Tick {
  double value;
  bool labelled;
};

/// Values and ticks of one axis: the range that the points need, rounded outwards.
struct Scale {
  double low, high;  ///< in logarithms on a logarithmic axis
  bool logarithmic;
  std::vector<Tick> ticks;
  double step() const { return logarithmic || ticks.size() < 2 ? 0 : ticks[1].value - ticks[0].value; }
  double fraction(double value) const { return ((logarithmic ? std::log10(value) : value) - low) / (high - low); }
};

Scale logarithmic_scale(double least, double most) {
  Scale scale{std::log10(least), std::log10(most), true, {}};
  const bool fine = scale.high - scale.low < 2.5;  // 1, 2, 5 of each decade are labelled
  const auto below = [&](double v) {
    const double decade = std::floor(v + 1e-9), mantissa = std::pow(10., v - decade);
    if (!fine) return decade;
    return decade + std::log10(mantissa >= 5 - 1e-9 ? 5 : mantissa >= 2 - 1e-9 ? 2 : 1);
  };
  const auto above = [&](double v) {
    const double decade = std::floor(v - 1e-9), mantissa = std::pow(10., v - decade);
    if (!fine) return decade + 1;
    return decade + std::log10(mantissa <= 2 + 1e-9 ? 2 : mantissa <= 5 + 1e-9 ? 5 : 10);
  };
  scale.low = below(scale.low);
  scale.high = above(scale.high);
  if (scale.high - scale.low < 0.2) scale.high += 0.4;
  const int every = std::max(1, static_cast<int>(std::ceil((scale.high - scale.low) / 8)));
  for (int decade = static_cast<int>(std::floor(scale.low)); decade <= scale.high; ++decade)
    for (int digit = 1; digit < 10; ++digit) {
      const double at = decade + std::log10(digit);
      if (at < scale.low - 1e-9 || at > scale.high + 1e-9 || (digit > 1 && every > 1)) continue;
      const bool labelled = digit == 1 ? decade % every == 0 : fine && (digit == 2 || digit == 5);
      scale.ticks.push_back({std::pow(10., at), labelled});
    }
  return scale;
}

Scale linear_scale(double least, double most) {
  if (least > 0 && least < 0.5 * most) least = 0;  // far from zero there is nothing to see
  if (most < 0 && most > 0.5 * least) most = 0;
  if (most - least <= 1e-12 * std::abs(most)) {
    least = std::min(0., least);
    most = most > least ? most : least + 1;
  }
  const double raw = (most - least) / 5, decade = std::pow(10., std::floor(std::log10(raw)));
  const double step = decade * (raw / decade <= 1 ? 1 : raw / decade <= 2 ? 2 : raw / decade <= 5 ? 5 : 10);
  Scale scale{std::floor(least / step + 1e-9) * step, std::ceil(most / step - 1e-9) * step, false, {}};
  for (int i = 0; scale.low + i * step < scale.high + step / 2; ++i)
    scale.ticks.push_back({scale.low + i * step, true});
  return scale;
}

Scale scale_of(const Plot& plot, const PlotAxis& axis, double PlotPoint::*value, double level) {
  double least = INFINITY, most = -INFINITY;
  const auto take = [&](double v) {
    least = std::min(least, v);
    most = std::max(most, v);
  };
  for (const PlotSeries& series : plot.series)
    for (const PlotPoint& point : series.points)
      if (shown(point, plot)) take(point.*value);
  if (std::isfinite(level) && (!axis.logarithmic || level > 0)) take(level);
  if (least > most) least = most = 1;
  return axis.logarithmic ? logarithmic_scale(least, most) : linear_scale(least, most);
}

/// The prefix of the labels of all ticks of an axis.
std::pair<double, std::string> prefix_of(const std::string& unit, double size) {
  constexpr std::pair<double, const char*> prefixes[]{{1e9, "G"},  {1e6, "M"},  {1e3, "k"}, {1, ""},
                                                      {1e-3, "m"}, {1e-6, "µ"}, {1e-9, "n"}};
  if (unit == "%") return {0.01, "%"};
  if (unit.empty() || unit.find_first_of("/^") != std::string::npos) return {1, unit};
  for (const auto& [factor, letter] : prefixes)
    if (size >= factor * 0.999) return {factor, letter + unit};
  return {1, unit};
}

/// `step`: to the next tick of a linear axis, 0 on a logarithmic one.
std::string tick_text(double value, const PlotAxis& axis, double step) {
  const auto [factor, unit] = prefix_of(axis.unit, std::abs(value));
  const double shown = value / factor, finest = step > 0 ? step / factor : std::abs(shown);
  // 0.00001 %, not 1e-05 %
  const bool small = finest > 0 && finest < 1e-3 && finest > 1e-9;
  const int digits = small ? static_cast<int>(std::ceil(-std::log10(finest) - 1e-9)) : 0;
  const std::string number = small && shown != 0 ? fmt::format("{:.{}f}", shown, digits) : fmt::format("{:g}", shown);
  return number + (unit.empty() ? "" : " ") + unit;
}

/// Of the labels of an axis, in px.
double widest_label(const Scale& scale, const PlotAxis& axis) {
  std::size_t letters = 0;
  for (const auto& [value, labelled] : scale.ticks)
    if (labelled) letters = std::max(letters, tick_text(value, axis, scale.step()).size());
  return kLetter * static_cast<double>(letters);
}

/// A plot on its paper: where values lie, in px.
struct Sheet {
  const Plot& plot;
  Scale x, y;
  double width, left, top, right, bottom;
  std::string out;
  double px(double value) const { return left + x.fraction(value) * (right - left); }
  double py(double value) const { return bottom - y.fraction(value) * (bottom - top); }
  template <class... Parts>
  void add(fmt::format_string<Parts...> text, Parts&&... parts) {
    fmt::format_to(std::back_inserter(out), text, std::forward<Parts>(parts)...);
  }
};

void add_grid(Sheet& sheet) {
  sheet.add("<g class=\"ticks\">");
  double free_from = 0;  // labels that would run into the one before are left out
  for (const auto& [value, labelled] : sheet.x.ticks) {
    sheet.add("<path class=\"grid\" d=\"M{0:.1f} {1:.1f}V{2:.1f}\" opacity=\"{3}\"/>", sheet.px(value), sheet.top,
              sheet.bottom, labelled ? 1 : 0.5);
    const std::string label = labelled ? tick_text(value, sheet.plot.x, sheet.x.step()) : "";
    const double half = kLetter / 2 * static_cast<double>(label.size()), at = sheet.px(value);
    if (label.empty() || at - half < free_from) continue;
    free_from = at + half + kLetter;
    sheet.add("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>", at, sheet.bottom + 18,
              escaped(label));
  }
  for (const auto& [value, labelled] : sheet.y.ticks) {
    sheet.add("<path class=\"grid\" d=\"M{:.1f} {:.1f}H{:.1f}\" opacity=\"{}\"/>", sheet.left, sheet.py(value),
              sheet.right, labelled ? 1 : 0.5);
    if (labelled)
      sheet.add("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>", sheet.left - 7, sheet.py(value) + 4,
                escaped(tick_text(value, sheet.plot.y, sheet.y.step())));
  }
  sheet.add("</g><text class=\"axis\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{} →</text>", sheet.right,
            sheet.bottom + 38, escaped(sheet.plot.x.title));
  sheet.add("<text class=\"axis\" x=\"8\" y=\"{:.1f}\">↑ {}</text>", sheet.top - 12, escaped(sheet.plot.y.title));
  if (std::isfinite(sheet.plot.level) && (!sheet.y.logarithmic || sheet.plot.level > 0))
    sheet.add(
        "<g class=\"level\"><path d=\"M{0:.1f} {1:.1f}H{2:.1f}\" stroke=\"var(--faint)\" stroke-dasharray=\"2 4\"/>"
        "<text x=\"{2:.1f}\" y=\"{3:.1f}\" text-anchor=\"end\">{4}</text></g>",
        sheet.left, sheet.py(sheet.plot.level), sheet.right, sheet.py(sheet.plot.level) - 5,
        escaped(sheet.plot.level_text));
}

void add_mark(Sheet& sheet, double x, double y, int colour, double r) {
  const std::string fill = plot_colour(colour);
  switch ((colour < 0 ? -1 - colour : colour / kPlotHues) % kPlotShades) {
    case 0:
      return sheet.add("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\" fill=\"{}\"/>", x, y, r, fill);
    case 1:
      return sheet.add("<rect x=\"{0:.1f}\" y=\"{1:.1f}\" width=\"{2}\" height=\"{2}\" fill=\"{3}\"/>", x - r * 0.9,
                       y - r * 0.9, r * 1.8, fill);
    case 2:
      return sheet.add("<path d=\"M{0:.1f} {1:.1f}l{2} {2} -{2} {2} -{2} -{2}z\" fill=\"{3}\"/>", x, y - r * 1.2,
                       r * 1.2, fill);
    default:
      return sheet.add("<path d=\"M{0:.1f} {1:.1f}l{2} {3}h-{4}z\" fill=\"{5}\"/>", x, y - r * 1.1, r * 1.15, r * 2,
                       r * 2.3, fill);
  }
}

void add_line(Sheet& sheet, const PlotSeries& series) {
  using Kind = PlotSeries::Kind;
  std::string path;
  bool gap = true;  // before the next point
  for (const PlotPoint& point : series.points) {
    if (!shown(point, sheet.plot)) {
      gap = true;
      continue;
    }
    const double x = sheet.px(point.x), y = sheet.py(point.y);
    path += std::exchange(gap, false)        ? fmt::format("M{:.1f} {:.1f}", x, y)
            : series.kind == Kind::staircase ? fmt::format("H{:.1f}V{:.1f}", x, y)
                                             : fmt::format("L{:.1f} {:.1f}", x, y);
  }
  if (path.empty()) return;
  const bool dashed = series.kind == Kind::dashed || series.kind == Kind::staircase;
  sheet.add(
      "<path class=\"line\" d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"{} stroke-linejoin=\"round\"/>",
      path, series.kind == Kind::dashed ? kInk : plot_colour(series.colour), dashed ? 1.3 : 2,
      dashed ? " stroke-dasharray=\"5 4\"" : "");
}

void add_series(Sheet& sheet, const PlotSeries& series) {
  using Kind = PlotSeries::Kind;
  sheet.add("<g class=\"series\" data-series=\"{}\">", escaped(series.name));
  if (series.kind != Kind::marks) add_line(sheet, series);
  for (const PlotPoint& point : series.points) {
    if (!shown(point, sheet.plot) || (series.kind != Kind::marks && series.kind != Kind::marked_line)) continue;
    const std::string text = escaped(point.text);
    if (!text.empty())
      sheet.add("<g class=\"mark\" tabindex=\"0\" role=\"img\" aria-label=\"{0}\"><title>{0}</title>", text);
    add_mark(sheet, sheet.px(point.x), sheet.py(point.y), series.colour, text.empty() ? 3 : 5.5);
    if (!text.empty()) sheet.add("</g>");
  }
  sheet.add("</g>");
}

/// The last letters of a name, as many as fit.
std::string fitting(std::string name, double wide) {
  const auto most = static_cast<std::size_t>(std::max(2., wide / kLetter));
  if (shown_width(name) <= most) return name;
  while (shown_width(name) >= most) name.erase(0, 1);
  while (shown_width(name.substr(0, 1)) == 0) name.erase(0, 1);  // the rest of a letter of several bytes
  return "…" + name;
}

/// Names side by side in as many lines as they need; returns the lowest of them.
double add_legend(Sheet& sheet, double top) {
  double x = sheet.left, y = top;
  for (const PlotSeries& series : sheet.plot.series) {
    if (series.name.empty()) continue;
    const std::string name = fitting(series.name, sheet.width - sheet.left - 30);
    const double wide = 26 + kLetter * static_cast<double>(shown_width(name));
    if (x > sheet.left && x + wide > sheet.width - 4) {
      x = sheet.left;
      y += 19;
    }
    sheet.add("<g class=\"key\" data-series=\"{}\">", escaped(series.name));
    if (series.kind == PlotSeries::Kind::dashed)
      sheet.add("<path d=\"M{:.1f} {:.1f}h14\" stroke=\"{}\" stroke-width=\"1.3\" stroke-dasharray=\"5 4\"/>", x - 1,
                y - 4, kInk);
    else
      add_mark(sheet, x + 6, y - 4, series.colour, 5);
    sheet.add("<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text></g>", x + 17, y, escaped(name));
    x += wide;
  }
  return y;
}

}  // namespace

PlotSeries& series_of(Plot& plot, const std::string& name, int colour) {
  for (PlotSeries& series : plot.series)
    if (series.name == name) return series;
  plot.series.push_back({name, colour, PlotSeries::Kind::marked_line, {}});
  return plot.series.back();
}

std::string plot_colour(int colour) {
  if (colour < 0) return colour >= -kPlotShades ? "#7e8799" : "#94806a";  // a cold grey, then a warm one
  const auto& hue = kHues[colour % kPlotHues];
  const auto& [other, share] = kShades[colour / kPlotHues % kPlotShades];
  std::array<double, 3> light{};  // linear
  for (std::size_t i = 0; i < 3; ++i) light[i] = std::pow((hue[i] + share * (other - hue[i])) / 255, kGamma);
  const double own = 0.2126 * light[0] + 0.7152 * light[1] + 0.0722 * light[2],
               wanted = std::clamp(own, kDarkest, kLightest);
  std::string out = "#";
  for (const double part : light) {
    const double seen = wanted <= own ? part * wanted / own : part + (wanted - own) / (1 - own) * (1 - part);
    out += fmt::format("{:02x}", std::lround(255 * std::pow(seen, 1 / kGamma)));
  }
  return out;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else if (c == '\'')
      out += "&#39;";
    else if (byte >= 0x20 || c == '\n' || c == '\t')
      out += c;
  }
  return out;
}

std::string svg_text(const Plot& plot, double width, bool alone) {
  constexpr double title_font = 15, title_line = 20;  // px
  const std::vector<std::string> title =
      folded(plot.title, static_cast<std::size_t>(std::max(20., (width - 16) / (kLetter * title_font / kFont))));
  const double top = alone ? 62 + title_line * static_cast<double>(title.size() - 1) : 30;
  const double high = std::clamp(width * 0.5, 250., 400.);
  const Scale x = scale_of(plot, plot.x, &PlotPoint::x, NAN), y = scale_of(plot, plot.y, &PlotPoint::y, plot.level);
  const double left = std::max(64., widest_label(y, plot.y) + 12);
  const double right = width - std::max(26., widest_label(x, plot.x) / 2 + 2);
  Sheet sheet{plot, x, y, width, left, top, right, top + high, ""};
  add_grid(sheet);
  for (const PlotSeries& series : plot.series) add_series(sheet, series);
  const double lowest = add_legend(sheet, sheet.bottom + 62);
  std::string head = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:g} {1:g}\" width=\"{0:g}\" height=\"{1:g}\" "
      "font-size=\"{2:g}\" role=\"group\" aria-label=\"{3}\" data-box=\"{4:.1f} {5:.1f} {6:.1f} {7:.1f}\" "
      "data-range=\"{8:.9g} {9:.9g} {10:.9g} {11:.9g}\">",
      width, lowest + 14, kFont, escaped(plot.title), left, top, right, top + high, x.low, x.high, y.low, y.high);
  if (alone)
    head += fmt::format("<style>{}</style><rect width=\"100%\" height=\"100%\" fill=\"var(--paper)\"/>", kStyle);
  for (std::size_t line = 0; alone && line < title.size(); ++line)
    head += fmt::format("<text class=\"head\" x=\"8\" y=\"{:g}\" font-size=\"{:g}\">{}</text>",
                        26 + title_line * static_cast<double>(line), title_font, escaped(title[line]));
  return head + sheet.out + "</svg>\n";
}

Plot overlaid(const std::vector<std::pair<std::string, Plot>>& plots) {
  if (plots.size() == 1) return plots.front().second;
  Plot all;
  int colours = 0;
  for (const auto& [name, plot] : plots) {
    if (all.series.empty()) {
      all.x = plot.x, all.y = plot.y;
    } else if (plot.x != all.x || plot.y != all.y) {
      const auto axes = [](const Plot& of) {
        const auto text = [](const PlotAxis& axis) {
          return axis.title + (axis.unit.empty() ? "" : " [" + axis.unit + "]");
        };
        return text(of.y) + " over " + text(of.x);
      };
      throw InputError(name + " shows " + axes(plot) + ", and " + plots.front().first + " " + axes(all) +
                       ": plot them one by one, or choose axes that both have");
    }
    all.title += (all.title.empty() ? "" : "; ") + plot.title;
    int own = 0;
    for (PlotSeries series : plot.series) {
      own = std::max(own, series.colour + 1);
      if (plot.series.size() == 1)
        series.name = name;
      else if (!series.name.empty())
        series.name = name + ": " + series.name;
      if (series.colour >= 0) series.colour = (series.colour + colours) % (kPlotHues * kPlotShades);
      all.series.push_back(std::move(series));
    }
    colours += own;
  }
  return all;
}

std::string plot_json(const Plot& plot) {
  using Kind = PlotSeries::Kind;
  const auto axis = [](const PlotAxis& a) {
    return nlohmann::json{{"title", a.title}, {"unit", a.unit}, {"logarithmic", a.logarithmic}};
  };
  nlohmann::json json{{"x", axis(plot.x)}, {"y", axis(plot.y)}, {"series", nlohmann::json::array()}};
  if (std::isfinite(plot.level)) json["level"] = plot.level;
  const auto rounded = [](double value) { return std::stod(fmt::format("{:.7g}", value)); };
  for (const PlotSeries& series : plot.series) {
    nlohmann::json points = nlohmann::json::array();
    for (const PlotPoint& point : series.points)
      if (shown(point, plot)) points.push_back({rounded(point.x), rounded(point.y)});
    json["series"].push_back(
        {{"name", series.name}, {"stairs", series.kind == Kind::staircase}, {"points", std::move(points)}});
  }
  std::string text = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos; at += 6) text.replace(at, 1, "\\u003c");
  return text;
}

}  // namespace elastin::lab
