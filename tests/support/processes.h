#pragma once
#include <barrier>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "elastin/core/model/share.h"

namespace elastin::testing {

/// What the threads that play processes have between them.
struct Table {
  explicit Table(int processes)
      : numbers(static_cast<std::size_t>(processes)), all(processes), letters(numbers.size()) {}
  std::vector<std::vector<double>> numbers;
  std::barrier<> all;
  std::mutex guard;
  std::vector<std::deque<std::vector<char>>> letters;  ///< that process 0 has sent
};

class Thread final : public Processes {
 public:
  Thread(Table& table, int rank) : table_(table), rank_(rank) {}
  int rank() const override { return rank_; }
  int count() const override { return static_cast<int>(table_.numbers.size()); }
  std::vector<double> gather(std::span<const double> own) const override {
    table_.numbers[rank_].assign(own.begin(), own.end());
    table_.all.arrive_and_wait();
    std::vector<double> together;
    for (const auto& one : table_.numbers) together.insert(together.end(), one.begin(), one.end());
    table_.all.arrive_and_wait();
    return together;
  }
  void send(int to, const std::vector<char>& bytes) const override {
    const std::lock_guard lock(table_.guard);
    table_.letters[to].push_back(bytes);
  }
  std::vector<char> receive(int) const override {
    while (true) {
      {
        const std::lock_guard lock(table_.guard);
        auto& mine = table_.letters[rank_];
        if (!mine.empty()) {
          std::vector<char> bytes = std::move(mine.front());
          mine.pop_front();
          return bytes;
        }
      }
      std::this_thread::yield();
    }
  }

 private:
  Table& table_;
  int rank_;
};

/// The result of work(processes), of each process.
template <class Work>
auto on_processes(int count, Work work) {
  using Result = decltype(work(std::shared_ptr<const Processes>()));
  Table table(count);
  std::vector<Result> results(static_cast<std::size_t>(count));
  std::vector<std::thread> threads;
  for (int rank = 0; rank < count; ++rank)
    threads.emplace_back([&, rank] { results[rank] = work(std::make_shared<const Thread>(table, rank)); });
  for (std::thread& thread : threads) thread.join();
  return results;
}

}  // namespace elastin::testing
