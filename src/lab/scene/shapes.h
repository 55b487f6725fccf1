#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lab/scene/parts.h"

namespace elastin::lab {

/// The order that a shape's cells are to have, which is chosen when all molecules are in their places.
struct CellOrder {
  std::optional<int> order;
  std::optional<Reader> order_place;
};
Key<CellOrder> order_key();

/// What the keys of the body get from the reading of its shape, in addition to the body.
struct ShapeContext {
  Reader& map;  ///< in which the shape is a key
  Remarks remarks;
  std::shared_ptr<const Processes> processes;
  VectorX volumes = {};  ///< of the molecules [m³]; empty: the shape does not know them
  CellOrder order = {};
};

/// A shape that bodies of scenes may have.
struct Shape {
  std::string name;
  std::string text;     ///< behind its name in the key reference, above its keys
  std::string section;  ///< of the key reference
  std::vector<SceneKey> keys;
  std::function<Body(const Reader& value, ShapeContext&)> make;
};

/// A shape with the keys of a Setup. `make` gets the setup, and the context if it takes that.
template <class Setup, class Make>
Shape shape(const std::string& name, std::string text, Keys<Setup> keys, Make make) {
  std::vector<SceneKey> rows = keys.rows();
  return {name, std::move(text), "body." + name, std::move(rows),
          [keys = std::move(keys), make = std::move(make)](const Reader& value, ShapeContext& context) -> Body {
            const Setup setup = keys.read(value);
            if constexpr (std::derived_from<Setup, CellOrder>) context.order = setup;
            if constexpr (std::invocable<Make, const Setup&>)
              return make(setup);
            else
              return make(setup, context);
          }};
}

std::vector<Shape> surface_shapes();
Shape fill_shape();

/// A key of which no body may have too many molecules.
template <class Setup, class Count>
Key<Setup> sized(Key<Setup> key, Count molecules) {
  return std::move(key).then(
      [molecules](const Reader& value, const Setup& setup) { value.check_size(molecules(setup)); });
}

/// A key of random bodies.
template <class Setup>
Key<Setup> seed_key(std::uint64_t Setup::*member) {
  return key::whole("seed", member, 0, "seed of the random numbers");
}

/// `connections.within`, where a body may have no connections of another kind.
template <class Setup>
Key<Setup> reach_key(std::optional<double> Setup::*member, std::string text, std::string otherwise) {
  return key::below(
      "connections",
      Keys<Setup>{
          key::quantity("within", member, dimension::length, std::move(text), kPositive).needed(std::move(otherwise))});
}

}  // namespace elastin::lab
