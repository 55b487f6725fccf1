"""Plots; matplotlib is loaded by the first."""

import numpy

from . import _elastin


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


def label(result, name):
    unit = result.units.get(name) or next((unit for known, unit, _ in _elastin.measures() if known == name), "")
    return name.replace("_", " ") + (f" [{unit}]" if unit else "")


def lines_of(positions, body, tensions, options):
    """The connections as a collection of lines, coloured by their tension where it is known."""
    from mpl_toolkits.mplot3d.art3d import Line3DCollection
    known = tensions is not None and len(tensions) > 0
    ends = numpy.asarray(body.connections)[: len(tensions)] if known else body.connections
    if not known:
        return Line3DCollection(positions[ends], **{"colors": "0.4", "linewidths": 1.0} | options)
    largest = max(abs(tensions).max(), 1e-300)
    lines = Line3DCollection(positions[ends], array=tensions, **{"cmap": "coolwarm", "linewidths": 1.0} | options)
    lines.set_clim(-largest, largest)
    return lines


def space(ax, low, high):
    """Equal scales around the middle of a box."""
    middle, half = (low + high) / 2, max((high - low).max() / 2, 1e-12)
    for axis, centre in zip("xyz", middle):
        getattr(ax, f"set_{axis}lim")(centre - half, centre + half)
        getattr(ax, f"set_{axis}label")(f"{axis} [m]")


def state(positions, body, tensions, title, ax, options):
    ax = figure(ax, projection="3d")
    lines = lines_of(positions, body, tensions, options)
    ax.add_collection3d(lines)
    space(ax, positions.min(axis=0), positions.max(axis=0))
    if lines.get_array() is not None:
        ax.figure.colorbar(lines, ax=ax, label="tension [N]", shrink=0.7, pad=0.12)
    ax.set_title(title)
    return ax


def body(result, ax, options):
    if len(result.positions) == 0:
        raise ValueError(f"there is no state to show: {result.outcome}: {result.cause}")
    return state(result.positions, result.body, result.tensions, f"{result.scene}, {result.strategy}", ax, options)


def animation(shown, states, scale, interval, options):
    """States after one another, displacements times `scale`."""
    if not states:
        raise ValueError("there are no states to show: run it with keep_states=True, or record some")
    ax = figure(None, projection="3d")
    from matplotlib.animation import FuncAnimation
    moved = [shown.positions + scale * (positions - shown.positions) for positions in states]
    lines = lines_of(moved[0], shown, None, options)
    ax.add_collection3d(lines)
    space(ax, numpy.min(moved, axis=(0, 1)), numpy.max(moved, axis=(0, 1)))
    ends = numpy.asarray(shown.connections)

    def show(number):
        lines.set_segments(moved[number][ends])
        return (lines,)

    return FuncAnimation(ax.figure, show, frames=len(moved), interval=interval, blit=False)


def curve(result, x, y, ax, options):
    columns = result.curve
    if not columns:
        raise ValueError(f"there is no curve to show: {result.outcome}: {result.cause}")
    strained = "strain" in columns and "stress" in columns
    x = x or ("strain" if strained else "at")
    y = y or ("stress" if strained else next((name for name in result.main if name in columns), "energy"))
    for name in (x, y):
        if name not in columns:
            raise KeyError(_elastin._missing_measure(name, list(columns)))
    ax = figure(ax)
    at_rest = x == "strain" and y == "stress"
    values = [numpy.concatenate(([0.0], columns[name])) if at_rest else columns[name] for name in (x, y)]
    ax.plot(*values, **{"marker": ".", "label": result.strategy} | options)
    ax.set(xlabel="load, or time [s]" if x == "at" else label(result, x), ylabel=label(result, y), title=result.scene)
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
