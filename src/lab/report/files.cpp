#include "lab/report/files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <system_error>

#include "contact/search.h"
#include "core/base/named.h"
#include "elastin/core/base/error.h"
#include "elastin/core/model/share.h"
#include "lab/format/vtu.h"
#include "lab/report/varied.h"
#include "lab/run/cell_stress.h"

namespace elastin::lab {

namespace {

constexpr std::string_view kNotInNames = "/\\\"'<>&|*?~ ";

/// No two texts may have one name: of the letters that are written otherwise only ":" becomes "-".
std::string written(const std::string& text, std::string_view otherwise) {
  std::string name;
  for (const char c : text)
    if (otherwise.find(c) != std::string_view::npos)
      name += fmt::format("~{:02x}", c);
    else
      name += c == ':' ? '-' : c;
  return name;
}

}  // namespace

std::string file_name(const std::string& scene) { return written(scene, kNotInNames); }

std::string file_name(const std::string& scene, const std::string& strategy) {
  return file_name(scene) + "-" + written(strategy, std::string(kNotInNames) + "-");
}

std::string csv_number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

std::string csv_field(std::string text) {
  if (!text.empty() && std::string_view("=+-@").find(text[0]) != std::string_view::npos) text.insert(0, 1, '\'');
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

namespace {

/// "elongation [m]"
std::string headed(const MeasureInfo& info) {
  const std::string unit = info.unit_text();
  return info.name + (unit.empty() ? "" : " [" + unit + "]");
}

/// "body.lattice.molecules=[5, 5, 5]; …": what a study has changed.
std::string variant_field(const Record& record) {
  return csv_field(joined(
      record.variant, [](const auto& changed) { return changed.first + "=" + changed.second; }, "; "));
}

/// The measures that some row has.
std::vector<const MeasureInfo*> columns_of(const Record& record) {
  const std::vector<CurvePoint>& rows = record.run.curve;
  std::vector<const MeasureInfo*> columns;
  for (const MeasureInfo& info : record.measures ? *record.measures : built_in_measures())
    if (std::any_of(rows.begin(), rows.end(),
                    [&](const CurvePoint& row) { return std::isfinite(row.measures.get(info.name)); }))
      columns.push_back(&info);
  return columns;
}

/// Connections as lines, then triangles, tetrahedra and the cells of blocks by VTK's types.
void add_cells(VtuArrays& arrays, std::string& out, const Body& body) {
  const OwnSimplices written(body);
  const auto for_each = [&](auto&& visit) {  // visit(corners, type)
    const auto visit_all = [&](const auto& cells, int type) {
      for (const auto& cell : cells) visit(cell, type);
    };
    visit_all(body.connections.ends, 3);
    if (written.triangles) visit_all(body.triangles, 5);
    if (written.tetrahedra) visit_all(body.tetrahedra, 10);
    for (const CellBlock& block : body.blocks)
      for (int cell = 0; cell < block.size(); ++cell) visit(block.cell(cell), block.kind->vtk);
  };
  out += "<Cells>\n";
  arrays.add_pushed<std::int32_t>("connectivity", "Int32", 1, [&](auto&& push) {
    for_each([&](const auto& cell, int) { std::for_each(cell.begin(), cell.end(), push); });
  });
  // Of a billion connections there are more corners than 32 bits count.
  arrays.add_pushed<std::int64_t>("offsets", "Int64", 1, [&](auto&& push) {
    std::int64_t end = 0;
    for_each([&](const auto& cell, int) { push(end += static_cast<std::int64_t>(cell.size())); });
  });
  arrays.add_pushed<std::uint8_t>("types", "UInt8", 1,
                                  [&](auto&& push) { for_each([&](const auto&, int type) { push(type); }); });
  out += "</Cells>\n";
}

/// Dimensions of each of these cells.
std::vector<int> file_dimensions(const Body& body) {
  const OwnSimplices written(body);
  std::vector<int> dimensions(written.triangles, 2);
  dimensions.resize(written.triangles + written.tetrahedra, 3);
  for (const CellBlock& block : body.blocks)
    dimensions.resize(dimensions.size() + static_cast<std::size_t>(block.size()), block.kind->dimensions);
  return dimensions;
}

/// As write_whole, of what write(stream) writes; that throws std::system_error where it cannot.
void write_whole_by(const std::string& path, const std::function<void(std::ostream&)>& write) {
  std::error_code problem;
  // A pipe or a device is not replaced by a file; a link stays, and what it points to is replaced.
  const bool special = std::filesystem::exists(path, problem) && !std::filesystem::is_regular_file(path, problem);
  std::filesystem::path target(path);
  if (!special) target = std::filesystem::weakly_canonical(path, problem);
  if (problem) target = path;
  problem.clear();
  if (target.has_parent_path()) std::filesystem::create_directories(target.parent_path(), problem);
  if (problem) throw InputError(path + ": cannot make its folder: " + problem.message());
  const std::string draft = special ? path : target.string() + ".part";
  problem.clear();
  std::ofstream stream(draft, std::ios::binary);
  if (!stream) problem = std::error_code(errno, std::generic_category());
  try {
    if (stream) write(stream);
  } catch (const std::system_error& failed) {
    problem = failed.code();
  }
  stream.close();
  if (!problem && !stream) problem = std::error_code(errno, std::generic_category());
  if (!problem && !special) std::filesystem::rename(draft, target, problem);
  if (!problem) return;
  std::error_code ignored;
  if (!special) std::filesystem::remove(draft, ignored);
  throw InputError(path + ": cannot write: " + problem.message());
}

}  // namespace

void write_whole(const std::string& path, const std::string& text) {
  write_whole_by(path, [&](std::ostream& stream) { stream << text; });
}

std::string csv_text(const std::vector<Record>& records) {
  std::vector<std::string> errors;
  for (const Record& record : records)
    for (const auto& [name, value] : record.errors)
      if (std::find(errors.begin(), errors.end(), name) == errors.end()) errors.push_back(name);
  MeasureList measures = built_in_measures();
  for (const Record& record : records)
    if (record.measures) measures.add(*record.measures);
  std::string out = "scene,strategy,solver,outcome,molecules,connections,cells,threads";
  for (const MeasureInfo& info : measures) out += "," + headed(info);
  for (const std::string& name : errors) out += ",error " + name;
  out +=
      ",build [s],solve [s],repeats,median "
      "[s],variant,iterations,linear_iterations,residual,zero_energy_modes,warnings";
  const std::vector<std::string> keys = varied_keys(records);
  for (const std::string& key : keys) {
    std::string unit;
    for (const Record& record : records)
      if (const auto value = varied_number(varied_text(record, key))) unit = si_unit(value->unit);
    out += "," + csv_field(key + (unit.empty() ? "" : " [" + unit + "]"));
  }
  out += "\n";
  for (const Record& record : records) {
    const Run& run = record.run;
    out += fmt::format("{},{},{},{},{},{},{},{}", csv_field(record.scene), csv_field(run.strategy), run.solver,
                       outcome_name(run), record.molecules, record.connections, record.cells, record.threads);
    for (const MeasureInfo& info : measures) out += "," + csv_number(run.measures.get(info.name));
    for (const std::string& name : errors) out += "," + csv_number(record.error(name));
    std::string notes = run.cause;
    for (const std::string& warning : record.warnings) notes += (notes.empty() ? "" : "; ") + warning;
    out += fmt::format(",{},{},{},{},{},{},{},{},{},{}", csv_number(run.build_seconds), csv_number(run.solve_seconds),
                       std::max<std::size_t>(1, record.repeats.size()), csv_number(record.median_seconds()),
                       variant_field(record), run.newton_iterations, run.linear_iterations, csv_number(run.residual),
                       run.zero_energy_modes, csv_field(notes));
    for (const std::string& key : keys) {
      const std::string text = varied_text(record, key);
      const auto value = varied_number(text);
      out += "," + (value ? csv_number(value->number) : csv_field(text));
    }
    out += "\n";
  }
  return out;
}

std::string curve_csv_text(const Record& record) {
  const bool in_time = record.run.time.has_value();
  const std::vector<const MeasureInfo*> columns = columns_of(record);
  std::string out = in_time ? "time [s]" : "load_factor";
  for (const MeasureInfo* info : columns) out += "," + headed(*info);
  out += in_time ? ",step [s],steps,newton_iterations,linear_iterations\n"
                 : ",newton_iterations,linear_iterations,residual\n";
  for (const CurvePoint& row : record.run.curve) {
    out += csv_number(in_time ? row.time : row.load_factor);
    for (const MeasureInfo* info : columns) out += "," + csv_number(row.measures.get(info->name));
    if (in_time) out += fmt::format(",{},{}", csv_number(row.step), row.steps);
    out += fmt::format(",{},{}{}\n", row.newton_iterations, row.linear_iterations,
                       in_time ? "" : "," + csv_number(row.residual));
  }
  return out;
}

namespace {

/// vtu_text; what is ready goes to the stream where there is one, so that a large body's file is never whole in memory.
/// `states`: of file_states.
VtuDeclared put_vtu(const Body& body, const Snapshot& shot, const std::vector<CellState>& states,
                    const VectorX& constants, std::string& out, std::ostream* stream) {
  VtuDeclared declared;
  const int n = body.size(), m = body.connections.size();
  const auto& ends = body.connections.ends;
  const auto& rest_length = body.connections.rest_length;
  const Positions& positions = shot.positions;
  const auto along = [&](int c) -> Vector3 { return positions.col(ends[c][1]) - positions.col(ends[c][0]); };
  const auto length = [&](int c) { return along(c).norm(); };
  Positions of_connections;
  const bool has_forces = shot.elastic_forces.size() > 0;
  if (!has_forces) of_connections.setZero(3, n);
  for (int c = 0; !has_forces && c < m; ++c) {
    of_connections.col(ends[c][0]) += shot.force_densities[c] * along(c);
    of_connections.col(ends[c][1]) -= shot.force_densities[c] * along(c);
  }
  const Positions& force = has_forces ? shot.elastic_forces : of_connections;
  const int cells = m + static_cast<int>(states.size());
  out += vtu_head(n, cells) + "<Points>\n";
  VtuArrays arrays(out, stream);
  arrays.add("positions", "Float64", 3, n, [&](int i, int k) { return positions(k, i); });
  declared.points = arrays.declared();
  out += "</Points>\n<PointData Vectors=\"displacement\">\n";
  arrays.add("displacement", "Float64", 3, n, [&](int i, int k) { return positions(k, i) - body.rest(k, i); });
  arrays.add("elastic_force", "Float64", 3, n, [&](int i, int k) { return force(k, i); });
  arrays.add("radius", "Float64", 1, n, [&](int i, int) { return body.radius[i]; });
  arrays.add("mass", "Float64", 1, n, [&](int i, int) { return body.mass[i]; });
  if (shot.contact_pressure.size()) {
    arrays.add("contact_pressure", "Float64", 1, n, [&](int i, int) { return shot.contact_pressure[i]; });
    arrays.add("contact_force", "Float64", 3, n, [&](int i, int k) { return shot.contact_forces(k, i); });
  }
  declared.point_data = arrays.declared();
  out += "</PointData>\n<CellData Scalars=\"strain\">\n";
  const auto state = [&](int cell) -> const CellState& { return states[cell - m]; };
  const auto of_connection = [&](const char* name, const auto& value) {
    arrays.add(name, "Float64", 1, cells, [&](int cell, int) { return cell < m ? value(cell) : 0; });
  };
  arrays.add("strain", "Float64", 1, cells, [&](int cell, int) {
    if (cell >= m) return largest_strain(state(cell));
    return rest_length[cell] > 0 ? length(cell) / rest_length[cell] - 1 : 0;
  });
  of_connection("tension", [&](int c) { return shot.force_densities[c] * length(c); });
  of_connection("force_density", [&](int c) { return shot.force_densities[c]; });
  if (constants.size()) of_connection("constant", [&](int c) { return constants[c]; });
  if (!states.empty()) {
    const std::vector<int> dimensions = file_dimensions(body);
    const auto has = [&](int wanted) {
      return std::find(dimensions.begin(), dimensions.end(), wanted) != dimensions.end();
    };
    const auto is = [&](int cell, int wanted) { return cell >= m && (wanted == 0 || dimensions[cell - m] == wanted); };
    const auto tensor = [&](const char* name, int wanted, Matrix3 CellState::*value) {
      arrays.add(name, "Float64", 9, cells,
                 [&](int cell, int k) { return is(cell, wanted) ? (state(cell).*value)(k / 3, k % 3) : 0; });
    };
    tensor("green_strain", 0, &CellState::strain);
    if (has(2)) tensor("membrane_stress", 2, &CellState::stress);
    if (has(3)) {
      tensor("stress", 3, &CellState::stress);
      arrays.add("von_mises", "Float64", 1, cells,
                 [&](int cell, int) { return is(cell, 3) ? von_mises(state(cell)) : 0; });
    }
  }
  declared.cell_data = arrays.declared();
  out += "</CellData>\n";
  add_cells(arrays, out, body);
  out += kVtuEnd;
  arrays.flush();
  return declared;
}

/// What a process computes of a body of which it has a share, with the molecules of these elements.
struct Piece {
  Body body;
  std::vector<int> molecules, connections, triangles, tetrahedra;
  std::vector<int> block_cells;  ///< of the share's blocks, counted through
};
Piece piece_of(const Body& share) {
  const Subdomain own = computed_by(share);
  Piece piece;
  std::vector<int> local(static_cast<std::size_t>(share.size()), -1);
  const auto reach = [&](const auto& elements) {
    for (const auto& element : elements)
      for (const int molecule : element) local[molecule] = 0;
  };
  for (std::size_t c = 0; c < own.computes.size(); ++c)
    if (own.computes[c]) piece.connections.push_back(static_cast<int>(c));
  Body& body = piece.body;
  for (const int c : piece.connections) {
    body.connections.ends.push_back(share.connections.ends[c]);
    body.connections.rest_length.push_back(share.connections.rest_length[c]);
    body.connections.cell_sides += c >= share.connections.proper();
  }
  piece.triangles = own.triangles, piece.tetrahedra = own.tetrahedra;
  for (const int cell : own.triangles) body.triangles.push_back(share.triangles[cell]);
  for (const int cell : own.tetrahedra) body.tetrahedra.push_back(share.tetrahedra[cell]);
  reach(body.connections.ends), reach(body.triangles), reach(body.tetrahedra);
  int number = 0;
  for (const CellBlock& all : share.blocks) {
    CellBlock& block = body.blocks.emplace_back(CellBlock{all.kind, {}, {}});
    for (int cell = 0; cell < all.size(); ++cell, ++number) {
      const auto nodes = all.cell(cell);
      if (!own.owns(lowest_in_whole(share, nodes))) continue;
      block.nodes.insert(block.nodes.end(), nodes.begin(), nodes.end());
      piece.block_cells.push_back(number);
    }
    for (const int molecule : block.nodes) local[molecule] = 0;
  }
  for (int molecule = 0; molecule < share.size(); ++molecule) {
    int& here = local[molecule];
    if (here < 0 && molecule >= own.owned) continue;
    here = static_cast<int>(piece.molecules.size());
    piece.molecules.push_back(molecule);
  }
  const auto renumber = [&](auto& elements) {
    for (auto& element : elements)
      for (int& molecule : element) molecule = local[molecule];
  };
  renumber(body.connections.ends), renumber(body.triangles), renumber(body.tetrahedra);
  for (CellBlock& block : body.blocks)
    for (int& molecule : block.nodes) molecule = local[molecule];
  body.rest = share.rest(Eigen::all, piece.molecules);
  body.mass = share.mass(piece.molecules), body.radius = share.radius(piece.molecules);
  return piece;
}

/// Of its cells, out of those of all cells around them, whose force densities the sides have.
std::vector<CellState> piece_states(const Body& share, const Snapshot& shot, const Piece& piece) {
  const OwnSimplices written(share);
  const std::vector<CellState> all = cell_states(share, shot);
  std::vector<CellState> own;
  for (const int cell : written.triangles ? piece.triangles : std::vector<int>()) own.push_back(all[cell]);
  for (const int cell : written.tetrahedra ? piece.tetrahedra : std::vector<int>())
    own.push_back(all[written.triangles + static_cast<std::size_t>(cell)]);
  for (const int cell : piece.block_cells)
    own.push_back(all[written.triangles + written.tetrahedra + static_cast<std::size_t>(cell)]);
  return own;
}

/// The state without what the piece does not have.
Snapshot on_piece(const Snapshot& shot, const Piece& piece) {
  Snapshot own{shot.at, shot.positions(Eigen::all, piece.molecules), shot.force_densities(piece.connections),
               shot.number};
  own.elastic_forces = shot.elastic_forces(Eigen::all, piece.molecules);
  return own;
}

std::string piece_file(const std::string& name, int number, int process) {
  return fmt::format("{}-{:03}.p{}.vtu", name, number, process);
}

}  // namespace

std::string shape_vtu_text(const Body& body, const Positions& positions) {
  Snapshot shape;
  shape.positions = positions;
  shape.force_densities = VectorX::Zero(body.connections.size());
  return vtu_text(body, shape, {});
}

std::string vtu_text(const Body& body, const Snapshot& shot, const VectorX& constants) {
  std::string out;
  put_vtu(body, shot, cell_states(body, shot), constants, out, nullptr);
  return out;
}

std::string cells_vtu_text(const Body& body, const std::vector<std::pair<std::string, VectorX>>& of_cells) {
  std::string out = vtu_head(body.size(), static_cast<int>(cells_in_blocks(body))) + "<Points>\n";
  VtuArrays arrays(out);
  arrays.add("positions", "Float64", 3, body.size(), [&](int i, int k) { return body.rest(k, i); });
  out += "</Points>\n<CellData Scalars=\"" + of_cells.front().first + "\">\n";
  for (const auto& [name, values] : of_cells)
    arrays.add(name.c_str(), "Float64", 1, values.size(),
               [&values = values](Eigen::Index i, int) { return values[i]; });
  out += "</CellData>\n";
  add_cells(arrays, out, body);
  out += kVtuEnd;
  arrays.flush();
  return out;
}

void write_pieces(const std::string& folder, const std::string& name, const Body& share, const Run& run) {
  const Piece piece = piece_of(share);
  const Processes& processes = *share.share->processes;
  const VectorX constants = run.constants.size() ? VectorX(run.constants(piece.connections)) : VectorX();
  std::string collection = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
  for (const Snapshot& shot : run.snapshots) {
    VtuDeclared declared;
    std::string failed;
    try {
      write_whole_by(folder + "/" + piece_file(name, shot.number, processes.rank()), [&](std::ostream& stream) {
        std::string out;
        declared =
            put_vtu(piece.body, on_piece(shot, piece), piece_states(share, shot, piece), constants, out, &stream);
      });
    } catch (const InputError& error) {
      failed = error.what();
    }
    failed = first_over(share, failed);  // no file names a piece that is not there
    if (!failed.empty()) throw InputError(failed);
    if (processes.rank() > 0) continue;
    std::vector<std::string> pieces;
    for (int process = 0; process < processes.count(); ++process)
      pieces.push_back(piece_file(name, shot.number, process));
    const std::string file = fmt::format("{}-{:03}.pvtu", name, shot.number);
    write_whole(folder + "/" + file, pvtu_text(declared, pieces));
    collection += fmt::format("<DataSet timestep=\"{}\" file=\"{}\"/>\n", shot.at, file);
  }
  if (processes.rank() == 0) write_whole(folder + "/" + name + ".pvd", collection + "</Collection>\n</VTKFile>\n");
}

void write_states(const std::string& folder, const std::string& name, const Body& body, const Run& run) {
  const std::vector<Snapshot>& shots = run.shown();
  std::string collection = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
  const auto file_of = [&](const char* part, std::size_t number) {
    return fmt::format("{}{}-{:03}.vtu", name, part, number);
  };
  int part = 0;
  const auto list = [&](double at, const std::string& file) {
    const std::string number = part ? fmt::format(" part=\"{}\"", part) : "";
    collection += fmt::format("<DataSet timestep=\"{}\"{} file=\"{}\"/>\n", at, number, file);
  };
  const auto write = [&](double at, const std::string& file, const std::string& text) {
    write_whole(folder + "/" + file, text);
    list(at, file);
  };
  // A run that goes on from a restart file shows the frames before as well, where they still stand.
  const std::size_t first = shots.empty() ? 0 : static_cast<std::size_t>(shots.front().number);
  constexpr const char* parts[] = {"", "-surface", "-obstacles"};
  for (std::size_t frame = 0; run.time && frame < std::min(first, run.curve.size()); ++frame)
    for (part = 0; part < 3; ++part)
      if (std::filesystem::exists(folder + "/" + file_of(parts[part], frame)))
        list(run.curve[frame].time, file_of(parts[part], frame));
  // Of every frame of a run in time that would be as much again; contact is worth it.
  const bool contact = !shots.empty() && shots.front().contact_pressure.size() > 0;
  const Cells<3> surface = contact ? contact::surface_triangles(body) : Cells<3>{};
  for (const Snapshot& shot : shots) {
    const auto number = static_cast<std::size_t>(shot.number);
    part = 0;
    write_whole_by(folder + "/" + file_of(parts[part], number), [&](std::ostream& stream) {
      std::string out;
      put_vtu(body, shot, cell_states(body, shot), run.constants, out, &stream);
    });
    list(shot.at, file_of(parts[part], number));
    part = 1;
    if (!surface.empty()) write(shot.at, file_of(parts[part], number), surface_vtu_text(body, surface, shot));
    part = 2;
    const Vector3 low = shot.positions.rowwise().minCoeff(), high = shot.positions.rowwise().maxCoeff();
    if (!shot.obstacles.empty())
      write(shot.at, file_of(parts[part], number), obstacles_vtu_text(run.obstacles, shot.obstacles, low, high));
  }
  write_whole(folder + "/" + name + ".pvd", collection + "</Collection>\n</VTKFile>\n");
  if (run.found && run.found->rest != body.rest)
    write_whole(folder + "/" + name + "-unloaded.vtu", shape_vtu_text(body, run.found->rest));
}

}  // namespace elastin::lab
