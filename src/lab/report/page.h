#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "lab/report/comparison.h"
#include "lab/report/plot.h"
#include "lab/report/records.h"

namespace elastin::lab {

/// A page up to its header's text: it needs no other file.
std::string page_begin(const std::string& title, const std::string& brand);

/// Its end: what it was made with, when and where, and its scripts.
/// @param machine, command what was measured on, and the command line; may be empty
/// @param note HTML behind them
/// @param data elements in front of the scripts
std::string page_end(const std::string& machine, const std::string& command, const std::string& note = "",
                     const std::string& data = "");

/// The text of a scene's file, folded; "" where there is no such file (any more).
std::string scene_text_html(const std::string& path);

/// A plot, wide and narrow, that can be saved under a name; nothing where it has no series.
std::string figure_html(const Plot& plot, const std::string& heading, const std::string& name);

/// A heading with HTML below it.
std::string card_html(const std::string& heading, const std::string& inside);

/// What a page is made of.
struct PageMatter {
  std::vector<Record> records;     ///< of all scenes, scene by scene
  std::vector<std::string> views;  ///< lines of body_view and states_view
  std::vector<Peer> peers;
  std::string machine, command;       ///< what it was measured on, and its command line
  std::vector<Record> baseline = {};  ///< of an earlier comparison, to report what changed
  std::string baseline_name = {};     ///< its folder
};

/// One HTML page that needs no other file: for each scene the advice, error against time, the time history of the
/// load, the body in 3D, all tables and warnings; of several scenes a summary in front.
std::string page_text(const PageMatter& matter);

/// The plots of one scene as files of their own: NAME-error.svg and NAME-response.svg.
std::vector<std::pair<std::string, std::string>> plot_files(const std::vector<Record>& records,
                                                            const std::vector<Peer>& peers);

/// What a page needs to show a body in 3D, as one line of JSON without a line break: positions at rest, radii,
/// connections and surface. Bodies of more than some 60 000 connections are shown by their surface, and then by every
/// this many connections; "shown" says so.
std::string body_view(const Scene& scene, const Record& record);

/// The states that the run has kept, at most 25 of them, evenly spread, in the order of body_view: displacements of the
/// molecules [m], tensions of the connections [N], sizes of the outer forces on molecules [N]; where there are any, von
/// Mises' stress of the cell behind each side of the surface ([Pa]; of a membrane [N/m]), contact pressures of the
/// molecules [Pa]. Displacements to 2⁻²¹ of the largest of the state, all else to 2⁻¹³. "" if the run kept no state.
std::string states_view(const Scene& scene, const Record& record);

/// The text of a file of src/lab/report/page or src/web/page, put into the program when it is built: "page.css".
const char* page_part(std::string_view file);
/// three, with its notice and the controls that turn a body, as gzip.
extern const std::string_view k_three;

}  // namespace elastin::lab
