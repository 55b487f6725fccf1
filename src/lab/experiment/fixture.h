#pragma once
#include <memory>

#include "lab/experiment/keys.h"

namespace elastin::lab {

/// The experiment at rest that says how another one fixes and loads its body. Throws InputError with place and key.
std::unique_ptr<const StaticExperiment> read_fixture(const Reader& reader, const ExperimentContext& context);

/// Of a setup with the members `fixture` and `context`.
template <class Setup>
Key<Setup> fixture_key(std::string text) {
  return {{"fixture", "experiment at rest", "", "", "none", std::move(text)},
          [](const Reader& value, Setup& setup, const Frame&) { setup.fixture = read_fixture(value, *setup.context); }};
}

}  // namespace elastin::lab
