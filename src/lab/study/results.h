#pragma once
#include <string>
#include <vector>

#include "lab/report/page.h"
#include "lab/study/plan.h"
#include "lab/study/request.h"

namespace elastin::lab {

/// The rows of a comparison in the order of its plan, and all that is reported of them: tables on the screen, files,
/// page.
class Results {
 public:
  /// Reads the peers and the baseline that the request names, which must outlive this. Throws InputError.
  explicit Results(const Request& request);
  /// A row, or of a later repeat (> 0) one more time of the row that is there.
  void add(Record record, int repeat);
  const std::vector<Record>& records() const { return records_; }
  bool has_body(const Record& record) const;  ///< whether some row has the scene and the variant of this one

  /// The table of one scene of a comparison, as soon as its rows are there: with its warnings, but of a study.
  void print_scene(const ScenePlan& plan) const;
  /// What a page shows in addition to its rows.
  struct Origin {
    std::string machine, command;
    std::vector<std::string> views;  ///< lines of body_view and states_view
  };
  /// When all rows are there: the tables of studies, the summary, runs.csv, runs.json, and with `page` the page and its
  /// plots. `stopped`: some rows are not there.
  void finish(const std::vector<ScenePlan>& plans, bool stopped, bool page, Origin origin);

 private:
  std::vector<Record> records_of(const std::string& scene) const;
  void print_table(const ScenePlan& plan) const;
  void refer_to_own_values(const std::vector<ScenePlan>& plans);
  void complete_failed_rows();

  const Request& request_;
  std::vector<Record> records_, baseline_;
  std::vector<Peer> peers_;
};

}  // namespace elastin::lab
