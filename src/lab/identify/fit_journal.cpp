#include "lab/identify/fit_journal.h"

#include <nlohmann/json.hpp>

#include "elastin/core/base/error.h"

namespace elastin::lab {
namespace {

using Json = nlohmann::ordered_json;

std::unordered_map<std::string, SearchEnd> read_ends(const std::string& path) {
  std::unordered_map<std::string, SearchEnd> ends;
  int line = 0;
  for (const std::string& text : lines_of(path)) {
    ++line;
    try {
      const Json json = Json::parse(text);
      SearchEnd end;
      const auto values = json.at("values").get<std::vector<double>>();
      end.values = Eigen::Map<const VectorX>(values.data(), static_cast<Eigen::Index>(values.size()));
      end.converged = json.at("converged"), end.message = json.at("message");
      end.starts = json.at("searches"), end.agreeing = json.at("searches_at_the_least");
      end.iterations = json.at("iterations"), end.evaluations = json.at("evaluations");
      end.seconds = json.at("seconds");
      ends.insert_or_assign(json.at("key"), std::move(end));
    } catch (const Json::exception& error) {
      throw InputError(SourceLocation{path, line},
                       std::string("this line is not a search of `identify`: ") + error.what());
    }
  }
  return ends;
}

}  // namespace

FitJournal::FitJournal(const std::string& folder, bool resume)
    : ends_(resume ? read_ends(folder + "/fits.jsonl") : std::unordered_map<std::string, SearchEnd>{}),
      file_(folder + "/fits.jsonl", resume) {}

std::optional<SearchEnd> FitJournal::find(const std::string& key) const {
  const auto found = ends_.find(key);
  return found == ends_.end() ? std::nullopt : std::optional(found->second);
}

void FitJournal::add(const std::string& key, const std::string& label, const SearchEnd& end) {
  const Json json{{"key", key},
                  {"of", label},
                  {"values", std::vector<double>(end.values.begin(), end.values.end())},
                  {"converged", end.converged},
                  {"message", end.message},
                  {"searches", end.starts},
                  {"searches_at_the_least", end.agreeing},
                  {"iterations", end.iterations},
                  {"evaluations", end.evaluations},
                  {"seconds", end.seconds}};
  file_.add(json.dump(-1, ' ', false, Json::error_handler_t::replace));
  ends_.insert_or_assign(key, end);
}

}  // namespace elastin::lab
