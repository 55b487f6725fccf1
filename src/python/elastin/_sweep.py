"""Sweeps: one scene, many values of its keys, here or on workers."""

import concurrent.futures
import itertools
import os

import numpy

from . import _laboratory, _progress, _tables
from ._elastin import InputError


def sweep(scene, key, values=None, *, strategy="", set=None, catalog=None, progress=None, client=None, **keys):
    """Runs a scene once for each value of one of its keys, sweep(scene, "material.poissons_ratio", [0.1, 0.2, 0.3]), or
    for each combination of the values of several, the last key fastest: sweep(scene, {"body.lattice.molecules": [[5, 5,
    5], [9, 9, 9]], "material.poissons_ratio": [0.1, 0.2]}). `strategy` may be a list: each of them runs in every
    combination. `set` and what else `run` takes hold for all rows.

    With a `client` its workers compute the rows: a dask.distributed.Client, or an executor of concurrent.futures. The
    rows are the same to the last bit but for times. A scene file must be there under the same path for all workers. Of
    a dask.distributed.Client a row whose worker dies goes to another one. `progress` is called with what a row is doing, or with
    a client how many rows are there."""
    axes = {key: values} if values is not None else dict(key)
    _check(axes)
    axes = {name: list(wanted) for name, wanted in axes.items()}
    strategies = list(strategy) if isinstance(strategy, (list, tuple)) else [strategy]
    rows = [(dict(zip(axes, combination)), one) for combination in itertools.product(*axes.values())
            for one in strategies]
    fixed = _laboratory._yaml.overrides(set)
    if client is None:
        with _progress.shown(progress) as report:
            results = [_row(scene, one, fixed, changes, catalog, keys, report and _laboratory._counted(
                report, f"{number} of {len(rows)}")) for number, (changes, one) in enumerate(rows, 1)]
    else:
        if isinstance(scene, (str, os.PathLike)):
            scene = os.path.abspath(scene)
        with _progress.shown(progress) as report:
            results = _by_workers(client, [(scene, one, fixed, changes, catalog, keys) for changes, one in rows], report)
    return Sweep([changes for changes, _ in rows], results)


def _check(axes):
    for number, (name, wanted) in enumerate(axes.items()):
        if isinstance(wanted, str):
            raise InputError(f"values of '{name}': write a list of them, ['{wanted}']")
        for other in list(axes)[:number]:
            if other.startswith(name + "."):
                raise InputError(f"'{name}' would replace '{other}', which changes before it: let it come first")


def _row(scene, strategy, fixed, changes, catalog, keys, progress=None):
    """What one worker does."""
    return _laboratory.run(scene, strategy, set=fixed + _laboratory._yaml.overrides(changes), catalog=catalog,
                           progress=progress, **keys)


def _by_workers(client, rows, progress):
    # Dask would take a row that it has seen for done, though the scene's file may have changed since.
    options = {"pure": False} if hasattr(client, "gather") else {}
    futures = [client.submit(_row, *row, **options) for row in rows]
    results = []
    try:
        for future in futures:
            results.append(future.result())
            if progress:
                progress(f"{len(results)} of {len(rows)} rows")
    except BaseException:
        for future in futures:
            future.cancel()
        # A pool of processes that is closed before it knows of them may wait for them for ever (CPython 3.11).
        if all(isinstance(future, concurrent.futures.Future) for future in futures):
            concurrent.futures.wait(futures)
        raise
    return results


class Sweep(list):
    """Results of one scene, one for each combination of the values of its keys; sweep["effective_modulus"] gives a measure
    as an array, NaN where a row has none. `changes` has what each row has under the keys."""

    def __init__(self, changes, results):
        super().__init__(results)
        self.changes = list(changes)

    def __getitem__(self, key):
        if not isinstance(key, str):
            return super().__getitem__(key)
        return numpy.array([result.get(key, float("nan")) for result in self])

    @property
    def key(self):
        """The first of the keys."""
        return next(iter(self.changes[0]), "") if self.changes else ""

    @property
    def values(self):
        """What each row has under the first key."""
        return [changes[self.key] for changes in self.changes] if self.key else []

    def columns(self):
        """A column for each key, then strategy, outcome, each measure that some row has, and seconds to build and to
        solve. pandas.DataFrame takes it as it is."""
        names = dict.fromkeys(name for result in self for name in result.measures)
        return (self._named() | {"strategy": [result.strategy for result in self],
                                 "outcome": [result.outcome for result in self]} |
                {name: self[name] for name in names} |
                {name: numpy.array([getattr(result, name) for result in self])
                 for name in ("build_seconds", "solve_seconds")})

    def _named(self):
        return {key: [changes[key] for changes in self.changes] for key in (self.changes[0] if self.changes else {})}

    def _table(self):
        named = self._named()
        if len({result.strategy for result in self}) > 1:
            named["strategy"] = [result.strategy for result in self]
        return _tables.of_results(self, named)

    def __repr__(self):
        return self._table().text()

    def _repr_html_(self):
        return self._table().html()

    def plot(self, measure=None, ax=None, **options):
        """A measure, by default the most telling one, over the values of the first key: a line for each strategy and each
        combination of the other keys. Options go to matplotlib's plot."""
        from . import _plots
        measure = _plots.main_measure(self, measure)
        lines = {}
        for changes, result in zip(self.changes, self):
            others = [str(value) for key, value in changes.items() if key != self.key]
            lines.setdefault(", ".join([result.strategy, *others]), []).append((changes[self.key], result))
        ax = _plots.figure(ax)
        for name, points in lines.items():
            x = [value if isinstance(value, (int, float)) else str(value) for value, _ in points]
            y = [result.get(measure, float("nan")) for _, result in points]
            ax.plot(x, y, **{"marker": "o", "label": name} | options)
        ax.set(xlabel=self.key, ylabel=_plots.label(self[0], measure), title=self[0].scene)
        ax.legend()
        return ax
