#include "lab/report/page_frame.h"

#include <fmt/format.h>

#include "lab/report/page_parts.h"

namespace elastin::lab {
namespace {

constexpr double kWide = 600, kNarrow = 360;  // px, of plots: on a page, on a phone

}  // namespace

std::string page_begin(const std::string& title, const std::string& brand) {
  return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
         "content=\"width=device-width, initial-scale=1\"><title>" +
         escaped(title) + " — Elastin</title>\n<style>" + k_page_css +
         "</style></head>\n<body>\n<header><p class=\"brand\">" + escaped(brand) + "</p>";
}

std::string figure_html(const Plot& plot, const std::string& heading, const std::string& name) {
  if (plot.series.empty()) return "";
  const auto classed = [&](double width, const char* kind) {
    return svg_text(plot, width, false).insert(4, fmt::format(" class=\"{}\"", kind));
  };
  return fmt::format(
      "<section class=\"card\"><div class=\"bar\"><h2>{0}</h2><button type=\"button\" data-save=\"svg\" "
      "data-name=\"{1}\">SVG"
      "</button><button type=\"button\" data-save=\"png\" "
      "data-name=\"{1}\">PNG</button></div><figure>{2}{3}</figure><script type=\"application/json\" class=\"plot\">{4}"
      "</script></section>\n",
      escaped(heading), escaped(name), classed(kWide, "wide"), classed(kNarrow, "narrow"), plot_json(plot));
}

std::string card_html(const std::string& heading, const std::string& inside) {
  return "<section class=\"card\"><h2>" + escaped(heading) + "</h2>" + inside + "</section>\n";
}

}  // namespace elastin::lab
