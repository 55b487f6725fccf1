#pragma once
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "elastin/core/model/body.h"
#include "elastin/core/model/material.h"

/// What the cases share: the cube they run on, how time and memory are taken, and the rows they report.
namespace bench {

inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// What was measured, in SI units; NaN where it does not apply. Trivially copyable: it comes from a child through a
/// pipe.
struct Figures {
  double molecules = kNone;
  double springs = kNone;
  double cells = kNone;
  double build = kNone;        ///< median [s] of making all that the solve needs: body, constants, model, matrix
  double minimum = kNone;      ///< [s]
  double median = kNone;       ///< [s]
  double each = kNone;         ///< the minimum a spring [s]
  double each_cell = kNone;    ///< the minimum a cell [s]
  double rate = kNone;         ///< springs a second, at the minimum; of whole steps at the median
  double bandwidth = kNone;    ///< [B/s], at the minimum
  double allowed = kNone;      ///< springs a second that the measured bandwidth allows
  double ratio = kNone;        ///< the peer's best minimum on no more threads over this minimum: > 1 is faster
  double whole_ratio = kNone;  ///< the same of build + solve medians: what one solve costs from nothing
  double behind = kNone;       ///< this median over that of Elastin's lattice steps: what those are ahead by
  double late = kNone;         ///< 99 % of the steps take no longer [s]
  double later = kNone;        ///< 99.9 % of them [s]
  double most = kNone;         ///< all of them [s]
  double missed = kNone;       ///< steps that ended after their deadline
  double asked = kNone;        ///< for memory, how many times
  double parts = kNone;        ///< in how many parts a step goes
  double newton = kNone;       ///< Newton iterations
  double iterations = kNone;   ///< of conjugate gradients, all Newton iterations together
  double residual = kNone;  ///< ‖b − K x‖/‖b‖ with the assembled matrix; of Newton, unbalanced force over loads
  double error = kNone;     ///< relative
  double peak = kNone;      ///< [B]: how far the peak of the process's resident memory grew
};

struct Row {
  std::string scenario;  ///< the case, "static"
  std::string method;
  int side = 0;  ///< molecules along the cube's side; of blocks of tetrahedra, cubes along the shortest side
  int threads = 1, repeats = 1;
  Figures figures;
  std::string note;
};

struct Settings {
  int repeats = 5;
  std::vector<int> sides{10, 22, 47}, threads{1, 2};
  double seconds = 60;  ///< of steady stepping
  std::string only;     ///< of embed and derivatives, what a row's name has in it
};

/// Gives each molecule the radius and mass that a scene would.
void set_matter(elastin::Body& body, int side);
/// The body of scenes/tension/cube-1000.yaml with `side`³ molecules: a cube of 86 cm, axis and face connections.
elastin::Body make_cube(int side);
inline constexpr double kCubeLength = 0.86;  // m
inline constexpr elastin::Material kMaterial{.youngs_modulus = 1e5};

struct Sample {
  double minimum, median;  ///< [s]
};
Sample summary(std::vector<double> seconds);
double seconds_of(const std::function<void()>& work);

/// Runs all once unmeasured, then all in turn, `repeats` times: what disturbs the machine then disturbs all alike.
std::vector<Sample> interleaved(const std::vector<std::function<void()>>& contenders, int repeats,
                                bool by_processor = false);

/// Runs work in a child process and returns what it returns; throws std::runtime_error if the child fails. Memory peaks
/// only ever rise in a process, and OpenMP does not survive a fork, so nothing is measured in the parent.
std::vector<Figures> in_child(const std::function<std::vector<Figures>()>& work);

/// Peak resident memory of this process so far [B].
double peak_memory();

/// One line: processor, cores, how busy they were, compiler, flags.
std::string machine();
void print_rows(const std::vector<Row>& rows);
void write_csv(const std::string& path, const std::string& machine, const std::vector<Row>& rows);
/// A line on stderr about what runs now.
void say(const std::string& doing);

/// a = b + s c over 240 MB: bytes read and written a second, those that a cache fetches to write into not counted. At
/// each number of threads.
std::vector<Figures> triad(const Settings& settings);

std::vector<Row> run_static(const Settings& settings);
std::vector<Row> run_derivatives(const Settings& settings);
std::vector<Row> run_forces(const Settings& settings);
std::vector<Row> run_steps(const Settings& settings);
std::vector<Row> run_embed(const Settings& settings);
std::vector<Row> run_laws(const Settings& settings);
std::vector<Row> run_identify(const Settings& settings);
std::vector<Row> run_cut(const Settings& settings);

}  // namespace bench
