#include "core/model/visit_state.h"

#include <cmath>

#include "elastin/core/base/error.h"

namespace elastin {
namespace {

void check_field(const char* name, const Positions& given, int molecules, const std::string& what) {
  if (given.cols() != molecules)
    throw InputError(what + " is another body's: " + std::to_string(given.cols()) + " " + name + ", not " +
                     std::to_string(molecules));
  if (!given.allFinite()) throw InputError(what + " is damaged: its " + name + " are not all finite");
}

void check_contact(const ContactHistory& entry, int molecules, const std::string& what) {
  bool sound = entry.count >= 0 && entry.count <= 3;
  for (std::size_t i = 0; sound && i < static_cast<std::size_t>(entry.count); ++i)
    sound = entry.molecules[i] >= 0 && entry.molecules[i] < molecules;
  if (!sound) throw InputError(what + " is damaged: a contact point of a molecule that does not exist");
}

}  // namespace

void check_state(const State& state, int molecules, const std::vector<HistoryBlock>& history, const std::string& what) {
  check_field("positions", state.positions, molecules, what);
  check_field("velocities", state.velocities, molecules, what);
  if (state.accelerations.cols() > 0) check_field("accelerations", state.accelerations, molecules, what);
  if (!std::isfinite(state.time)) throw InputError(what + " is damaged: its time is not finite");
  for (const ContactHistory& entry : state.contact_history) check_contact(entry, molecules, what);
  if (state.history.empty()) return;
  for (const HistoryBlock& block : state.history)
    for (const double value : block.values)
      if (!std::isfinite(value)) throw InputError(what + " is damaged: history '" + block.name + "' is not all finite");
  const auto fits = [](const HistoryBlock& own, const HistoryBlock& declared) {
    return own.name == declared.name && own.values.size() == declared.values.size();
  };
  if (!std::equal(state.history.begin(), state.history.end(), history.begin(), history.end(), fits))
    throw InputError(what + " has a history that this model does not have: another material, load or body made it");
}

}  // namespace elastin
