#pragma once
#include <string>
#include <unordered_map>
#include <vector>

#include "lab/report/records.h"

namespace elastin::lab {

/// A file of lines that only grows: each line whole or not there at all, whatever ends the program.
class LineFile {
 public:
  /// Starts an empty file, or with `keep` goes on after the last whole line. Nobody else may write to it meanwhile.
  /// Throws InputError naming the path.
  LineFile(std::string path, bool keep);
  ~LineFile();
  LineFile(const LineFile&) = delete;
  LineFile& operator=(const LineFile&) = delete;
  /// Throws InputError naming the path where the line cannot be written whole; those before it stay.
  void add(const std::string& line);
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  int file_ = -1;
};

/// The lines of such a file; a last one that was cut off does not count.
std::vector<std::string> lines_of(const std::string& path);

/// What a scene's runs in a journal are made from: another content gives other runs, whatever the scene is called.
struct RunSource {
  std::string scene;                   ///< its name
  std::string content;                 ///< key_of its file's text
  std::vector<std::string> overrides;  ///< KEY.PATH=VALUE of the command line
  bool operator==(const RunSource&) const = default;
};

/// Why runs of another source must not be put together with those that `who`, "this command", wants: "contains runs of
/// …"; "" if they may.
std::string mismatch(const RunSource& there, const std::vector<RunSource>& wanted, const std::string& who);

/// A finished run as a journal has it.
struct JournalEntry {
  std::string key;
  RunSource source;
  Record record;
  std::string line;  ///< all of it, as it is written
};

/// A JSON object's text with its checksum as the last key: what has changed in it since is noticed.
std::string with_sum(std::string object);

/// The finished runs in a folder. Throws InputError with the line that is no run, or whose checksum does not hold.
std::vector<JournalEntry> journal_of(const std::string& folder);

/// The finished runs of a comparison, in DIR/runs.jsonl, and what its page shows of them in 3D, in DIR/views.jsonl.
class Journal {
 public:
  /// `resume`: takes the runs that are there, all of which must come from one of the sources: throws InputError that
  /// says what is there and what is wanted. Otherwise both files start empty.
  Journal(const std::string& folder, bool resume, const std::vector<RunSource>& sources);
  /// The run that was finished under this key, or nullptr.
  const Record* find(const std::string& key) const;
  void add(const std::string& key, const RunSource& source, const Record& record);
  void add_view(const std::string& line) { views_.add(line); }
  const std::string& views_path() const { return views_.path(); }

 private:
  std::unordered_map<std::string, Record> finished_;
  LineFile runs_, views_;
};

/// The identity of a run, in 16 letters: a change of any of the parts gives another.
std::string key_of(const std::vector<std::string>& parts);

}  // namespace elastin::lab
