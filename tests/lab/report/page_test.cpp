// The page that compare leaves: what stands in it, and what a browser makes of it, where one is installed.

#include "lab/report/page.h"

#include <sys/wait.h>
#include <zlib.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>

#include "lab/format/vtu.h"
#include "lab/study/journal.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;
using Catch::Matchers::Contains;
using Json = nlohmann::json;

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

/// What the browser's log says after a driver at the page's end has done what a visitor does; for at most two minutes.
std::string visit(const std::string& chromium, const TemporaryFolder& folder, const std::string& flags) {
  std::string page = page_of(folder);
  page.insert(page.rfind("</body>"),
              "<script>" + text_of_file(ELASTIN_TEST_DATA "/lab/report/page_driver.js") + "</script>");
  folder.write("driven.html", page);
  run("cd '" + folder.path("") + "'; " + chromium +
      " --headless --no-sandbox --disable-gpu --disable-dev-shm-usage --no-first-run --disable-background-networking "
      "--disable-component-update --disable-sync --use-angle=swiftshader --enable-unsafe-swiftshader "
      "--enable-logging=stderr --user-data-dir=profile " +
      flags +
      " \"file://$PWD/driven.html\" > /dev/null 2> log & browser=$!; for wait in $(seq 600); do grep -q DRIVEN log && "
      "break; kill -0 $browser 2> /dev/null || break; sleep 0.2; "
      "done; kill $browser; wait $browser 2> /dev/null; sleep 0.3");  // its helpers still write into the profile
  return text_of_file(folder.path("log"));
}

Json driven(const std::string& log) {
  const std::size_t begin = log.find("DRIVEN {");
  REQUIRE(begin != std::string::npos);
  return Json::parse(log.substr(begin + 7, log.find("}\", source", begin) - begin - 6));
}

std::string inflated_base64(const std::string& text) {
  const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes, out(2'000'000, '\0');
  unsigned bits = 0;
  for (std::size_t i = 0; i < text.size() && text[i] != '='; ++i) {
    bits = bits << 6 | static_cast<unsigned>(letters.find(text[i]));
    if (i % 4 != 0) bytes += static_cast<char>(bits >> (6 - 2 * (i % 4)));
  }
  z_stream stream{};
  REQUIRE(inflateInit2(&stream, 15 + 16) == Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  CHECK(inflate(&stream, Z_FINISH) == Z_STREAM_END);
  out.resize(stream.total_out);
  inflateEnd(&stream);
  return out;
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
  CHECK_FALSE(std::regex_search(page, std::regex("(src|href)\\s*=\\s*[\"']|@import|url\\((?!#)")));
  CHECK_THAT(page, !Contains("<script>alert") &&
                       Contains("&lt;script&gt;alert(&#39;no&#39;)&lt;/script&gt; &amp; &quot;co&quot;"));
  CHECK_THAT(page, !Contains("nan,") && !Contains(":null") && !Contains("NaN}"));
  CHECK(count(page, "<article class=\"scene\"") == 2);
  CHECK(count(page, "<canvas") == 2);
  CHECK(count(page, "<script type=\"application/gzip\" class=\"view\"") ==
        2 * (1 + 4));  // a body and four strategies each
  CHECK_THAT(page, Contains("class=\"advice") && Contains("Error against time") && Contains("stress–strain curve"));
  CHECK(std::filesystem::exists(folder.path("out/first-error.svg")));
  CHECK(std::filesystem::exists(folder.path("out/first-response.svg")));
}

TEST_CASE("positions and tensions come through base64 as they are", "[page]") {
  CHECK(base64("", 0).empty());  // RFC 4648, section 10
  CHECK(base64("f", 1) == "Zg==");
  CHECK(base64("fo", 2) == "Zm8=");
  CHECK(base64("foobar", 6) == "Zm9vYmFy");
  const TemporaryFolder folder;
  page_of(folder);
  const auto views = lines_of(folder.path("out/views.jsonl"));
  REQUIRE(views.size() == 2 * 5);
  const auto body = Json::parse(views[0]), states = Json::parse(views[1]);
  CHECK(body["rest"].get<std::string>().size() == 64 * 3 * 4 / 3 * 4);  // 64 molecules, three floats each
  CHECK(states["frames"].size() == 4);                                  // rest and three steps
  const double most = states["frames"][3]["tensions"]["most"];
  CHECK(most > 0);
  CHECK(states["frames"][0]["tensions"]["most"] < 1e-9 * most);
}

TEST_CASE("a page has the body where the first strategy fails before it has a state", "[page]") {
  const TemporaryFolder folder;
  folder.write("it.yaml",
               "body: {molecules: [[0, 0, 0], [0, 0, 1 cm], [0, 0, 1 cm], [0, 0, 2 cm]],"
               " connections: [[0, 1], [1, 2], [2, 3]], radius: 5 mm}\nmaterial: {youngs_modulus: 10 kPa}\n"
               "stiffness: standard\nexperiment: {kind: tension, axis: z, force: 1 mN, cross_section: 1 cm2,"
               " fixed_grip: clamped, loaded_grip: clamped}\n");
  run("cd '" + folder.path("") +
      "' && '" ELASTIN_COMMAND "' compare it.yaml --strategies standard,uniform --quiet --out out");
  const auto views = lines_of(folder.path("out/views.jsonl"));
  REQUIRE(views.size() == 3);
  CHECK(Json::parse(views[0])["kind"] == "body");
  CHECK(Json::parse(views[1])["strategy"] == "standard");
  const std::string page = text_of_file(folder.path("out/report.html"));
  CHECK(count(page, "<canvas") == 1);
  CHECK_THAT(page, !Contains("The body is not drawn here"));
}

TEST_CASE("what a page carries packed is gzip of the text", "[page]") {
  const std::string text = "positions and tensions, positions and tensions";
  const std::string inflated = inflated_base64(packed(text));
  CHECK(inflated == text);
  CHECK(inflated_base64(packed("")).empty());
  CHECK(packed(std::string(100'000, 'a')).size() < 1000);
}

TEST_CASE("a page carries three with its notice", "[page]") {
  const TemporaryFolder folder;
  const std::string page = page_of(folder);
  const std::size_t begin = page.find('>', page.find("id=\"three\"")) + 1;
  const std::string three = inflated_base64(page.substr(begin, page.find('<', begin) - begin));
  CHECK_THAT(three, Contains("The MIT License") && Contains("three.js authors") && Contains("OrbitControls"));
  CHECK(page.size() < 475'000);  // three has 230'000, scripts and styles 78'000, two scenes of 64 molecules the rest
}

TEST_CASE("a browser draws the page and a visitor's hand turns it", "[page][browser][slow]") {
  const std::string chromium = browser();
  if (chromium.empty()) {
    WARN("no Chromium here: the page was not looked at");
    return;
  }
  const TemporaryFolder folder;
  const std::string log = visit(chromium, folder, "");
  const Json seen = driven(log);
  CHECK(seen["errors"] == "");
  CHECK(std::regex_search(log, std::regex("CONSOLE(?!.*(DRIVEN|ReadPixels))")) == false);

  // The body is whole in the picture, and as large as it can be.
  for (const char* width : {"wide", "narrow"}) {
    CAPTURE(width, seen[width].dump());
    CHECK(seen[width]["edge"] > 0.02);
    CHECK(std::max(seen[width]["width"].get<double>(), seen[width]["height"].get<double>()) > 0.8);
  }

  const Json& hand = seen["hand"];
  const auto turned = [&](const char* how) {
    return std::abs(hand[how]["yaw"].get<double>() - hand["start"]["yaw"].get<double>());
  };
  CHECK(turned("dragged") > 0.3);
  CHECK(hand["dragged"]["distance"].get<double>() == Approx(hand["start"]["distance"].get<double>()));
  CHECK(hand["shifted"]["yaw"] == hand["dragged"]["yaw"]);
  CHECK(hand["shifted"]["side"] > 0.1);
  CHECK(hand["scrolled_past"].get<double>() == Approx(hand["start"]["distance"].get<double>()));
  CHECK(hand["zoomed"] < 0.95 * hand["start"]["distance"].get<double>());
  CHECK(hand["reset"] == hand["start"]);
  CHECK(turned("key") == Approx(0.1));

  // ▶ begins again at rest, becomes pause, stands still, goes on to the end and is ▶ again.
  const Json& playing = seen["playing"]["seen"];
  CHECK(playing[0] == Json::array({"play", 1}));
  CHECK(playing[1][0] == "pause");
  CHECK(playing[2][0] == "play");
  CHECK(playing[2][1] < 1);
  CHECK(seen["playing"]["paused"].get<double>() == Approx(playing[2][1].get<double>()).margin(0.006));
  CHECK(playing[3] == Json::array({"play", 1}));

  for (const Json& found : seen["picks"]) CHECK(found == true);
  const double strains[] = {0.2, -0.3, 0, 0.3};  // of triangles stretched by (1.2, 0.9), (0.7, 1.1), 1, (1.05, 1.3)
  for (int i = 0; i < 4; ++i) CHECK(seen["strains"][i].get<double>() == Approx(strains[i]).margin(1e-6));  // float
  const auto colours = [&](const std::string& title) {
    for (const Json& kind : seen["colours"])
      if (kind[0] == title) return kind;
    return Json();
  };
  CHECK(seen["colours"].size() == 6);  // no contact here
  CHECK(colours("tension of the connections")[3] == "signed");
  CHECK(colours("displacement")[1] == "0");
  CHECK(colours("displacement")[3] == "rising");
  CHECK(colours("von Mises stress")[3] == "rising");
  CHECK(colours("distance from the best")[2] == "0");  // the best is nowhere away from itself
  // A run that ends unloaded has the colours of its loaded states.
  CHECK(seen["ranges"]["unloaded"] == seen["ranges"]["loaded"]);
  const Json& opened = seen["opened"];
  CHECK(opened["free"]["scale"] != "true to scale");
  CHECK(opened["touching"]["scale"] == "true to scale");
  CHECK(opened["modes"]["scale"] == "shape of the mode, enlarged");
  CHECK(opened["modes"]["title"] == "displacement, of the enlarged mode");
  CHECK(opened["free"]["inside"] == "The surface alone is drawn: connections and molecules show the inside.");
  CHECK(seen["picture"][0] == seen["picture"][1]);
  CHECK(seen["staged"] == Json::array({1, 1}));  // of two scenes, one body at a time
}

TEST_CASE("without WebGL the processor draws", "[page][browser][slow]") {
  const std::string chromium = browser();
  if (chromium.empty()) {
    WARN("no Chromium here: the page was not looked at");
    return;
  }
  const TemporaryFolder folder;
  const Json seen = driven(visit(chromium, folder, "--disable-3d-apis"));
  CHECK(seen["errors"] == "");
  CHECK(seen["view"] == "");
  CHECK(seen["wide"]["height"] > 0.5);
}
