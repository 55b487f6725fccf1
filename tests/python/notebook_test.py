"""How things show themselves, and plots."""

import importlib.util
import os
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

import elastin
from helpers import CUBE, SOURCE, TABLE_1

HAS_MATPLOTLIB = importlib.util.find_spec("matplotlib") is not None
if HAS_MATPLOTLIB:
    import matplotlib
    matplotlib.use("Agg")


class Shown(unittest.TestCase):
    def test_things_say_what_they_are(self):
        body = elastin.lattice((3, 3, 3), 1e-3, ["axis"])
        self.assertEqual(repr(body), "<elastin.Body: 27 molecules, 54 connections>")
        self.assertEqual(repr(elastin.Material(5e3)), "<elastin.Material: E = 5000 Pa, nu = 0.25, 1000 kg/m^3>")
        self.assertEqual(repr(elastin.Simulation(body, "standard", elastin.Material(5e3))),
                         "<elastin.Simulation: 27 molecules at 0.0 s>")
        self.assertIn("cube-27-face", repr(elastin.Laboratory(CUBE)))

    def test_tables(self):
        comparison = elastin.compare(TABLE_1[0])
        lines = repr(comparison).splitlines()
        self.assertEqual(lines[0], "table1-a")
        self.assertEqual(len(lines), 2 + len(comparison))
        self.assertRegex(lines[2], r"^standard +5\.0000 kPa +3\.3333 mm")  # between clamps: no error
        html = comparison._repr_html_()
        self.assertEqual(html.count("<tr>"), 1 + len(comparison))
        self.assertIn("effective_modulus", comparison["standard"]._repr_html_())
        self.assertIn("<td>standard</td>", html)
        swept = elastin.sweep(CUBE, "material.youngs_modulus", [1e3, 2e3])
        self.assertRegex(repr(swept), r"(?m)^2000\.0 ")

    def test_measures_that_a_scene_names_have_units(self):
        result = elastin.run(elastin.lattice((3, 3, 3), 1e-3, ["axis", "face"]), "lattice", material=elastin.Material(5e3),
                             experiment={"kind": "loads", "read": [{"name": "top", "molecules": {"side": "z"}}]},
                             loads=[{"gravity": [0, 0, -1]}], supports=[{"molecules": {"side": "-z"}}])
        self.assertEqual(result.units["top_z"], "m")
        self.assertRegex(repr(result), r"(?m)^top_z +-[0-9.]+ [nµm]m")
        self.assertRegex(repr(result), r"(?m)^top_reaction_z +0 N")

    def test_nothing_of_a_scene_becomes_html(self):
        result = elastin.run(CUBE, set={"title": "a"})
        self.assertNotIn("<script>", elastin.Comparison([result])._repr_html_())
        from elastin._tables import Table
        self.assertIn("&lt;script&gt;", Table(["a"], [["<script>"]]).html())


class WithoutMatplotlib(unittest.TestCase):
    def test_the_message_says_what_to_install(self):
        with unittest.mock.patch.dict(sys.modules, {"matplotlib": None}):
            with self.assertRaisesRegex(ImportError, "python3-matplotlib"):
                elastin.run(CUBE).plot()


@unittest.skipUnless(HAS_MATPLOTLIB, "matplotlib is missing")
class Plots(unittest.TestCase):
    def test_body_has_its_connections_coloured_by_tension(self):
        result = elastin.run(CUBE)
        ax = result.plot()
        lines = ax.collections[0]
        self.assertEqual(list(lines.get_array()), list(result.tensions))
        ax.figure.canvas.draw()

    def test_curve(self):
        result = elastin.run(CUBE, set={"experiment.load_steps": 3})
        line = result.plot_curve().lines[0]
        self.assertEqual(list(line.get_ydata()), [0, *result.curve["stress"]])
        with self.assertRaisesRegex(KeyError, "did you mean 'stress'"):
            result.plot_curve(y="stres")

    def test_sweep_and_comparison(self):
        swept = elastin.sweep(CUBE, "material.youngs_modulus", [1e3, 2e3])
        self.assertEqual(list(swept.plot().lines[0].get_ydata()), list(swept["effective_modulus"]))
        comparison = elastin.compare(TABLE_1[0])
        self.assertEqual(len(comparison.plot().lines), sum(bool(result.errors) for result in comparison))


class Examples(unittest.TestCase):
    def run_example(self, name, *arguments):
        return subprocess.run([sys.executable, f"{SOURCE}/tests/examples/{name}", *arguments], cwd=SOURCE,
                              capture_output=True, text=True, check=False)

    def test_tension_table(self):
        ended = self.run_example("tension_table.py")
        self.assertEqual(ended.stderr, "")
        printed = {tuple(line.split()[:2]): line.split()[2] for line in ended.stdout.splitlines()}
        modulus = elastin.run(TABLE_1[1], "standard")["effective_modulus"]
        self.assertEqual(printed["table1-b", "standard"], f"{modulus:.4f}")

    def test_tension_sweep(self):
        with tempfile.TemporaryDirectory() as folder:
            picture = os.path.join(folder, "sweep.png")
            ended = self.run_example("tension_sweep.py", picture)
            rows = {line.split()[0]: [float(word) for word in line.split()[1:]] for line in ended.stdout.splitlines()}
            for ratio in rows["calibrated:standard"]:
                self.assertAlmostEqual(ratio, 1, delta=0.02)
            if HAS_MATPLOTLIB:
                with open(picture, "rb") as stream:
                    self.assertEqual(stream.read(8), b"\x89PNG\r\n\x1a\n")
            else:
                self.assertIn("matplotlib is missing", ended.stderr)


if __name__ == "__main__":
    unittest.main()
