"""Scenes: run, compared, identified."""

import json
import os

from . import _elastin, _tables, _yaml
from ._elastin import Catalog, Strategy


class Laboratory(_elastin._Laboratory):
    """A scene file, read, checked and built. `set` changes its keys, as the command's --set:
    {"material.youngs_modulus": 5e3, "experiment.force": "1 mN"}. With a Catalog, strategies of one's own may be
    named."""

    def __init__(self, scene, *, set=None, catalog=None):
        super().__init__(os.fspath(scene), _yaml.overrides(set), catalog)

    def __repr__(self):
        return f"<elastin.Laboratory {self.name}: {self.title}>"


def _named(choices, catalog):
    """Names of the strategies, and a catalog that has those which were handed over as objects."""
    own = [choice for choice in choices if isinstance(choice, Strategy)]
    if own:
        chosen, catalog = catalog, Catalog()
        known = _elastin.Catalog().names
        for strategy in list(chosen or []) + own:
            if strategy.name not in known:
                catalog.add(strategy)
                known.append(strategy.name)
    return [getattr(choice, "name", choice) for choice in choices], catalog


def run(scene, strategy="", *, set=None, catalog=None, progress=None):
    """Runs a scene with a strategy (a name, or a Strategy; "" is the scene's own) and gives its Result. Numbers equal
    those of the command to the last bit."""
    (name,), catalog = _named([strategy], catalog)
    return Laboratory(scene, set=set, catalog=catalog).run(name, progress=progress)


def compare(scene, strategies=None, *, set=None, catalog=None, progress=None):
    """Runs a scene with several strategies, by default those that it compares itself."""
    names, catalog = _named(strategies or [], catalog)
    laboratory = Laboratory(scene, set=set, catalog=catalog)
    return Comparison([laboratory.run(name, progress=progress) for name in names or laboratory.strategies])


def identify(scene, data=None, *, tests=(), laws=(), strategies=(), set=None, progress=None):
    """Fits the material of a scene's `identify` section to its measured tests and gives what the command writes as JSON:
    "parameters" (name, value, unit, low, high), "correlation", "relative_rms", "warnings" and more; SI units. `data`
    names other CSV files, {test: path}; of `tests` alone are fitted, the others predicted; `laws` are compared
    (["all"]); of several `strategies` of the specimens a list, one each."""
    files = [f"{test}={os.fspath(path)}" for test, path in (data or {}).items()]
    found = json.loads(_elastin._identify(os.fspath(scene), _yaml.overrides(set), files, list(tests), ",".join(laws),
                                          ",".join(strategies), progress))
    return found.get("identifications", found)


def strategies(catalog=None):
    """Every strategy there is, with summary, source and parameters."""
    return list(catalog or Catalog())


class Comparison(list):
    """Results of one scene, a strategy each: a list that can be asked by name, and shows itself as a table."""

    def __getitem__(self, key):
        if not isinstance(key, str):
            return super().__getitem__(key)
        for result in self:
            if result.strategy == key:
                return result
        raise KeyError(f"no strategy '{key}' here; there are " + ", ".join(result.strategy for result in self))

    def _table(self):
        return _tables.of_results(self)

    def __repr__(self):
        return self._table().text()

    def _repr_html_(self):
        return self._table().html()

    def plot(self, measure=None, ax=None):
        """Error of a measure, by default the most telling one, against the seconds that it took."""
        from . import _plots
        return _plots.speed_against_error(self, measure, ax)


def _measure_of(result, measure):
    """Its value; a name that was not measured raises KeyError with the nearest one."""
    if measure not in result.measures:
        raise KeyError(_elastin._missing_measure(measure, list(result.measures)))
    return result.measures[measure]


def _plot(result, ax=None, **options):
    """The body in its last state, its connections coloured by their tension. Options go to Line3DCollection."""
    from . import _plots
    return _plots.body(result, ax, options)


def _plot_curve(result, x=None, y=None, ax=None, **options):
    """One measure of the curve over another: by default the stress–strain curve, or what there is over the load or time."""
    from . import _plots
    return _plots.curve(result, x, y, ax, options)


Result = _elastin.Result
Result.__getitem__ = _measure_of
Result.get = lambda result, measure, default=None: result.measures.get(measure, default)
Result.__repr__ = lambda result: _tables.of_result(result).text()
Result._repr_html_ = lambda result: _tables.of_result(result).html()
Result.plot = _plot
Result.plot_curve = _plot_curve
for _method, _name in ((_measure_of, "__getitem__"), (_plot, "plot"), (_plot_curve, "plot_curve"), (Result.get, "get")):
    _method.__name__, _method.__qualname__ = _name, f"Result.{_name}"
Result.get.__doc__ = "The measure of this name, or `default` if it was not taken."
