#include "fuzz/kinds.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>

#include "elastin/core/base/error.h"
#include "elastin/core/simulation/catalog.h"
#include "elastin/mesh/mesh_file.h"
#include "lab/format/csv.h"
#include "lab/run/step_control.h"
#include "lab/scene/scene.h"
#include "lab/study/journal.h"
#include "lab/study/plan.h"

namespace fuzz {
namespace {

namespace fs = std::filesystem;
using elastin::InputError;

/// Bodies here are small: what takes long with them is a fault.
constexpr double kMostMolecules = 1000;

/// A restart is of some run: the text says of which.
constexpr const char* kIdentity = "uniform,symplectic_euler,0123456789abcdef";

std::string bytes_of(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write(const fs::path& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

/// Files below a folder with one of these endings, in the order of their names.
std::vector<fs::path> files_below(const fs::path& folder, const std::vector<std::string>& endings) {
  std::vector<fs::path> found;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (std::find(endings.begin(), endings.end(), entry.path().extension().string()) != endings.end())
      found.push_back(entry.path());
  std::sort(found.begin(), found.end());
  return found;
}

const elastin::Catalog& catalog() {
  static const elastin::Catalog all = elastin::built_in_catalog();
  return all;
}

void read_scene(const std::string& path, const std::vector<std::string>& overrides = {}) {
  const auto scene = elastin::lab::load_scene(path, catalog(), overrides, kMostMolecules);
  elastin::lab::combinations(scene->study.axes);
}

/// Fewer molecules in each direction, so that many scenes are read in a second.
std::string made_small(const std::string& scene) {
  static const std::regex counts("(molecules|cells|cubes|squares|divisions|rings): *(\\[[0-9, ]*\\]|[0-9]+)");
  static const std::regex number("[0-9]+");
  std::string out;
  auto from = scene.cbegin();
  for (std::sregex_iterator found(scene.begin(), scene.end(), counts), end; found != end; ++found) {
    out.append(from, (*found)[2].first);
    out += std::regex_replace((*found)[2].str(), number, "4");
    from = (*found)[2].second;
  }
  return out.append(from, scene.cend());
}

/// Scenes, and the mesh files that they name.
Kind scenes(const fs::path& source, const fs::path& folder) {
  Kind kind{"scene", {}, [](const std::string& path) { read_scene(path); }, true};
  fs::create_directories(folder / ".." / "tension");
  for (const fs::path& file : files_below(source / "scenes", {".msh", ".stl", ".csv"})) {
    const fs::path at = file.parent_path().filename() == "tension" ? folder / ".." / "tension" : folder;
    fs::copy_file(file, at / file.filename(), fs::copy_options::overwrite_existing);
  }
  for (const fs::path& file : files_below(source / "scenes", {".yaml"}))
    kind.seeds.push_back({".yaml", made_small(bytes_of(file))});
  return kind;
}

constexpr const char* kMeshScene =
    "title: a mesh\nbody: {mesh: {file: x, length_unit: mm}, radius: 1 mm}\n"
    "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, thickness: 1 mm}\nstiffness: standard\n"
    "experiment: {kind: tension, axis: z, displacement: 0.1 mm}\n";
constexpr const char* kFillScene =
    "title: a filling\nbody: {fill: {file: x, length_unit: m, spacing: 0.4 m, connections: {within: 0.7 m}}}\n"
    "material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3}\nstiffness: standard\n"
    "experiment: {kind: tension, axis: z, displacement: 0.1 mm}\n";
constexpr const char* kInp =
    "*HEADING\na cell\n** comment\n*NODE, NSET=ALL\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n"
    "*ELEMENT, TYPE=C3D4, ELSET=BODY\n7, 1, 2,\n3, 4\n*NSET, NSET=BASE, GENERATE\n1, 3, 1\n*NSET, NSET=TOP\n4, BASE\n";
constexpr const char* kObj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
constexpr const char* kPly =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
    "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
constexpr const char* kStl =
    "solid s\nfacet normal 0 0 -1\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 1 0 0\nendloop\nendfacet\n"
    "facet normal 0 -1 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\nendloop\nendfacet\n"
    "facet normal 1 1 1\nouter loop\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet\n"
    "facet normal -1 0 0\nouter loop\nvertex 0 1 0\nvertex 0 0 0\nvertex 0 0 1\nendloop\nendfacet\nendsolid s\n";

/// The same tetrahedron as binary files.
std::string binary_stl() {
  std::string out(80, ' ');
  const auto put = [&](const auto& value) { out.append(reinterpret_cast<const char*>(&value), sizeof value); };
  const float points[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  put(4);
  for (const auto& face : faces) {
    for (int i = 0; i < 3; ++i) put(0.F);
    for (const int corner : face)
      for (const float x : points[corner]) put(x);
    put(static_cast<short>(0));
  }
  return out;
}
std::string binary_ply() {
  std::string out(kPly);
  out.replace(out.find("ascii"), 5, "binary_little_endian");
  out.resize(out.find("end_header\n") + 11);
  const auto put = [&](const auto& value) { out.append(reinterpret_cast<const char*>(&value), sizeof value); };
  for (const float x : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F}) put(x);
  for (const auto& face : {std::array{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}) {
    put('\3');
    for (const int corner : face) put(corner);
  }
  return out;
}

/// Reads the file, and builds and fills bodies with it.
Kind meshes(const fs::path& source, const fs::path& folder) {
  write(folder / "mesh.yaml", kMeshScene);
  write(folder / "fill.yaml", kFillScene);
  Kind kind{"mesh",
            {},
            [folder](const std::string& path) {
              if (elastin::mesh::load_mesh(path).points.cols() > kMostMolecules) return;
              const std::string name = fs::path(path).filename().string();
              for (const char* shape : {"mesh", "fill"}) try {
                  const std::string key = "body." + std::string(shape) + ".file=";
                  read_scene((folder / shape).string() + ".yaml", {key + name});
                } catch (const InputError&) {  // it was read, and makes no such body
                }
            },
            false};
  for (const fs::path& file : files_below(source / "tests" / "mesh" / "data", {".msh", ".vtk", ".vtu", ".bdf", ".unv"}))
    kind.seeds.push_back({file.extension().string(), bytes_of(file)});
  for (const auto& [ending, text] : std::initializer_list<Seed>{
           {".obj", kObj},
           {".inp", kInp},
           {".ply", kPly},
           {".stl", kStl},
           {".stl", binary_stl()},
           {".ply", binary_ply()},
           {".off", "COFF\n4 4 0\n0 0 0 1\n1 0 0 1\n0 1 0 1\n0 0 1 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3 7\n"}})
    kind.seeds.push_back({ending, text});
  return kind;
}

Kind tables() {
  Kind kind{"table",
            {},
            [](const std::string& path) {
              const elastin::lab::Csv csv = elastin::lab::load_csv(path);
              for (std::size_t row = 0; row < csv.rows.size(); ++row)
                for (std::size_t column = 0; column < csv.head.size(); ++column) csv.number(row, column);
            },
            true};
  kind.seeds = {{".csv", "method,minimum_s,error\nlattice,0.1,0.02\n\"a, \"\"b\"\"\",1e-3,\n"},
                {".csv", "x,y\n1,2\n3,4\n"}};
  return kind;
}

Kind restarts() {
  Kind kind{
      "restart", {}, [](const std::string& path) { elastin::lab::parse_restart(bytes_of(path), kIdentity); }, false};
  elastin::lab::RestartPoint point;
  point.frame = 3;
  point.state.positions = point.state.velocities = point.state.accelerations = elastin::Positions::Random(3, 4);
  point.state.contact_history.resize(2);
  point.history.resize(2);
  point.history[1].measures.set("force", 2);
  kind.seeds.push_back({".restart", elastin::lab::restart_text(point, kIdentity)});
  return kind;
}

/// What --set and --vary are given, a line each, on a scene with most of the keys.
Kind overrides(const fs::path& source, const fs::path& folder) {
  fs::copy_file(source / "scenes" / "tension" / "table1-b.yaml", folder / "base.yaml",
                fs::copy_options::overwrite_existing);
  Kind kind{"override",
            {},
            [folder](const std::string& path) {
              std::ifstream stream(path, std::ios::binary);
              std::vector<std::string> lines;
              for (std::string line; std::getline(stream, line) && lines.size() < 8;) lines.push_back(line);
              try {
                read_scene((folder / "base.yaml").string(), lines);
              } catch (const InputError&) {
              }
              std::vector<elastin::lab::StudyAxis> axes;
              for (const std::string& line : lines) axes.push_back(elastin::lab::read_axis(line));
              elastin::lab::combinations(axes);
            },
            false};
  kind.seeds = {{".txt", "body.lattice.molecules=[3, 3, 3]\nmaterial.youngs_modulus=10 kPa\n"},
                {".txt", "material.poissons_ratio=[0.1, 0.2, 0.3]\nsolver={tolerance: 1e-6}\n"},
                {".txt", "{body.lattice.molecules: [[3, 3, 3], [4, 4, 4]], stiffness: [uniform, lattice]}\n"},
                {".txt", "strategies.0=uniform\nexpect.0.value=5 kPa\nloads=[]\n"}};
  return kind;
}

const elastin::lab::RunSource kSource{"a \"b\"", "0123456789abcdef", {}};

Kind journals(const fs::path& folder) {
  Kind kind{"journal",
            {},
            [folder](const std::string& path) {
              fs::create_directories(folder / "journal");
              fs::copy_file(path, folder / "journal" / "runs.jsonl", fs::copy_options::overwrite_existing);
              elastin::lab::Journal(folder / "journal", true, {kSource});
            },
            false};
  elastin::lab::Record record;
  record.scene = "a \"b\"", record.run.strategy = "uniform";
  record.run.measures.set("effective_modulus", 1e4);
  record.verdicts.resize(1);
  record.warnings = {"one"};
  fs::create_directories(folder / "journal");
  elastin::lab::Journal(folder / "journal", false, {kSource}).add("0123456789abcdef", kSource, record);
  kind.seeds.push_back({".jsonl", bytes_of(folder / "journal" / "runs.jsonl")});
  return kind;
}

Kind studies(const fs::path& folder) {
  Kind kind{"study",
            {},
            [folder](const std::string& path) {
              fs::create_directories(folder / "study");
              fs::copy_file(path, folder / "study" / "study.json", fs::copy_options::overwrite_existing);
              elastin::lab::read_study(folder / "study");
            },
            false};
  elastin::lab::Request request;
  request.out = folder / "study";
  request.shard = {2, 3};
  request.overrides = {"material.youngs_modulus=1"};
  std::vector<elastin::lab::ScenePlan> plans(1);
  plans[0].name = "a \"b\"";
  plans[0].strategies = {"uniform", "lattice"};
  plans[0].threads = {0, 2};
  plans[0].combinations = {{{"body.lattice.molecules", "[3, 3, 3]"}}, {}};
  fs::create_directories(folder / "study");
  elastin::lab::write_study(request, plans);
  kind.seeds.push_back({".json", bytes_of(folder / "study" / "study.json")});
  return kind;
}

}  // namespace

std::vector<Kind> all_kinds(const std::string& source, const std::string& folder) {
  return {scenes(source, folder),    meshes(source, folder), tables(),       restarts(),
          overrides(source, folder), journals(folder),       studies(folder)};
}

}  // namespace fuzz
