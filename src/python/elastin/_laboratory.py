"""Scenes: run, compared, identified."""

import json
import logging
import os

from . import _elastin, _exchange, _own, _pictures, _progress, _scenes, _tables, _yaml
from ._elastin import Catalog, InputError, Strategy

_log = logging.getLogger("elastin")


class Laboratory(_elastin._Laboratory):
    """A scene, read, checked and built: the path of a file, a dict as its YAML would be, or a Body. In addition to a dict or a
    Body `experiment` (elastin.Tension(…)), `material` and all other keys of a scene may stand: contact={…}, loads=[…],
    time={…}. `set` changes keys, as the command's --set: {"material.youngs_modulus": 5e3, "experiment.force": "1 mN"}.
    With a Catalog, strategies of one's own may be named."""

    def __init__(self, scene, *, experiment=None, material=None, set=None, catalog=None, **keys):
        opened = _scenes.opened(scene, (), experiment, material, keys)
        self._made_of = scene, {"experiment": experiment, "material": material, "set": set, "catalog": catalog, **keys}
        self._opened = opened
        with opened.messages():
            super().__init__(opened.source, _yaml.overrides(set), _own.catalog_with(catalog, opened.own),
                             [one._info() for one in opened.experiments.values()])

    def __reduce__(self):
        return _laboratory_again, (type(self), *self._made_of)

    def __repr__(self):
        return f"<elastin.Laboratory {self.name}: {self.title}>"

    def _repr_html_(self):
        return _tables.of_laboratory(self)


    def exported(self, strategy=""):
        """The body with the constants of a strategy, as `elastin export --to json` writes it: a dict of lists, SI units.
        "connections" have "a", "b", "rest_length" and "stiffness"; the keys are described in scenes/README.md."""
        return json.loads(self._exported(strategy))

    def export(self, path, to, strategy=""):
        """Writes the scene for another program, as `elastin export --to FORMAT` does: a file, or of an engine a folder with
        its constants. What a user must know of it goes to the logger "elastin"."""
        files, notes = self._export(to, strategy)
        ending = _elastin._export_formats()[to]
        if ending and not os.fspath(path).endswith(ending):
            raise InputError(f"path: files of {to} end in {ending}")
        for name, text in files:
            target = os.path.join(path, name) if name else path
            os.makedirs(os.path.dirname(os.path.abspath(target)), exist_ok=True)
            with open(target, "w", encoding="utf8") as stream:
                stream.write(text)
        for note in notes:
            _log.info(note)

    def measure(self, step):
        """Runs the experiment in a solver of one's own, with the constants of the scene's strategy: step(request) gets what
        an engine of `elastin compare --engine` reads, a dict, and gives what that prints: {"positions": (n, 3), …}.
        The Result is measured off it as a strategy's is; what step raises comes out."""

        def listed(value):
            return value.tolist() if hasattr(value, "tolist") else str(value)

        return self._measure(lambda request: json.dumps(step(json.loads(request)), default=listed))


def _laboratory_again(kind, scene, options):
    return kind(scene, **options)


def _named(choices, catalog):
    """Names of the strategies, and a catalog that has those which were handed over as objects."""
    own = [choice for choice in choices if isinstance(choice, Strategy)]
    return [getattr(choice, "name", choice) for choice in choices], _own.catalog_with(catalog, own)


def run(scene, strategy="", *, experiment=None, material=None, reference="none", set=None, catalog=None, progress=None,
        keep_states=False, derivatives_by=(), **keys):
    """Runs a scene with a strategy (a name, or a Strategy; "" is the scene's own) and gives its Result. The scene is a
    file, a dict or a Body, with further keys, as for Laboratory. Numbers equal those of the command to the
    last bit. progress: a function that is called with what is being done, or True for a line that says it. reference: "computed" first computes the values that errors refer to; keep_states: the result has the
    positions of every load step or frame; derivatives_by: the result's gradients are by these keys."""
    (name,), catalog = _named([strategy], catalog)
    opened = _scenes.opened(scene, [name] if name else [], experiment, material, keys)
    laboratory = Laboratory(opened, set=set, catalog=catalog)
    with _progress.shown(progress) as report:
        laboratory.compute_reference(reference, progress=report)
        return laboratory.run(name, progress=report, keep_states=keep_states, derivatives_by=list(derivatives_by))


def gradient(scene, of=None, by=(), strategy="", **options):
    """Derivatives of measures by numbers of a scene, as an array (measures, numbers) in SI units, by one linear solve a
    number at each equilibrium. of: names of measures, by default all, in the order of the result's; by: keys of the scene
    that state numbers, ["material.youngs_modulus", "loads.0.pressure"]. Scene and options are as for run. Experiments in
    time, friction and other histories raise InputError."""
    import numpy
    opened_by = [by] if isinstance(by, str) else list(by)
    result = run(scene, strategy, derivatives_by=opened_by, **options)
    if result.outcome != "converged":
        raise RuntimeError(f"no equilibrium: {result.outcome}: {result.cause}")
    names = list(result.gradients) if of is None else [of] if isinstance(of, str) else list(of)
    for name in names:
        _measure_of(result, name)
    return numpy.array([[result.gradients.get(name, {}).get(key, numpy.nan) for key in opened_by] for name in names])


def compare(scene, strategies=None, *, experiment=None, material=None, reference="", set=None, catalog=None,
            progress=None, **keys):
    """Runs a scene (a file, a dict or a Body, as for Laboratory) with several strategies: names and strategies of one's
    own; by default those that it compares itself, of a Body all. Where the scene says so, or nothing else shows what is
    right, its reference is computed first, as the command does: reference="none" leaves that out, "computed" does it in
    any case."""
    one = isinstance(strategies, (str, Strategy))
    names, catalog = _named([strategies] if one else strategies or [], catalog)
    opened = _scenes.opened(scene, names, experiment, material, keys)
    laboratory = Laboratory(opened, set=set, catalog=catalog)
    names = names or laboratory.strategies
    if opened.experiments and not reference:
        reference = "none"  # finer cells would need the experiment made for them
    with _progress.shown(progress) as report:
        laboratory.compute_reference(reference, progress=report)
        return Comparison([laboratory.run(name, progress=report and _counted(report, f"{number} of {len(names)}, {name}"))
                           for number, name in enumerate(names, 1)])


def _counted(report, which):
    return lambda doing: report(f"{which}: {doing}")


def export(scene, path, to, strategy="", *, experiment=None, material=None, set=None, catalog=None, **keys):
    """Writes a scene for another program, see Laboratory.export."""
    Laboratory(scene, experiment=experiment, material=material, set=set, catalog=catalog, **keys).export(path, to, strategy)


def measure(step, scene, experiment=None, *, material=None, set=None, catalog=None, **keys):
    """Measures a solver of one's own, see Laboratory.measure: step(request) solves, the scene is a Body, a dict or a
    file, further keys are as for Laboratory, stiffness="lattice" and engines={"dt": "1 ms"} among them."""
    return Laboratory(scene, experiment=experiment, material=material, set=set, catalog=catalog, **keys).measure(step)


def verify(scene, *, experiment=None, material=None, set=None, catalog=None, progress=None, **keys):
    """Compares a scene, or each of a list, with what it expects: Verdicts, a dict a run with "scene", "strategy",
    "verdict" ("passed", "failed" or "not judged"), "outcome", "cause", "measures", "seconds" and "expectations"."""
    cases = []
    with _progress.shown(progress) as report:
        for one in scene if isinstance(scene, (list, tuple)) else [scene]:
            opened = _scenes.opened(one, (), experiment, material, keys)
            if opened.experiments:
                raise InputError("verify: takes experiments of the table; compare the measures of run() for one of your own")
            with opened.messages():
                cases += _elastin._verify(opened.source, _yaml.overrides(set), _own.catalog_with(catalog, opened.own),
                                          report)
    return Verdicts(cases)


def strategies(catalog=None):
    """Every strategy there is, with summary, source and parameters."""
    return list(catalog or Catalog())


class Verdicts(list):
    """Results of scenes compared with what they expect: a list of dicts that shows itself as a table."""

    @property
    def passed(self):
        """Whether nothing failed."""
        return all(case["verdict"] != "failed" for case in self)

    def to_frame(self):
        """A pandas DataFrame, one row an expectation."""
        columns = ("scene", "strategy", "verdict", "outcome", "cause", "seconds")
        return _exchange.frame([{name: case[name] for name in columns} | expectation for case in self
                                for expectation in case["expectations"] or [{}]])

    def _table(self):
        return _tables.of_verdicts(self)

    def __repr__(self):
        return self._table().text()

    def _repr_html_(self):
        return self._table().html()


class Comparison(list):
    """Results of one scene, a strategy each: a list that can be indexed by name, and shows itself as a table."""

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
        return _tables.with_picture(self._table(), next(filter(None, map(_pictures.of_result, self)), ""))

    @property
    def recommended(self):
        """The strategy that `elastin compare` recommends by these results; "" where none comes near enough."""
        return _elastin._advice(list(self))[0]

    @property
    def advice(self):
        """That strategy with its numbers in a sentence, or why none is recommended."""
        return _elastin._advice(list(self))[1]

    def to_html(self, path):
        """Writes their page, as `elastin compare --out` does: advice, error against time, curves, the body in 3D, tables. It
        needs no other file."""
        _pictures.write(path, _elastin._page(list(self)))

    def view(self):
        """The body in 3D with the states of all results: a View."""
        return _pictures.View(_elastin._view(list(self)))

    def to_frame(self):
        """A pandas DataFrame, one row a strategy: its outcome, measures, errors (error_MEASURE) and seconds."""
        return _exchange.frame_of_results(self)

    def plot_curves(self, x=None, y=None, ax=None, **options):
        """The curves of all results in one picture; see Result.plot_curve."""
        from . import _plots
        for result in self:
            if result.curve:
                ax = _plots.curve(result, x, y, ax, options)
        return ax

    def plot(self, measure=None, ax=None):
        """Error of a measure, by default the most telling one, against the seconds that it took."""
        from . import _plots
        return _plots.speed_against_error(self, measure, ax)


def _measure_of(result, measure):
    """Its value; a name that was not measured raises KeyError with the nearest one."""
    if measure not in result.measures:
        raise KeyError(_elastin._missing_measure(measure, list(result.measures)))
    return result.measures[measure]


def _get(result, measure, default=None):
    """The measure of this name, or `default` if it was not taken."""
    return result.measures.get(measure, default)


def _view(result):
    """The body in 3D with its states: a View. Where states were kept, all of them."""
    return _pictures.View(_elastin._view([result]))


def _states(result):
    """Where the molecules were at rest and after each load step or frame: pairs (load factor or time [s], positions (n, 3)
    [m]); empty unless it was run with keep_states=True."""
    return result._states


def _plot(result, ax=None, **options):
    """The body in its last state, its connections coloured by their tension. Options go to Line3DCollection."""
    from . import _plots
    return _plots.body(result, ax, options)


def _plot_curve(result, x=None, y=None, ax=None, **options):
    """One measure of the curve over another: by default the stress–strain curve, or another measure over the load or time."""
    from . import _plots
    return _plots.curve(result, x, y, ax, options)


def _animate(result, scale=1.0, interval=100, **options):
    """A matplotlib animation of the states that were kept, displacements times `scale`, `interval` [ms] a state; in a
    notebook HTML(animation.to_jshtml()) plays it. Options go to Line3DCollection."""
    from . import _plots
    return _plots.animation(result.body, [positions for _, positions in result.states], scale, interval, options)


Result = _elastin.Result
Result.states = property(_states)
Result.__repr__ = lambda result: _tables.of_result(result).text()
Result._repr_html_ = lambda result: _tables.with_picture(_tables.of_result(result), _pictures.of_result(result))
for _name, _method in (("__getitem__", _measure_of), ("get", _get), ("view", _view), ("plot", _plot), ("plot_curve", _plot_curve),
                       ("animate", _animate), ("to_frame", _exchange.frame_of_curve),
                       ("to_vtu", _exchange.result_to_vtu), ("to_meshio", _exchange.result_to_meshio),
                       ("to_pyvista", _exchange.result_to_pyvista)):
    _method.__name__, _method.__qualname__ = _name, f"Result.{_name}"
    setattr(Result, _name, _method)
