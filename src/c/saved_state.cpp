#include "c/saved_state.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>

#include "elastin/core/base/error.h"

namespace elastin::c {
namespace {

/// Grows with every change of what follows. Read as a number it tells the byte order too.
constexpr std::uint64_t kMark = 0x656c617374310001;  // "elast1", version 1

/// Appends what it is shown.
struct Writer {
  std::vector<char> bytes;
  void raw(void* data, std::size_t size) {
    const char* from = static_cast<const char*>(data);
    bytes.insert(bytes.end(), from, from + size);
  }
  std::uint64_t count(std::uint64_t present, std::size_t /*bytes_each*/) {
    raw(&present, sizeof present);
    return present;
  }
};

/// Fills what it is shown.
struct Reader {
  const char* at;
  std::size_t left;
  void raw(void* data, std::size_t size) {
    if (size > left) throw InputError("the saved state is cut off");
    std::memcpy(data, at, size);
    at += size, left -= size;
  }
  std::uint64_t count(std::uint64_t, std::size_t bytes_each) {
    std::uint64_t given = 0;
    raw(&given, sizeof given);
    if (given > left / bytes_each) throw InputError("the saved state is cut off");
    return given;
  }
};

// Each part is told once, for both ways.

template <class Archive, class Number>
requires std::is_arithmetic_v<Number>
void pass(Archive& archive, Number& number) { archive.raw(&number, sizeof number); }

template <class Archive>
void pass(Archive& archive, Vector3& vector) {
  archive.raw(vector.data(), 3 * sizeof(double));
}
template <class Archive>
void pass(Archive& archive, Matrix3& matrix) {
  archive.raw(matrix.data(), 9 * sizeof(double));
}

template <class Archive>
void pass(Archive& archive, Positions& positions) {
  const auto columns = archive.count(static_cast<std::uint64_t>(positions.cols()), 3 * sizeof(double));
  positions.resize(3, static_cast<Eigen::Index>(columns));
  archive.raw(positions.data(), 3 * sizeof(double) * columns);
}

template <class Archive, class Item>
void pass_all(Archive& archive, std::vector<Item>& items) {
  items.resize(archive.count(items.size(), 1));  // an item takes more than a byte
  for (Item& item : items) pass(archive, item);
}

template <class Archive>
void pass(Archive& archive, ContactHistory& entry) {
  pass(archive, entry.sample), pass(archive, entry.target), pass(archive, entry.count);
  for (int& molecule : entry.molecules) pass(archive, molecule);
  for (double& weight : entry.weights) pass(archive, weight);
  pass(archive, entry.offset), pass(archive, entry.multiplier);
}

template <class Archive>
void pass(Archive& archive, Support& support) {
  pass(archive, support.molecule), pass(archive, support.free);
  pass(archive, support.displacement), pass(archive, support.velocity);
}

template <class Archive>
void pass(Archive& archive, Coupling& coupling) {
  pass(archive, coupling.id), pass(archive, coupling.molecule), pass(archive, coupling.stiffness),
      pass(archive, coupling.damping);
  pass(archive, coupling.position), pass(archive, coupling.velocity);
}

template <class Archive>
void pass(Archive& archive, SimulationState::HostSupport& support) {
  pass(archive, support.molecule);
  std::uint8_t moves = support.next.has_value();
  pass(archive, moves);
  if (moves > 1) throw InputError("the saved state is damaged");
  if (moves && !support.next) support.next.emplace();
  if (moves) pass(archive, *support.next);
}

template <class Archive>
void pass(Archive& archive, SimulationState& saved) {
  State& state = saved.state;
  pass(archive, state.positions), pass(archive, state.velocities), pass(archive, state.time);
  pass(archive, state.accelerations), pass_all(archive, state.contact_history);
  pass_all(archive, saved.supports), pass(archive, saved.host_forces);
  pass_all(archive, saved.couplings), pass_all(archive, saved.host_supports), pass(archive, saved.others_supports);
}

}  // namespace

std::vector<char> bytes_of(const SimulationState& state) {
  Writer writer;
  std::uint64_t mark = kMark;
  pass(writer, mark);
  SimulationState copy = state;
  pass(writer, copy);
  return std::move(writer.bytes);
}

SimulationState state_of(const void* bytes, std::size_t size) {
  Reader reader{static_cast<const char*>(bytes), size};
  std::uint64_t mark = 0;
  if (size < sizeof mark) throw InputError("this is no saved state");
  pass(reader, mark);
  if (mark >> 16 != kMark >> 16) throw InputError("this is no saved state, or that of another kind of machine");
  if (mark != kMark)
    throw InputError("this saved state has version " + std::to_string(mark & 0xffff) + "; version " +
                     std::to_string(kMark & 0xffff) + " is read");
  SimulationState state;
  pass(reader, state);
  if (reader.left > 0) throw InputError("the saved state is followed by " + std::to_string(reader.left) + " bytes");
  return state;
}

}  // namespace elastin::c
