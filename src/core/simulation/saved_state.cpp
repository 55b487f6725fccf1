#include "elastin/core/simulation/saved_state.h"

#include <cstdint>
#include <cstring>
#include <string>

#include "core/base/archive.h"
#include "core/forces/visit_support.h"
#include "core/model/visit_body.h"
#include "elastin/core/base/error.h"

namespace elastin {
namespace {

/// Grows with every change of what follows. Read as a number it also states the byte order.
constexpr std::uint64_t kMark = 0x656c617374310006;  // "elast1", version 6

/// Stands before the state.
struct Head {
  std::uint64_t mark = kMark, length = 0, checksum = 0;
};

}  // namespace

inline auto members(Coupling& coupling) {
  return std::tie(coupling.id, coupling.molecule, coupling.stiffness, coupling.damping, coupling.position,
                  coupling.velocity);
}
inline auto members(SimulationState::HostSupport& support) { return std::tie(support.molecule, support.next); }
inline auto members(StepBound& bound) {
  return std::tie(bound.frequency, bound.damping_rate, bound.added_square, bound.added_rate);
}
inline auto members(Pose& pose) { return std::tie(pose.turn, pose.position); }
inline auto members(Tool& tool) { return std::tie(tool.pose, tool.next); }
inline auto members(Topology& topology) {
  return std::tie(topology.body, topology.constants, topology.origin, topology.stiffness);
}

template <class Archive>
void visit(Archive& archive, SimulationState& saved) {
  std::optional<Topology> topology;
  if (saved.topology) topology = *saved.topology;
  visit_each(archive, saved.state, saved.supports, saved.host_forces, saved.couplings, saved.host_supports,
             saved.others_supports, saved.tools, saved.effort, saved.seen.frequency, saved.seen.turn,
             saved.seen.positions, saved.seen.elastic_forces, saved.bound, saved.rest_moments, topology);
  if constexpr (Archive::reads)
    if (topology) saved.topology = std::make_shared<const Topology>(std::move(*topology));
}

std::vector<char> bytes_of(const SimulationState& state) {
  ByteWriter writer;
  SimulationState copy = state;
  visit(writer, copy);
  const std::vector<char> body = writer.take();
  const Head head{kMark, body.size(), checksum(body.data(), body.size())};
  std::vector<char> bytes(sizeof head + body.size());
  std::memcpy(bytes.data(), &head, sizeof head);
  std::memcpy(bytes.data() + sizeof head, body.data(), body.size());
  return bytes;
}

SimulationState simulation_state_of(const void* bytes, std::size_t size) {
  Head head;
  if (size < sizeof head) throw InputError("this is no saved state");
  std::memcpy(&head, bytes, sizeof head);
  if (head.mark >> 16 != kMark >> 16) throw InputError("this is no saved state, or that of another kind of machine");
  if (head.mark != kMark)
    throw InputError("this saved state has version " + std::to_string(head.mark & 0xffff) + "; version " +
                     std::to_string(kMark & 0xffff) + " is read");
  const char* body = static_cast<const char*>(bytes) + sizeof head;
  const std::size_t left = size - sizeof head;
  if (left < head.length) throw InputError("the saved state is cut off");
  if (left > head.length)
    throw InputError("the saved state is followed by " + std::to_string(left - head.length) + " bytes");
  if (checksum(body, left) != head.checksum) throw InputError("the saved state is damaged: its checksum does not hold");
  ByteReader reader(body, left, "the saved state");
  SimulationState state;
  visit(reader, state);
  if (reader.left() > 0) throw InputError("the saved state is damaged: more stands in it than a state");
  return state;
}

}  // namespace elastin
