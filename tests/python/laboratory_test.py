"""Scenes: the same numbers as the command, to the last bit."""

import contextlib
import io
import pickle
import tempfile
import unittest

import numpy

import elastin
from helpers import CUBE, SOURCE, TABLE_1, command, runs_of_command

ONE_OF_EACH_KIND = ["material/shear", "material/cube-stiffness", "dynamics/drag-stokes", "contact/patch-test",
                    "membrane/sphere-corners-type-1"]


class Identification(unittest.TestCase):
    SCENE = f"{SOURCE}/scenes/identify/treloar-ogden.yaml"

    def test_numbers_of_a_law(self):
        found = elastin.identify(self.SCENE, laws=["mooney_rivlin"])
        self.assertEqual([number["name"] for number in found["parameters"]], ["c1", "c2"])
        self.assertAlmostEqual(found["parameters"][0]["value"], 0.1828e6, delta=200)  # the best known fit
        self.assertAlmostEqual(found["relative_rms"]["equibiaxial"], 0.07, delta=0.005)

    def test_arrays(self):
        """P = 2 (stretch - stretch^-2) (c1 + c2 / stretch) of a solid that keeps its volume [Rivlin 1948]."""
        stretch = numpy.linspace(1.05, 2, 12)
        stress = 2 * (stretch - stretch**-2) * (1e3 + 200 / stretch)
        material = {"law": "mooney_rivlin", "c1": 400, "c2": 400, "bulk_modulus": 1e9}
        for columns in ({"stretch": stretch, "nominal_stress": stress},
                        {"nominal_stress [kPa]": list(stress / 1e3), "stretch": list(stretch), "residuals": "relative"}):
            found = elastin.identify(data={"uniaxial": columns}, material=material)
            self.assertAlmostEqual(found["c1"], 1e3, delta=0.1)
            self.assertAlmostEqual(found["c2"], 200, delta=0.1)
        self.assertRegex(repr(found), r"c1 +1\.0000\d* kPa")
        self.assertIn("<svg", found._repr_html_())
        self.assertAlmostEqual(found.material.youngs_modulus, 6 * 1200, delta=1)
        self.assertTrue(any(len(column) == 12 for column in found.points.values()))
        again = elastin.identify({"material": material, "identify": {"tests": [{"kind": "uniaxial", "stretch": stretch, "nominal_stress": stress}]}},
                                 {"uniaxial": {"stretch": stretch, "nominal_stress": 2 * stress}})
        self.assertAlmostEqual(again["c1"], 2e3, delta=0.2)
        with self.assertRaisesRegex(elastin.InputError, r"columns must be arrays of one length; they have stretch \(12,\), nominal_stress \(11,\)"):
            elastin.identify(data={"uniaxial": {"stretch": stretch, "nominal_stress": stress[1:]}}, material=material)
        with self.assertRaisesRegex(elastin.InputError, "arrays:0.csv"):
            elastin.identify(data={"uniaxial": {"stretch": -stretch, "nominal_stress": stress}}, material=material)
        with self.assertRaisesRegex(KeyError, "did you mean 'c1'"):
            found["c11"]

    def test_a_law_of_ones_own(self):
        """Its constants are found: a solid that hardly changes its volume, pulled along its fibres, P = 2 c (s - s^-2) + 4 k (s^3 - s)."""
        mine = elastin.law("mine", lambda I1_bar, I4_bar, J, c=1e3, k=1e3, bulk=1e9:
                           c * (I1_bar - 3) + k * (I4_bar - 1) ** 2 + bulk / 2 * numpy.log(J) ** 2)
        stretch = numpy.linspace(1.02, 1.5, 15)
        stress = 2 * 800 * (stretch - stretch**-2) + 4 * 300 * (stretch**3 - stretch)
        test = {"uniaxial": {"stretch": stretch, "nominal_stress": stress}}
        material = {"law": mine, "c": 500, "k": 2e3, "direction": [0, 0, 1]}
        found = elastin.identify(data=test, material=material, identify={"fixed": ["bulk"]})
        self.assertAlmostEqual(found["c"] / 800, 1, 4)
        self.assertAlmostEqual(found["k"] / 300, 1, 4)
        self.assertIn("law: mine", found["material"])
        found = elastin.identify(data=test, material=material, identify={"unknowns": ["k"]})
        self.assertEqual([number["name"] for number in found["parameters"]], ["k"])

    def test_wrong_use(self):
        with self.assertRaisesRegex(elastin.InputError, "did you mean 'planar'"):
            elastin.identify(self.SCENE, tests=["planer"])

        class Squeeze(elastin.Experiment):
            measures = {"force": "N"}

            def hold(self, body):
                return []

        # Arrays are in SI units: an angular frequency in rad/s.
        w, tau, g, modulus = numpy.logspace(-1, 2, 20), 0.5, 0.6, 9e3
        real, imaginary = 1 + g * (w * tau)**2 / (1 + (w * tau)**2), g * w * tau / (1 + (w * tau)**2)
        found = elastin.identify(data={"storage_modulus": {"angular_frequency": w, "storage_modulus": modulus * real},
                                       "loss_modulus": {"angular_frequency": w, "loss_modulus": modulus * imaginary}},
                                 material={"law": "mooney_rivlin", "c1": 1e3, "bulk_modulus": 1e9,
                                           "relaxation": {"terms": [[0.3, 1.0]]}},
                                 identify={"unknowns": ["c1", "g_1", "tau_1"]})
        self.assertAlmostEqual(found["tau_1"], tau, places=4)
        with self.assertRaisesRegex(elastin.InputError, "identify: takes experiments of the table"):
            elastin.identify({"body": elastin.lattice((3, 3, 3), 1e-3), "identify": {"tests": []}}, experiment=Squeeze())


class Pages(unittest.TestCase):
    def test_what_compare_recommends_and_writes(self):
        compared = elastin.compare(CUBE)
        self.assertIn(f"recommended: {compared.recommended}", compared.advice)
        self.assertIn(compared.advice.strip().splitlines()[0].rpartition(",")[0], command("compare", CUBE).stdout)  # but the time
        with tempfile.TemporaryDirectory() as folder:
            compared.to_html(f"{folder}/page.html")
            compared.view().to_html(f"{folder}/view.html")
            with open(f"{folder}/page.html", encoding="utf8") as page, open(f"{folder}/view.html", encoding="utf8") as view:
                page, view = page.read(), view.read()
        self.assertIn("<canvas", page)
        self.assertIn(compared[0].strategy, page)
        self.assertIn("<canvas", view)
        again = pickle.loads(pickle.dumps(compared[0]))
        with self.assertRaisesRegex(elastin.InputError, "was unpacked"):
            again.view()

    def test_bodies_simulations_and_results_turn_in_notebooks(self):
        body = elastin.lattice((3, 3, 3), 1e-3)
        for thing in (body, elastin.Simulation(body, "standard", elastin.Material(5e3)), elastin.run(CUBE, keep_states=True)):
            self.assertRegex(thing.view()._repr_html_(), "^<iframe srcdoc=\"&lt;!doctype html&gt;")

    def test_other_programs_get_what_the_command_writes(self):
        with tempfile.TemporaryDirectory() as folder:
            for to, path in (("vtu", "own.vtu"), ("lammps", "own")):
                elastin.export(CUBE, f"{folder}/{path}", to, "lattice")
                command("export", CUBE, "--to", to, "--strategy", "lattice", "--out", f"{folder}/by-{path}")
            for name in ("own.vtu", "own/body.data", "own/in.body"):
                with open(f"{folder}/{name}", encoding="utf8") as own, open(f"{folder}/by-{name}", encoding="utf8") as other:
                    self.assertEqual(own.read(), other.read())
            with self.assertRaisesRegex(elastin.InputError, "end in .vtu"):
                elastin.export(CUBE, f"{folder}/own.vtk", "vtu")

    def test_progress_is_a_line_on_standard_error(self):
        with contextlib.redirect_stderr(io.StringIO()) as said:
            elastin.compare(CUBE, ["standard", "lattice"], progress=True)
        self.assertRegex(said.getvalue(), r"\[#{10}-{10}\] 1 of 2, standard: ")
        self.assertTrue(said.getvalue().endswith("\r"))


class Engines(unittest.TestCase):
    """A bar of three molecules in a row: k = E A / L each, so that the force moves the ends by 2 f / k."""

    BAR = {"title": "bar",
           "body": {"lattice": {"kind": "cubic", "molecules": [1, 1, 3], "spacing": 0.01, "connections": ["axis"]}, "radius": 0.01},
           "stiffness": {"strategy": "uniform", "constant": 50}, "reference": "none"}
    TEST = {"experiment": elastin.Tension(axis="z", force=0.01, fixed_grip="clamped", cross_section=1e-4, gauge_length=0.02),
            "material": elastin.Material(5e3)}

    def solved(self, request):
        body = request["body"]
        positions = numpy.array(body["positions"])
        k = body["connections"][0]["stiffness"]
        positions[1, 2] += 0.01 / k
        positions[2, 2] += 0.02 / k
        self.seen = request["dt"], request["iterations"], k, body["forces"]
        return {"positions": positions, "engine": "by hand"}

    def test_a_function_is_an_engine(self):
        result = elastin.measure(self.solved, self.BAR, engines={"dt": 0.002, "iterations": 7}, **self.TEST)
        self.assertEqual(self.seen, (0.002, 7, 50.0, [{"molecule": 2, "force": [0, 0, 0.01]}]))
        self.assertEqual((result.outcome, result.strategy), ("converged", "engine"))
        # stress / strain: (f / A) / (2 f / k / L)
        self.assertAlmostEqual(result.measures["effective_modulus"], 50 * 0.02 / 2 / 1e-4, delta=1e-6)

    def test_wrong_answers_are_outcomes_and_errors_come_out(self):
        for answer, words in [({"positions": [[0, 0, 0]]}, "1 of 3 molecules"), ({}, "neither 'positions'"),
                              ({"positions": [[0, 0, float("nan")]] * 3}, "not finite")]:
            result = elastin.measure(lambda request: answer, self.BAR, **self.TEST)
            self.assertEqual(result.outcome, "diverged")
            self.assertIn(words, result.cause)
        with self.assertRaises(ZeroDivisionError):
            elastin.measure(lambda request: 1 / 0, self.BAR, **self.TEST)

    def test_constants(self):
        body = elastin.Laboratory(self.BAR, **self.TEST).exported()
        self.assertEqual([one["stiffness"] for one in body["connections"]], [50, 50])
        self.assertEqual([one["rest_length"] for one in body["connections"]], [0.01, 0.01])


class TheCommandsNumbers(unittest.TestCase):
    def hold_against(self, result, run):
        self.assertEqual([result.scene, result.strategy, result.outcome],
                         [run[name] for name in ("scene", "strategy", "outcome")])
        self.assertEqual(result.cause, run["cause"])
        self.assertEqual(result.measures, run["measures"])
        self.assertEqual(result.errors, run["errors"])
        self.assertEqual(result.warnings, run["warnings"])
        self.assertEqual(result.notes, run["notes"])
        self.assertEqual(result.linear_iterations, run["linear_iterations"])
        rows = [{name: float(column[row]) for name, column in result.curve.items() if not numpy.isnan(column[row])}
                for row in range(len(run["curve"]))]
        for row, told in zip(rows, run["curve"]):
            told.pop("step", None)
            told["at"] = told.pop("time") if "time" in told else told.pop("load_factor")
            self.assertEqual(row, told)

    def test_tension_table(self):
        compared = 0
        for scene in TABLE_1:
            for result, run in zip(elastin.compare(scene), runs_of_command("compare", scene), strict=True):
                with self.subTest(scene=scene, strategy=run["strategy"]):
                    self.hold_against(result, run)
                    compared += "effective_modulus" in result.measures
        self.assertGreaterEqual(compared, 12)

    def test_other_experiments(self):
        for name in ONE_OF_EACH_KIND:
            with self.subTest(scene=name):
                scene = f"{SOURCE}/scenes/{name}.yaml"
                self.hold_against(elastin.run(scene), runs_of_command("run", scene)[0])

    def test_changed_keys_and_strategies_by_name(self):
        changes = {"material.youngs_modulus": 7123.456789012345, "body.lattice.molecules": [3, 4, 3]}
        result = elastin.run(CUBE, "calibrated:angles", set=changes)
        run = runs_of_command("compare", CUBE, "--strategies", "calibrated:angles",
                              "--set", "material.youngs_modulus=7123.456789012345",
                              "--set", "body.lattice.molecules=[3, 4, 3]")[0]
        self.hold_against(result, run)

    def test_sweep(self):
        moduli = [1e3, 5e3]
        swept = elastin.sweep(CUBE, "material.youngs_modulus", moduli, strategy="standard")
        for modulus, measured in zip(moduli, swept["effective_modulus"], strict=True):
            again = elastin.run(CUBE, "standard", set={"material.youngs_modulus": modulus})
            self.assertEqual(measured, again["effective_modulus"])
        self.assertTrue(numpy.isnan(swept["frequency"]).all())


class WhatAResultHolds(unittest.TestCase):
    def test_state_is_the_bodys(self):
        result = elastin.run(CUBE)
        body = result.body
        self.assertEqual(result.positions.shape, (len(body), 3))
        ends = result.positions[body.connections]
        lengths = numpy.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        pulled = result.tensions > 1e-9 * abs(result.tensions).max()
        self.assertTrue(pulled.any())
        self.assertTrue((lengths > body.rest_lengths)[pulled].all())

    def test_what_a_scene_says(self):
        laboratory = elastin.Laboratory(TABLE_1[0])
        self.assertEqual(laboratory.strategy, "standard")
        self.assertEqual(laboratory.expectations[0],
                         {"strategy": "standard", "measure": "effective_modulus", "value": 4994.5, "unit": "Pa",
                          "source": "[M03] Table 1 a"})
        self.assertTrue(laboratory.run().good)
        self.assertFalse(elastin.run(TABLE_1[0], set={"material.youngs_modulus": 6e3}).good)

    def test_unsuited_is_an_outcome(self):
        result = elastin.run(CUBE, "neo_hookean")
        self.assertEqual(result.outcome, "unsuited")
        self.assertIn("tetrahedra", result.cause)
        self.assertEqual(result.positions.shape, (0, 3))

    def test_progress_is_told_and_may_end_a_run(self):
        told = []
        elastin.run(CUBE, progress=told.append)
        self.assertIn("building", told)

        def refuse(doing):
            raise RuntimeError(doing)

        with self.assertRaisesRegex(RuntimeError, "building"):
            elastin.run(CUBE, progress=refuse)

    def test_a_body_that_settles_comes_where_the_scene_does(self):
        scene = f"{SOURCE}/scenes/tension/cube-1000.yaml"
        laboratory = elastin.Laboratory(scene)
        for strategy in ("standard", "calibrated:angles"):
            result = laboratory.run(strategy)
            tissue = laboratory.simulation(strategy)
            self.assertTrue(tissue.settle())
            displacement = abs(result.positions - result.body.positions).max()
            self.assertLess(abs(tissue.positions - result.positions).max(), 1e-8 * displacement)


if __name__ == "__main__":
    unittest.main()
