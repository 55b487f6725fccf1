#include "elastin/core/simulation/saved_state.h"

#include <array>
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
constexpr std::uint64_t kMark = 0x656c617374310004;  // "elast1", version 4

/// Stands before the state.
struct Head {
  std::uint64_t mark = kMark, length = 0, checksum = 0;
};

}  // namespace

template <class Archive>
void visit(Archive& archive, Coupling& coupling) {
  archive.whole(coupling.id);
  archive.whole(coupling.molecule);
  for (double* value : {&coupling.stiffness, &coupling.damping}) visit(archive, *value);
  for (Vector3* value : {&coupling.position, &coupling.velocity}) visit(archive, *value);
}

template <class Archive>
void visit(Archive& archive, SimulationState::HostSupport& support) {
  archive.whole(support.molecule);
  int moves = support.next.has_value();
  archive.whole(moves);
  if (moves && !support.next) support.next.emplace();
  if (moves) visit(archive, *support.next);
}

template <class Archive>
void visit(Archive& archive, Tool& tool) {
  const auto visit_pose = [&](Pose& pose) {
    visit(archive, pose.turn);
    visit(archive, pose.position);
  };
  visit_pose(tool.pose);
  int moves = tool.next.has_value();
  archive.whole(moves);
  if (moves && !tool.next) tool.next.emplace();
  if (moves) visit_pose(*tool.next);
}

template <class Archive>
void visit(Archive& archive, SimulationState& saved) {
  visit(archive, saved.state);
  visit_all(archive, saved.supports);
  visit(archive, saved.host_forces);
  visit_all(archive, saved.couplings);
  visit_all(archive, saved.host_supports);
  archive.whole(saved.others_supports);
  visit_all(archive, saved.tools);
  archive.whole(saved.effort);
  visit(archive, saved.seen.frequency);
  archive.whole(saved.seen.turn);
  for (Positions* field : {&saved.seen.positions, &saved.seen.elastic_forces}) visit(archive, *field);
  int changed = saved.topology != nullptr;
  archive.whole(changed);
  if (!changed) return;
  Topology topology = saved.topology ? *saved.topology : Topology();
  visit(archive, topology.body);
  visit(archive, topology.constants);
  visit_all(archive, topology.origin);
  if constexpr (Archive::reads) saved.topology = std::make_shared<const Topology>(std::move(topology));
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
