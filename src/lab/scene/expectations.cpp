#include <algorithm>

#include "elastin/core/base/error.h"
#include "lab/run/run.h"
#include "lab/scene/parts.h"
#include "lab/scene/scene.h"

namespace elastin::lab {
namespace {

/// What names a measure, with the unit of its values.
template <class Setup>
struct Measured : Setup {
  Dimension unit = dimension::none;
};

template <class Setup>
Key<Measured<Setup>> measure_key(const MeasureList& measures) {
  return {{"measure", "word", "", "", "none", "name of a measure; `elastin list` prints all"},
          [&measures](const Reader& value, Measured<Setup>& setup) {
            const MeasureInfo info = value.located([&] { return measures.at(value.text()); });
            setup.measure = info.name;
            setup.unit = info.unit;
          }};
}

/// A quantity in the unit of the measure.
template <class Setup>
Key<Measured<Setup>> measured_key(SceneKey row, double Setup::*member, const Range& range = {}) {
  row.type = "quantity", row.unit = "the measure's", row.range = range_text(range.low, range.high, range.open_low);
  return {std::move(row),
          [=](const Reader& value, Measured<Setup>& setup) { setup.*member = value.quantity(setup.unit, range); }};
}

Keys<Measured<Expectation>> expect_keys(const std::vector<StrategyChoice>& strategies, const Catalog& catalog,
                                        const MeasureList& known) {
  using S = Measured<Expectation>;
  const auto stops = [](const S& setup) { return !setup.outcome.empty(); };
  const auto measures = [](const S& setup) { return setup.outcome.empty(); };
  std::vector<std::pair<std::string, std::string>> outcomes{{kUnsuited, kUnsuited}};
  for (const Outcome stop : {Outcome::limit_reached, Outcome::inverted, Outcome::diverged, Outcome::mechanism})
    outcomes.emplace_back(name_of(stop), name_of(stop));
  return {Key<S>({"strategy", "word", "", "", "every one", "name or label of the strategy that it is about"},
                 [&](const Reader& value, S& setup) {
                   setup.strategy = value.text();
                   if (!find_strategy(strategies, setup.strategy))
                     value.located([&] { return choose_strategy(catalog, setup.strategy); });
                 }),
          key::text("source", &S::source, "where the value comes from").needed(),
          key::choice("outcome", &S::outcome, outcomes, "how the run must stop").otherwise("needed, or `measure`"),
          Key<S>(key::text("cause", &S::cause, "words that the cause must contain"))
              .needed_when(stops, "needed with `outcome`")
              .then([](const Reader& value, const S& setup) {
                if (setup.cause.empty()) value.fail("name the cause: words that the cause of the run must contain");
              }),
          measure_key<Expectation>(known).needed_when(measures, "needed, or `outcome`"),
          measured_key({.name = "value", .text = "what the measure must be"}, &Expectation::value)
              .needed_when(measures, "needed with `measure`"),
          Key<S>(key::quantity("tolerance", &S::relative, dimension::none, "relative difference that is allowed",
                               kPositive))
              .otherwise("this, `absolute` or both")
              .when(measures),
          measured_key({.name = "absolute", .fallback = "0", .text = "difference that is allowed besides `tolerance`"},
                       &Expectation::absolute, kPositive)
              .when(measures),
          Key<S>(key::text("not_reproduced", &S::not_reproduced, "why the value is printed but not judged"))
              .otherwise("judged")
              .when(measures)};
}

/// points: [[where, value, standard deviation], …]; the last one is the reference's value.
void read_measured_points(const Reader& reader, const MeasureList& known, Measured<Reference>& setup) {
  const auto axes = std::find_if(known.response.begin(), known.response.end(),
                                 [&](const ResponseAxes& one) { return one.y == setup.measure; });
  if (axes == known.response.end()) reader.fail("no response is drawn as " + setup.measure + "; give its `value`");
  setup.along = axes->x;
  const Dimension unit = setup.along == "time"   ? dimension::time
                         : setup.along == "load" ? dimension::none
                                                 : known.at(setup.along).unit;
  for (const Reader& item : reader.items()) {
    const auto triple = item.items(3);
    const double at = triple[0].quantity(unit);
    if (!setup.points.empty() && std::abs(at) <= std::abs(setup.points.back()[0]))
      triple[0].fail("points stand in the order of the load, each further from 0 than the one before");
    setup.points.push_back({at, triple[1].quantity(setup.unit), triple[2].quantity(setup.unit, kPositive)});
  }
  if (setup.points.empty()) reader.fail("names no point; write [[where, value, standard deviation], ...]");
  setup.value = setup.points.back()[1];
  setup.scatter = setup.points.back()[2] / std::abs(setup.value);
}

Keys<Measured<Reference>> reference_keys(const MeasureList& known) {
  using S = Measured<Reference>;
  return {measure_key<Reference>(known).needed(),
          Key<S>({"points", "list of triples", "", "", "this, or `value`",
                  "a measured curve, `[where, value, standard deviation]` in the order of the load, over what the "
                  "response is drawn over, a stress over the strain; errors are in units of the standard deviation"},
                 [&known](const Reader& value, S& setup) { read_measured_points(value, known, setup); }),
          measured_key({.name = "value", .text = "what the measure is"}, &Reference::value)
              .needed_when([](const S& setup) { return setup.points.empty(); }, "needed, or `points`"),
          key::text("source", &Reference::source, "where the value comes from").needed(),
          Key<S>(key::quantity("scatter", &Reference::scatter, dimension::none,
                               "standard deviation of measured specimens over the value; errors are in units of it, "
                               "and what comes within it is recommended",
                               kPositive))
              .when([](const S& setup) { return setup.points.empty(); }),
          key::quantity("uncertainty", &Reference::uncertainty, dimension::none,
                        "relative uncertainty of the value; beyond 5 % it ranks nothing", kPositive)};
}

Keys<ComputedReference> computed_keys(const Catalog& catalog) {
  using S = ComputedReference;
  return {key::quantity("uncertainty", &S::uncertainty, dimension::none,
                        "the body's cells are refined until the main measures are known to this", {1e-6, 0.05, false}),
          key::whole("most_cells", &S::most_cells, 1, 100000000, "no body of more cells is solved"),
          key::quantity("seconds", &S::seconds, dimension::time,
                        "no body is solved that would probably take longer, and one that does is given up", kPositive),
          Key<S>({"strategy", "word", "", "", "the material's own law",
                  "the law that is refined; by default `neo_hookean` or `curve`, with `+volume` where ν > 0.4, of "
                  "membranes `neo_hookean_membrane` or `curve_membrane`"},
                 [&catalog](const Reader& value, S& computed) {
                   computed.strategy = value.text();
                   value.located([&] { return choose_strategy(catalog, computed.strategy); });
                 })};
}

/// computed, none, {computed: {…}}, or one stated value.
void read_reference(Reader item, const Catalog& catalog, const MeasureList& measures, Scene& scene) {
  using When = ComputedReference::When;
  if (item.is_text()) {
    scene.computed.when = item.choice<When>({{"computed", When::always}, {"none", When::never}});
  } else if (const auto computed = item.find("computed")) {
    scene.computed = computed_keys(catalog).read(*computed, {}, scene.computed);
    scene.computed.when = When::always;
    item.finish();
  } else {
    scene.references.push_back(reference_keys(measures).read(item));
  }
}

}  // namespace

std::vector<Expectation> read_expectations(const Reader& list, const std::vector<StrategyChoice>& strategies,
                                           const Catalog& catalog, const MeasureList& measures) {
  const auto keys = expect_keys(strategies, catalog, measures);
  std::vector<Expectation> all;
  for (const Reader& item : list.items()) {
    const Expectation& expectation = all.emplace_back(keys.read(item));
    const bool judged = expectation.outcome.empty() && expectation.not_reproduced.empty();
    if (judged && expectation.relative == 0 && expectation.absolute == 0)
      item.fail(
          "an expectation needs a tolerance (relative), an absolute tolerance, or not_reproduced with the reason");
    if (judged && expectation.value == 0 && expectation.absolute == 0)
      item.fail("`tolerance` is relative, and of 0 it allows nothing: give `absolute`");
  }
  return all;
}

void read_references(const Reader& reader, const Catalog& catalog, const MeasureList& measures, Scene& scene) {
  if (reader.is_text() || reader.is_map()) return read_reference(reader, catalog, measures, scene);
  for (const Reader& item : reader.items()) {
    if (item.is_text() && item.text() == "none") item.fail("stands alone: reference: none");
    read_reference(item, catalog, measures, scene);
  }
}

std::vector<KeySection> expectation_keys(const Catalog& catalog) {
  std::vector<SceneKey> reference = reference_keys(built_in_measures()).rows();
  for (SceneKey& row : key::rows_below({.name = "computed"}, computed_keys(catalog)))
    reference.push_back(std::move(row));
  return {
      {"reference", "Reference",
       "`reference` is `none`, `computed`, one map, or a list of maps and `computed`. An item states a value, or has "
       "the key `computed` alone. A stated value counts before a computed one. Without the key the reference is "
       "computed where the grips clamp or the body is no prism:",
       std::move(reference)},
      {"expect", "Expectations",
       "Each item of `expect` names a measure with its value, or the outcome with which a run must stop:",
       expect_keys({}, catalog, built_in_measures()).rows()}};
}

}  // namespace elastin::lab
