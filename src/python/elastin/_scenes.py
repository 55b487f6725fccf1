"""Scenes of Python values: dicts, bodies, experiments."""

import contextlib
import json
import numbers
import os
import re

import numpy

from . import _elastin, _yaml
from ._elastin import Body, InputError, Load, Material, Stepper, Strategy
from ._experiments import Experiment

ARRAYS = ("positions", "connections", "triangles", "tetrahedra", "cells", "rest_lengths", "masses", "radii", "density",
          "thickness", "growth", "stiffness")


class Held:
    """A scene in memory; `root` is what messages call it."""

    def __init__(self, tree, root="scene"):
        self.root, self.places, self.lines, self.bodies, self.materials = root, {}, [], [], []
        self.own, self.experiments = [], {}  # loads, steppers and strategies; experiments by their kind
        self._write(tree, root, "", "")
        self.text = "\n".join(self.lines) + "\n"
        self.source = _elastin._HeldScene(self.text, self.bodies, self.materials)

    def _line(self, place, text):
        """One line of YAML for each value: its number then says where it stood."""
        self.lines.append(text)
        self.places[len(self.lines)] = place

    def _write(self, value, place, before, after):
        value = self._plain(value, place)
        if isinstance(value, dict):
            self._line(place, before + "{")
            last = len(value) - 1
            for number, (key, item) in enumerate(value.items()):
                if isinstance(key, numbers.Integral) and not isinstance(key, bool):
                    key = str(key)  # a label of an image
                if not isinstance(key, str) or not key:
                    raise InputError(f"{place}: a key must be a word, not {key!r}")
                self._write(item, f"{place}[{key!r}]", f"{json.dumps(key, ensure_ascii=False)}: ",
                            "," if number < last else "")
            self._line(place, "}" + after)
        elif isinstance(value, list):
            self._line(place, before + "[")
            for number, item in enumerate(value):
                self._write(item, f"{place}[{number}]", "", "," if number < len(value) - 1 else "")
            self._line(place, "]" + after)
        elif isinstance(value, str):
            formula = "!formula " if value.startswith("=") else ""  # a text in quotes alone is no formula
            self._line(place, before + formula + json.dumps(value, ensure_ascii=False) + after)
        else:
            self._line(place, before + _yaml.text(value) + after)

    def _plain(self, value, place):
        """Dicts, lists, words and numbers alone; bodies and materials by their numbers."""
        if isinstance(value, Body):
            return {"given": self._number(self.bodies, value)}
        if isinstance(value, Material):
            return {"given": self._number(self.materials, value)}
        if isinstance(value, Experiment):
            if hasattr(value, "hold") and self.experiments.setdefault(value.keys()["kind"], value) is not value:
                raise InputError(f"{place}: there is another experiment '{value.keys()['kind']}' in this scene")
            return value.keys()
        if isinstance(value, (Load, Stepper, Strategy)):
            self.own.append(value)
            return {value.name: {}} if isinstance(value, Load) else value.name
        if isinstance(value, dict) and "body" in value and place.startswith(f"{self.root}['bodies']["):
            return {key: item for key, item in value.items() if key != "body"} | self._plain(value["body"], place)
        if isinstance(value, dict) and "positions" in value:
            return self._body_of_arrays(value, place)
        if isinstance(value, dict) and isinstance(value.get("given"), (Body, Material)):
            return value | self._plain(value["given"], place)
        if isinstance(value, numpy.ndarray):
            return value.tolist()
        if isinstance(value, os.PathLike):
            return os.fspath(value)
        if isinstance(value, (list, tuple, range)):
            return list(value)
        if isinstance(value, (dict, str, numbers.Real, numpy.bool_)) or value is None:
            return value
        raise InputError(f"{place}: is a {type(value).__name__}; allowed: dicts, lists, text, numbers, arrays, and "
                         "bodies, materials and experiments of elastin")

    def _number(self, things, thing):
        things.append(thing)
        return len(things) - 1

    def _body_of_arrays(self, value, place):
        """Masses and radii come from the scene's material, as those of every shape, unless they stand among the arrays."""
        arrays = {key: item for key, item in value.items() if key in ARRAYS}
        others = {key: item for key, item in value.items() if key not in ARRAYS}
        own = {"masses", "radii", "density"} & set(arrays)
        try:
            made = Body(**arrays)
        except InputError as error:
            raise InputError(f"{place}: {error}") from None
        return others | {"given" if own else "given_shape": self._number(self.bodies, made)}

    @contextlib.contextmanager
    def messages(self):
        """Errors name the place of a value as Python has it: scene['body']['lattice']."""
        try:
            yield
        except InputError as error:
            raise type(error)(self.placed(str(error))) from None

    def placed(self, message):
        def place(found):
            line = int(found[1] or 1)
            return self.places.get(line, self.root) if line > 1 else self.root

        return re.sub(r"\bscene:(\d+):\d+|^scene(?=: )", place, message)


class File:
    """A scene file, where a scene in memory could stand."""

    own, experiments = (), {}

    def __init__(self, path):
        self.source = os.fspath(path)

    def messages(self):
        return contextlib.nullcontext()


def opened(scene, strategies=(), experiment=None, material=None, keys=None):
    """A scene file, or a scene in memory, with a `source` and with `messages`. In addition to a dict or a body `experiment`,
    `material` and other keys of a scene may stand; a body alone has them all from there."""
    added = {"experiment": experiment, "material": material, **(keys or {})}
    added = {key: value for key, value in added.items() if value is not None}
    if isinstance(scene, (Held, File)):
        return scene
    if isinstance(scene, (str, os.PathLike)):
        if added:
            raise InputError(f"{', '.join(added)}: the file {os.fspath(scene)} says it already; change it by `set`")
        return File(scene)
    if not isinstance(scene, (dict, Body)):
        raise InputError(f"scene: is a {type(scene).__name__}; allowed: the path of a file, a dict, or a Body")
    tree = {"body": scene} if isinstance(scene, Body) else dict(scene)
    tree.update(added)
    if isinstance(scene, Body):
        tree = usual_strategies(scene, strategies) | tree
    elif strategies:
        tree = {"stiffness": strategies[0]} | tree
    return Held(tree)


def usual_strategies(body, strategies):
    """Of a body alone: what its cells allow, and in a comparison all."""
    if strategies:
        return {"stiffness": strategies[0]}
    cells = set(body.cells)
    solid = any(not name.startswith(("triangle", "quadrilateral")) for name in cells)
    rule = _elastin._usual_rule(body)
    return {"stiffness": "neo_hookean" if solid else "neo_hookean_membrane" if cells else rule, "strategies": "all"}
