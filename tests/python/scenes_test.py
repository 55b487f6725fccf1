"""Scenes without a file: dicts, bodies, arrays, experiments. Their results are those of the file."""

import inspect
import os
import unittest

import numpy

import elastin
from helpers import CUBE, SOURCE, runs_of_command

CUBE_AS_DICT = {
    "body": {"lattice": {"kind": "cubic", "molecules": [3, 3, 3], "spacing": "7.5 mm", "connections": ["axis", "face"]}},
    "material": {"youngs_modulus": "5 kPa"},
    "stiffness": "lattice",
    "experiment": {"kind": "tension", "force": "1 mN"}}
BAR = {"tetrahedra": {"kind": "body_centred", "cubes": [6, 2, 2], "size": [30e-3, 10e-3, 10e-3]}}
RUBBER = elastin.Material(120e3, 0.3, 1100)
PULL = elastin.Tension(axis="x", strain=0.15, grips="clamped", load_steps=3)


def dict_of(path):
    """A scene file as a dict, all of its values text as YAML has them."""
    import yaml
    with open(path, encoding="utf8") as stream:
        return yaml.load(stream, yaml.BaseLoader)


class Dicts(unittest.TestCase):
    def test_numbers_are_the_files(self):
        """The same scene as YAML text, given by --set over another file of the same kind, to the last bit."""
        result = elastin.run(CUBE_AS_DICT)
        changes = [f"--set={key}={value}" for key, value in
                   {"body": "{lattice: {kind: cubic, molecules: [3, 3, 3], spacing: 7.5 mm, connections: [axis, face]}}",
                    "material": "{youngs_modulus: 5 kPa}", "stiffness": "lattice",
                    "experiment": "{kind: tension, force: 1 mN}"}.items()]
        run = runs_of_command("run", CUBE, *changes)[0]
        self.assertEqual(result.measures, run["measures"])

    def test_scenes_of_every_kind(self):
        """Contact, several bodies, moving tools, runs in time: what a file says, a dict says."""
        try:
            import yaml  # noqa: F401
        except ImportError:
            self.skipTest("python3-yaml is missing")
        folder = os.getcwd()
        self.addCleanup(os.chdir, folder)
        for name in ("contact/patch-test", "contact/tied-blocks", "contact/sled", "dynamics/drag-stokes",
                     "material/shear", "tissue/muscle", "membrane/sphere-corners-type-1"):
            path = f"{SOURCE}/scenes/{name}.yaml"
            os.chdir(os.path.dirname(path))
            with self.subTest(scene=name):
                file, given = elastin.run(path), elastin.run(dict_of(path))
                self.assertEqual(given.measures, file.measures)
                self.assertEqual((given.outcome, given.errors), (file.outcome, file.errors))

    def test_plain_numbers_are_si_beside_units(self):
        plain = {**CUBE_AS_DICT, "material": {"youngs_modulus": 5e3},
                 "experiment": {"kind": "tension", "force": numpy.float64(1e-3)}}
        self.assertEqual(elastin.run(plain).measures, elastin.run(CUBE_AS_DICT).measures)

    def test_set_and_keys_change_it(self):
        harder = elastin.run(CUBE_AS_DICT, set={"material.youngs_modulus": 1e4})
        self.assertEqual(elastin.run(CUBE_AS_DICT, material={"youngs_modulus": "10 kPa"}).measures, harder.measures)
        self.assertAlmostEqual(harder["effective_modulus"] / elastin.run(CUBE_AS_DICT)["effective_modulus"], 2, 2)
        with self.assertRaisesRegex(elastin.InputError, "material: the file .* says it already"):
            elastin.run(CUBE, material=RUBBER)

    def test_sweep(self):
        moduli = elastin.sweep(CUBE_AS_DICT, "material.youngs_modulus", [1e3, 2e3])["effective_modulus"]
        self.assertAlmostEqual(moduli[1] / moduli[0], 2, 2)

    def test_verify(self):
        expected = {**CUBE_AS_DICT, "expect": [
            {"measure": "effective_modulus", "value": "5 kPa", "tolerance": "1 %", "source": "its material"}]}
        verdicts = elastin.verify([expected, expected | {"material": {"youngs_modulus": "6 kPa"}}])
        self.assertEqual([case["verdict"] for case in verdicts], ["passed", "failed"])
        self.assertFalse(verdicts.passed)
        self.assertIn("1 of 2 passed", repr(verdicts))
        self.assertEqual(verdicts[0]["expectations"][0]["source"], "its material")
        self.assertTrue(elastin.verify(f"{SOURCE}/scenes/tension/cube-27-face.yaml").passed)


class Messages(unittest.TestCase):
    def said(self, scene, **keys):
        with self.assertRaises(elastin.InputError) as caught:
            elastin.run(scene, **keys)
        return str(caught.exception)

    def changed(self, key, **values):
        return {**CUBE_AS_DICT, key: CUBE_AS_DICT[key] | values}

    def test_place_key_given_allowed_and_nearest(self):
        self.assertRegex(self.said(self.changed("material", poison_ratio=0.3)),
                         r"^scene\['material'\]\['poison_ratio'\]: material: unknown key 'poison_ratio'; did you mean "
                         r"'poissons_ratio'\? \(allowed: .*density")
        self.assertRegex(self.said(self.changed("experiment", force="1 kg")),
                         r"^scene\['experiment'\]\['force'\]: experiment.force: 'kg' cannot be converted to N")
        self.assertRegex(self.said(self.changed("material", youngs_modulus=-5)),
                         r"^scene\['material'\]\['youngs_modulus'\]: .*out of range: must be above 0 Pa")
        self.assertRegex(self.said(self.changed("experiment", kind="tensoin")),
                         r"^scene\['experiment'\]\['kind'\]: .*did you mean 'tension'")
        lattice = CUBE_AS_DICT["body"]["lattice"] | {"molecules": [3, 0, 3]}
        self.assertRegex(self.said(self.changed("body", lattice=lattice)),
                         r"^scene\['body'\]\['lattice'\]\['molecules'\]\[1\]: ")
        self.assertRegex(self.said({key: CUBE_AS_DICT[key] for key in ("body", "material", "stiffness")}),
                         r"^scene: key 'experiment' is missing")

    def test_what_is_no_scene(self):
        self.assertIn("scene: is a int; allowed: the path of a file, a dict, or a Body", self.said(5))
        self.assertIn("scene['body']: is a set", self.said({"body": {1, 2}}))
        self.assertIn("scene: a key must be a word, not None", self.said({None: 1}))
        self.assertIn("unknown key '5'", self.said({**CUBE_AS_DICT, 5: 1}))
        self.assertIn("scene['title']: has no value", self.said({**CUBE_AS_DICT, "title": None}).replace(" title:", ""))

    def test_text_is_text(self):
        """Whatever YAML would make of it."""
        for title in ("a: b", "[1, 2", "'", '"\\', "{}", "# no comment", "ä €", "two\nlines"):
            self.assertEqual(elastin.Laboratory({**CUBE_AS_DICT, "title": title}).title, title)

    def test_body_says_places_too(self):
        with self.assertRaisesRegex(elastin.InputError, r"^body\['lattice'\]\['kind'\]: .*did you mean 'cubic'"):
            elastin.body({"lattice": {"kind": "cubik", "molecules": [2, 2, 2], "spacing": 1}})


class Bodies(unittest.TestCase):
    def test_a_body_with_an_experiment(self):
        """The same as a file: made of the description, the body and its arrays."""
        body = elastin.body(BAR, RUBBER)
        strategies = ["neo_hookean", "standard"]
        given = elastin.compare(body, strategies, experiment=PULL, material=RUBBER, reference="none")
        scene = {"body": BAR, "material": {"youngs_modulus": 120e3, "poissons_ratio": 0.3, "density": 1100},
                 "stiffness": "neo_hookean",
                 "experiment": {"kind": "tension", "axis": "x", "displacement": 0.15 * 30e-3, "fixed_grip": "clamped",
                                "loaded_grip": "clamped", "load_steps": 3}}
        described = elastin.compare(scene, strategies, reference="none")
        arrays = {"positions": body.positions, "tetrahedra": body.tetrahedra}
        listed = elastin.compare({**scene, "body": arrays}, strategies, reference="none")
        for one, other, third in zip(given, described, listed, strict=True):
            self.assertEqual(one.outcome, "converged")
            self.assertEqual(one.measures, other.measures)
            self.assertEqual(one.measures, third.measures)
        self.assertAlmostEqual(given[0]["engineering_strain"] if "engineering_strain" in given[0].measures
                               else given[0].curve["strain"][-1], 0.15, 12)

    def test_all_strategies_and_the_reference_by_default(self):
        """Of a body alone; clamped, so that the material's E is not what is right."""
        body = elastin.body({"tetrahedra": {"kind": "kuhn", "cubes": [1, 1, 2], "size": [1e-2, 1e-2, 2e-2]}})
        comparison = elastin.compare(body, experiment=elastin.Tension(displacement=1e-4, grips="clamped"),
                                     material=elastin.Material(5e3, 0.3), set={"reference": [{"computed": {
                                         "uncertainty": 0.05, "most_cells": 2000}}]})
        names = [result.strategy for result in comparison]
        for name in ("neo_hookean", "standard", "st_venant_kirchhoff", "van_gelder"):
            self.assertIn(name, names)
        self.assertIn("effective_modulus_to_reference", comparison["neo_hookean"].errors)

    def test_masses(self):
        """Those that a Body states are kept; without masses and density it gets those of the scene's material."""
        arrays = {"positions": [[0, 0, 0], [1e-2, 0, 0], [0, 1e-2, 0], [0, 0, 1e-2]], "tetrahedra": [[0, 1, 2, 3]]}
        scene = {"material": elastin.Material(5e3, density=500), "stiffness": "neo_hookean",
                 "experiment": elastin.Tension(displacement=1e-5, loaded=[3], cross_section=1e-5)}
        volume = 1e-6 / 6
        for body, density in ((arrays, 500), (elastin.Body(**arrays), 500), ({**arrays, "density": 700}, 700),
                              (elastin.Body(**arrays, density=1000), 1000),
                              ({"given": elastin.Body(**arrays), "radius": 1e-3}, 500)):
            made = elastin.Laboratory({**scene, "body": body}).body
            self.assertAlmostEqual(made.masses.sum() / (density * volume), 1, 12)
        self.assertEqual(list(made.radii), [1e-3] * 4)

    def test_several_bodies_with_materials_of_their_own(self):
        """Two bars glued end to end: each gets half of the force's elongation, by its own modulus."""
        bar = elastin.body({"tetrahedra": {"kind": "kuhn", "cubes": [2, 2, 2], "size": [1e-2, 1e-2, 1e-2]}})
        other = elastin.Body(bar.positions + (0, 0, 1e-2), tetrahedra=bar.tetrahedra)
        result = elastin.run({
            "bodies": [{"name": "soft", "body": bar},
                       {"name": "hard", "body": other, "material": elastin.Material(10e3, 0)}],
            "ties": [{"between": ["soft", "hard"], "within": 1e-6}],
            "material": elastin.Material(5e3, 0), "stiffness": "neo_hookean",
            "experiment": elastin.Tension(force=1e-4), "solver": {"displacements": "small"}})
        self.assertEqual(result.outcome, "converged")
        self.assertAlmostEqual(result["effective_modulus"] / (2 / (1 / 5e3 + 1 / 10e3)), 1, 6)

    def test_material_objects_carry_all_they_have(self):
        """A law with constants of its own, here and in a dict."""
        body = elastin.body({"tetrahedra": {"kind": "kuhn", "cubes": [1, 1, 1], "size": [1e-2, 1e-2, 1e-2]}})
        constants = {"law": "yeoh", "terms": [[1e4], [5e2]], "bulk_modulus": 1e6}
        described = dict(constants, terms=[1e4, 5e2])
        pulls = elastin.Tension(strain=0.2, load_steps=2)
        object_given = elastin.run(body, "yeoh", experiment=pulls, material=elastin.Material(law=constants))
        dict_given = elastin.run(body, "yeoh", experiment=pulls, material=described)
        self.assertEqual(object_given.measures, dict_given.measures)


class Experiments(unittest.TestCase):
    def test_every_row_of_the_table_is_a_class(self):
        for row in elastin.experiments():
            self.assertIs(getattr(elastin, row.__name__), row)
            self.assertTrue(row.__doc__)
            self.assertIn(row.__name__, elastin.__all__)
        kinds = {row.kind for row in elastin.experiments()}
        self.assertLessEqual({"tension", "shear", "torsion", "indentation", "press", "motion"}, kinds)
        self.assertIn("strain", inspect.signature(elastin.Tension).parameters)

    def test_wrong_keys(self):
        with self.assertRaisesRegex(elastin.InputError, "Tension: unknown key 'axsi'; did you mean 'axis'"):
            elastin.Tension(axsi="z")
        with self.assertRaisesRegex(elastin.InputError, "grips sets fixed_grip and loaded_grip"):
            elastin.Tension(grips="clamped", fixed_grip="sliding")
        with self.assertRaisesRegex(elastin.InputError, r"scene\['experiment'\]\['axis'\]"):
            elastin.run({**CUBE_AS_DICT, "experiment": elastin.Tension(axis="w", force=1)})

    def test_strain_of_the_length_along_the_axis(self):
        body = elastin.body(BAR)
        for axis in ("x", "-x", [1, 0, 0]):
            result = elastin.run(body, "neo_hookean", experiment=elastin.Compression(axis=axis, strain=0.1),
                                 material=RUBBER)
            self.assertAlmostEqual(result.curve["strain"][-1], -0.1, 10)

    def test_how_they_show_themselves(self):
        self.assertEqual(repr(elastin.Shear(direction="x", strain=0.1)), "Shear(direction='x', strain=0.1)")
        self.assertEqual(elastin.Shear(direction="x"), elastin.Shear(direction="x", strain=None))


if __name__ == "__main__":
    unittest.main()
