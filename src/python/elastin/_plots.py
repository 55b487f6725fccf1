"""Plots; matplotlib is loaded when the first is asked for."""

import numpy

from . import _elastin
from ._tables import UNITS


def figure(ax, **options):
    """The axes given, or new ones."""
    if ax is not None:
        return ax
    try:
        from matplotlib import pyplot
    except ImportError as missing:
        raise ImportError("plots need matplotlib: apt-get install python3-matplotlib, or pip install matplotlib; "
                          "every number is in the result without it") from missing
    return pyplot.figure(layout="constrained").add_subplot(**options)


def label(name):
    unit = UNITS.get(name, "")
    return name.replace("_", " ") + (f" [{unit}]" if unit else "")


def body(result, ax, options):
    positions, tensions, ends = result.positions, result.tensions, result.body.connections
    if len(positions) == 0:
        raise ValueError(f"there is no state to show: {result.outcome}: {result.cause}")
    ax = figure(ax, projection="3d")
    from mpl_toolkits.mplot3d.art3d import Line3DCollection
    largest = max(abs(tensions).max(), 1e-300) if len(tensions) else 1
    settings = {"cmap": "coolwarm", "linewidths": 1.0} | options
    lines = Line3DCollection(positions[ends], array=tensions, **settings)
    lines.set_clim(-largest, largest)
    ax.add_collection3d(lines)
    low, high = positions.min(axis=0), positions.max(axis=0)
    middle, half = (low + high) / 2, max((high - low).max() / 2, 1e-12)
    for axis, centre in zip("xyz", middle):
        getattr(ax, f"set_{axis}lim")(centre - half, centre + half)
        getattr(ax, f"set_{axis}label")(f"{axis} [m]")
    ax.figure.colorbar(lines, ax=ax, label="tension [N]", shrink=0.7, pad=0.12)
    ax.set_title(f"{result.scene}, {result.strategy}")
    return ax


def curve(result, x, y, ax, options):
    columns = result.curve
    if not columns:
        raise ValueError(f"there is no curve to show: {result.outcome}: {result.cause}")
    told = "strain" in columns and "stress" in columns
    x = x or ("strain" if told else "at")
    y = y or ("stress" if told else next((name for name in result.main if name in columns), "energy"))
    for name in (x, y):
        if name not in columns:
            raise KeyError(_elastin._missing_measure(name, list(columns)))
    ax = figure(ax)
    at_rest = x == "strain" and y == "stress"
    values = [numpy.concatenate(([0.0], columns[name])) if at_rest else columns[name] for name in (x, y)]
    ax.plot(*values, **{"marker": ".", "label": result.strategy} | options)
    ax.set(xlabel="load, or time [s]" if x == "at" else label(x), ylabel=label(y), title=result.scene)
    ax.legend()
    return ax


def main_measure(results, wanted):
    return wanted or next((result.main[0] for result in results if result.main), "effective_modulus")


def speed_against_error(comparison, measure, ax):
    measure = main_measure(comparison, measure)
    ax = figure(ax)
    for result in comparison:
        if measure in result.errors:
            error = max(abs(result.errors[measure]), 1e-16)
            ax.loglog(result.build_seconds + result.solve_seconds, error, "o", label=result.strategy)
    ax.set(xlabel="seconds", ylabel=f"|error of {measure.replace('_', ' ')}|", title=comparison[0].scene)
    ax.legend()
    return ax
