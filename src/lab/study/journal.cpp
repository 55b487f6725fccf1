#include "lab/study/journal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "core/base/archive.h"
#include "elastin/core/base/error.h"
#include "lab/report/records.h"

namespace elastin::lab {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RunSource, scene, content, overrides)

namespace {

[[noreturn]] void fail(const std::string& path, int problem) {
  throw InputError(path + ": cannot write: " + std::strerror(problem));
}

/// Before the checksum of what stands before this in a line, which has 16 letters and ends the line.
constexpr std::string_view kSum = ",\"sum\":\"", kEnd = "\"}";

void check_sum(const std::string& line) {
  const std::size_t at = line.size() - std::min(line.size(), kSum.size() + 16 + kEnd.size());
  if (line.compare(at, kSum.size(), kSum) != 0)
    throw InputError("it has no checksum: an older version wrote it, or it is damaged");
  if (line != with_sum(line.substr(0, at) + "}")) throw InputError("it is damaged: its checksum does not hold");
}

JournalEntry entry_of(const std::string& line) {
  check_sum(line);
  const auto object = nlohmann::ordered_json::parse(line);
  const nlohmann::json source = nlohmann::json::parse(object.at("source").dump());
  return {object.at("key"), source.get<RunSource>(), record_of_json(object.at("run").dump()), line};
}

/// "--set a=1 --set b=2", or "no --set".
std::string overrides_text(const std::vector<std::string>& overrides) {
  return overrides.empty() ? "no --set" : fmt::format("--set {}", fmt::join(overrides, " --set "));
}

std::unordered_map<std::string, Record> read_finished(const std::string& folder,
                                                      const std::vector<RunSource>& sources) {
  std::unordered_map<std::string, Record> finished;
  for (JournalEntry& entry : journal_of(folder)) {
    if (const std::string why = mismatch(entry.source, sources, "this command"); !why.empty())
      throw InputError("--resume: " + folder + " " + why + ". Use another folder with --out");
    finished.insert_or_assign(entry.key, std::move(entry.record));
  }
  return finished;
}

}  // namespace

std::string with_sum(std::string line) {
  line.pop_back();
  const std::uint64_t sum = checksum(line.data(), line.size());
  return fmt::format("{}{}{:016x}{}", line, kSum, sum, kEnd);
}

std::string mismatch(const RunSource& there, const std::vector<RunSource>& wanted, const std::string& who) {
  std::string names;
  for (const RunSource& source : wanted) {
    if (source == there) return "";
    names += (names.empty() ? "'" : ", '") + source.scene + "'";
    if (source.scene != there.scene) continue;
    if (source.content != there.content)
      return fmt::format(
          "contains runs of another version of the scene '{}': its file has changed since, or one that it names",
          there.scene);
    return fmt::format("contains runs of the scene '{}' with {}; {} has {}", there.scene,
                       overrides_text(there.overrides), who, overrides_text(source.overrides));
  }
  return fmt::format("contains runs of the scene '{}'; {} is about {}", there.scene, who, names);
}

std::vector<JournalEntry> journal_of(const std::string& folder) {
  const std::string path = folder + "/runs.jsonl";
  std::vector<JournalEntry> entries;
  for (const std::string& line : lines_of(path)) {
    const int number = static_cast<int>(entries.size()) + 1;
    try {
      entries.push_back(entry_of(line));
    } catch (const std::exception& error) {
      throw InputError(SourceLocation{path, number},
                       std::string("this line is not a run of a comparison: ") + error.what());
    }
  }
  return entries;
}

std::vector<std::string> lines_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(stream)), {});
  std::vector<std::string> lines;
  for (std::size_t from = 0, to; (to = text.find('\n', from)) != std::string::npos; from = to + 1)
    lines.push_back(text.substr(from, to - from));
  return lines;
}

LineFile::LineFile(std::string path, bool keep) : path_(std::move(path)) {
  std::error_code problem;
  const std::filesystem::path folder = std::filesystem::path(path_).parent_path();
  if (!folder.empty()) std::filesystem::create_directories(folder, problem);
  if (problem) throw InputError(path_ + ": cannot make its folder: " + problem.message());
  file_ = open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (file_ < 0) fail(path_, errno);
  if (flock(file_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    close(file_);
    throw InputError(path_ + ": another command writes to it; let it finish, or choose another folder");
  }
  std::size_t whole = 0;
  if (keep)
    for (const std::string& line : lines_of(path_)) whole += line.size() + 1;
  if (ftruncate(file_, static_cast<off_t>(whole)) != 0) {
    const int why = errno;
    close(file_);
    fail(path_, why);
  }
}

LineFile::~LineFile() { close(file_); }

void LineFile::add(const std::string& line) {
  const std::string text = line + "\n";
  struct stat before {};
  fstat(file_, &before);
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t written = write(file_, text.data() + done, text.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      const int why = errno;
      // Should this fail too, the cut line is left out when the file is read.
      if (ftruncate(file_, before.st_size) != 0) errno = 0;
      fail(path_, why);
    }
    done += static_cast<std::size_t>(written);
  }
}

Journal::Journal(const std::string& folder, bool resume, const std::vector<RunSource>& sources)
    : finished_(resume ? read_finished(folder, sources) : std::unordered_map<std::string, Record>{}),
      runs_(folder + "/runs.jsonl", resume),
      views_(folder + "/views.jsonl", resume) {}

const Record* Journal::find(const std::string& key) const {
  const auto found = finished_.find(key);
  return found == finished_.end() ? nullptr : &found->second;
}

void Journal::add(const std::string& key, const RunSource& source, const Record& record) {
  const std::string from = nlohmann::json(source).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  runs_.add(with_sum(fmt::format("{{\"key\":\"{}\",\"source\":{},\"run\":{}}}", key, from, json_line(record))));
}

std::string key_of(const std::vector<std::string>& parts) {
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a
  const auto take = [&](unsigned char byte) { hash = (hash ^ byte) * 1099511628211u; };
  for (const std::string& part : parts) {
    for (const char c : part) take(static_cast<unsigned char>(c));
    take(0xff);  // no byte of UTF-8: "ab", "c" is not "a", "bc"
  }
  return fmt::format("{:016x}", hash);
}

}  // namespace elastin::lab
