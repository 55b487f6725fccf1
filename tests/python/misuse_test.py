"""What must not be taken in silence: names that are taken, values of a wrong type, files that are not there."""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest
import warnings

import numpy

import elastin
from helpers import CUBE

SOFT = elastin.Material(1e4)
LATTICE = elastin.lattice((4, 4, 4), 1e-3)
TENSION = elastin.Tension(axis="z", force=1e-4)


def rule(name, constant):
    return elastin.Strategy(name, lambda body, material: numpy.full(body.proper_connections, constant))


class Names(unittest.TestCase):
    def test_a_name_that_is_taken_is_refused(self):
        with self.assertRaisesRegex(elastin.InputError, "strategy 'lattice' already"):
            elastin.run(LATTICE, rule("lattice", 1.0), experiment=TENSION, material=SOFT)
        with self.assertRaisesRegex(elastin.InputError, "strategy 'mine' already"):
            elastin.compare(LATTICE, [rule("mine", 1.0), rule("mine", 2.0)], experiment=TENSION, material=SOFT)
        with self.assertRaisesRegex(elastin.InputError, "strategy 'neo_hookean' already"):
            elastin.run(LATTICE, elastin.law("neo_hookean", lambda I1, J, mu: mu / 2 * (I1 - 3) - mu * numpy.log(J)),
                        experiment=TENSION, material=SOFT)

    def test_numbers_of_threads_have_the_range_of_the_command(self):
        before = elastin.threads()
        for number in (-5, 10**9):
            with self.assertRaisesRegex(elastin.InputError, f"threads is {number}; it must be at least 0 and at most 4096"):
                elastin.set_threads(number)
        self.assertEqual(elastin.threads(), before)

    def test_the_same_strategy_may_be_named_again(self):
        own = rule("mine", 1.0)
        both = elastin.compare(LATTICE, [own, own, elastin.Catalog()["lattice"]], experiment=TENSION, material=SOFT)
        self.assertEqual([one.strategy for one in both], ["mine", "mine", "lattice"])

    def test_obstacles_of_two_contacts_keep_their_forces(self):
        """A block that stands on one plane and is pressed by another: each has its own force, and they are equal."""
        tissue = elastin.Simulation(LATTICE, "lattice", SOFT, stepper="backward_euler")
        turned = numpy.diag([1.0, -1.0, -1.0])  # a half space above
        tissue.add_contact(1e8, [{"shape": "plane", "position": (0, 0, 1e-6)}])
        tissue.add_contact(1e8, [{"shape": "plane", "position": (0, 0, 3e-3 - 1e-5), "turn": turned}])
        tissue.settle()
        forces = tissue.contact_forces()
        self.assertEqual(list(forces), ["plane0", "plane1"])
        self.assertGreater(abs(forces["plane0"][2]), 0)
        self.assertAlmostEqual(forces["plane0"][2], -forces["plane1"][2], delta=1e-5 * abs(forces["plane0"][2]))
        with self.assertRaisesRegex(elastin.InputError, "the name 'plane0' is taken"):
            tissue.add_contact(1e8, [{"shape": "plane", "name": "plane0"}])

    def test_several_materials_need_parts(self):
        with self.assertRaisesRegex(elastin.InputError, "a list of 2 for a body without parts"):
            elastin.Simulation(LATTICE, "lattice", [SOFT, elastin.Material(2e4)])


class Defaults(unittest.TestCase):
    def test_a_lattice_takes_the_rule_made_for_it(self):
        """The rule is exact on cubic lattices at nu = 1/4."""
        result = elastin.run(LATTICE, experiment=TENSION, material=SOFT)
        self.assertEqual(result.strategy, "lattice")
        self.assertLess(abs(result.errors["effective_modulus"]), 1e-2)


class Values(unittest.TestCase):
    def test_a_value_of_a_wrong_type_is_named(self):
        tissue = elastin.Simulation(LATTICE, "lattice", SOFT)
        tool = tissue.add_tool((0, 0, 1))
        for act, said in (
                (lambda: tissue.add_contact(1e8, [{"shape": "sphere", "radius": "wide"}]), "radius: is 'wide'; allowed: a number"),
                (lambda: tissue.add_contact(1e8, [{"shape": "spher"}]), "no shape 'spher'"),
                (lambda: tissue.add_contact(1e8, [{"shape": "torus"}]), "convex.*mesh"),
                (lambda: tissue.add_contact(1e8, [{"shape": "sphere", "radius": 1e-3, "tool": tool, "position": (0, 0, 1)}]),
                 "has a tool, which says where it is"),
                (lambda: tissue.add_contact(1e8, [{"shape": 3}]), "shape: is 3; allowed: a text"),
                (lambda: tissue.add_contact(1e8, [{"shape": "plane", "position": "up"}]), "position: is 'up'; allowed: three"),
                (lambda: tissue.add_load("gravity", acceleration="down"), "acceleration: is 'down'; allowed: three"),
                (lambda: tissue.fix(0, free=numpy.ones(2)), "free: is .*; allowed: letters of xyz"),
                (lambda: elastin.Material(law={"law": "ogden", "terms": [["a", 2]]}), "terms: is .*; allowed: lists of numbers"),
                (lambda: elastin.Material(law={"law": 3}), "law: is 3; allowed: a text"),
                (lambda: elastin.Catalog().add("lattice"), "own: is 'lattice'; allowed: a Strategy")):
            with self.assertRaisesRegex(elastin.InputError, said):
                act()

    def test_none_is_no_body_stepper_or_load(self):
        """Not even a null pointer."""
        tissue = elastin.Simulation(LATTICE, "lattice", SOFT)
        laboratory = elastin.Laboratory(LATTICE, experiment=TENSION, material=SOFT)
        for act in (lambda: elastin.Simulation(None, "lattice", SOFT), lambda: elastin.Simulation(LATTICE, "lattice", SOFT, stepper=None),
                    lambda: tissue.add_load(None), lambda: laboratory.simulation("lattice", stepper=None)):
            with self.assertRaisesRegex(TypeError, "incompatible"):
                act()

    def test_arrays_of_a_body_are_named_as_its_arguments(self):
        points = [[0, 0, 0], [1e-2, 0, 0], [0, 1e-2, 0], [0, 0, 1e-2]]
        for given, said in (({}, "^radii: are needed"), ({"masses": [1] * 4}, "^radii: are needed"),
                            ({"cells": {"tetrahedron4": [[0, 1, 2, 4]]}}, "^cells: tetrahedron4.0.: there is no molecule 4"),
                            ({"cells": {"tet": [[0, 1, 2, 3]]}}, "^cells: unknown cell shape 'tet'")):
            with self.assertRaisesRegex(elastin.InputError, said):
                elastin.Body(points, **given)

    def test_masked_values_do_not_count_in_silence(self):
        ends, modulus = [[0, 1]], {"law": "yeoh", "terms": [1e3], "bulk_modulus": 1e9}
        places = numpy.ma.masked_array([[0.0, 0, 0], [1, 0, 0]], mask=[[0, 0, 0], [1, 0, 0]])
        data = {"stretch": [1.1, 1.2, 1.3], "nominal_stress": numpy.ma.masked_array([1.0, 2, 70], mask=[0, 0, 1])}
        for act, said in (
                (lambda: elastin.Body(places, ends), "positions: has masked values"),
                (lambda: elastin.Body(places.data, numpy.ma.masked_array(ends, mask=[[0, 1]])), "connections: has masked"),
                (lambda: elastin.Body(places.data, ends, masses=numpy.ma.masked_array([1.0, 2], mask=[1, 0])), "masses: has"),
                (lambda: elastin.identify(data={"uniaxial": data}, material=modulus), "nominal_stress has masked values")):
            with self.assertRaisesRegex(elastin.InputError, said):
                act()
        self.assertEqual(len(elastin.Body(numpy.ma.masked_array(places.data), ends)), 2)

    def test_an_unknown_name_is_said_whatever_its_value(self):
        tissue = elastin.Simulation(LATTICE, "lattice", SOFT)
        with self.assertRaisesRegex(elastin.InputError, "gravity has no 'accel'"):
            tissue.add_load("gravity", accel=(0, 0, 1))
        with self.assertRaisesRegex(elastin.InputError, "posiition: is .*; allowed: .* other keys are shape, name, position"):
            tissue.add_contact(1e8, [{"shape": "sphere", "radius": 1e-3, "posiition": (0, 0, 0)}])
        with self.assertRaisesRegex(elastin.InputError, "point.molecules: names no molecule"):
            tissue.add_load("point", molecules=LATTICE.positions[:, 2] < 0, force=(0, 0, 1))

    def test_one_strategy_by_its_name(self):
        found = elastin.compare(LATTICE, "lattice", experiment=TENSION, material=SOFT)
        self.assertEqual([result.strategy for result in found], ["lattice"])

    def test_a_file_that_is_not_there(self):
        for read in (lambda: elastin.run("no/such.yaml"), lambda: elastin.read_mesh("no_such.msh", "mm"),
                     lambda: elastin.body({"mesh": {"file": "no_such.vtk", "length_unit": "mm"}}),
                     lambda: elastin.identify({"identify": {"tests": [{"name": "pull", "kind": "uniaxial", "file": "no_such.csv"}]},
                                               "material": {"law": "yeoh", "terms": ["1 kPa"]}})):
            with self.assertRaises(FileNotFoundError) as raised:
                read()
            self.assertIsInstance(raised.exception, elastin.InputError)
            self.assertIn("no_such" if "no_such" in str(raised.exception) else "no/such", str(raised.exception))

    def test_formulas_in_dicts(self):
        scene = {"values": {"stiff": "10 kPa"}, "body": LATTICE, "material": {"youngs_modulus": "= max(stiff, 2 * stiff)"},
                 "stiffness": "lattice", "experiment": {"kind": "tension", "force": "= 1 mN / 2"}}
        self.assertEqual(elastin.Laboratory(scene).material.youngs_modulus, 2e4)
        self.assertEqual(elastin.Laboratory(scene, set={"values.stiff": "5 kPa"}).material.youngs_modulus, 1e4)
        with self.assertRaisesRegex(elastin.InputError, r"scene\['material'\]\['youngs_modulus'\].*no value 'stif'"):
            elastin.Laboratory({**scene, "material": {"youngs_modulus": "= 2 * stif"}})


class Warnings(unittest.TestCase):
    def test_a_simulation_warns(self):
        corners = numpy.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * 1e-2
        pieces = elastin.Body(numpy.vstack([corners, corners + 0.1]), tetrahedra=[[0, 1, 2, 3], [4, 5, 6, 7]])
        with self.assertWarnsRegex(UserWarning, "not connected: 2 pieces"):
            tissue = elastin.Simulation(pieces, "neo_hookean", SOFT)
        self.assertRegex(tissue.warnings[0], "not connected: 2 pieces")
        self.assertEqual(elastin.Simulation(LATTICE, "lattice", SOFT).warnings, [])
        self.assertRegex(elastin.Simulation(LATTICE, rule("pushed", -1.0), SOFT).warnings[0], "constants are negative")

    def test_how_a_mesh_was_read_is_no_warning(self):
        text = """$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 "all"\n$EndPhysicalNames
$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n$Elements\n1\n1 4 2 1 1 1 2 3 4\n$EndElements\n"""
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "one.msh")
            with open(path, "w") as file:
                file.write(text)
            with warnings.catch_warnings(), self.assertLogs("elastin", "INFO"):
                warnings.simplefilter("error")
                elastin.read_mesh(path, "mm")


class DecimalComma(unittest.TestCase):
    def test_a_host_with_a_decimal_comma(self):
        """The host's locale changes neither formulas nor saved states nor measured data."""
        if not shutil.which("localedef") or not os.path.exists("/usr/share/i18n/locales/de_DE"):
            self.skipTest("localedef or its tables are missing")
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", os.path.join(folder, "de_DE.UTF-8")], check=True,
                           capture_output=True)
            code = f"""
import elastin, locale, pickle
locale.setlocale(locale.LC_ALL, "de_DE.UTF-8")
assert locale.localeconv()["decimal_point"] == ","
scene = {{"values": {{"half": "= 1 / 2"}}, "body": elastin.lattice((3, 3, 3), 1e-3),
         "material": {{"youngs_modulus": "= half * 3 kPa", "poissons_ratio": 0.25}}, "stiffness": "lattice",
         "experiment": {{"kind": "tension", "force": "= half * 1 mN"}}}}
laboratory = elastin.Laboratory(scene)
assert laboratory.material.youngs_modulus == 1500, laboratory.material
assert laboratory.run().good
assert elastin.run({CUBE!r}).good
"""
            subprocess.run([sys.executable, "-c", code], check=True, env={**os.environ, "LOCPATH": folder})


if __name__ == "__main__":
    unittest.main()
