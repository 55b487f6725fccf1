#include "measure.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "elastin/core/shapes/shapes.h"
#include "lab/report/machine.h"
#include "lab/report/table.h"

namespace bench {
namespace {

struct Column {
  const char* key;   // in the CSV, with its SI unit
  const char* head;  // of the table
  double Figures::*value;
  std::string (*text)(double);
};

/// Three digits, from nanoseconds to minutes.
std::string seconds_text(double seconds) {
  for (const auto& [unit, name] : {std::pair{1., "s"}, {1e-3, "ms"}, {1e-6, "µs"}})
    if (seconds >= 0.9995 * unit) return fmt::format("{:#.3g} {}", seconds / unit, name);
  return fmt::format("{:#.3g} ns", seconds * 1e9);
}

std::string millions(double value) { return fmt::format("{:.1f}", value / 1e6); }

constexpr Column kColumns[] = {
    {"molecules", "molecules", &Figures::molecules, [](double v) { return fmt::format("{:.0f}", v); }},
    {"springs", "springs", &Figures::springs, [](double v) { return fmt::format("{:.0f}", v); }},
    {"cells", "cells", &Figures::cells, [](double v) { return fmt::format("{:.0f}", v); }},
    {"build_s", "build", &Figures::build, seconds_text},
    {"minimum_s", "minimum", &Figures::minimum, seconds_text},
    {"median_s", "median", &Figures::median, seconds_text},
    {"s_per_spring", "a spring", &Figures::each, seconds_text},
    {"s_per_cell", "a cell", &Figures::each_cell, seconds_text},
    {"springs_per_s", "Mspring/s", &Figures::rate, millions},
    {"bandwidth_B_per_s", "GB/s", &Figures::bandwidth, [](double v) { return fmt::format("{:.1f}", v / 1e9); }},
    {"springs_per_s_allowed", "memory allows", &Figures::allowed, millions},
    {"peer_over_this", "peer/this", &Figures::ratio, [](double v) { return fmt::format("{:.2f}", v); }},
    {"peer_over_this_with_build", "with build", &Figures::whole_ratio,
     [](double v) { return fmt::format("{:.2f}", v); }},
    {"over_elastin_lattice", "elastin ahead", &Figures::behind, [](double v) { return fmt::format("{:.2f}", v); }},
    {"late_s", "99 %", &Figures::late, seconds_text},
    {"later_s", "99.9 %", &Figures::later, seconds_text},
    {"most_s", "most", &Figures::most, seconds_text},
    {"missed", "missed", &Figures::missed, [](double v) { return fmt::format("{:.0f}", v); }},
    {"allocations", "allocations", &Figures::asked, [](double v) { return fmt::format("{:.0f}", v); }},
    {"parts", "parts", &Figures::parts, [](double v) { return fmt::format("{:.0f}", v); }},
    {"newton_iterations", "Newton", &Figures::newton, [](double v) { return fmt::format("{:.0f}", v); }},
    {"cg_iterations", "CG", &Figures::iterations, [](double v) { return fmt::format("{:.0f}", v); }},
    {"residual", "residual", &Figures::residual, [](double v) { return fmt::format("{:.1e}", v); }},
    {"error", "error", &Figures::error, [](double v) { return fmt::format("{:.4f} %", 100 * v); }},
    {"peak_B", "peak MB", &Figures::peak, millions},
};

std::string quoted(std::string text) {
  std::replace(text.begin(), text.end(), '"', '\'');
  return '"' + text + '"';
}

}  // namespace

void set_matter(elastin::Body& body, int side) {
  elastin::set_matter(body, kCubeLength / (side - 1) / 2, kMaterial.density, 0, std::pow(kCubeLength, 3));
}

elastin::Body make_cube(int side) {
  elastin::Body cube = elastin::cubic_lattice({side, side, side}, kCubeLength / (side - 1),
                                              {.axis = true, .face = true, .space = false});
  set_matter(cube, side);
  return cube;
}

Sample summary(std::vector<double> seconds) {
  std::sort(seconds.begin(), seconds.end());
  const std::size_t half = seconds.size() / 2;
  return {seconds.front(), seconds.size() % 2 ? seconds[half] : (seconds[half - 1] + seconds[half]) / 2};
}

double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

namespace {

double processor_seconds_of(const std::function<void()>& work) {
  const auto now = [] {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  };
  const double start = now();
  work();
  return now() - start;
}

}  // namespace

std::vector<Sample> interleaved(const std::vector<std::function<void()>>& contenders, int repeats, bool by_processor) {
  for (const auto& contender : contenders) contender();
  std::vector<std::vector<double>> seconds(contenders.size());
  for (int repeat = 0; repeat < repeats; ++repeat)
    for (std::size_t i = 0; i < contenders.size(); ++i)
      seconds[i].push_back(by_processor ? processor_seconds_of(contenders[i]) : seconds_of(contenders[i]));
  std::vector<Sample> samples;
  for (auto& times : seconds) samples.push_back(summary(std::move(times)));
  return samples;
}

std::vector<Figures> in_child(const std::function<std::vector<Figures>()>& work) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no child process");
  if (child == 0) {
    close(ends[0]);
    try {
      const std::vector<Figures> found = work();
      const std::size_t bytes = found.size() * sizeof(Figures);
      _exit(write(ends[1], found.data(), bytes) == static_cast<ssize_t>(bytes) ? 0 : 1);
    } catch (const std::exception& error) {
      fmt::print(stderr, "{}\n", error.what());
      _exit(1);
    }
  }
  close(ends[1]);
  std::vector<Figures> found;
  for (Figures one; read(ends[0], &one, sizeof one) == static_cast<ssize_t>(sizeof one);) found.push_back(one);
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw std::runtime_error(WIFSIGNALED(status) ? fmt::format("a measurement died of signal {}", WTERMSIG(status))
                                                 : "a measurement failed");
  return found;
}

double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024. * static_cast<double>(usage.ru_maxrss);
}

std::string machine() { return elastin::lab::this_machine().text(); }

void print_rows(const std::vector<Row>& rows) {
  std::vector<const Column*> shown;
  for (const Column& column : kColumns)
    if (std::any_of(rows.begin(), rows.end(), [&](const Row& row) { return !std::isnan(row.figures.*column.value); }))
      shown.push_back(&column);
  std::vector<std::string> head{"side", "method", "threads", "repeats"};
  for (const Column* column : shown) head.push_back(column->head);
  head.push_back("");
  elastin::lab::Table table(head);
  for (const Row& row : rows) {
    std::vector<elastin::lab::TableCell> cells{{row.side ? std::to_string(row.side) : "", {}, true},
                                               {row.method},
                                               {std::to_string(row.threads), {}, true},
                                               {std::to_string(row.repeats), {}, true}};
    for (const Column* column : shown) {
      const double value = row.figures.*column->value;
      cells.push_back({std::isnan(value) ? "" : column->text(value), {}, true});
    }
    cells.push_back({row.note});
    table.add(std::move(cells));
  }
  fmt::print("{}\n", table.text(false));
}

void write_csv(const std::string& path, const std::string& machine, const std::vector<Row>& rows) {
  std::ofstream file(path);
  file << "case,side,method,threads,repeats";
  for (const Column& column : kColumns) file << ',' << column.key;
  file << ",note,machine\n";
  for (const Row& row : rows) {
    file << fmt::format("{},{},{},{},{}", row.scenario, row.side, quoted(row.method), row.threads, row.repeats);
    for (const Column& column : kColumns) {
      const double value = row.figures.*column.value;
      file << ',' << (std::isnan(value) ? "" : fmt::format("{:.6g}", value));
    }
    file << ',' << quoted(row.note) << ',' << quoted(machine) << '\n';
  }
  if (!file.flush()) throw std::runtime_error("cannot write " + path);
}

void say(const std::string& doing) { fmt::print(stderr, "{} …\n", doing); }

}  // namespace bench
