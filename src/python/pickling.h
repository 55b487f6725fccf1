#pragma once
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>

#include "core/base/archive.h"
#include "lab/study/visit_result.h"
#include "python/bind.h"

namespace elastin::python {

/// What a program of the same version on the same kind of machine reads back: its checksum first.
template <class Thing>
py::bytes packed(Thing thing) {
  ByteWriter writer;
  std::string version = ELASTIN_VERSION;
  writer.word(version);
  visit(writer, thing);
  std::vector<char> bytes = writer.take();
  const std::uint64_t sum = checksum(bytes.data(), bytes.size());
  const auto* first = reinterpret_cast<const char*>(&sum);
  bytes.insert(bytes.begin(), first, first + sizeof sum);
  return {bytes.data(), bytes.size()};
}

/// Throws InputError where another version wrote it, or it is cut off or damaged. `what` names it in messages.
template <class Thing>
std::shared_ptr<Thing> unpacked(const py::bytes& bytes, const char* what) {
  const auto text = static_cast<std::string>(bytes);
  std::uint64_t sum = 0;
  if (text.size() < sizeof sum) throw InputError(std::string(what) + " is cut off");
  std::memcpy(&sum, text.data(), sizeof sum);
  const char* begin = text.data() + sizeof sum;
  const std::size_t size = text.size() - sizeof sum;
  if (checksum(begin, size) != sum) throw InputError(std::string(what) + " is damaged: its checksum does not hold");
  ByteReader reader(begin, size, what);
  std::string version;
  reader.word(version);
  if (version != ELASTIN_VERSION)
    throw InputError(std::string(what) + ": version " + version +
                     " has pickled it; version " ELASTIN_VERSION " reads its own");
  auto thing = std::make_shared<Thing>();
  visit(reader, *thing);
  return thing;
}

}  // namespace elastin::python
