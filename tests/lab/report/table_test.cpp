#include "lab/report/table.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "lab/report/screen.h"

using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

/// A screen for as long as it lives.
struct Screen {
  explicit Screen(std::size_t width) { set_screen_width(width); }
  ~Screen() { set_screen_width(0); }
};

Table comparison() {
  Table table(
      {"strategy", "E measured", "error of E", "Poisson's ratio", "elongation", "iterations", "build", "solve", ""});
  table.add({{"calibrated:van_gelder+volume"},
             number_cell("8.5978 kPa", 1),
             number_cell("-14.02 %", 1),
             number_cell("0.4254", 1),
             number_cell("6.0000 mm", 1),
             number_cell("16 / 2109", 1),
             number_cell("179.1 ms", 1),
             number_cell("986.0 ms", 1),
             {"not suited: needs tetrahedra or triangles", Tone::bad}});
  table.add({{"standard"},
             number_cell("20.346 kPa", 1),
             number_cell("+103 %", 1),
             number_cell("0.1349", 1),
             number_cell("6.0000 mm", 1),
             number_cell("10 / 917", 1),
             number_cell("146 µs", 1),
             number_cell("106.2 ms", 1),
             {""}});
  return table;
}

std::size_t widest_line(const std::string& text) {
  std::istringstream lines(text);
  std::size_t widest = 0;
  for (std::string line; std::getline(lines, line);) widest = std::max(widest, shown_width(line));
  return widest;
}

}  // namespace

TEST_CASE("a table fits its screen: heads and words are folded, and what can be spared goes", "[files][screen]") {
  const std::string whole = comparison().text(false);
  CHECK(widest_line(whole) > 130);
  CHECK_THAT(whole,
             Contains("iterations") && Contains("build") && Contains("not suited: needs tetrahedra or triangles\n"));
  for (const std::size_t width : {40u, 60u, 80u, 100u, 120u}) {
    INFO(width);
    const Screen screen(width);
    const std::string text = comparison().text(false);
    CHECK(widest_line(text) <= width);
    CHECK_THAT(text, Contains("strategy") && Contains("standard"));
    CHECK(widest_line(comparison().text(false, "      ")) <= width);
  }
  const Screen screen(100);
  const std::string text = comparison().text(false);
  CHECK_THAT(text, Contains("calibrated:van_gelder+volume") && Contains("-14.02 %") && !Contains("iterations"));
  const Screen wide(1000);
  CHECK(comparison().text(false) == whole);
}

TEST_CASE("text is folded at blanks, and no letter is lost", "[files][screen]") {
  using Lines = std::vector<std::string>;
  CHECK(folded("", 5) == Lines{""});
  CHECK(folded("one two", 7) == Lines{"one two"});
  CHECK(folded("one two", 6) == Lines{"one", "two"});
  CHECK(folded("one two", 3) == Lines{"one", "two"});
  CHECK(folded("longest", 3) == Lines{"lon", "ges", "t"});
  CHECK(folded("äöü äöü", 3) == Lines{"äöü", "äöü"});  // columns, not bytes
}

TEST_CASE("the time left moves with the run under way", "[screen]") {
  CHECK(std::isnan(time_left({4, 0, 0, 0}, 3)));  // nothing is known before the first run
  const RunCount count{4, 2, 2, 20};              // 10 s each, two to come
  CHECK(time_left(count, 0) == Approx(20));
  CHECK(time_left(count, 4) == Approx(16));
  CHECK(time_left(count, 10) == Approx(10));
  CHECK(time_left(count, 25) ==
        Approx(10));  // it takes longer than those before, and the last at least as long as they
  CHECK(progress_text(count, 4, "cube, lattice") == "  4 s  run 3 of 4, about 16.00 s left: cube, lattice");
  CHECK(progress_text(count, 25, "cube, lattice") == "  25 s  run 3 of 4, at least 10.00 s left: cube, lattice");
  CHECK(progress_text({4, 3, 3, 30}, 12, "last") == "  12 s  run 4 of 4: last");  // nothing is known any more
  CHECK(progress_text({1, 0, 0, 0}, 4, "reading") == "  4 s  reading");
}
