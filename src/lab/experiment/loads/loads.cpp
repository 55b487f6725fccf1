#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/model/block_geometry.h"
#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/model/parts.h"
#include "elastin/core/model/share.h"
#include "lab/experiment/keys.h"
#include "lab/run/cell_stress.h"
#include "lab/run/common_measures.h"
#include "lab/run/contact_measures.h"

namespace elastin::lab {
namespace {

/// Molecules whose displacements and supports' forces are measured under a name.
struct ReadSet {
  std::string name;
  std::vector<int> molecules;       ///< ascending
  std::optional<RoundAxis> around;  ///< of its stresses and its turn
};

/// Molecules that are moved by a displacement [m] along some directions, free along the others.
struct MovedSet {
  std::vector<int> molecules;
  Vector3 displacement = Vector3::Zero();
  std::vector<Vector3> directions;  ///< unit, perpendicular; empty: along all
};

/// What all items together prescribe of one molecule.
struct Moved {
  Matrix3 free = Matrix3::Identity();
  Vector3 displacement = Vector3::Zero();  ///< in the directions that are not free

  /// False where another displacement is prescribed along a direction.
  bool prescribe(const Vector3& direction, const Vector3& own) {
    const double missing = direction.dot(own - displacement);
    const Vector3 left = free * direction;
    if (left.norm() < 1e-9) return std::abs(missing) <= 1e-9 * std::max(own.norm(), displacement.norm());
    displacement += missing / left.squaredNorm() * left;
    free = without_rounding(free - left * left.transpose() / left.squaredNorm());
    return true;
  }
};

struct LoadsSetup {
  std::vector<ReadSet> read;
  std::vector<MovedSet> moved;
  std::map<int, Moved> moved_molecules;  ///< of all these
  std::map<int, Moved> staying;          ///< of those whose displacement is 0: a release leaves them where they are
  int load_steps = 1;
};

constexpr std::array<const char*, 3> kAxes{"x", "y", "z"}, kRound{"radius", "circumference", "axis"};

MeasureList loads_measures(const std::vector<ReadSet>& sets) {
  using namespace dimension;
  MeasureList list{{{"largest_displacement", length, "largest displacement of a molecule", MeasureRole::displacement},
                    {"released_displacement", length,
                     "displacement of the molecule that the load had moved most, along the way in which it had"}},
                   {{"load", "largest_displacement", true}}};
  std::vector<MeasureInfo> rows;
  for (const auto* axis : kAxes)
    rows.push_back({std::string("reaction_") + axis, force, std::string("sum of all supports' forces along ") + axis,
                    MeasureRole::detail});
  for (const ReadSet& set : sets) {
    rows.push_back({set.name + "_displacement", length, "largest displacement of a molecule of `" + set.name + "`"});
    for (const auto* axis : kAxes)
      rows.push_back({set.name + "_" + axis, length, "mean displacement of `" + set.name + "` along " + axis,
                      MeasureRole::detail});
    for (const auto* axis : kAxes)
      rows.push_back({set.name + "_reaction_" + axis, force,
                      "sum of the forces of the supports of `" + set.name + "` along " + axis, MeasureRole::detail});
    if (!set.around) continue;
    rows.push_back({set.name + "_turn", none, "mean rotation of `" + set.name + "` about its axis [rad]"});
    for (const char* direction : kRound)
      rows.push_back({set.name + "_" + direction + "_stress", pressure,
                      std::string("mean Cauchy stress along ") + direction + " of the cells within `" + set.name + "`",
                      MeasureRole::detail});
  }
  for (MeasureInfo& row : rows) list.add(MeasureList{{std::move(row)}});
  return list;
}

/// A load of the scene, as large as the experiment has it now.
class GrowingLoad final : public ScaledLoad {
 public:
  GrowingLoad(std::unique_ptr<Load> load, const double& factor) : ScaledLoad(std::move(load)), factor_(factor) {}

 private:
  double factor(double) const override { return factor_; }
  const double& factor_;
};

/// A rigid body of which some molecules are moved is moved with them as a whole.
void move_rigid_parts(const Body& body, LoadsSetup& setup) {
  for (const Part& part : body.parts) {
    if (!part.rigid) continue;
    const std::vector<int> whole = molecules_of(part);
    Vector3 displacement = Vector3::Zero();
    const auto for_each_moved = [&](const auto& visit) {
      for (const int molecule : whole)
        if (const auto at = setup.moved_molecules.find(molecule); at != setup.moved_molecules.end()) visit(at->second);
    };
    for_each_moved([&](const Moved& moved) {
      if (moved.displacement.norm() > displacement.norm()) displacement = moved.displacement;
    });
    if (displacement.isZero(0)) continue;
    for_each_moved([&](const Moved& moved) {
      const Vector3 missing = displacement - moved.displacement;
      if ((missing - moved.free * missing).norm() > 1e-9 * displacement.norm())
        throw InputError("moved: '" + part.name + "' is rigid, and its molecules are moved by different displacements");
    });
    for (const int molecule : whole) setup.moved_molecules[molecule] = {Matrix3::Zero(), displacement};
    for (const int molecule : whole) setup.staying.erase(molecule);
  }
}

/// The scene's own supports and loads, which grow together from nothing; it measures displacements and reactions alone.
class Loads final : public StaticExperiment {
 public:
  Loads(const Body& body, LoadsSetup setup) : body_(body), setup_(std::move(setup)) { move_rigid_parts(body, setup_); }

  std::string name() const override { return "loads"; }
  MeasureList measures() const override { return loads_measures(setup_.read); }
  std::unique_ptr<StaticRig> make_rig(Model& model) const override;
  int load_steps() const override { return setup_.load_steps; }
  const StaticExperiment* calibration() const override { return nullptr; }  // it measures no modulus
  ResponseMeasures response_measures() const override { return {"largest_displacement", "", "released_displacement"}; }
  std::string no_reference() const override {
    return "loads of one's own prescribe no value; compare with the solid itself (neo_hookean, refined)";
  }
  std::vector<MainMeasure> main_measures(const Material&, const Measures&) const override {
    std::vector<MainMeasure> measures;
    for (const ReadSet& set : setup_.read) measures.push_back({set.name + "_displacement"});
    if (measures.empty()) measures.push_back({"largest_displacement"});
    return measures;
  }

 private:
  friend class LoadsRig;
  const Body& body_;
  LoadsSetup setup_;
};

class LoadsRig final : public StaticRig {
 public:
  LoadsRig(const Loads& experiment, Model& model) : setup_(experiment.setup_), body_(experiment.body_), model_(model) {
    const contact::Contact* contact = contact_of(model);
    for (std::unique_ptr<Load>& load : model.extract_loads()) {
      if (static_cast<const Load*>(contact) == load.get() ||
          !load->acts_at_rest())  // damping and drag stay as they are
        model.add(std::move(load));
      else
        model.add(std::make_unique<GrowingLoad>(std::move(load), factor_));
    }
    for (const auto& [molecule, moved] : setup_.moved_molecules) model.supports.push_back({molecule, moved.free});
    std::vector<Support> staying;
    for (const auto& [molecule, moved] : setup_.staying) staying.push_back({molecule, moved.free});
    model.add_supports(staying);
  }

  void set_load(double factor) override {
    factor_ = factor;
    std::size_t support = 0;
    for (const auto& [molecule, moved] : setup_.moved_molecules)
      model_.supports[support++].displacement = factor * moved.displacement;
  }

  void set_load_rate(double rate) override {
    std::size_t support = 0;
    for (const auto& [molecule, moved] : setup_.moved_molecules)
      model_.supports[support++].velocity = rate * moved.displacement;
  }

  void release(const State& loaded) override {
    set_load(0);
    model_.release_supports(0, setup_.moved_molecules.size());
    Positions motion = loaded.positions - body_.rest;
    for (const Support& support : model_.supports)
      motion.col(support.molecule) = (support.free * motion.col(support.molecule)).eval();
    const double most = motion.colwise().squaredNorm().maxCoeff(&released_);
    released_way_ = most > 0 ? Vector3(motion.col(released_) / std::sqrt(most)) : Vector3::Zero();
  }

  Measures measure(const Start&, const State& state, const StaticOptions&, StaticResult& solved) const override {
    const Positions motion = state.positions - body_.rest;
    Measures measures;
    measures.set("largest_displacement", largest(motion, all()));
    if (!released_way_.isZero(0)) measures.set("released_displacement", released_way_.dot(motion.col(released_)));
    Vector3 reaction = reaction_of(solved.reactions, nullptr);
    for (int axis = 0; axis < 3; ++axis) measures.set(std::string("reaction_") + kAxes[axis], reaction[axis]);
    double size = std::max(reaction.norm(), solved.scale);  // a closed surface's pressures have no sum
    for (const ReadSet& set : setup_.read) {
      measures.set(set.name + "_displacement", largest(motion, set.molecules));
      const Vector3 mean = mean_of(motion, set.molecules), own = reaction_of(solved.reactions, &set.molecules);
      for (int axis = 0; axis < 3; ++axis) measures.set(set.name + "_" + kAxes[axis], mean[axis]);
      for (int axis = 0; axis < 3; ++axis) measures.set(set.name + "_reaction_" + kAxes[axis], own[axis]);
      size = std::max(size, own.norm());
      if (set.around) measure_around(set, state, measures);
    }
    add_state(model_, state, solved, size, measures);
    return measures;
  }

 private:
  std::vector<int> all() const {
    std::vector<int> molecules(static_cast<std::size_t>(body_.size()));
    for (int molecule = 0; molecule < body_.size(); ++molecule) molecules[molecule] = molecule;
    return molecules;
  }
  static double largest(const Positions& motion, const std::vector<int>& molecules) {
    double most = 0;
    for (const int molecule : molecules) most = std::max(most, motion.col(molecule).norm());
    return most;
  }
  static Vector3 mean_of(const Positions& motion, const std::vector<int>& molecules) {
    Vector3 sum = Vector3::Zero();
    for (const int molecule : molecules) sum += motion.col(molecule) / static_cast<double>(molecules.size());
    return sum;
  }
  /// The turn of the set about its axis, and the stresses of the cells all of whose molecules are in it, in the
  /// directions at the quadrature points of a law, else at the present middles of the cells.
  void measure_around(const ReadSet& set, const State& state, Measures& measures) const {
    const Vector3 axis = set.around->direction, before = mean_of(body_.rest, set.molecules),
                  now = mean_of(state.positions, set.molecules);
    double sine = 0, cosine = 0;
    for (const int molecule : set.molecules) {
      const Vector3 from = body_.rest.col(molecule) - before, to = state.positions.col(molecule) - now;
      sine += axis.dot(from.cross(to)), cosine += from.dot(to) - axis.dot(from) * axis.dot(to);
    }
    measures.set(set.name + "_turn", std::atan2(sine, cosine));
    const std::vector<CellState> states = cell_states(body_, snapshot_of(model_, state, 0, 0));
    Vector3 sum = Vector3::Zero();
    double all = 0;
    std::size_t number = 0;
    const auto picked = [&](const auto& cell) {
      return std::all_of(cell.begin(), cell.end(), [&](int molecule) {
        return std::binary_search(set.molecules.begin(), set.molecules.end(), molecule);
      });
    };
    const auto middle_of = [&](const auto& cell) -> Vector3 {
      return positions_of(state.positions, cell).rowwise().mean();
    };
    const auto along = [&](const Vector3& place, const Matrix3& stress) -> Vector3 {
      const Matrix3 directions = frame_at(*set.around, place);
      return (directions.transpose() * stress * directions).diagonal();
    };
    const auto add = [&](const auto& cell, double volume) {
      const CellState& own = states[number++];
      if (picked(cell)) sum += volume * along(middle_of(cell), own.stress), all += volume;
    };
    const OwnSimplices simplices(body_);
    for (std::size_t i = 0; i < simplices.triangles; ++i) add(body_.triangles[i], 0);
    for (std::size_t i = 0; i < simplices.tetrahedra; ++i)
      add(body_.tetrahedra[i], signed_volume(state.positions, body_.tetrahedra[i]));
    for (const CellBlock& block : body_.blocks)
      for (int cell = 0; cell < block.size(); ++cell) {
        const Eigen::MatrixXd nodes = positions_of(state.positions, block.cell(cell));
        double volume = 0;  // of sheets, whose stress is a force over a width, none counts
        for (std::size_t g = 0; block.kind->dimensions == 3 && g < block.kind->slopes.size(); ++g)
          volume +=
              block.kind->weights[static_cast<Eigen::Index>(g)] * measure_of(nodes * block.kind->slopes[g].transpose());
        add(block.cell(cell), volume);
      }
    for (const NodalForces* law : model_.nodal_laws())  // a cell's mean stress has the directions of its middle
      law->show_points(state.positions, [&](std::span<const int> cell, const PointState& at) {
        if (picked(cell)) sum += at.volume * (along(at.position, at.stress) - along(middle_of(cell), at.stress));
      });
    for (int direction = 0; all > 0 && direction < 3; ++direction)
      measures.set(set.name + "_" + kRound[static_cast<std::size_t>(direction)] + "_stress", sum[direction] / all);
  }
  /// Of the supports of these molecules; null: of all.
  Vector3 reaction_of(const Positions& reactions, const std::vector<int>* molecules) const {
    Vector3 sum = Vector3::Zero();
    for (std::size_t i = 0; i < model_.supports.size(); ++i)
      if (!molecules || std::binary_search(molecules->begin(), molecules->end(), model_.supports[i].molecule))
        sum += reactions.col(static_cast<Eigen::Index>(i));
    return sum;
  }

  const LoadsSetup& setup_;
  const Body& body_;
  Model& model_;
  double factor_ = 0;
  Eigen::Index released_ = 0;               // the molecule that is watched after a release,
  Vector3 released_way_ = Vector3::Zero();  // and along what; 0: nothing was released
};

std::unique_ptr<StaticRig> Loads::make_rig(Model& model) const { return std::make_unique<LoadsRig>(*this, model); }

std::vector<int> ascending(std::vector<int> molecules) {
  std::sort(molecules.begin(), molecules.end());
  molecules.erase(std::unique(molecules.begin(), molecules.end()), molecules.end());
  return molecules;
}

Keys<ReadSet> read_keys() {
  return {key::text("name", &ReadSet::name, "letters, digits and _: the measures begin with it").needed(),
          Key<ReadSet>({"molecules", "list of molecules, or [pick](#picked-molecules)", "", "0 … last molecule",
                        "needed", "whose displacements and supports' forces are measured"},
                       [](const Reader& value, ReadSet& set, const Frame& frame) {
                         set.molecules = ascending(read_molecules(value, *frame.body, frame.rotation));
                       })
              .needed(),
          key::map("around", &ReadSet::around, around_keys("the mean stresses of the set's cells are"))};
}

Keys<MovedSet> moved_keys() {
  return {Key<MovedSet>({"molecules", "list of molecules, or [pick](#picked-molecules)", "", "0 … last molecule",
                         "needed", "which molecules are moved"},
                        [](const Reader& value, MovedSet& set, const Frame& frame) {
                          set.molecules = ascending(read_molecules(value, *frame.body, frame.rotation));
                        })
              .needed(),
          key::vector("displacement", &MovedSet::displacement, dimension::length, "their displacement").needed(),
          Key<MovedSet>({"fix", "list of directions, or `all`", "", "", "`all`",
                         "perpendicular directions along which the displacement is prescribed; they are free along "
                         "the others"},
                        [](const Reader& value, MovedSet& set, const Frame& frame) {
                          if (value.is_text() && value.text() == "all") return;
                          for (const Reader& item : value.items()) {
                            const Vector3 direction = frame.rotation * item.direction();
                            for (const Vector3& other : set.directions)
                              if (!perpendicular(direction, other))
                                item.fail("must be perpendicular to the directions before it");
                            set.directions.push_back(direction);
                          }
                          if (set.directions.empty())
                            value.fail("names no direction; write all, or a list such as [x, y]");
                        })};
}

/// A list of maps with these keys.
template <class Item>
Key<LoadsSetup> list_key(const std::string& name, Keys<Item> keys, std::vector<Item> LoadsSetup::*member,
                         const std::string& text, const std::function<void(const Reader&, LoadsSetup&)>& check = {}) {
  std::vector<SceneKey> rows{{name, "list of maps", "", "", "none", text}};
  for (SceneKey row : keys.rows()) {
    row.name = name + "." + row.name;
    rows.push_back(std::move(row));
  }
  return {name, std::move(rows), [=](const Reader& value, LoadsSetup& setup, const Frame& frame) {
            for (const Reader& item : value.items()) {
              (setup.*member).push_back(keys.read(item, frame));
              if (check) check(item, setup);
            }
          }};
}

/// Names become names of measures.
void check_name(const Reader& item, LoadsSetup& setup) {
  const std::string& name = setup.read.back().name;
  const Reader place = Reader(item).at("name");
  const auto fits = [](char letter) { return std::isalnum(static_cast<unsigned char>(letter)) || letter == '_'; };
  if (name.empty() || !std::all_of(name.begin(), name.end(), fits))
    place.fail("'" + name + "' is no name of a measure: write letters, digits and _");
  for (std::size_t i = 0; i + 1 < setup.read.size(); ++i)
    if (setup.read[i].name == name) place.fail("there is a set '" + name + "' already");
}

/// Items may each hold a molecule in directions of their own, as planes of symmetry that meet do.
void combine(const Reader& item, LoadsSetup& setup) {
  const MovedSet& set = setup.moved.back();
  Vector3 lost = set.directions.empty() ? Vector3::Zero() : set.displacement;
  for (const Vector3& direction : set.directions) lost -= direction.dot(lost) * direction;
  if (lost.norm() > 1e-9 * set.displacement.norm())
    Reader(item)
        .at("displacement")
        .fail("has " + number(1e3 * lost.norm(), 3) +
              " mm along directions that `fix` leaves free; let `fix` name them, or leave this part out");
  const std::vector<Vector3> all{Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ()};
  for (const int molecule : set.molecules)
    for (const Vector3& direction : set.directions.empty() ? all : set.directions) {
      if (set.displacement.isZero(0)) setup.staying[molecule].prescribe(direction, set.displacement);
      if (!setup.moved_molecules[molecule].prescribe(direction, set.displacement))
        item.fail("molecule " + std::to_string(molecule) +
                  " is moved twice along one direction, by different displacements; let its items `fix` different "
                  "directions");
    }
}

}  // namespace

ExperimentInfo loads_row() {
  using S = LoadsSetup;
  return with_keys(
      {.name = "loads",
       .summary = "the scene's own `loads` and `supports` grow together: displacements, reactions of named sets",
       .measures = loads_measures({})},
      Keys<S>{
          list_key("read", read_keys(), &S::read,
                   "sets that are measured: for the name `top`, `top_displacement` (the largest), `top_x` (the "
                   "mean) and `top_reaction_x` (the sum), and so along y and z; with `around` `top_turn` [rad] and "
                   "the stresses `top_radius_stress`, `top_circumference_stress`, `top_axis_stress`",
                   check_name),
          list_key(
              "moved", moved_keys(), &S::moved,
              "molecules that are moved, in addition to `supports`; an item adds its directions to those "
              "of the items before it, and a rigid body moves as a whole; `release` frees those with a displacement",
              combine),
          load_steps_key(&S::load_steps)},
      [](const ExperimentContext& context, S setup) {
        return std::make_unique<Loads>(context.body, std::move(setup));
      });
}

}  // namespace elastin::lab
