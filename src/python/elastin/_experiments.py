"""Experiments as objects: elastin.Tension(axis="z", strain=0.15, grips="clamped"). Their keys are those of scenes, and
come from the same table."""

import inspect

from . import _elastin
from ._elastin import InputError

# What stands for several keys.
GRIPS = ("fixed_grip", "loaded_grip")


class Experiment:
    """What is done to a body, and what is read: an experiment of the scenes with its keys. Quantities are plain numbers in
    SI units or text with a unit, "3 mm". Where the ends have grips, `grips` sets both."""

    kind = ""
    in_time = False
    table = {}

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
        keys = {"kind": self.kind} | self.given
        if "grips" in keys:
            keys |= dict.fromkeys(GRIPS, keys.pop("grips"))
        return keys

    def __eq__(self, other):
        return type(self) is type(other) and self.given == other.given

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
