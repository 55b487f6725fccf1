// The page that compare leaves: what stands in it, and what a browser makes of it, where one is installed.

#include "lab/report/page.h"

#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>

#include "lab/report/view.h"
#include "lab/study/journal.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;

namespace {

const std::string kScene = R"(title: "<script>alert('no')</script> & \"co\""
body:
  lattice: {kind: cubic, molecules: [4, 4, 4], spacing: 1 mm, connections: [axis, face]}
  cells: delaunay
material: {youngs_modulus: 5 kPa, poissons_ratio: 0.25}
stiffness: lattice
strategies: [standard, lattice, neo_hookean, "calibrated:standard"]
experiment: {kind: tension, axis: z, displacement: 0.3 mm, load_steps: 3}
)";

int run(const std::string& line) {
  const int status = std::system(line.c_str());
  REQUIRE(WIFEXITED(status));
  return WEXITSTATUS(status);
}

std::string browser() {
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"})
    if (run(std::string("command -v ") + name + " > /dev/null") == 0) return name;
  return "";
}

/// The page of two scenes, in the folder's out/.
std::string page_of(const TemporaryFolder& folder) {
  folder.write("first.yaml", kScene);
  folder.write("second.yaml", kScene);
  REQUIRE(run("cd '" + folder.path("") +
              "' && '" ELASTIN_COMMAND "' compare first.yaml second.yaml --quiet --out out") == 0);
  return text_of_file(folder.path("out/report.html"));
}

int count(const std::string& text, const std::string& what) {
  int found = 0;
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += what.size()) ++found;
  return found;
}

}  // namespace

TEST_CASE("the page stands alone and says no more than text", "[page]") {
  const TemporaryFolder folder;
  const std::string page = page_of(folder);
  CHECK_FALSE(std::regex_search(page, std::regex("(src|href)\\s*=\\s*[\"']|@import|url\\(")));
  CHECK_THAT(page, !Contains("<script>alert") &&
                       Contains("&lt;script&gt;alert(&#39;no&#39;)&lt;/script&gt; &amp; &quot;co&quot;"));
  CHECK_THAT(page, !Contains("nan,") && !Contains(":null") && !Contains("NaN}"));
  CHECK(count(page, "<article class=\"scene\"") == 2);
  CHECK(count(page, "<canvas") == 2);
  CHECK(count(page, "<script type=\"application/json\"") == 2 * (1 + 4));  // a body and four strategies each
  CHECK_THAT(page, Contains("class=\"advice") && Contains("Error against time") && Contains("stress over strain"));
  CHECK(std::filesystem::exists(folder.path("out/first-error.svg")));
  CHECK(std::filesystem::exists(folder.path("out/first-course.svg")));
}

TEST_CASE("places and tensions come through base64 as they are", "[page]") {
  CHECK(base64("", 0).empty());  // RFC 4648, section 10
  CHECK(base64("f", 1) == "Zg==");
  CHECK(base64("fo", 2) == "Zm8=");
  CHECK(base64("foobar", 6) == "Zm9vYmFy");
  const TemporaryFolder folder;
  page_of(folder);
  const auto views = lines_of(folder.path("out/views.jsonl"));
  REQUIRE(views.size() == 2 * 5);
  const auto body = nlohmann::json::parse(views[0]), states = nlohmann::json::parse(views[1]);
  CHECK(body["rest"].get<std::string>().size() == 64 * 3 * 4 / 3 * 4);  // 64 molecules, three floats each
  CHECK(states["frames"].size() == 4);                                  // rest and three steps
  const double most = states["frames"][3]["most"];
  CHECK(most > 0);
  CHECK(states["frames"][0]["most"] < 1e-9 * most);
}

TEST_CASE("a browser draws the page without an error", "[page][browser]") {
  const std::string chromium = browser();
  if (chromium.empty()) {
    WARN("no Chromium here: the page was not looked at");
    return;
  }
  const TemporaryFolder folder;
  page_of(folder);
  const std::string line =
      chromium +
      " --headless --no-sandbox --disable-dev-shm-usage --use-angle=swiftshader "
      "--enable-unsafe-swiftshader --enable-logging=stderr --virtual-time-budget=3000 --user-data-dir='" +
      folder.path("profile") + "' --dump-dom 'file://" + folder.path("out/report.html") + "' > '" + folder.path("dom") +
      "' 2> '" + folder.path("log") + "'";
  REQUIRE(run(line) == 0);
  const std::string dom = text_of_file(folder.path("dom"));
  CHECK_THAT(dom, Contains("data-ready=\"yes\"") && !Contains("data-errors"));
  CHECK_THAT(text_of_file(folder.path("log")), !Contains("CONSOLE"));
  std::smatch pixels;  // one scene is shown, the other waits
  REQUIRE(std::regex_search(dom, pixels, std::regex("data-pixels=\"([0-9]+)\"")));
  CHECK(std::stoi(pixels[1]) > 5000);
  CHECK(count(dom, "data-pixels") == 1);
  CHECK_THAT(dom, Contains("arrow keys turn it") && Contains(" (best)</option>"));
  CHECK(count(dom, "class=\"mark\"") >= 4);
}
