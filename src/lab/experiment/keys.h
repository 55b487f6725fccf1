#pragma once
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/keys.h"
#include "elastin/lab/experiment/experiment_catalog.h"
#include "lab/experiment/pick.h"
#include "lab/experiment/tension/tension.h"
#include "lab/run/config_names.h"
#include "lab/run/ends.h"

namespace elastin::lab {

/// {axis: z, through: [0, 0, 0]}; @param what is along radius, circumference and axis, "those of fibres are"
inline Keys<RoundAxis> around_keys(const std::string& what) {
  return {key::direction("axis", &RoundAxis::direction,
                         "axis around which directions turn: " + what + " along radius, circumference and axis")
              .needed(),
          key::vector("through", &RoundAxis::point, dimension::length, "a point of the axis")};
}

/// The row of an experiment whose keys are read into a Setup. `make` is called with a setup that the keys allow; what
/// it throws gets the place of the map. A member `context` of the setup is set before anything is read.
template <class Setup, class Make>
ExperimentInfo with_keys(ExperimentInfo info, Keys<Setup> keys, Make make) {
  info.keys = keys.rows();
  info.read = [keys = std::move(keys), make = std::move(make)](Reader& reader, const ExperimentContext& context) {
    Setup own;
    if constexpr (requires { own.context; }) own.context = &context;
    Setup setup = keys.read(reader, {context.rotation, &context.body}, std::move(own));
    return reader.located([&]() -> std::unique_ptr<Experiment> {
      std::unique_ptr<Experiment> made = make(context, std::move(setup));
      if (Findings* all = context.findings) {
        const Findings& found = made->findings();
        all->notes.insert(all->notes.end(), found.notes.begin(), found.notes.end());
        all->warnings.insert(all->warnings.end(), found.warnings.begin(), found.warnings.end());
      }
      return made;
    });
  };
  return info;
}

template <class Setup>
Key<Setup> grip_depth_key(double Setup::*member) {
  return key::quantity("grip_depth", member, dimension::length,
                       "molecules that are so near to the furthest one of an end, or to the furthest voxel of an "
                       "image, belong to it",
                       kPositive)
      .otherwise("the whole end: its plane, or, where it is rough or tilted, the sides of the cells that look outward");
}

/// Molecules that are held in place of those of an end.
template <class Setup>
Key<Setup> end_key(const std::string& name, std::optional<std::vector<int>> Setup::*member, const std::string& end) {
  return {{name, "list of molecules, or [pick](#picked-molecules)", "", "0 … last molecule", "the end",
           "molecules that are held in place of " + end},
          [member](const Reader& value, Setup& setup, const Frame& frame) {
            std::vector<int> molecules = read_molecules(value, *frame.body, frame.rotation);
            std::sort(molecules.begin(), molecules.end());
            molecules.erase(std::unique(molecules.begin(), molecules.end()), molecules.end());
            setup.*member = std::move(molecules);
          }};
}

/// `fixed`, `loaded` and `grip_depth` of an experiment whose setup is a GripSetup.
template <class Setup>
std::vector<Key<Setup>> grip_keys() {
  std::vector<Key<Setup>> keys;
  const std::vector<Key<GripSetup>> own{end_key("fixed", &GripSetup::fixed, "the fixed end"),
                                        end_key("loaded", &GripSetup::loaded, "the loaded end"),
                                        grip_depth_key(&GripSetup::grip_depth)};
  for (const Key<GripSetup>& key : own) keys.emplace_back(key);
  return keys;
}

/// The axis of a body with two ends: a direction, or `longest`.
template <class Setup>
Key<Setup> axis_key(Vector3 Setup::*member, const std::string& text) {
  const Key<Setup> direction = key::direction("axis", member, text);
  SceneKey row = direction.rows().front();
  row.type += ", or `longest`";
  row.text += "; `longest`: the principal axis of inertia along which the body extends furthest";
  return {std::move(row),
          [=](const Reader& value, Setup& setup, const Frame& frame) {
            setup.longest = value.is_text() && value.text() == "longest";
            if (setup.longest)
              setup.*member = value.located([&] { return longest_axis(*frame.body); });
            else
              direction.read(value, setup, frame);
          },
          [=](Setup& setup, const Frame& frame) { direction.read(std::nullopt, setup, frame); }};
}

/// Whether two directions are perpendicular, as far as a scene can write them.
inline bool perpendicular(const Vector3& a, const Vector3& b) { return std::abs(a.dot(b)) <= 1e-6; }

/// A direction across the axis of an experiment; of `axis: longest` its part across that axis.
template <class Setup>
Key<Setup> direction_across_key(Vector3 Setup::*member, Vector3 Setup::*axis, const std::string& text) {
  return key::direction("direction", member,
                        text + ", perpendicular to `axis`; of `axis: longest` the part that is counts")
      .needed()
      .then([=](const Reader& value, Setup& setup) {
        if (!setup.longest) return;
        const Vector3 across = setup.*member - (setup.*axis).dot(setup.*member) * (setup.*axis);
        if (!(across.norm() > 0.1)) value.fail("lies along the body's longest axis; give one across it");
        setup.*member = across.normalized();
      })
      .refused_for([=](const Setup& setup) {
        return perpendicular(setup.*axis, setup.*member) ? "" : "must be perpendicular to the axis";
      });
}

template <class Setup>
Key<Setup> load_steps_key(int Setup::*member) {
  return key::whole("load_steps", member, 1, 100000, "equal steps in which the load grows");
}

template <class Setup>
Key<Setup> cross_section_key(double Setup::*member) {
  return key::quantity("cross_section", member, dimension::area, "section A that carries the load", kPositive)
      .otherwise(
          "volume over length of the cells, between the planes of `gauge` if there are any; without cells the "
          "hull of the molecules along the axis");
}

/// Fails on a length that is given in percent.
inline void refuse_percent(const Reader& length) {
  if (length.is_text() && length.text().ends_with('%'))
    length.fail("'" + length.text() + "' is no length; write strain: " + length.text());
}

/// How far something is moved along an axis (unit): a length, or a strain times the height of all bodies along it.
template <class Setup, class Member>
std::vector<Key<Setup>> travel_keys(const std::string& name, Member Setup::*member, Vector3 Setup::*axis,
                                    const std::string& text) {
  return {key::quantity(name, member, dimension::length, text, kPositive).first(refuse_percent),
          {{"strain", "number", "", "> 0", "none",
            "`" + name + "` over the height along the axis of the body, of all bodies together"},
           [=](const Reader& value, Setup& setup, const Frame& frame) {
             const VectorX heights = frame.body->rest.transpose() * (setup.*axis);
             const double height = heights.maxCoeff() - heights.minCoeff();
             if (!(height > 0)) value.fail("the body has no height along the axis: give a " + name);
             setup.*member = value.quantity(dimension::none, kPositive) * height;
           }}};
}

/// How an end is fixed.
template <class Setup>
Key<Setup> grip_key(std::string name, Grip Setup::*member, std::string text) {
  return key::choice(std::move(name), member, {{"clamped", Grip::clamped}, {"sliding", Grip::sliding}},
                     std::move(text));
}

/// Planes of symmetry through the origin, by their normals.
template <class Setup>
Key<Setup> symmetry_key(std::vector<Vector3> Setup::*member) {
  return {{"symmetry", "list of directions", "", "", "none",
           "normals of planes through the origin that cut the body, each perpendicular to the others"},
          [member](const Reader& value, Setup& setup, const Frame& frame) {
            for (const Reader& item : value.items()) {
              const Vector3 normal = frame.rotation * item.direction();
              for (const Vector3& other : setup.*member)
                if (std::abs(other.dot(normal)) > 1e-9) item.fail("must be perpendicular to the planes before it");
              (setup.*member).push_back(normal);
            }
          }};
}

/// Of a value that may not be 0, or there is nothing to measure.
template <class Setup, class Member>
Key<Setup> not_zero(Key<Setup> key, Member Setup::*member) {
  return std::move(key).then([member](const Reader& value, const Setup& setup) {
    if (setup.*member == 0) value.fail("a load of zero moves nothing: nothing can be measured");
  });
}

/// The scene's contact, to which an experiment adds obstacles. Throws InputError where the scene has none.
inline contact::ContactOptions& contact_of_scene(const ExperimentContext& context) {
  if (!context.contact)
    throw InputError("needs contact: key 'contact' of the scene is missing, for example contact: {friction: 0.3}");
  return *context.contact;
}

/// The experiment at rest that says how another one fixes and loads its body. Throws InputError with place and key.
std::unique_ptr<StaticExperiment> read_fixture(const Reader& reader, const ExperimentContext& context);

/// Of a setup with the members `fixture` and `context`.
template <class Setup>
Key<Setup> fixture_key(std::string text) {
  return {{"fixture", "experiment at rest", "", "", "none", std::move(text)},
          [](const Reader& value, Setup& setup, const Frame&) { setup.fixture = read_fixture(value, *setup.context); }};
}

/// {kind: NAME, …}, of the context's catalog. Throws InputError with source location and key.
std::unique_ptr<Experiment> read_experiment(Reader reader, const ExperimentContext& context);

/// "motion, release and creep": those that run through time.
std::string timed_experiment_names(const ExperimentCatalog& catalog);

/// Molecules that are held, with the projector on the directions in which each stays free.
using FixedMolecules = std::map<int, Matrix3>;

/// Holds the molecules that lie in planes of symmetry through the origin in the directions across these; `normals` are
/// unit and across each other. Throws InputError where the body lies on both sides of a plane, or none of it in one.
void fix_in_planes(const Body& body, const std::vector<Vector3>& normals, FixedMolecules& fixed);

}  // namespace elastin::lab
