"""Derivatives in Python: measures by numbers of a scene, equilibria by forces, supports and stiffness."""
import importlib.util
import os
import sys
import unittest

import numpy

import elastin

ROOT = os.environ.get("ELASTIN_SOURCE_DIR", os.path.join(os.path.dirname(__file__), "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "tests", "examples"))
import derivatives  # noqa: E402

SCENE = {"body": {"lattice": {"kind": "cubic", "molecules": [3, 3, 4], "spacing": "10 mm", "connections": ["axis", "face"]}},
         "material": {"youngs_modulus": "9 kPa", "poissons_ratio": 0.25}, "stiffness": "lattice",
         "experiment": {"kind": "tension", "axis": "z", "force": "0.4 N"}, "solver": {"tolerance": 1e-13}}
OF, BY, AT = ["elongation", "energy"], ["material.youngs_modulus", "experiment.force"], [9000., 0.4]


def differences():
    def at(numbers):
        result = elastin.run(SCENE, set=dict(zip(BY, numbers)))
        return numpy.array([result[name] for name in OF])

    columns = []
    for i, value in enumerate(AT):
        step = numpy.zeros(2)
        step[i] = 1e-3 * value
        plus, minus, plus2, minus2 = (at(AT + times * step) for times in (1, -1, 2, -2))
        columns.append((8 * (plus - minus) - (plus2 - minus2)) / (12 * step[i]))
    return numpy.transpose(columns)


class Derivatives(unittest.TestCase):
    def test_gradient_is_that_of_whole_runs(self):
        found = elastin.gradient(SCENE, of=OF, by=BY)
        numpy.testing.assert_allclose(found, differences(), rtol=1e-8)
        with self.assertRaisesRegex(elastin.InputError, "did you mean"):
            elastin.gradient(SCENE, of=OF, by=["material.young_modulus"])
        with self.assertRaises(KeyError):
            elastin.gradient(SCENE, of=["elongatio"], by=BY)

    def test_deviations(self):
        result = elastin.run({**SCENE, "uncertainty": {"material.youngs_modulus": "2 %", "experiment.force": "4 mN"}})
        spread = result.spreads["elongation"]
        by_hand = differences()[0] * [180, 4e-3]
        self.assertAlmostEqual(spread["deviation"] / numpy.linalg.norm(by_hand), 1, 7)
        self.assertAlmostEqual(spread["experiment.force"], by_hand[1]**2 / sum(by_hand**2), 7)

    @unittest.skipUnless(importlib.util.find_spec("scipy"), "scipy is missing")
    def test_scipy_finds_the_best_angle_of_fibres(self):
        import fibre_angle
        best, step = fibre_angle.best_angle(), 0.02
        below, least, above = (fibre_angle.energy_and_slope(best + side * step)[0] for side in (-1, 0, 1))
        self.assertLess(least, min(below, above))
        parabola = best + step * (below - above) / (2 * (below - 2 * least + above))
        self.assertAlmostEqual(best, parabola, 3)

    def test_equilibria_forward_and_adjoint(self):
        body = elastin.lattice((3, 3, 4), 0.01, density=1000)
        simulation = elastin.Simulation(body, "lattice", elastin.Material(9000, 0.25))
        low = [i for i in range(len(body.positions)) if body.positions[i][2] < 1e-6]
        for molecule in low:
            simulation.fix(molecule)
        simulation.add_load("gravity", acceleration=(1, 0, -9.81))
        with self.assertRaisesRegex(elastin.InputError, "settle"):
            simulation.vjp(numpy.ones((len(body.positions), 3)))
        simulation.settle()
        random = numpy.random.default_rng(3)
        shape = (len(body.positions), 3)
        forces, moved, weights, of_reactions = (random.normal(size=shape) for _ in range(4))
        fixed = numpy.isin(numpy.arange(shape[0]), low)[:, None]
        motion, reactions = simulation.jvp(forces=forces, displacement=moved * fixed)
        found = simulation.vjp(weights, of_reactions)
        forward = numpy.sum(weights * motion) + numpy.sum(of_reactions * reactions * fixed)
        adjoint = numpy.sum(found["forces"] * forces) + numpy.sum(found["displacement"] * moved)
        self.assertLess(abs(forward - adjoint), 1e-12 * numpy.linalg.norm(weights) * numpy.linalg.norm(motion)
                        + 1e-12 * numpy.linalg.norm(of_reactions) * numpy.linalg.norm(reactions))
        self.assertEqual(len(found["stiffness"][0]), len(body.connections))

    def test_a_run_in_time_backward(self):
        body = elastin.lattice((3, 3, 4), 0.01, density=1000)
        simulation = elastin.Simulation(body, "lattice", elastin.Material(9000, 0.25))
        for molecule in numpy.flatnonzero(body.positions[:, 2] < 1e-6):
            simulation.fix(molecule)
        random = numpy.random.default_rng(4)
        shape = (len(body.positions), 3)
        start, weights, direction = (random.normal(size=shape) for _ in range(3))
        start[body.positions[:, 2] < 1e-6] = direction[body.positions[:, 2] < 1e-6] = 0

        def end(size):
            simulation.velocities = 0.01 * start + size * direction
            return simulation.trajectory(1e-4, 400, "velocity_verlet")
        h = 1e-5
        difference = numpy.sum(weights * (end(h).positions - end(-h).positions)) / (2 * h)
        found = end(0).vjp(weights)
        self.assertAlmostEqual(numpy.sum(found["velocities"] * direction) / difference, 1, 6)
        self.assertEqual(len(found["stiffness"][0]), len(body.connections))
        run = end(0)
        for _ in range(400):
            simulation.step(1e-4)
        self.assertLess(numpy.abs(simulation.positions - run.positions).max(), 1e-5)
        with self.assertRaisesRegex(elastin.InputError, "has no transpose"):
            simulation.trajectory(1e-4, 4, "xpbd")

    @unittest.skipUnless(importlib.util.find_spec("torch"), "PyTorch is not installed")
    def test_pytorch(self):
        import torch
        numbers = torch.tensor(AT, dtype=torch.float64, requires_grad=True)
        derivatives.torch_measures(SCENE, OF, BY)(numbers)[0].backward()
        numpy.testing.assert_allclose(numbers.grad, differences()[0], rtol=1e-7)

    @unittest.skipUnless(importlib.util.find_spec("jax"), "JAX is not installed")
    def test_jax(self):
        import jax
        jax.config.update("jax_enable_x64", True)
        found = jax.jacrev(derivatives.jax_measures(SCENE, OF, BY))(jax.numpy.array(AT))
        numpy.testing.assert_allclose(found, differences(), rtol=1e-7)


if __name__ == "__main__":
    unittest.main()
