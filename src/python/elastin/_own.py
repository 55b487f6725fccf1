"""Loads and steppers of one's own."""

import functools
import inspect

from . import _elastin
from ._elastin import Catalog, InputError, Parameter


def _by_name(what, function, known):
    """A function that takes values of all `known` names, in this order, and a dict of parameters, and hands over those that
    `function` names; the names that it takes; and its parameters, the arguments with a default."""
    taken, parameters = [], []
    for argument, described in inspect.signature(function).parameters.items():
        if argument in known:
            taken.append(argument)
        elif described.default is described.empty:
            raise InputError(f"{what}: argument '{argument}' has no default" + _elastin._suggestion(argument, list(known))
                             + ", or a parameter with a default")
        else:
            default = described.default
            parameters.append(default if isinstance(default, Parameter) else Parameter(argument, default))

    def called(*values):
        given = dict(zip(known, values))
        return function(**{name: given[name] for name in taken}, **values[len(known)])

    return called, taken, parameters


def load(name, forces, energy=None, *, summary="", source=""):
    """A load of one's own for Simulation.add_load and scenes, from a function of the forces [N] on all molecules, (n, 3):

        elastin.load("trap", lambda positions, stiffness=1e-3: -stiffness * (positions - middle))
        elastin.load("wind", lambda velocities, time, drag=1e-6: drag * (wind(time) - velocities))

    The names of its arguments determine their meaning: positions [m] and velocities [m/s], (n, 3), time [s], the body.
    Every other argument is a parameter with a default, a number or a Parameter, that add_load(trap, stiffness=2e-3) and a
    scene, loads=[{"trap": {"stiffness": 2e-3}}], set. `energy`, a function of the same arguments, is the potential energy
    [J], where the forces have one: equilibria then minimise it. Newton's method takes how the force on each molecule changes with
    its own position and velocity, by differences; forces between molecules cost it more iterations. What a function
    raises ends the step or run, and comes out. A scene takes the load as it is, loads=[trap], or by its name from a
    Catalog."""
    known = ("body", "positions", "velocities", "time")
    called, taken, parameters = _by_name(f"load '{name}'", forces, known)
    of_energy = None
    if energy is not None:
        of_energy, _, more = _by_name(f"load '{name}', energy", energy, known)
        for one in more:
            if one.name not in [mine.name for mine in parameters]:
                raise InputError(f"load '{name}': the forces have no parameter '{one.name}'")
        names = list(inspect.signature(energy).parameters)
        all_of_energy = of_energy
        of_energy = lambda *values: all_of_energy(*values[:-1], {key: value for key, value in values[-1].items() if key in names})
    made = _elastin._load(name, parameters, summary, source, called, of_energy, "positions" in taken,
                          "velocities" in taken, "time" in taken)
    made._made_by = functools.partial(load, summary=summary, source=source), (name, forces, energy)
    return made


def stepper(name, step, *, explicit=True, order=1, summary="", source=""):
    """A stepper of one's own, Simulation(…, stepper=it), from a function that gives positions and velocities, (n, 3) each, at
    the end of a step by dt [s]:

        def leap(positions, velocities, forces, masses, dt):
            velocities = velocities + dt * forces(positions, velocities) / masses[:, None]
            return positions + dt * velocities, velocities

    The names of its arguments determine their meaning: positions [m] and velocities [m/s] at the beginning, masses (n,) [kg],
    dt, time [s], the body, and forces, a function of positions and velocities that gives all forces [N] but those of
    supports, as they act at the end of the step. Other arguments are parameters with a default (stepper_parameters). Fixed and
    moved molecules then go where their supports want them; a step that is not finite, or inverts a cell, fails and leaves the
    state as it was. explicit: whether steps must stay below the body's longest stable one, and are divided. order: of the error
    at a fixed time."""
    known = ("body", "positions", "velocities", "forces", "masses", "dt", "time")
    called, _, parameters = _by_name(f"stepper '{name}'", step, known)
    made = _elastin._stepper(name, parameters, summary, source, called, explicit, order)
    made._made_by = functools.partial(stepper, explicit=explicit, order=order, summary=summary, source=source), (name, step)
    return made


def same(one, other):
    """Whether two rows are one: the same object, a copy of it, or one of Elastin's own."""
    if one is other or getattr(one, "_made_by", one) == getattr(other, "_made_by", other):
        return True
    return (one.summary, one.source) == (other.summary, other.source) != ("", "")


def catalog_with(catalog, own):
    """A catalog that also has these rows; what is taken by another one of its kind raises InputError."""
    if not own:
        return catalog
    made = Catalog()
    for row in [*getattr(catalog, "_own", []), *own]:
        known = [*made, *getattr(made, "_own", [])]
        if not any(type(other) is type(row) and other.name == row.name and same(other, row) for other in known):
            made.add(row)
    return made
