#pragma once
#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "elastin/core/model/body.h"

namespace elastin {

/// The history of one contact point of the body: where on the target it sticks, and the multiplier beyond its penalty.
/// Sorted by (sample, target).
struct ContactHistory {
  int sample = 0, target = 0;
  /// The anchor: offset + Σ weight · molecule of the target; on an obstacle (count 0) the offset is in its own frame.
  std::array<int, 3> molecules{-1, -1, -1};
  std::array<double, 3> weights{0, 0, 0};
  int count = 0;
  Vector3 offset = Vector3::Zero();  ///< [m]
  double multiplier = 0;             ///< pressure on the molecule that the sample is nearest to [Pa]
};

/// The history of a law or a load from one accepted step to the next: numbers under a name of its own.
struct HistoryBlock {
  std::string name;
  std::vector<double> values;
};

/// The only thing that changes during a run.
struct State {
  Positions positions;   ///< [m]
  Positions velocities;  ///< [m/s]
  double time = 0;       ///< [s]
  /// [m/s²], of the last step's end; empty before the first step. Steppers that need it go on from there.
  Positions accelerations = {};
  // Both of the last state that was reached: changed where a step is accepted, carried along by trials.
  std::vector<ContactHistory> contact_history = {};  ///< empty without contact
  std::vector<HistoryBlock> history = {};            ///< as Model::declare_history has made it; in order of name

  /// The block of this name, or null where none is declared.
  const HistoryBlock* find_history(const std::string& name) const {
    const auto found =
        std::find_if(history.begin(), history.end(), [&](const HistoryBlock& block) { return block.name == name; });
    return found == history.end() ? nullptr : &*found;
  }
  HistoryBlock* find_history(const std::string& name) {
    return const_cast<HistoryBlock*>(std::as_const(*this).find_history(name));
  }
  /// Copies the time and the history of another state; allocates only where it has less memory than that needs.
  void carry_over(const State& from) {
    time = from.time;
    contact_history = from.contact_history;
    history = from.history;
  }
};

/// The body at rest: its own positions, no velocity, time 0.
inline State state_at_rest(const Body& body) { return {body.rest, Positions::Zero(3, body.size())}; }

}  // namespace elastin
