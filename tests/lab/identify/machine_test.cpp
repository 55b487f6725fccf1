// Curves as testing machines write them, ten layouts, none edited: a neo-Hookean strip of 25 x 6 x 2 mm, c1 = 20 kPa,
// with the scatter of a load cell of 2 mN, torn, looped, slack and preloaded among them, gives c1 back.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <functional>

#include "elastin/core/base/error.h"
#include "lab/identify/data.h"
#include "lab/identify/identify.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;

namespace {

constexpr double kConstant = 20e3, kLength = 25, kSection = 12;  // Pa, mm, mm²
const std::string kSizes = ", cross_section: 12 mm2, length: 25 mm";

/// Force [N] at an elongation [mm].
double force_at(double displacement) {
  const double stretch = 1 + displacement / kLength;
  return displacement > 0 ? 2 * kConstant * (stretch - 1 / (stretch * stretch)) * kSection * 1e-6 : 0;
}

struct Sample {
  double time, displacement, force;  // s, mm, N
};

/// Normal scatter, the same on every machine.
class Scatter {
 public:
  double operator()() {
    double sum = -6;  // of twelve uniform numbers: a normal one nearly
    for (int i = 0; i < 12; ++i) {
      state_ = state_ * 6364136223846793005u + 1442695040888963407u;
      sum += static_cast<double>(state_ >> 11) * 0x1.0p-53;
    }
    return sum;
  }

 private:
  std::uint64_t state_ = 37;
};

struct Test {
  double to = 7.5, slack = 0, noise = 2e-3;
  int rows = 200, still = 10, loops = 0;
  bool torn = false;
};

/// A machine at rest, some loops to two thirds of which each loses a tenth on its way back, then the test.
std::vector<Sample> readings(const Test& test) {
  std::vector<Sample> all;
  Scatter scatter;
  const auto add = [&](double at, double force) {
    all.push_back({0.02 * static_cast<double>(all.size()), at, force + test.noise * scatter()});
  };
  for (int i = 0; i < test.still; ++i) add(0, force_at(-test.slack));
  for (int loop = 0; loop < test.loops; ++loop) {
    for (int i = 1; i <= 100; ++i) add(test.to * i / 150, 0.8 * force_at(test.to * i / 150));
    for (int i = 99; i >= 0; --i) add(test.to * i / 150, 0.7 * force_at(test.to * i / 150));
  }
  for (int i = 1; i <= test.rows; ++i) add(test.to * i / test.rows, force_at(test.to * i / test.rows - test.slack));
  for (int i = 1; test.torn && i <= 60; ++i) add(test.to * (1 + i / 120.), 0);
  return all;
}

struct Layout {
  std::string machine, preamble, head, separator = ",";
  char decimal = '.';
  std::string quote = {}, columns = "tdf", end = {}, newline = "\r\n";
  double displacement_factor = 1, force_factor = 1, offset = 0;  // to the file's units
  bool grouped = false;
};

std::string number_of(double value, const Layout& layout) {
  std::string text = fmt::format("{:.5f}", value);
  if (layout.grouped && std::abs(value) >= 1000) text.insert(text.find('.') - 3, layout.decimal == ',' ? "@" : ",");
  for (char& c : text) c = c == '.' ? layout.decimal : c == '@' ? '.' : c;
  return layout.quote + text + layout.quote;
}

std::string file_of(const Layout& layout, const std::vector<Sample>& rows) {
  std::string text = layout.preamble + layout.head;
  for (const Sample& row : rows) {
    std::string line;
    for (const char column : layout.columns) {
      if (!line.empty()) line += layout.separator;
      line += number_of(column == 't'   ? row.time
                        : column == 'd' ? layout.offset + layout.displacement_factor * row.displacement
                                        : layout.force_factor * row.force,
                        layout);
    }
    text += line + "\n";
  }
  text += layout.end;
  std::string lines;
  for (const char c : text) lines += c == '\n' ? layout.newline : std::string(1, c);
  return lines;
}

std::string utf16(const std::string& text) {
  std::string wide = "\xFF\xFE";
  for (const char c : text) wide += {c, '\0'};
  return wide;
}

Answer answer_of(const TemporaryFolder& folder, const std::string& data, const std::string& keys,
                 const std::string& kind = "uniaxial", const std::string& material = "law: yeoh, terms: [1 kPa]") {
  folder.write("data.csv", data);
  return identify(folder.write("scene.yaml", "material: {" + material + "}\nidentify:\n  tests: [{kind: " + kind +
                                                 ", file: data.csv" + keys + "}]\n"),
                  built_in_catalog(), {})
      .front();
}

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::string in_one(const std::vector<std::string>& texts) { return fmt::format("{}", fmt::join(texts, "; ")); }
bool has(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

const Layout kBluehill{"Instron Bluehill",
                       "Specimen properties : Label,\"S-3\"\nSpecimen properties : Length,\"25.00000\",mm\n\n",
                       "Time,Extension,Load\n(s),(mm),(N)\n",
                       ",",
                       '.',
                       "\""};
const Layout kTestXpert{"Zwick testXpert",
                        "\"Pr\xFC"
                        "fnorm\";\"DIN 53504\"\nKunde;Gewebe GmbH;Vorkraft;0,02;N\n\n",
                        "\"Pr\xFC"
                        "fzeit\";\"Standardweg\";\"Standardkraft\"\n\"s\";\"mm\";\"N\"\n",
                        ";", ','};
const Layout kTestSuite{"MTS TestSuite",
                        "MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A\nData Acquisition: Timed\nStation Name: bench.cfg\n",
                        "Axial Displacement\tAxial Force\tRunning Time\nmm\tN\tSec\n",
                        "\t",
                        '.',
                        "",
                        "dft"};
const Layout kTrapezium{"Shimadzu Trapezium",
                        "\"\",\"1 _ 1\",\"\"\n",
                        "\"Time\",\"Force\",\"Stroke\"\n\"sec\",\"N\",\"mm\"\n",
                        ",",
                        '.',
                        "\"",
                        "tfd"};
const Layout kElectroForce{"TA ElectroForce WinTest", "File: run 7\nDate: 3/12/2024, 10:31\n",
                           "Elapsed Time (Sec), Disp (mm), Load (N)\n", ", "};
const Layout kBioTester{
    "CellScale BioTester", "", "Time_S,XDisplacement_um,XForce_mN\n", ",", '.', "", "tdf", "", "\n", 1000, 1000};
const Layout kMach1{
    "Biomomentum Mach-1",
    "<INFO>\nTime:\t13:20:49\nLoad cell range, N:\t1.5\n<END INFO>\n<Find Contact>\nSpeed, mm/s:\t0.1\n<DATA>\n"
    "Time, s\tGain\n0.0\t1.0\n0.1\t1.0\n<END DATA>\n<Move Relative>\n<DATA>\n",
    "Time, s\tPosition (z), mm\tFz, N\n",
    "\t",
    '.',
    "",
    "tdf",
    "<END DATA>\n",
    "\n",
    1,
    1,
    12.25};
const Layout kChinese{"a machine in GB 2312",
                      "\n",
                      "\"\xCA\xB1\xBC\xE4\",\"\xCE\xBB\xD2\xC6\",\"\xC1\xA6\"\n(s),(mm),(N)\n",
                      ",",
                      '.',
                      "\""};
const Layout kUnicodeText{"a sheet as Unicode text",
                          "Probe 12\t\t\n",
                          "Zeit [s]\tWeg [um]\tKraft [uN]\n",
                          "\t",
                          ',',
                          "",
                          "tdf",
                          "",
                          "\r\n",
                          1000,
                          1e6,
                          0,
                          true};
const Layout kInches{
    "a machine in inches", "", "Time (s)   Position (in)   Load (lbf)\n", "   ", '.', "", "tdf", "", "\n", 1 / 25.4,
    1 / 4.4482216152605};

struct Export {
  Layout layout;
  Test test;
  std::string keys, recognised, warned;
  double allowed = 0.01;
};

const Test kSlack{.slack = 0.8}, kPreloaded{.slack = -0.8, .still = 0}, kLooped{.still = 0, .loops = 3},
    kTorn{.torn = true};
const std::vector<Export> kExports{
    {kBluehill,
     {},
     kSizes,
     "names of columns in line 4, units in the line below the names, 'Extension' [mm] as displacement",
     ""},
    {kTestXpert, kTorn, kSizes, "WINDOWS-1252, semicolons between fields, decimal commas",
     "falls by 100 % at line 216"},
    {kTestSuite, kLooped, kSizes + ", branch: loading, cycle: -1", "loading branch 4 of 4", ""},
    {kTrapezium, {}, kSizes, "'Stroke' [mm] as displacement, 'Force' [N] as force", ""},
    {kElectroForce, {.noise = 10e-3}, kSizes, "'Disp (mm)' as displacement", "", 0.02},
    {kBioTester, kLooped, kSizes + ", branch: loading, cycle: 4", "'XForce_mN' [mN] as force", ""},
    {kMach1, {}, kSizes, "block 2 of 2", ""},
    {kChinese, kSlack, ", cross_section: 12 mm2, length: 24.2 mm, zero: found", "GB18030", "", 0.02},
    {kUnicodeText, kPreloaded, ", cross_section: 12 mm2, length: 25.8 mm, zero: found",
     "UTF-16LE, tabs between fields, decimal commas, marks between thousands", "", 0.03},
    {kInches, {}, kSizes, "blanks between fields", ""},
    {kBluehill, kSlack, ", cross_section: 12 mm2, length: 24.2 mm", "'Load' [N]", "slack, and no curve", 0.02},
};

}  // namespace

TEST_CASE("ten machines' exports are read as they are and give their material", "[identify][machines][slow]") {
  const TemporaryFolder folder;
  for (const Export& machine : kExports) {
    INFO(machine.layout.machine);
    const std::string text = file_of(machine.layout, readings(machine.test));
    const Answer answer =
        answer_of(folder, machine.layout.machine == "a sheet as Unicode text" ? utf16(text) : text, machine.keys);
    const std::string notes = in_one(answer.tests.front().data.notes), warnings = in_one(answer.warnings);
    INFO(notes << "\n" << warnings);
    CHECK(answer.outcome == FitOutcome::converged);
    CHECK(answer.numbers.front().value == Approx(kConstant).epsilon(machine.allowed));
    const double half = (answer.numbers.front().high - answer.numbers.front().low) / 2;
    CHECK(std::abs(answer.numbers.front().value - kConstant) < 1.5 * half);  // three deviations
    CHECK(has(notes, machine.recognised));
    CHECK(has(warnings, machine.warned));
    CHECK(has(warnings, "falls by") == machine.test.torn);
  }
}

TEST_CASE("columns of displacement and force count where the scene makes strain and stress of them",
          "[identify][machines]") {
  const TemporaryFolder folder;
  Layout layout = kBluehill;
  layout.head = "Time,Extension,Load,Tensile strain,Tensile stress\n(s),(mm),(N),(mm/mm),(MPa)\n";
  std::string text = layout.preamble + layout.head;
  for (const Sample& row : readings({.to = 1.2, .rows = 60}))
    text += fmt::format("\"{:.4f}\",\"{:.5f}\",\"{:.5f}\",\"{:.5f}\",\"{:.6f}\"\n", row.time, row.displacement,
                        row.force, row.displacement / kLength, row.force / kSection);
  const std::vector<std::pair<std::string, std::string>> read{
      {kSizes, "names of columns in line 4, units in the line below the names, 'Extension' [mm] as displacement"},
      {"", "'Tensile strain' [mm/mm] as nominal_strain, 'Tensile stress' [MPa] as nominal_stress"},
      {kSizes + ", columns: {Extension: displacement, 3: 'force [N]'}", "units in the line below the names"}};
  for (const auto& [keys, note] : read) {
    const Answer answer = answer_of(folder, text, keys);
    INFO(keys);
    CHECK(answer.numbers.front().value == Approx(kConstant).epsilon(0.025));  // of 5 % of strain and noise of 4 % of it
    CHECK(has(in_one(answer.tests.front().data.notes), note));
  }
}

TEST_CASE("a curve that cannot be meant as it is, is refused with its line and the key that helps",
          "[identify][machines]") {
  const TemporaryFolder folder;
  Layout plain{"", "", "displacement [mm],force [N]\n", ",", '.', "", "df", "", "\n"};
  const auto refused = [&](const Test& test, const std::string& keys) {
    return message_of([&] { answer_of(folder, file_of(plain, readings(test)), kSizes + keys); });
  };
  CHECK(has(refused(kLooped, ""), "data.csv:102: displacement goes back here: choose a branch by branch: loading"));
  CHECK(has(refused(kLooped, ", branch: loading, cycle: 5"), "has 4 loading branches"));
  CHECK(has(refused({}, ", residuals: relative"), "data.csv:2: "));
  CHECK(has(refused({}, ", residuals: relative"), "write residuals: automatic"));
  CHECK(has(refused(kLooped, ", branch: unloading, zero: found"), "do not begin near rest"));
  plain.end = "300,0.001\n390,0.0008\n";  // a slip, in strains of 12 and more
  plain.head = "nominal_strain,nominal_stress [MPa]\n", plain.displacement_factor = 1 / kLength,
  plain.force_factor = 1 / kSection;
  const std::string slipped = file_of(plain, readings({}));
  CHECK(has(message_of([&] { answer_of(folder, slipped, ""); }), "data.csv:212: strain 300 is beyond any material"));
  CHECK(answer_of(folder, slipped, ", to: 0.31").numbers.front().value == Approx(kConstant).epsilon(0.01));
}

TEST_CASE("a displacement that is the position of a crosshead is named, and counts from where the load begins",
          "[identify][machines]") {
  const TemporaryFolder folder;
  Layout layout{"", "", "Crosshead (mm),Load (N)\n", ",", '.', "", "df", "", "\n"};
  layout.offset = 105.3;
  const auto answer = [&](const Test& test, const std::string& keys) {
    return answer_of(folder, file_of(layout, readings(test)), kSizes + keys);
  };
  const Answer unsaid = answer({}, "");
  INFO(in_one(unsaid.warnings));
  CHECK(has(in_one(unsaid.warnings),
            "the displacement begins at 105.30 mm, a strain of 421 %, where the force is "
            "nothing ("));
  CHECK(has(in_one(unsaid.warnings), "zero: first counts from the first row"));
  CHECK(!has(in_one(unsaid.warnings), "measure a force"));  // that was measured
  for (const char* keys : {", zero: first", ", zero: found"}) {
    const Answer found = answer({}, keys);
    INFO(keys << ": " << in_one(found.warnings));
    CHECK(found.numbers.front().value == Approx(kConstant).epsilon(0.02));
    CHECK(has(in_one(found.tests.front().data.notes), "displacement counts from the first row, 105.30 mm"));
    CHECK(!has(in_one(found.warnings), "the displacement begins at"));
  }
  CHECK(!has(in_one(answer({}, ", zero: as_given").warnings), "the displacement begins at"));
  // Moved down, a crosshead presses.
  Layout pressing = layout;
  pressing.displacement_factor = -1;
  const std::string text = file_of(pressing, readings({.to = 5}));
  CHECK(answer_of(folder, text, kSizes + ", zero: first", "compression").tests.front().data.x.minCoeff() < -4e-3);
}

TEST_CASE("where a curve counts from behind its slack, the length there is said", "[identify][machines]") {
  const TemporaryFolder folder;
  const std::string text = file_of(kBluehill, readings(kSlack)), sizes = ", cross_section: 12 mm2, length: 24.2 mm";
  const std::string length = "where the length is 25.0";  // and 0.8 mm of slack
  CHECK(has(in_one(answer_of(folder, text, sizes).warnings), length));
  CHECK(has(in_one(answer_of(folder, text, sizes + ", zero: found").tests.front().data.notes), length));
}

TEST_CASE("rows behind a tear that count give no material", "[identify][machines]") {
  const TemporaryFolder folder;
  const Layout plain{"", "", "displacement [mm],force [N]\n", ",", '.', "", "df", "", "\n"};
  Test torn = kTorn;
  torn.rows = 60;
  const Answer answer = answer_of(folder, file_of(plain, readings(torn)), kSizes + ", torn: keep");
  CHECK(answer.outcome == FitOutcome::misfit);
  CHECK(!answer.succeeded());
  CHECK(has(in_one(answer.warnings), "as `torn: keep` says"));
}

TEST_CASE("compression is read whatever signs the machine gives it", "[identify][machines]") {
  const TemporaryFolder folder;
  for (const double of_strain : {1., -1.})
    for (const double of_stress : {1., -1.}) {
      std::string text = "# compression of a gel\nnominal_strain [%],nominal_stress [Pa]\n";
      for (int i = 1; i <= 20; ++i) {
        const double stretch = 1 - 0.02 * i;
        text += fmt::format("{},{:.2f}\n", of_strain * 2 * i,
                            of_stress * 2 * kConstant * (1 / (stretch * stretch) - stretch));
      }
      CHECK(answer_of(folder, text, "", "compression").numbers.front().value == Approx(kConstant).epsilon(1e-5));
      if (of_strain > 0 && of_stress > 0) {
        CHECK(answer_of(folder, text, ", signs: pressing").numbers.front().value == Approx(kConstant).epsilon(1e-5));
        CHECK(has(message_of([&] { answer_of(folder, text, ""); }),
                  "data.csv:1: the file speaks of compression and its values are positive: write kind: compression"));
      }
    }
  const Layout compressive{"", "", "Compressive extension (mm);Compressive load (N)\n", ";", '.', "", "df", "", "\n"};
  CHECK(has(in_one(answer_of(folder, file_of(compressive, readings({.still = 0})), kSizes).tests.front().data.notes),
            "displacement and force turned to negative"));
}

TEST_CASE("powers of ten are read as Fortran writes them, too", "[identify][machines]") {
  const TemporaryFolder folder;
  const std::string head = "nominal_strain [-],nominal_stress [Pa]\n";
  std::string small, large;
  for (int i = 1; i < 9; ++i) {
    small += "0." + std::to_string(i) + "E-02," + std::to_string(30 * i) + "\n";
    large += "0." + std::to_string(i) + "D-02," + std::to_string(3 * i) + ".0D+01\n";
  }
  const Answer plain = answer_of(folder, head + small, ""), fortran = answer_of(folder, head + large, "");
  REQUIRE(plain.tests.front().data.x.size() == 8);
  CHECK(fortran.numbers.front().value == plain.numbers.front().value);
}

TEST_CASE("rows that go on behind a line of words belong to their block", "[identify][machines]") {
  const TemporaryFolder folder;
  const Layout commas{"", "", "displacement [mm],force [N]\n", ",", '.', "", "df", "", "\n"};
  const Layout blanks{"", "", "Extension (mm)   Load (N)\n", "   ", '.', "", "df", "", "\n"};
  for (const Layout& layout : {commas, blanks})
    for (const std::string words : {"Page 2 of 2\n", "Event: pause,\n", "Page 2\nof 12.03.2024\n"}) {
      const std::string whole = file_of(layout, readings({}));
      std::size_t at = 0;
      for (int line = 1; line < 120; ++line) at = whole.find('\n', at) + 1;
      const auto with = [&](const std::string& between) { return whole.substr(0, at) + between + whole.substr(at); };
      if (layout.separator != "," && words != "Page 2 of 2\n") continue;
      INFO(words << layout.head);
      const Answer answer = answer_of(folder, with(words), kSizes);
      CHECK(answer.numbers.front().value == answer_of(folder, whole, kSizes).numbers.front().value);
      CHECK(has(in_one(answer.tests.front().data.notes), "between the rows passed over, the first in line 120"));
      CHECK(has(message_of([&] { answer_of(folder, with(layout.head), kSizes); }), "several blocks"));
    }
  // What may be their names, and rows that begin again, are a question.
  const std::string rows = file_of(commas, readings({}));
  const auto refused = [&](const std::string& behind) {
    return message_of([&] { answer_of(folder, rows + behind, kSizes); });
  };
  const std::string other = rows.substr(commas.head.size());
  CHECK(has(refused("Event,pause\n" + other),
            "data.csv:213: 210 rows from here on have as many columns as block 1, but "
            "the names 'Event' … in line 212: block: 1 takes the 210 rows"));
  CHECK(has(refused("Specimen 2\n" + other), "but no names"));
  CHECK(answer_of(folder, rows + "Event,pause\n" + other, kSizes + ", block: 1").numbers.front().value ==
        Approx(kConstant).epsilon(0.01));
  CHECK(refused("Specimen,Largest load\n1,0.4\n2,0.5\n") == "");  // a table of results
}

TEST_CASE("a large strain without a unit is named, with what to write if it is in per cent", "[identify][machines]") {
  const TemporaryFolder folder;
  for (const std::string kind : {"uniaxial", "shear"}) {
    const std::string name = kind == "shear" ? "Shear strain" : "Tensile strain",
                      quantity = kind == "shear" ? "shear" : "nominal_strain",
                      stress = kind == "shear" ? "Shear stress (Pa)" : "Tensile stress (Pa)";
    const auto warnings_of = [&](const std::string& head, const std::string& keys, double scale) {
      std::string text = head + "," + stress + "\n";
      for (int i = 1; i <= 20; ++i) text += fmt::format("{:.6g},{:.6g}\n", scale * i / 20, 600. * i);
      return in_one(answer_of(folder, text, keys, kind).warnings);
    };
    const std::string words =
        "column '" + name + "' has no unit, and its largest value, 10, is taken as a strain of 1000 %";
    INFO(warnings_of(name, "", 10));
    CHECK(has(warnings_of(name, "", 10), words));
    CHECK(has(warnings_of(name, "", 10), "columns: {\"" + name + "\": '" + quantity + " [%]'}"));
    CHECK(!has(warnings_of(name, ", columns: {" + name + ": '" + quantity + " [%]'}", 10), "has no unit"));
    CHECK(!has(warnings_of(name, ", columns: {" + name + ": '" + quantity + " [-]'}", 10), "has no unit"));
    CHECK(!has(warnings_of(name + " [-]", "", 10), "has no unit"));
    CHECK(!has(warnings_of(name, "", 1.2), "has no unit"));
  }
}

TEST_CASE("both directions of an equibiaxial test are compared", "[identify][machines]") {
  const TemporaryFolder folder;
  const auto answer = [&](const std::string& head, double of_strain, double of_stress, bool turned = false) {
    std::string text = head + "\n";
    Scatter scatter;
    for (int i = 1; i <= 60; ++i) {
      const double stretch = 1 + 0.005 * i, stress = 2e-3 * kConstant * (stretch - std::pow(stretch, -5));
      const auto shown = [&](double factor, double rest, double value, double noise) {
        return fmt::format("{:.6g}", rest + factor * (value - rest) + noise * scatter());
      };
      const std::string x = shown(1, 1, stretch, 0), y = shown(of_strain, 1, stretch, 0), p = shown(1, 0, stress, 0.05),
                        q = shown(of_stress, 0, stress, 0.05);
      text += (turned ? y + "," + x + "," + q + "," + p : x + "," + y + "," + p + "," + q) + "\n";
    }
    return answer_of(folder, text, "", "equibiaxial");
  };
  const std::string head = "stretch_x,stretch_y,nominal_stress_x [kPa],nominal_stress_y [kPa]";
  for (const auto& [heads, turned] : {std::pair{head, false},
                                      {"stretch_y,stretch_x,nominal_stress_y [kPa],nominal_stress_x [kPa]", true},
                                      {"λ1 [-],λ2 [-],PK1 stress 1 (kPa),PK1 stress 2 (kPa)", false}}) {
    const Answer same = answer(heads, 1, 1, turned);
    INFO(heads << in_one(same.tests.front().data.notes) << in_one(same.warnings));
    CHECK(same.numbers.front().value == Approx(kConstant).epsilon(2e-3));
    CHECK(!has(in_one(same.warnings), "differs from"));
    CHECK(has(in_one(same.tests.front().data.notes), "is within 0 % of it"));
  }
  CHECK(has(in_one(answer(head, 1, 1).tests.front().data.notes),
            "'nominal_stress_x [kPa]' counts, and 'nominal_stress_y [kPa]' is within"));
  const std::string stresses = in_one(answer(head, 1, 2).warnings);
  INFO(stresses);
  CHECK(has(stresses, "'nominal_stress_y [kPa]' differs from 'nominal_stress_x [kPa]', by up to "));
  CHECK(has(stresses, " of its largest value, in line 6"));  // 61 but for the scatter
  CHECK(has(in_one(answer(head, 0.5, 1).warnings), "'stretch_y' differs from 'stretch_x', by up to 50 %"));
  CHECK(has(in_one(answer(head, 1.05, 1).warnings), "'stretch_y' differs from 'stretch_x', by up to 5 %"));
}

TEST_CASE("rows in which the strain is held belong to no branch", "[identify][machines]") {
  const TemporaryFolder folder;
  // Of a material with 20 kPa that loses 30 % while it is held, and goes back with 14 kPa.
  const auto text = [](double jitter, int held, bool back, double scale) {
    Scatter scatter;
    std::string rows = "nominal_strain,nominal_stress [Pa]\n";
    const auto add = [&](double e, double c) {
      rows += fmt::format("{:.7f},{:.5f}\n", scale * (e + jitter * scatter()),
                          scale * 2 * c * (1 + e - std::pow(1 + e, -2)));
    };
    for (int i = 0; i <= 40; ++i) add(0.005 * i, 20e3);
    for (int i = 1; i <= held; ++i) add(0.2, 20e3 - 6e3 * i / held);
    for (int i = 39; back && i >= 0; --i) add(0.005 * i, 14e3);
    return rows;
  };
  const std::string material = "law: mooney_rivlin, c1: 1 kPa, c2: 0 Pa";
  const auto answer = [&](const std::string& data, const std::string& keys) {
    folder.write("data.csv", data);
    return identify(folder.write("a.yaml", "material: {" + material +
                                               "}\nidentify: {fixed: [c2], tests: [{kind: uniaxial, file: data.csv" +
                                               keys + "}]}\n"),
                    built_in_catalog(), {})
        .front();
  };
  for (const double jitter : {0., 2e-5})
    for (const int held : {7, 30}) {
      INFO(jitter << ", " << held);
      const std::string whole = text(jitter, held, true, 1);
      const Answer up = answer(whole, ", branch: loading"), down = answer(whole, ", branch: unloading"),
                   alone = answer(text(jitter, held, false, 1), "");
      CHECK(up.numbers.front().value == Approx(20e3).epsilon(2e-3));
      CHECK(down.numbers.front().value == Approx(14e3).epsilon(2e-3));
      CHECK(alone.numbers.front().value == Approx(20e3).epsilon(2e-3));
      const std::string notes = in_one(down.tests.front().data.notes);
      INFO(notes);
      CHECK(has(notes, "left out, where the nominal_strain is held while the nominal_stress changes: lines 4"));
      CHECK(has(notes, fmt::format(" to {}, down by", 42 + held)));
    }
  // What stands still at rest, or goes at an even or a growing pace, is no hold; nor is one without relaxation.
  const VectorX even = VectorX::LinSpaced(3000, 0, 1);
  CHECK(find_holds(even, even, 0, 0).empty());
  CHECK(find_holds(even.array().pow(4).matrix(), even, 0, 0).empty());
  CHECK(find_holds(even.array().sqrt().matrix(), even, 0, 0).empty());
  VectorX still(400), drift = VectorX::LinSpaced(400, 0, 1);
  still << VectorX::Zero(200), VectorX::LinSpaced(200, 0, 1);
  CHECK(find_holds(still, drift, 0, 0).empty());
  still << VectorX::LinSpaced(200, 0, 1), VectorX::Ones(200);
  CHECK(find_holds(still, still, 0, 0).empty());
  CHECK(find_holds(still, drift, 0, 0).size() == 1);
}

TEST_CASE("a prefix that is wrong more often than not is named", "[identify][machines]") {
  const TemporaryFolder folder;
  const auto warnings_of = [&](const std::string& head, const std::string& keys) {
    return in_one(answer_of(folder, head + "\n0.1,1\n0.2,1.8\n0.3,2.5\n", keys).warnings);
  };
  const std::string words =
      "is taken in millipascals, mPa: if megapascals are meant, write columns: {\"nominal_stress "
      "[mPa]\": 'nominal_stress [MPa]'}";
  CHECK(has(warnings_of("nominal_strain,nominal_stress [mPa]", ""), words));
  CHECK(!has(warnings_of("nominal_strain,nominal_stress [mPa]", ", columns: {2: 'nominal_stress [mPa]'}"),
             "is taken in"));
  CHECK(!has(warnings_of("nominal_strain,nominal_stress [MPa]", ""), "is taken in"));
  CHECK(has(warnings_of("displacement [mm],force [MN]", kSizes), "is taken in meganewtons, MN: if millinewtons"));
}

TEST_CASE("a second column of the same quantity is named", "[identify][machines]") {
  const TemporaryFolder folder;
  const auto notes_of = [&](const std::string& keys) {
    return in_one(answer_of(folder, "displacement [mm],corrected extension [mm],force [N]\n1,1,1\n2,2,1.8\n3,3,2.5\n",
                            kSizes + keys)
                      .tests.front()
                      .data.notes);
  };
  CHECK(has(notes_of(""), "passed over: 'corrected extension [mm]'"));
  CHECK(!has(notes_of(", columns: {2: 'displacement [mm]'}"), "passed over"));
}

TEST_CASE("statistics below the readings are left out with a note", "[identify][machines]") {
  const TemporaryFolder folder;
  Layout footed{"", "", "displacement [mm],force [N]\n", ",", '.', "", "df", "Max,0.42\nMean,0.2\n", "\n"};
  const Answer answer = answer_of(folder, file_of(footed, readings({})), kSizes);
  CHECK(answer.numbers.front().value == Approx(kConstant).epsilon(0.01));
  CHECK(has(in_one(answer.tests.front().data.notes), "2 rows behind the end of these columns left out"));
  // Between readings a word is a fault.
  footed.end += "7.6,0.5\n";
  CHECK(has(message_of([&] { answer_of(folder, file_of(footed, readings({})), kSizes); }), "'Max' is no number"));
}

TEST_CASE("a file that counts pulling as negative says how it is read, and what turns it", "[identify][machines]") {
  const TemporaryFolder folder;
  Layout negative{"", "", "displacement [mm],force [N]\n", ",", '.', "", "df", "", "\n"};
  negative.displacement_factor = negative.force_factor = -1;
  const std::string text = file_of(negative, readings({.still = 0}));
  const auto notes_with = [&](const std::string& keys) {
    return in_one(answer_of(folder, text, kSizes + keys).tests.front().data.notes);
  };
  CHECK(has(notes_with(""), "displacement and force are negative, and count as compression; signs: pressing turns"));
  CHECK(!has(notes_with(", signs: pulling"), "count as compression"));
  CHECK(answer_of(folder, text, kSizes + ", signs: pressing").numbers.front().value == Approx(kConstant).epsilon(0.01));
}

TEST_CASE("moduli by windows are those of the law, within their intervals", "[identify][machines]") {
  const TemporaryFolder folder;
  const Answer answer =
      answer_of(folder, file_of(kBluehill, readings({.rows = 400})),
                kSizes +
                    ", moduli: [{kind: chord, from: 5 %, to: 15 %}, {kind: chord, from: 2 kPa, to: 10 kPa}, "
                    "{kind: tangent, at: 10 %}, {kind: secant, at: 20 kPa}]");
  const auto stress = [](double strain) { return 2 * kConstant * (1 + strain - 1 / ((1 + strain) * (1 + strain))); };
  const auto strain = [&](double at) {
    double low = 0, high = 1;
    for (int i = 0; i < 60; ++i) (stress((low + high) / 2) < at ? low : high) = (low + high) / 2;
    return low;
  };
  const double expected[] = {(stress(0.15) - stress(0.05)) / 0.1, 8e3 / (strain(10e3) - strain(2e3)),
                             2 * kConstant * (1 + 2 / std::pow(1.1, 3)), 20e3 / strain(20e3)};
  const std::vector<WindowModulus>& found = answer.tests.front().moduli;
  REQUIRE(found.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    INFO(found[i].window << ": " << found[i].value << ", " << found[i].low << " to " << found[i].high);
    CHECK(found[i].value == Approx(expected[i]).epsilon(0.02));
    // Three standard deviations: 95 % intervals miss one of twenty.
    CHECK(std::abs(found[i].value - expected[i]) < 0.75 * (found[i].high - found[i].low));
  }
}

TEST_CASE("moduli by windows are those of strongly bent curves, within their intervals", "[identify][machines][slow]") {
  // Fung's exponential, by its closed forms; exact readings and noisy ones.
  constexpr double a = 1e3, b = 20;
  const auto stress = [](double strain) { return a * std::expm1(b * strain); };
  const auto strain = [](double at) { return std::log1p(at / a) / b; };
  DataTest test;
  test.fail = [](const std::string& message) { FAIL(message); };
  using enum ModulusWindow::Kind;
  test.moduli = {{chord, {0.05}, {0.15}, {}}, {chord, {2e3, true}, {20e3, true}, {}},
                 {tangent, {}, {}, {0.1}},    {tangent, {}, {}, {10e3, true}},
                 {secant, {}, {}, {0.1}},     {secant, {}, {}, {10e3, true}},
                 {chord, {0}, {0.2}, {}}};
  const double expected[] = {(stress(0.15) - stress(0.05)) / 0.1,
                             18e3 / (strain(20e3) - strain(2e3)),
                             a * b * std::exp(b * 0.1),
                             b * (a + 10e3),
                             stress(0.1) / 0.1,
                             10e3 / strain(10e3),
                             stress(0.2) / 0.2};
  MeasuredData data;
  data.x = VectorX::LinSpaced(201, 0, 0.2);
  const VectorX exact = data.x.unaryExpr(stress);
  Scatter scatter;
  constexpr int repeats = 200;
  for (const double noise : {0., 20., 500.}) {
    std::array<int, std::size(expected)> within{};
    std::array<double, std::size(expected)> widths{};
    for (int repeat = 0; repeat < (noise > 0 ? repeats : 1); ++repeat) {
      data.y = exact.unaryExpr([&](double y) { return y + noise * scatter(); });
      const std::vector<WindowModulus> found = window_moduli(test, data);
      for (std::size_t i = 0; i < found.size(); ++i) {
        INFO(noise << " " << found[i].window << ": " << found[i].value << " of " << expected[i]);
        within[i] += found[i].low <= expected[i] && expected[i] <= found[i].high;
        widths[i] += (found[i].high - found[i].low) / expected[i];
      }
    }
    for (std::size_t i = 0; i < within.size(); ++i) {
      INFO(noise << " " << expected[i] << ": " << within[i]);
      CHECK(widths[i] < (noise > 100 ? 0.7 * repeats : noise > 0 ? 0.05 * repeats : 1e-3));
      CHECK(within[i] >= (noise > 0 ? 0.9 * repeats : 1));  // 95 %, less three deviations of 200
    }
  }
}

TEST_CASE("zero points, tears and branches of curves", "[identify][machines]") {
  Scatter scatter;
  const VectorX x = VectorX::LinSpaced(300, 0, 3);
  const auto curve = [&](double noise, const std::function<double(double)>& y) {
    return VectorX(x.unaryExpr([&](double at) { return y(at) + noise * scatter(); }));
  };
  for (const double zero : {-0.4, 0.5}) {
    const VectorX y =
        curve(0.01, [&](double at) { return at > zero ? (at - zero) + 0.3 * (at - zero) * (at - zero) : 0; });
    const auto found = find_zero(x, y);
    REQUIRE(found);
    CHECK(found->low < zero);
    CHECK(found->high > zero);
    CHECK(found->high - found->low < 0.2);
    const auto turned = find_zero(-x, -y);
    REQUIRE(turned);
    CHECK(turned->low == Approx(-found->high));
    CHECK(turned->high == Approx(-found->low));
  }
  // Of a preloaded specimen no beginning is within reach: the search ends as far before its ten first rows as these
  // are long.
  const auto far = find_zero(x, curve(0, [](double at) { return 100 + at; }));
  REQUIRE(far);
  CHECK(far->value == Approx(-x[9]));
  CHECK(far->low >= -x[9] * (1 + 1e-12));
  const auto toe =
      find_toe(x, curve(0.01, [](double at) { return at < 1 ? at * at / 2 : at - 0.5; }));  // its tangent crosses 0.5
  REQUIRE(toe);
  CHECK(toe->low < 0.5);
  CHECK(toe->high > 0.5);
  CHECK(toe->high - toe->low < 0.2);
  const auto late = [&](double noise, const std::function<double(double)>& y) {
    return begins_late(x, curve(noise, y), noise);
  };
  CHECK(late(0.01, [](double at) { return std::max(0., at - 0.3); }));
  CHECK_FALSE(late(0.01, [](double at) { return at; }));
  for (const double rate : {1., 3., 6.})  // toes of tissues
    CHECK_FALSE(late(0.01, [&](double at) { return std::expm1(rate * at) / std::expm1(rate); }));
  CHECK_FALSE(late(0.01, [](double at) { return 0.1 * at + 0.003 * std::expm1(2 * at); }));
  CHECK_FALSE(late(0.002, [](double at) { return at * at * at; }));
  CHECK(!find_tear(x, curve(0.01, [](double at) { return at; }), 0.01));
  CHECK(find_tear(x, curve(0.01, [](double at) { return at < 2 ? at : at - 0.6; }), 0.01)->row == 200);  // x is 2.007
  CHECK(find_tear(x, curve(0, [](double at) { return at < 1.5 ? at : 2.35 - 0.6 * at; }), 0)->row ==
        150);  // x is 1.505
  CHECK(noise_of(x, curve(0.02, [](double at) { return at * at; })) == Approx(0.02).epsilon(0.3));
  VectorX loops(9);
  loops << 0, 1, 2, 1, 0.02, 0.9, 2, 3, 3;
  const std::vector<Branch> branches = branches_of(loops);
  REQUIRE(branches.size() == 3);
  CHECK((branches[0].end == 3 && branches[0].loading && branches[1].end == 5 && !branches[1].loading));
  CHECK((branches[2].begin == 5 && branches[2].end == 9 && branches[2].loading));
}

TEST_CASE("a zero point of stretches is a stretch", "[identify][machines]") {
  const TemporaryFolder folder;
  for (const double zero : {0.1, -0.08}) {
    INFO(zero);
    Scatter scatter;
    std::string rows = "stretch,nominal_stress [Pa]\n";
    for (double e = 0; e < 0.6; e += 0.005)  // 1000 Pa times the neo-Hookean l - l^-2, of the length at the zero point
      rows += fmt::format("{:.6g},{:.6g}\n", 1 + e, [&, l = std::max(1., (1 + e) / (1 + zero))] {
        return 1000 * (l - 1 / (l * l)) + scatter();
      }());
    folder.write("data.csv", rows);
    const Answer answer =
        identify(folder.write("a.yaml",
                              "material: {law: mooney_rivlin, c1: 1 kPa, c2: 0 Pa}\nidentify: {fixed: "
                              "[c2], tests: [{kind: uniaxial, file: data.csv, zero: found}]}\n"),
                 built_in_catalog(), {})
            .front();
    const std::string notes = fmt::format("{}", fmt::join(answer.tests.front().data.notes, "; ")),
                      words = "stretch counts from ";
    const std::size_t at = notes.find(words);
    REQUIRE(at != std::string::npos);
    double found = 0, low = 0, high = 0;
    REQUIRE(std::sscanf(notes.c_str() + at + words.size(), "%lf (95 %%: %lf … %lf)", &found, &low, &high) == 3);
    CHECK(found == Approx(1 + zero).margin(0.02));
    CHECK((low > 0.9 && low < high && high < 1.2));
  }
}

TEST_CASE("a record of relaxation is read from where the load begins, and by its sign", "[identify][machines]") {
  const TemporaryFolder folder;
  const auto held = [](double strain) { return 2 * kConstant * (1 + strain - 1 / ((1 + strain) * (1 + strain))); };
  const std::string head = "Time (s),nominal_stress [Pa]\n", pressed = "Time (s),Compressive stress (Pa)\n";
  /// @param clock when the strain is there
  const auto record = [&](double stress, double clock = 0) {
    std::string text;
    for (int i = 1; i <= 200; ++i) {
      const double t = 0.01 * i * i / 10;
      text += fmt::format("{:.6f},{:.9g}\n", clock + t, stress * (0.7 + 0.3 * std::exp(-t / 2)));
    }
    return text;
  };
  const auto found = [&](const std::string& text, const std::string& keys) {
    return answer_of(folder, text, keys, "relaxation",
                     "law: yeoh, terms: [1 kPa], relaxation: {terms: [[0.1, 1 s]], moduli: instantaneous}");
  };
  struct Case {
    std::string what, text, keys, warning;
    bool true_numbers = true;
  };
  const double pulls = held(0.2), presses = held(-0.2);
  const std::string slow = fmt::format("0.1,{}\n0.3,{}\n0.5,{}\n", 0.2 * pulls, 0.6 * pulls, 0.9 * pulls);
  const std::vector<Case> cases{
      {"from the step on", head + record(pulls), ", strain: 0.2", ""},
      {"a row at rest", head + "0,0\n" + record(pulls), ", strain: 0.2", ""},
      {"rows at rest", head + "0,0\n1,1e-3\n2,-1e-3\n3.2,0\n" + record(pulls, 3.2), ", strain: 0.2",
       "no load until 3.2 s, so time counts from there"},
      {"the machine's clock", head + record(pulls, 3.2), ", strain: 0.2", "if the file has the machine's clock", false},
      {"the machine's clock, as the scene says", head + record(pulls, 3.2), ", strain: 0.2, begins: 3.2 s", ""},
      {"the clock, with readings before", head + "1,0.5\n3,0.4\n" + record(pulls, 3.2), ", strain: 0.2, begins: 3.2 s",
       ""},
      {"a ramp that is not stated", head + slow + record(pulls, 0.5), ", strain: 0.2", "the load grows until 501.00 ms",
       false},
      {"pressed, with its sign", head + record(presses), ", strain: -0.2", ""},
      {"pressed, counted positive", head + record(-presses), ", strain: -0.2", ""},
      {"pressed, by its name", pressed + record(-presses), ", strain: -0.2", ""},
      {"pressed, as the scene says", head + record(-presses), ", strain: -0.2, signs: pressing", ""}};
  for (const Case& one : cases) {
    INFO(one.what);
    const Answer answer = found(one.text, one.keys);
    const std::string warnings = in_one(answer.warnings);
    INFO(warnings);
    CHECK(has(warnings, one.warning));
    if (one.warning.empty()) CHECK(answer.warnings.size() == 0);
    if (!one.true_numbers) continue;
    CHECK(answer.numbers[0].value == Approx(kConstant).epsilon(1e-4));
    CHECK(answer.numbers[1].value == Approx(0.3).epsilon(1e-4));
    CHECK(answer.numbers[2].value == Approx(2).epsilon(1e-4));
  }
  CHECK(has(message_of([&] { found(head + record(presses), ", strain: 0.2"); }), "write strain: -20 %"));
  CHECK(has(message_of([&] { found(pressed + record(pulls), ", strain: 0.2"); }), "write strain: -20 %"));
  CHECK(has(message_of([&] { found(head + record(pulls), ", strain: 0.2, begins: 3600 s"); }),
            "begins: fewer than two rows"));
}

TEST_CASE("times as hours, minutes and seconds are seconds", "[identify][machines]") {
  const TemporaryFolder folder;
  const double elastic = 2 * kConstant * (1.2 - 1 / 1.44);
  const auto found = [&](const std::string& head, const std::string& date, char decimal, const std::string& keys) {
    std::string text = head + "\n";
    for (int i = 1; i <= 100; ++i) {
      const double t = 2. * i;
      std::string time = fmt::format("{}:{:02d}:{:06.3f}", i * 2 / 3600, i * 2 / 60 % 60, std::fmod(t, 60));
      std::string stress = fmt::format("{:.4f}", elastic * (0.7 + 0.3 * std::exp(-t / 20)));
      if (decimal == ',') time[time.find('.')] = ',', stress[stress.find('.')] = ',';
      text += date + time + ";" + stress + "\n";
    }
    return answer_of(folder, text, ", strain: 0.2" + keys, "relaxation",
                     "law: yeoh, terms: [1 kPa], relaxation: {terms: [[0.1, 5 s]], moduli: instantaneous}");
  };
  for (const Answer& answer :
       {found("Time;nominal_stress [Pa]", "", '.', ""), found("Zeit (hh:mm:ss);nominal_stress [Pa]", "", ',', ""),
        found("Time;nominal_stress [Pa]", "2024-03-12 ", '.', ""),
        found("T;nominal_stress [Pa]", "", '.', ", columns: {T: 'time [s]'}")}) {
    CHECK(answer.numbers[0].value == Approx(kConstant).epsilon(1e-4));
    CHECK(answer.numbers[2].value == Approx(20).epsilon(1e-4));
    CHECK(has(in_one(answer.tests.front().data.notes), "times as hours:minutes:seconds"));
  }
}

TEST_CASE("relaxation of 36 000 rows gives its terms", "[identify][machines][slow]") {
  const TemporaryFolder folder;
  Scatter scatter;
  std::string text = "Time_s;nominal_stress_Pa\n";
  const double elastic = 2 * kConstant * (1.2 - 1 / 1.44);
  for (int i = 0; i < 36000; ++i) {
    const double t = 0.01 * i;
    const double stress = elastic * (0.5 + 0.3 * std::exp(-t / 2) + 0.2 * std::exp(-t / 40));
    text += fmt::format("{:.2f};{:.3f}\n", t, stress * (1 + 0.003 * scatter()));
  }
  const Answer answer =
      answer_of(folder, text, ", strain: 0.2", "relaxation",
                "law: yeoh, terms: [1 kPa], relaxation: {terms: [[0.1, 1 s], [0.1, 20 s]], moduli: instantaneous}");
  REQUIRE(answer.numbers.size() == 5);
  CHECK(answer.numbers[0].value == Approx(kConstant).epsilon(0.01));
  const bool swapped = answer.numbers[2].value > answer.numbers[4].value;  // the terms have no order
  const auto value = [&](int i) { return answer.numbers[swapped ? (i > 2 ? i - 2 : i + 2) : i].value; };
  const double expected[] = {0.3, 2, 0.2, 40};
  for (int i = 0; i < 4; ++i) CHECK(value(i + 1) == Approx(expected[i]).epsilon(0.01));
}
