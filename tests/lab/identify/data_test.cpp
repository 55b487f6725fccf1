// Broken data files: each is answered with file:line and what is needed.

#include "lab/identify/data.h"

#include <catch2/catch.hpp>

#include "elastin/core/base/error.h"
#include "lab/identify/identify.h"
#include "support/temporary_folder.h"

using namespace elastin;
using namespace elastin::lab;

namespace {

struct Broken {
  std::string what, text;
  int line;            ///< of the data file; 0: the place is in the scene; -1: the whole file
  std::string needed;  ///< words of the message
  std::string kind = "uniaxial", more = "", material = "";
};

std::string scene_of(const Broken& broken) {
  return "material: {law: yeoh, terms: [1 kPa]" + broken.material + "}\nidentify:\n  tests: [{kind: " + broken.kind +
         ", file: data.csv" + broken.more + "}]\n";
}

std::string message_of(const std::string& scene) {
  try {
    identify(scene, built_in_catalog(), {});
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

const std::string kGood = "stretch,nominal_stress [kPa]\n1.1,0.5\n1.2,1\n1.3,1.4\n";

const std::vector<Broken> kBroken{
    {"no unit", "stretch,nominal_stress\n1.1,1\n1.2,2\n", 1, "has no unit; write for example 'nominal_stress ["},
    {"unknown unit", "stretch,nominal_stress [dyn]\n1.1,1\n1.2,2\n", 1, "'dyn' is no unit of nominal_stress"},
    {"a mass for a force", "displacement [mm],Force (kg)\n1.1,1\n1.2,2\n", 1,
     "'kg' is no unit of force; write for example 'force [kgf]'"},
    {"unit of something else", "stretch,nominal_stress [mm]\n1.1,1\n1.2,2\n", 1, "'mm' is no unit of nominal_stress"},
    {"a unit in the name and another below", "stretch,nominal_stress [kPa]\n-,Pa\n1.1,1\n1.2,2\n", 2,
     "column 'nominal_stress [kPa]': the unit 'Pa' here is another than 'kPa' in its name; state the one that counts: "
     "columns: {\"nominal_stress [kPa]\": 'nominal_stress [kPa]' or 'nominal_stress [Pa]'}"},
    {"a strain in per cent over a ratio", "Tensile strain [%],nominal_stress\nmm/mm,Pa\n1.1,1\n1.2,2\n", 2,
     "'mm/mm' here is another than '%'"},
    {"a unit of something else below", "stretch,nominal_stress [Pa]\n-,mm\n1.1,1\n1.2,2\n", 2, "the unit 'mm' here"},
    {"a shear modulus as that of tension", "Frequency [Hz],G' [Pa],G'' [Pa]\n1,2,1\n2,3,1\n", 1,
     "column 'G' [Pa]' has the name of a modulus in a shear test, and this one has held: uniaxial; write held: shear",
     "storage_modulus", "", ", relaxation: {terms: [[0.1, 1 s]]}"},
    {"a modulus of tension as that of shear", "Frequency [Hz],E' [MPa],E'' [MPa]\n1,2,1\n2,3,1\n", 1,
     "column 'E'' [MPa]' has the name of a modulus in a uniaxial test, and this one has held: shear", "loss_modulus",
     ", held: shear", ", relaxation: {terms: [[0.1, 1 s]]}"},
    {"nominal or true unsaid", "stretch,stress [kPa]\n1.1,1\n1.2,2\n", 1,
     "nominal_stress (force over section at rest) or true_stress"},
    {"which strain unsaid", "strain,nominal_stress [kPa]\n0.1,1\n0.2,2\n", 1, "nominal_strain, true_strain or stretch"},
    {"misspelt column", "strech,nominal_stress [kPa]\n1.1,1\n1.2,2\n", 1, "did you mean 'stretch'?"},
    {"no response", "stretch,thickness [mm]\n1.1,1\n1.2,2\n", 1, "no column says what answers"},
    {"columns swapped", "stretch,nominal_stress [kPa]\n0.1,1.1\n0.2,1.2\n0.3,1.3\n", 2, "are the columns swapped"},
    {"strain headed as stretch", "stretch,nominal_stress [kPa]\n0,0.1\n0.1,1\n", 2,
     "it is 1 at rest; is the column nominal_strain?"},
    {"per cent headed as stretch", "stretch,nominal_stress [kPa]\n101,0.1\n110,1\n", 2,
     "in per cent? then head it 'stretch [%]'"},
    {"two directions of a test in one", "stretch_x,stretch_y,nominal_stress [kPa]\n1.1,1,1\n1.2,1,2\n", 1,
     "two columns say what is prescribed, stretch_x and stretch_y; state the one that counts, by its number: columns: "
     "{\"1\": 'stretch'}"},
    {"a stress without its name in a test in two directions",
     "stretch_x,stretch_y,P_x [kPa],P_y [kPa]\n1.1,1,1,1\n1.2,1,2,2\n", 1,
     "columns: {\"P_x [kPa]\": 'nominal_stress [kPa]' or 'true_stress [kPa]'}", "equibiaxial"},
    {"a relaxation in shear that is not said to be one",
     "Time [s];Shear Stress [Pa];Shear Strain [%]\n1;4;10\n2;3;10\n", 1,
     "column 'Shear Stress [Pa]' is of a test in shear, and this one has held: uniaxial; write held: shear",
     "relaxation", ", strain: 0.1", ", relaxation: {terms: [[0.1, 1 s]]}"},
    {"megametres", "displacement (Mm),force [N]\n1,1\n2,2\n", 1,
     "'Mm' is no unit of displacement; write for example 'displacement [mm]'"},
    {"a position that counts down", "Displacement [mm],Force [N]\n25,0\n24,1\n23,2\n22,3\n", 2,
     "displacement -25.000 mm is a strain of -100 % of the length, 25.000 mm, and it must be above -100 %: if it "
     "counts "
     "from elsewhere, as the position of a crosshead does, zero: first counts from the first row",
     "compression", ", length: 25 mm, cross_section: 12 mm2"},
    {"a compression in per cent", "Compressive strain,nominal_stress [Pa]\n1,1\n5,2\n9,3\n", 4,
     "nominal_strain -9.0000 is a strain of -900 %, and it must be above -100 %: if the column is in per cent",
     "compression"},
    {"tension as compression", "Tensile extension (mm),Tensile load (N)\n1,1\n2,2\n3,3\n", 2,
     "column 'Tensile extension (mm)' counts what pulls, and is positive: write kind: uniaxial, or signs: pressing",
     "compression", ", length: 25 mm, cross_section: 12 mm2"},
    {"two ways to measure an elongation", "Displacement (mm),Corrected displacement (mm),Load (N)\n1,1,1\n2,2,2\n", 1,
     "two columns say what is prescribed, Displacement (mm) and Corrected displacement (mm); state the one that "
     "counts"},
    {"two ways to measure it, of other names", "Crosshead displacement (mm),Extensometer (mm),Load (N)\n1,1,1\n2,2,2\n",
     1, "two columns say what is prescribed, Crosshead displacement (mm) and Extensometer (mm)"},
    {"unsorted", "stretch,nominal_stress [kPa]\n1.1,0.5\n1.3,1.4\n1.2,1\n", 4, "stretch goes back"},
    {"not a number", "stretch,nominal_stress [kPa]\n1.1,0.5\n1.2,nan\n1.3,1\n", 3, "'nan' is no measured value"},
    {"a word", "stretch,nominal_stress [kPa]\n1.1,0.5\n1.2,n/a\n1.3,1\n", 3, "'n/a' is no number"},
    {"another base", "stretch,nominal_stress [kPa]\n1.1,0.5\n1.2,0x10\n1.3,1\n", 3, "'0x10' is no number"},
    {"names that nobody knows", "Ext (mm),Ld (N)\n1,1\n2,2.2\n", 1,
     "or state what a name means, columns: {\"Ext (mm)\": 'displacement [mm]'}"},
    {"no length", "Extension (mm),Load (N)\n1,1\n2,2.2\n", 0, "key 'length' is missing: the data have a displacement"},
    {"an unknown name with its unit", "Ext (%),Ld (N)\n1,1\n2,2.2\n", 1,
     "columns: {\"Ext (%)\": 'stretch [%]' or 'nominal_strain [%]' or 'true_strain [%]'"},
    {"a unit that is none of a strain", "Dehnung ε;Spannung MPa\n0,1;1,2\n0,2;2,2\n", 1,
     "columns: {\"Dehnung ε\": 'nominal_strain'}"},
    {"the stress that is known is not meant", "Way,nominal stress (kPa)\n1.1,1\n1.2,2\n", 1,
     "columns: {\"Way\": 'stretch'"},
    {"a stress that could be either", "stretch,sigma (kPa)\n1.1,1\n1.2,2\n", 1,
     "columns: {\"sigma (kPa)\": 'nominal_stress [kPa]' or 'true_stress [kPa]'}"},
    {"a shear stress of a test without shear", "nominal_strain,Shear stress (kPa)\n1,1\n2,2.2\n", 1,
     "columns: {\"Shear stress (kPa)\": 'nominal_stress [kPa]' or 'true_stress [kPa]'}"},
    {"a gap at the end", "stretch,nominal_stress [kPa]\n1.1,0.5\n1.2,1\n1.3,\n", 4, "nothing stands there"},
    {"no names", "1,1\n2,2.2\n", 1, "there are no names of columns above the numbers"},
    {"a machine's stress", "Dehnung;Spannung\n%;MPa\n1,5;1,2\n2,5;2,2\n", 1,
     "State it: columns: {\"Dehnung\": 'nominal_strain [%]'}"},
    {"a spreadsheet", "PK\x03\x04 and so on", -1, "save the sheet as CSV"},
    {"no text", std::string("a,b\n1,\0x\n", 10), -1, "is no text"},
    {"points and commas", "stretch;nominal_stress [kPa]\n1,1;0,5\n1.2;1\n", 3,
     "decimal points in line 3 and decimal commas in line 2: state decimal: point"},
    {"two blocks", "stretch,nominal_stress [kPa]\n1.1,1\n1.2,2\nstretch,nominal_stress [kPa]\n1.1,3\n1.2,4\n", 1,
     "1 (line 1, 2 rows), 2 (line 4, 2 rows); choose one, for example block: 1"},
    {"too few blocks", kGood, 0, "block: ", "uniaxial", ", block: 2"},
    {"to and fro", "stretch,nominal_stress [kPa]\n1.1,1\n1.2,2\n1.1,.9\n1.2,2\n1.1,.9\n", 4,
     "branch: loading or branch: unloading, and one of 2 cycles by cycle: 1 … 2"},
    {"too few cycles", "stretch,nominal_stress [kPa]\n1.1,1\n1.2,2\n1.1,.9\n", 0, "has 1 loading branch", "uniaxial",
     ", cycle: 2"},
    {"stretches that are pressed", kGood, 2, "stretches above 1 are no compression", "compression"},
    {"a window without rows", kGood, 0, "moduli: tangent at 80 %", "uniaxial", ", moduli: [{kind: tangent, at: 80 %}]"},
    {"no body", "displacement [mm],force [N]\n1,1\n2,2.2\n", 0, "a specimen needs its body", "specimen"},
    {"a gap", "stretch,nominal_stress [kPa]\n1.1,0.5\n1.2,\n1.3,1\n", 3, "nothing stands there"},
    {"one point", "stretch,nominal_stress [kPa]\n1.1,0.5\n", 0, "has 1 point; a curve needs two or more"},
    {"constant response", "stretch,nominal_stress [kPa]\n1.1,2\n1.2,2\n1.3,2\n", 2,
     "nominal_stress is the same in all rows"},
    {"constant stretch", "stretch,nominal_stress [kPa]\n1.1,1\n1.1,2\n1.1,3\n", 2, "stretch is the same in all rows"},
    {"a row too short", "stretch,nominal_stress [kPa]\n1.1,0.5\n1.2\n1.3,1\n", 3, "1 fields; the head has 2"},
    {"a row that ends before the columns that count",
     "Time [s],stretch,nominal_stress [kPa]\n0,1.1,0.5\n1,1.2,1\n2\n3,1.3,1.4\n", 4, "stretch: nothing stands there"},
    {"no such row, and one that ends before its column", "stretch,nominal_stress [kPa],part\n1.1,1,a\n1.2,2,a\n,\n", 0,
     "has 'b' as its part", "uniaxial", ", rows: {part: b}"},
    {"decimals or thousands", "stretch;nominal_stress [kPa]\n1,100;1,500\n1,200;2,500\n", 2,
     "the commas of the numbers may stand before decimals or between thousands: state decimal: point"},
    {"German points between thousands", "displacement [um];force [uN]\n200;6.114\n1.200;38.482\n", 2,
     "the points of the numbers may stand before decimals or between thousands: state decimal: point"},
    {"column twice", "stretch,nominal_stress [kPa],stretch\n1.1,0.5,1\n1.2,1,1\n", 1,
     "two columns are called 'stretch'"},
    {"empty", "", 1, "no head"},
    {"units in the cells", "displacement,force\n0 mm,0 N\n1 mm,0.02 N\n", 2, "write numbers alone, and their unit in"},
    {"head alone", "stretch,nominal_stress [kPa]\n", 0, "has 0 points"},
    {"zero under relative residuals", "stretch,nominal_stress [kPa]\n1.05,0\n1.1,0.5\n1.2,1\n", 2,
     "write residuals: absolute", "uniaxial", ", residuals: relative"},
    {"another test's column", "shear,nominal_stress [kPa]\n0.1,0.5\n0.2,1\n", 1, "'shear' does not"},
    {"no section", "stretch,force [N]\n1.1,0.5\n1.2,1\n", 0, "key 'cross_section' is missing"},
    {"fibres together with a law", kGood, 0, "the material's `fibre` would be left out", "uniaxial", "",
     ", fibre: {direction: z, youngs_modulus: 1 kPa}"},
    {"no rows of that name", kGood, 1, "no column 'region'", "uniaxial", ", rows: {region: cortex}"},
    {"range without points", kGood, 0, "between `from` and `to`", "uniaxial", ", from: 2"},
    {"no such head", kGood, 0, "has no column 'Load'", "uniaxial", ", columns: {Load: 'force [N]'}"},
};

}  // namespace

TEST_CASE("each broken data file is answered with its place and what is needed", "[identify]") {
  const TemporaryFolder folder;
  for (const Broken& broken : kBroken) {
    INFO(broken.what);
    const std::string data = folder.write("data.csv", broken.text),
                      scene = folder.write("scene.yaml", scene_of(broken));
    const std::string message = message_of(scene);
    INFO(message);
    const std::string place = broken.line < 0   ? data + ":"
                              : broken.line > 0 ? data + ":" + std::to_string(broken.line) + ":"
                                                : scene + ":3:";
    CHECK(message.starts_with(place));
    CHECK(message.find(broken.needed) != std::string::npos);
  }
}

TEST_CASE("a data file that is not there is named with its neighbour", "[identify]") {
  const TemporaryFolder folder;
  folder.write("dat.csv", kGood);
  const std::string message = message_of(folder.write("scene.yaml", scene_of({"", "", 0, ""})));
  CHECK(message.find("data.csv") != std::string::npos);
  CHECK(message.find("did you mean") != std::string::npos);
}

TEST_CASE("columns in any unit and spelling of their heads are the same data", "[identify]") {
  const TemporaryFolder folder;
  const auto data_of = [&](const std::string& text, const std::string& more) {
    folder.write("data.csv", text);
    const IdentifyTask task =
        load_identify_task(folder.write("scene.yaml", scene_of({"", "", 0, "", "uniaxial", more})), built_in_catalog());
    return as_strain_and_stress(task.tests.front(), load_data(task.tests.front()));
  };
  const MeasuredData expected = data_of("stretch,nominal_stress [Pa]\n1.1,1000\n1.25,2000\n", "");
  CHECK(expected.x[1] == Approx(0.25));
  CHECK(expected.y[1] == 2000);
  const std::vector<std::pair<std::string, std::string>> same{
      // Specimens side by side, of which this one is the shorter; with and without marks of the empty fields.
      {"A,,B,\nDisp (mm),Load (N),Disp (mm),Load (N)\n4,0.04,1,1\n10,0.08,2,2\n,,3,3\n,,4,4\n",
       ", columns: {1: 'displacement [mm]', 2: 'force [N]'}, length: 40 mm, cross_section: 40 mm2"},
      {"A,,B,\nDisp (mm),Load (N),Disp (mm),Load (N)\n1,1,4,0.04\n2,2,10,0.08\n3,3,,\n4,4\n",
       ", columns: {3: 'displacement [mm]', 4: 'force [N]'}, length: 40 mm, cross_section: 40 mm2"},
      {"# a remark\nstretch,nominal_stress_kPa\n1.1,1\n1.25,2\n", ""},
      {"nominal_strain [%],nominal_stress (kPa)\r\n10,1\r\n25,2\r\n", ""},
      // The same unit in the name and below, in any spelling; of another one the scene says which counts.
      {"nominal_strain [%];nominal_stress (N/mm2)\n(%);[MPa]\n10;0.001\n25;0.002\n", ""},
      {"nominal_strain [%];nominal_stress (MPa)\n%;kPa\n10;1\n25;2\n", ", columns: {2: 'nominal_stress [kPa]'}"},
      {"\xEF\xBB\xBFnominal_stress / MPa,true_strain\n0.001,0.0953101798\n0.002,0.22314355131\n", ""},
      {"stretch;nominal_stress [kPa]\n1,1;1\n1,25;2\n", ""},
      {"stretch\tnominal_stress [Pa]\n1.1\t1,000\n1.25\t2,000\n", ""},
      {"1;1.000\n1,1;1.000\n1,25;2.000\n", ", from: 1.05, columns: {1: stretch, 2: 'nominal_stress [Pa]'}"},
      {"stretch,true_stress [kPa]\n1.1,1.1\n1.25,2.5\n", ""},
      {"Ext,Load,note\n4,0.04,a\n10,0.08,b\n",
       ", columns: {Ext: 'displacement [mm]', Load: 'force [N]'}, length: 40 mm, cross_section: 40 mm2"},
  };
  for (const auto& [text, more] : same) {
    INFO(text);
    const MeasuredData data = data_of(text, more);
    CHECK((data.x - expected.x).norm() < 1e-9);
    CHECK((data.y - expected.y).norm() < 1e-6);
  }
}

TEST_CASE("units that machines have in addition to SI are read", "[identify]") {
  const std::vector<std::pair<std::string, double>> forces{{"daN", 10},
                                                           {"dyn", 1e-5},
                                                           {"kp", 9.80665},
                                                           {"kgf", 9.80665},
                                                           {"gf", 9.80665e-3},
                                                           {"lbf", 4.4482216152605},
                                                           {"lbs", 4.4482216152605},
                                                           {"ozf", 0.27801385095378}};
  for (const auto& [unit, newtons] : forces) {
    INFO(unit);
    CHECK(machine_unit(unit, dimension::force).value_or(0) == Approx(newtons));
  }
  CHECK(machine_unit("kgf/cm2", dimension::pressure).value_or(0) == Approx(98066.5));
  CHECK(machine_unit("gf/mm²", dimension::pressure).value_or(0) == Approx(9806.65));
  CHECK(machine_unit("in/in", dimension::none).value_or(0) == 1);
  CHECK(!machine_unit("dyn", dimension::pressure));
}

TEST_CASE("shear strain and shear stress are the columns of a test in shear", "[identify]") {
  const TemporaryFolder folder;
  folder.write("data.csv", "Shear strain (%),Shear stress (kPa)\n10,0.4\n25,1\n");
  const IdentifyTask task =
      load_identify_task(folder.write("scene.yaml", scene_of({"", "", 0, "", "shear"})), built_in_catalog());
  const MeasuredData data = load_data(task.tests.front());
  CHECK(data.x.isApprox(Eigen::Vector2d(0.1, 0.25)));
  CHECK(data.y.isApprox(Eigen::Vector2d(400, 1000)));
}
