"""Experiments as objects: elastin.Tension(axis="z", strain=0.15, grips="clamped"). Their keys are those of scenes, and
come from the same table."""

import inspect
import re

from . import _elastin
from ._elastin import InputError

# What stands for several keys.
GRIPS = ("fixed_grip", "loaded_grip")


class Experiment:
    """What is done to a body, and what is read: an experiment of the scenes with its keys. Quantities are plain numbers in
    SI units or text with a unit, "3 mm". Where the ends have grips, `grips` sets both.

    A class of one's own is an experiment at rest with measures of its own:

        class Squeeze(elastin.Experiment):
            measures = {"force": "N", "bulge": "m"}                    # by name their SI unit, the most telling first
            def __init__(self, depth):
                self.depth = depth
            def hold(self, body):                                      # who is held, and where it goes [m]
                return [(bottom, (0, 0, 0)), (top, (0, 0, -self.depth), "xy")]
            def measure(self, body, positions, reactions):             # (n, 3) [m] and [N]
                return {"force": reactions[bottom, 2].sum(), "bulge": numpy.ptp(positions[:, 0])}

    `hold` gives triples of molecules, a displacement (3,) or (k, 3), and directions that stay free, "xy" or a projector,
    if any; `forces(body)`, if it is there, forces on all molecules (n, 3) [N]; `load_steps` is the number of steps in which
    both grow. What either raises ends the run, and comes out."""

    kind = ""
    in_time = False
    table = {}
    given = {}
    measures = {}
    load_steps = 1

    def __init__(self, **keys):
        for key in keys:
            if key not in self.allowed():
                raise InputError(f"{type(self).__name__}: unknown key '{key}'"
                                 + _elastin._suggestion(key, self.allowed()))
        if "grips" in keys and set(GRIPS) & set(keys):
            raise InputError(f"{type(self).__name__}: grips sets fixed_grip and loaded_grip; leave these out")
        self.given = {key: value for key, value in keys.items() if value is not None}

    @classmethod
    def allowed(cls):
        """The names of its keys."""
        names = list(dict.fromkeys(key.split(".")[0] for key in cls.table))
        if set(GRIPS) <= set(names):
            names.append("grips")
        return names

    def keys(self):
        """As a scene has it: a dict with `kind`."""
        keys = {"kind": self.kind or re.sub(r"(?<!^)(?=[A-Z])", "_", type(self).__name__).lower()} | self.given
        if "grips" in keys:
            keys |= dict.fromkeys(GRIPS, keys.pop("grips"))
        return keys

    def forces(self, specimen):
        """Of an experiment of one's own: forces on all molecules (n, 3) [N], or None."""

    def _info(self):
        """Of an experiment of one's own: what C++ takes."""
        summary = (inspect.getdoc(type(self)) or "").split("\n")[0]
        return _elastin._Experiment(self, self.keys()["kind"], summary, list(self.measures.items()), self.load_steps)

    def __eq__(self, other):
        return type(self) is type(other) and vars(self) == vars(other)

    def __repr__(self):
        return f"{type(self).__name__}({', '.join(f'{key}={value!r}' for key, value in self.given.items())})"


def class_name(kind):
    """Tension; of `material`, which is another class, MaterialExperiment."""
    name = "".join(word.capitalize() for word in kind.split("_"))
    return name + "Experiment" if hasattr(_elastin, name) else name


def doc_of(row):
    lines = [f"{row['summary'][0].upper()}{row['summary'][1:]}."]
    if row["source"]:
        lines[0] += f" [{row['source']}]"
    for key in row["keys"]:
        unit = f" [{key['unit']}]" if key["unit"] else ""
        lines.append(f"{key['name']}{unit}: {key['text']} ({key['type'].replace('`', '')}; "
                     f"default: {key['default'].replace('`', '')}).")
    return "\n".join(lines)


def made_class(row):
    made = type(class_name(row["name"]), (Experiment,), {
        "__doc__": doc_of(row), "__module__": "elastin", "kind": row["name"], "in_time": row["in_time"],
        "table": {key["name"]: key for key in row["keys"]}})
    parameters = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None) for name in made.allowed()]
    made.__signature__ = inspect.Signature(parameters)
    return made


CLASSES = {made.__name__: made for made in map(made_class, _elastin._experiments())}


def experiments():
    """Every kind of experiment, a class each."""
    return list(CLASSES.values())
