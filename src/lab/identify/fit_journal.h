#pragma once
#include <optional>
#include <string>
#include <unordered_map>

#include "lab/identify/fit.h"
#include "lab/study/journal.h"

namespace elastin::lab {

/// How the searches of a folder ended, in DIR/fits.jsonl, so that none is made twice.
class FitJournal {
 public:
  /// `resume`: takes the searches that are there; else the file starts empty. Throws InputError with the line that is
  /// none.
  FitJournal(const std::string& folder, bool resume);
  /// That of this key, which is made of all that it follows from; none if it was not made.
  std::optional<SearchEnd> find(const std::string& key) const;
  void add(const std::string& key, const std::string& label, const SearchEnd& end);

 private:
  std::unordered_map<std::string, SearchEnd> ends_;
  LineFile file_;
};

}  // namespace elastin::lab
