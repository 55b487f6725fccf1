#pragma once
#include <string>
#include <vector>

#include "lab/report/records.h"

namespace elastin::lab {

/// Writes a whole file or none: to a neighbour first, then in its place. Throws InputError naming the path.
void write_whole(const std::string& path, const std::string& text);

/// How the names of a run's files begin, or of a scene's: without letters that mean something in a path or in XML.
std::string file_name(const std::string& scene, const std::string& strategy);
std::string file_name(const std::string& scene);

/// A number with all its digits, or nothing: files never hold NaN.
std::string csv_number(double value);
/// What a spreadsheet would take for a formula begins with an apostrophe, its sign for text.
std::string csv_field(std::string text);

/// One row a run; columns scene, strategy, …, every measure there is, so that files of several scenes can be joined,
/// every error, seconds.
std::string csv_text(const std::vector<Record>& records);

/// One row a load step or frame of one run; a column for each measure that some row has.
std::string curve_csv_text(const Record& record);

/// A VTU file of one state, packed by zlib: molecules as points (displacement, elastic force, radius, mass; contact
/// pressure [Pa] and force [N] where there is contact); connections as lines (strain, tension [N], force density [N/m],
/// and the spring constant [N/m] where the strategy has one), cells of any shape (largest principal strain,
/// Green–Lagrange strain, stress [Pa] and its von Mises size; of triangles the membrane stress [N/m]; see cell_states).
/// What belongs to the others is 0.
std::string vtu_text(const Body& body, const Snapshot& shot, const VectorX& constants);
/// The body in a shape alone, at these positions [m].
std::string shape_vtu_text(const Body& body, const Positions& positions);

/// The blocks of a body at rest with numbers of their cells, one or more.
std::string cells_vtu_text(const Body& body, const std::vector<std::pair<std::string, VectorX>>& of_cells);

/// Of a body of which several processes have shares, called by all: each writes what it computes of each state as
/// NAME-000.p1.vtu, the first also NAME-000.pvtu, which names these, and the collection NAME.pvd.
void write_pieces(const std::string& folder, const std::string& name, const Body& share, const Run& run);

/// Writes NAME.pvd and one NAME-STEP.vtu a load step into a folder, for ParaView; of a body with cells
/// that is at rest or has contact NAME-surface-STEP.vtu next to each, and NAME-obstacles-STEP.vtu where there are any;
/// NAME-unloaded.vtu of a run that found one. Of natural vibrations each step is a mode.
void write_states(const std::string& folder, const std::string& name, const Body& body, const Run& run);

}  // namespace elastin::lab
