"""Materials from measured curves: files or arrays in, an object with tables and figures out."""

import csv
import io
import json
import os
import re
import tempfile
import textwrap

import numpy

from . import _elastin, _own, _pictures, _progress, _scenes, _yaml
from ._bodies import material as _material
from ._elastin import InputError


class Identification(dict):
    """What `elastin identify --json` writes, a dict: "parameters" (name, value, unit, low, high), "correlation",
    "relative_rms", "warnings" and more, SI units. found["mu_1"] is the value of a number by its name. It shows itself as the
    command does, in a notebook with the fit."""

    def __init__(self, found, answers, number):
        super().__init__(found)
        self._answers, self._number = answers, number

    def __missing__(self, name):
        for one in self["parameters"]:
            if one["name"] == name:
                return one["value"]
        raise KeyError(f"'{name}'" + _elastin._suggestion(name, [*self, *(one["name"] for one in self["parameters"])]))

    @property
    def material(self):
        """The material found, a Material."""
        return _material(textwrap.dedent(re.sub(r"^material: *\n", "", self["material"])))

    @property
    def figure(self):
        """Each test with its fit, SVG."""
        return self._answers.figure(self._number)

    @property
    def points(self):
        """Every point with its fit, columns by name."""
        rows = list(csv.DictReader(io.StringIO(self._answers.points(self._number))))

        def column(name):
            try:
                return numpy.array([float(row[name]) for row in rows])
            except ValueError:
                return [row[name] for row in rows]

        return {name: column(name) for name in (rows[0] if rows else {})}

    def to_html(self, path):
        """Writes the page of `elastin identify --out`, of all strategies: tables, figures, intervals. It needs no other file."""
        _pictures.write(path, self._answers.page())

    def __repr__(self):
        return self._answers.text(self._number).strip("\n")

    def _repr_html_(self):
        return f"<pre>{_pictures.escape(repr(self))}</pre>{self.figure}"


def _is_column(value):
    return isinstance(value, numpy.ndarray) or (isinstance(value, (list, tuple)) and len(value) > 1
                                                and all(isinstance(one, (int, float, numpy.number)) for one in value))


def _with_file(test, name, folder):
    """A test whose columns are arrays, as one with a file; SI units where a name has none."""
    columns = {key: numpy.asarray(value, float) for key, value in test.items() if _is_column(value)}
    if not columns:
        return test
    for key in columns:
        if numpy.ma.is_masked(test[key]):
            raise InputError(f"data of '{name}': {key} has masked values; leave their rows out of every column")
    sizes = {key: column.shape for key, column in columns.items()}
    if len(set(sizes.values())) > 1 or any(len(shape) != 1 for shape in sizes.values()):
        raise InputError(f"data of '{name}': columns must be arrays of one length; they have "
                         + ", ".join(f"{key} {shape}" for key, shape in sizes.items()))
    units = _elastin._data_quantities() | {"angle": "rad", "angular_frequency": "rad/s"}
    heads = [key if "[" in key or not units.get(key) else f"{key} [{units[key]}]" for key in columns]
    path = os.path.join(folder, f"{len(os.listdir(folder))}.csv")
    with open(path, "w", encoding="utf8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(heads)
        writer.writerows([repr(float(value)) for value in row] for row in zip(*columns.values()))
    return {key: value for key, value in test.items() if key not in columns} | {"file": path}


def identify(scene=None, data=None, *, material=None, tests=(), laws=(), strategies=(), set=None, catalog=None,
             progress=None, **keys):
    """Fits a material to measured tests and gives an Identification, of several `strategies` of the specimens a list.

        elastin.identify(data={"uniaxial": {"stretch": stretch, "nominal_stress": stress}},
                         material={"law": "ogden", "terms": [[1e5, 2]]})

    The scene is a file, a dict or a Body, as for Laboratory, with an `identify` section whose tests are files, or columns of
    arrays by name, {"kind": "uniaxial", "stretch": …, "nominal_stress": …}; SI units, unless a name has another,
    "force [kN]". Without a scene the tests are those of `data` by their kind, each with its keys and columns, and
    identify={"fixed": ["bulk_modulus"]} has the section's other keys. With one `data`
    has what replaces the data of its tests, {test: path or columns}. Of `tests` alone are fitted, the others predicted;
    `laws` are compared (["all"]); a law of one's own, elastin.law, is named where the material has its constants,
    material={"law": mine, "k": 3e4}. A Catalog brings strategies of one's own. progress: True shows a line, a function is called
    with what is being done."""
    with tempfile.TemporaryDirectory() as folder, _progress.shown(progress) as report:
        files = []
        if scene is None:
            made = [{"kind": kind} | test for kind, test in (data or {}).items()]
            scene, data = {"identify": keys.pop("identify", {}) | {"tests": made}}, None
        if isinstance(scene, dict) and isinstance(scene.get("identify"), dict):
            section = dict(scene["identify"])
            section["tests"] = [_with_file(test, test.get("name", test.get("kind", "")), folder)
                                for test in section.get("tests", [])]
            scene = scene | {"identify": section}
        for test, given in (data or {}).items():
            path = _with_file(given, test, folder)["file"] if isinstance(given, dict) else os.fspath(given)
            files.append(f"{test}={path}")
        opened = _scenes.opened(scene, (), material=material, keys=keys)
        if opened.experiments:
            raise InputError("identify: takes experiments of the table; fit one of your own by the measures of run() and "
                             "scipy.optimize.least_squares")
        with opened.messages():
            try:
                answers = _elastin._identify(opened.source, _yaml.overrides(set), files, list(tests), ",".join(laws),
                                             ",".join(strategies), _own.catalog_with(catalog, opened.own), report)
            except InputError as error:
                raise type(error)(str(error).replace(folder + os.sep, "arrays:")) from None
        found = json.loads(answers.json())
        several = found.get("identifications", [found])
        made = [Identification(one, answers, number) for number, one in enumerate(several)]
        return made if "identifications" in found else made[0]
