#pragma once
#include <memory>
#include <string>

#include "core/base/archive.h"
#include "lab/study/visit_result.h"
#include "python/bind.h"

namespace elastin::python {

/// What a program of the same version on the same kind of machine reads back.
template <class Thing>
py::bytes packed(Thing thing) {
  ByteWriter writer;
  std::string version = ELASTIN_VERSION;
  writer.word(version);
  visit(writer, thing);
  const std::vector<char> bytes = writer.take();
  return {bytes.data(), bytes.size()};
}

/// Throws InputError where another version wrote it, or it is cut off. `what` names it in messages.
template <class Thing>
std::shared_ptr<Thing> unpacked(const py::bytes& bytes, const char* what) {
  const auto text = static_cast<std::string>(bytes);
  ByteReader reader(text.data(), text.size(), what);
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
