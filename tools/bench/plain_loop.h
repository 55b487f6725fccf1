#pragma once
#include <atomic>
#include <functional>
#include <thread>
#include <vector>

#include "elastin/core/model/body.h"

/// The peer of the force passes: what one writes by hand, on threads of its own.
namespace bench {

/// Where a fixed number of threads wait for each other. Looks for a while before it sleeps: sleeping and waking costs
/// more than a small pass, and looking forever starves the rest of a busy machine.
class Gate {
 public:
  explicit Gate(int size) : size_(size) {}
  void arrive_and_wait() {
    const int round = round_.load();
    if (arrived_.fetch_add(1) + 1 == size_) {
      arrived_ = 0;
      round_ = round + 1;
      round_.notify_all();
      return;
    }
    for (int look = 0; look < 20000; ++look)
      if (round_.load() != round) return;
    round_.wait(round);
  }

 private:
  int size_;
  std::atomic<int> arrived_{0}, round_{0};
};

/// Threads that wait for work: starting one a pass would cost more than a small pass itself.
class Team {
 public:
  explicit Team(int size) : size_(size), start_(size), end_(size) {
    for (int member = 1; member < size; ++member)
      others_.emplace_back([this, member] {
        for (start_.arrive_and_wait(); work_; start_.arrive_and_wait()) {
          (*work_)(member);
          end_.arrive_and_wait();
        }
      });
  }
  ~Team() {
    work_ = nullptr;
    start_.arrive_and_wait();
  }
  int size() const { return size_; }
  /// Calls work(member) once for each member, each on its own thread.
  void run(const std::function<void(int member)>& work) {
    work_ = &work;
    start_.arrive_and_wait();
    work(0);
    end_.arrive_and_wait();
  }
  /// Where a member's part of `count` items begins; it ends where the next one's begins.
  int begin(int member, int count) const { return static_cast<int>(static_cast<long long>(count) * member / size_); }

 private:
  int size_;
  Gate start_, end_;
  const std::function<void(int)>* work_ = nullptr;
  std::vector<std::jthread> others_;
};

struct Springs {
  const elastin::Connections& connections;
  const elastin::VectorX& constants;
};

/// One loop over the connections that adds ± k (1 − L/l) d to both ends; on several threads each has forces of its own,
/// which are added up afterwards. forces[0] is the result.
void plain_forces(Team& team, const Springs& springs, const elastin::Positions& positions,
                  std::vector<elastin::Positions>& forces);

}  // namespace bench
