"""What Python adds to simulations: pictures and animations."""

import concurrent.futures
import os

import numpy

from . import _elastin, _exchange, _pictures, _tables
from ._elastin import InputError, Simulation, StepError


def _plot(simulation, ax=None, **options):
    """The body as it is now, its connections coloured by their tension. Options go to Line3DCollection."""
    from . import _plots
    return _plots.state(numpy.array(simulation.positions), simulation.body, numpy.array(simulation.tensions),
                        f"t = {simulation.time:g} s", ax, options)


def _animate(simulation, dt, frames, *, scale=1.0, interval=40, act=None, **options):
    """Steps `frames` times by dt [s] and gives a matplotlib animation of it, displacements times `scale`, `interval` [ms] a
    frame; act(simulation), if given, is called before each step. Options go to Line3DCollection."""
    from . import _plots
    states = [numpy.array(simulation.positions)]
    for _ in range(frames):
        if act:
            act(simulation)
        simulation.step(dt)
        states.append(numpy.array(simulation.positions))
    return _plots.animation(simulation.body, states, scale, interval, options)


def _view(simulation):
    """The body as it is now in 3D: a View."""
    return _pictures.View(_elastin._view(simulation))


def _html(simulation):
    table = _tables.of_body(simulation.body)
    table.head = ["simulation", f"{simulation.time:g} s"]
    return _tables.with_picture(table, _pictures.of_body(simulation.body, simulation.positions, simulation.tensions))


def _tangent(simulation):
    """The stiffness -d(all forces)/d(positions) [N/m] now, (3 n, 3 n), supports not regarded, as the arrays that
    scipy.sparse.csr_matrix takes: data, column indices and indptr. Molecule m has rows 3 m, 3 m + 1 and 3 m + 2."""
    blocks, columns, starts = simulation.stiffness()
    counts = numpy.repeat(numpy.diff(starts), 3)  # blocks of each row
    rows = [slice(starts[m], starts[m + 1]) for m in range(len(starts) - 1)]
    data = [blocks[row].transpose(1, 0, 2).ravel() for row in rows]
    indices = [numpy.tile((3 * columns[row, None] + numpy.arange(3, dtype=numpy.int32)).ravel(), 3) for row in rows]
    return numpy.concatenate(data), numpy.concatenate(indices), numpy.concatenate([[0], 3 * numpy.cumsum(counts)]).astype(numpy.int32)


def _mass_matrix(simulation):
    """The masses of the molecules [kg] on the diagonal, (3 n, 3 n), as tangent() has its matrix."""
    data = numpy.repeat(simulation.body.masses, 3)
    return data, numpy.arange(len(data), dtype=numpy.int32), numpy.arange(len(data) + 1, dtype=numpy.int32)


def step_all(simulations, dt, count=1, *, check=True, threads=None):
    """Brings many simulations forward by dt [s], `count` times, at the same time: each goes on in one thread at a time, of
    `threads`, by default one a core. Gives their last results in order, bitwise those of step(). One that fails stops, and
    raises StepError when the others are done, unless check=False. Ctrl-C ends all within a step."""
    stopped = []

    def steps(simulation):
        for _ in range(count):
            result = None if stopped else simulation.step(dt, check=False)
            if not result:
                break
        return result

    simulations = list(simulations)
    if count < 1:
        raise InputError(f"count: is {count}; allowed: 1 or more")
    if len({id(one) for one in simulations}) != len(simulations):
        raise InputError("simulations: one is named twice")
    with concurrent.futures.ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        try:
            results = list(pool.map(steps, simulations))
        except BaseException:
            stopped.append(True)
            raise
    for number, result in enumerate(results if check else []):
        if not result:
            error = StepError(f"simulation {number}: {result.outcome}: {result.cause}")
            error.result = result
            raise error
    return results


Simulation._repr_html_ = _html
for _name, _method in (("plot", _plot), ("view", _view), ("animate", _animate), ("tangent", _tangent), ("mass_matrix", _mass_matrix), ("to_vtu", _exchange.simulation_to_vtu),
                       ("to_meshio", _exchange.simulation_to_meshio), ("to_pyvista", _exchange.simulation_to_pyvista)):
    _method.__name__, _method.__qualname__ = _name, f"Simulation.{_name}"
    setattr(Simulation, _name, _method)
