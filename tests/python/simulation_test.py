"""A simulation of a body, without a scene, gives what the command gives: strategies by their whole name, preparation."""

import unittest

import numpy

import elastin
from helpers import SOURCE, runs_of_command

SOFT = elastin.Material(10e3)
LATTICE = {"lattice": {"kind": "cubic", "molecules": [7, 7, 7], "spacing": 5e-3, "connections": ["axis", "face"]}}


def modulus_and_ratio(body, strategy, material):
    """E [Pa] and Poisson's ratio of a block in tension along z between sliding grips."""
    tissue = elastin.Simulation(body, strategy, material)
    x, z = body.positions[:, 0], body.positions[:, 2]
    low, high = numpy.flatnonzero(z == z.min()), numpy.flatnonzero(z == z.max())
    elongation = 1e-5 * numpy.ptp(z)
    for molecule in (*low, *high):
        tissue.fix(molecule, "xy")
    for molecule in high:
        tissue.move_to(molecule, body.positions[molecule] + (0, 0, elongation))
    assert tissue.settle()
    force = sum(tissue.reaction(molecule)[2] for molecule in high)
    stress = force / (numpy.ptp(x) * numpy.ptp(body.positions[:, 1]))
    middle = abs(z - z.mean()) < 1e-9
    narrowing = -numpy.polyfit(x[middle], (tissue.positions - body.positions)[middle, 0], 1)[0]
    return stress / 1e-5, narrowing / 1e-5


class WholeNames(unittest.TestCase):
    def test_volume_is_the_commands(self):
        scene = f"{SOURCE}/scenes/material/any-nu-lattice.yaml"
        material = elastin.Material(10e3, 0.45)
        body = elastin.body(LATTICE, material)
        for strategy in ("lattice+volume", "patch+volume"):
            run = runs_of_command("compare", scene, "--strategies", strategy)[0]
            modulus, ratio = modulus_and_ratio(body, strategy, material)
            self.assertAlmostEqual(modulus / run["measures"]["effective_modulus"], 1, delta=1e-4)
            self.assertAlmostEqual(ratio, run["measures"]["poissons_ratio"], delta=1e-4)
            self.assertAlmostEqual(ratio, 0.45, delta=1e-3)

    def test_calibrated_is_the_commands(self):
        scene = f"{SOURCE}/scenes/material/cube-stiffness.yaml"
        catalog, body = elastin.Catalog(), elastin.body(LATTICE, SOFT)
        for rule in ("standard", "angles"):
            run = runs_of_command("compare", scene, "--strategies", f"calibrated:{rule}")[0]
            factor = catalog[f"calibrated:{rule}"].constants(body, SOFT) / catalog[rule].constants(body, SOFT)
            self.assertAlmostEqual(numpy.ptp(factor), 0, delta=1e-12)
            self.assertAlmostEqual(factor[0] / run["calibration_factor"], 1, delta=1e-9)

    def test_calibrated_takes_no_scene(self):
        tissue = elastin.Simulation(elastin.body(LATTICE, SOFT), "calibrated:standard", SOFT)
        tissue.host_forces[0] = 1e-3
        self.assertTrue(tissue.step(1e-4))
        with self.assertRaisesRegex(elastin.InputError, "did you mean 'standard'"):
            elastin.Simulation(elastin.body(LATTICE, SOFT), "calibrated:standrad", SOFT)


class Preparation(unittest.TestCase):
    def test_bending(self):
        """A strip under its weight sinks at its tip by w L^4 / (8 D): a beam, for Poisson's ratio 0. Two rows of
        molecules are held, and its length counts from the middle between them."""
        length, rigidity, gravity = 0.1, 1e-4, 0.01
        square = length / 20.5
        material = elastin.Material(1e6, 0, thickness=1e-3, bending_rigidity=rigidity)
        body = elastin.body({"sheet": {"size": [21 * square, 4 * square], "squares": [21, 4]}}, material)
        tissue = elastin.Simulation(body, "st_venant_kirchhoff_membrane", material)
        x = body.positions[:, 0]
        for molecule in numpy.flatnonzero(x < 1.1 * square):
            tissue.fix(molecule)
        tissue.add_load("gravity", acceleration=(0, 0, -gravity))
        self.assertTrue(tissue.settle())
        sunk = -tissue.positions[x == x.max(), 2].mean()
        expected = 1000 * 1e-3 * gravity * length**4 / (8 * rigidity)
        self.assertAlmostEqual(sunk / expected, 1, delta=0.01)

    def test_bending_of_what_cannot_bend(self):
        with self.assertRaisesRegex(elastin.InputError, "bending needs triangles"):
            elastin.Simulation(elastin.body(LATTICE, SOFT), "lattice", elastin.Material(1e4, bending_rigidity=1))

    def test_voronoi_cells(self):
        body = elastin.body({"packing": {"size": [0.02, 0.02, 0.02], "distance": 2.5e-3, "seed": 1,
                                         "connections": {"within": 4e-3}}}, SOFT)
        constants = elastin.Catalog()["voronoi"].constants(body, SOFT)
        self.assertGreater((constants > 0).mean(), 0.5)
        tissue = elastin.Simulation(body, "voronoi", SOFT)
        self.assertEqual(len(tissue.tensions), len(constants))


if __name__ == "__main__":
    unittest.main()
