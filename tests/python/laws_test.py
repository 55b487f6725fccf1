"""Cell laws of one's own: their slopes are exact, and they stand next to the built-in ones."""

import inspect
import pickle
import unittest

import numpy

import elastin

BAR = elastin.body({"tetrahedra": {"kind": "body_centred", "cubes": [3, 2, 2], "size": [15e-3, 10e-3, 10e-3]}})
CUBE27 = elastin.body({"lattice": {"kind": "cubic", "molecules": [3, 3, 3], "spacing": 5e-3, "order": 2}})
RUBBER = elastin.Material(120e3, 0.3, 1100)
PULL = elastin.Tension(axis="x", strain=0.3, grips="clamped", load_steps=3)


def neo_hookean(I1, J, mu, lam):
    return mu / 2 * (I1 - 3) - mu * numpy.log(J) + lam / 2 * (J - 1) ** 2


def forces_of(body, strategy, positions, material=RUBBER):
    """[N], (n, 3): of the body at these positions."""
    tissue = elastin.Simulation(body, strategy, material)
    for molecule, position in enumerate(positions):
        tissue.fix(molecule)
        tissue.move_to(molecule, position)
    tissue.step(1e-9)
    return numpy.array(tissue.forces)


def strained(body, amount=0.2):
    numbers = numpy.random.default_rng(1)
    gradient = numpy.eye(3) + amount * numbers.uniform(-1, 1, (3, 3))
    return body.positions @ gradient.T


class BesideBuiltIn(unittest.TestCase):
    def same(self, own, built_in, body=BAR, material=RUBBER, delta=1e-10, experiment=PULL):
        comparison = elastin.compare(body, [built_in, own], experiment=experiment, material=material, reference="none")
        self.assertEqual([result.outcome for result in comparison], ["converged"] * 2)
        for name, value in comparison[0].measures.items():
            if name in ("stress", "force", "effective_modulus", "poissons_ratio", "energy"):
                self.assertAlmostEqual(comparison[1][name] / value, 1, delta=delta, msg=name)
        self.assertLess(abs(comparison[0].positions - comparison[1].positions).max(), delta * numpy.ptp(body.positions))

    def test_neo_hookean(self):
        mine = elastin.law("mine", neo_hookean)
        for body in (BAR, CUBE27):
            positions = strained(body)
            expected = forces_of(body, "neo_hookean", positions)
            self.assertLess(abs(forces_of(body, mine, positions) - expected).max(), 1e-10 * abs(expected).max())
        self.same(mine, "neo_hookean")

    def test_written_with_third_invariant_and_moduli(self):
        """log I3 / 2 = log J, E and nu instead of mu and lam."""
        def written(I1, I3, E, nu):
            mu, lam = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))
            J = I3 ** 0.5
            return mu / 2 * (I1 - 3) - mu / 2 * numpy.log(I3) + lam / 2 * (J - 1) ** 2

        self.same(elastin.law("mine", written), "neo_hookean")

    def test_log(self):
        def written(I1, J, mu, lam):
            return mu / 2 * (I1 - 3) - mu * numpy.log(J) + lam / 2 * numpy.log(J) ** 2

        law = {"law": "neo_hookean_log"}
        self.same(elastin.law("mine", written), "neo_hookean_log",
                  material=elastin.Material(120e3, 0.3, law=law), delta=1e-9)

    def test_second_invariant_and_a_change_of_shape_alone(self):
        """Mooney and Rivlin's, with their constants as parameters; where nothing cancels in the built-in one."""
        c1, c2, bulk = 2e4, 5e3, 2e5

        def written(I1_bar, I2_bar, J, c1=c1, c2=c2, bulk=bulk):
            return c1 * (I1_bar - 3) + c2 * (I2_bar - 3) + bulk / 2 * numpy.log(J) ** 2

        material = elastin.Material(law={"law": "mooney_rivlin", "c1": c1, "c2": c2, "bulk_modulus": bulk})
        self.same(elastin.law("mine", written), "mooney_rivlin", material=material, delta=1e-8)
        for body in (BAR, CUBE27):
            positions = strained(body)
            expected = forces_of(body, "mooney_rivlin", positions, material)
            mine = forces_of(body, elastin.law("mine", written), positions, material)
            self.assertLess(abs(mine - expected).max(), 1e-10 * abs(expected).max())

    def test_yeoh_with_terms_of_numpy(self):
        c = (2e4, 1e3, 50.)

        def written(I1_bar, J, bulk=2e5):
            first = I1_bar - 3
            return sum(one * first ** power for power, one in enumerate(c, 1)) + bulk / 2 * numpy.square(numpy.log(J))

        material = elastin.Material(law={"law": "yeoh", "terms": c, "bulk_modulus": 2e5})
        self.same(elastin.law("mine", written), "yeoh", material=material, delta=1e-8)

    def test_membranes(self):
        """In plane stress, where the built-in one finds the thickness by a method of its own."""
        mine = elastin.law("mine", neo_hookean, membrane=True)
        sheet = elastin.Material(120e3, 0.3, thickness=1e-3)
        disc = elastin.body({"disc": {"radius": 1e-2, "rings": 3}}, sheet)
        for amount in (0.05, 0.4):
            positions = strained(disc, amount)
            expected = forces_of(disc, "neo_hookean_membrane", positions, sheet)
            self.assertLess(abs(forces_of(disc, mine, positions, sheet) - expected).max(), 1e-9 * abs(expected).max())
        result = elastin.run(BAR, mine, experiment=PULL, material=RUBBER)
        self.assertEqual(result.outcome, "unsuited")

    def test_fibres(self):
        """Gasser, Ogden and Holzapfel's law with both families along the direction, in a wall whose direction turns, too."""
        c, k1, k2, bulk = 2e4, 3e4, 1.5, 3e5

        def written(I1_bar, I4_bar, J, c=c, k1=k1, k2=k2, bulk=bulk):
            fibres = numpy.expm1(k2 * numpy.maximum(0, I4_bar - 1) ** 2)
            return c / 2 * (I1_bar - 3) + k1 / k2 * fibres + bulk / 4 * (J ** 2 - 1 - 2 * numpy.log(J))

        mine, direction = elastin.law("mine", written), [0.6, 0, 0.8]
        constants = {"c": c, "k1": k1, "k2": k2, "direction": direction}
        built_in = {"law": "holzapfel_gasser_ogden", "angle": 0, "across": [0, 1, 0], "bulk_modulus": bulk} | constants
        own = elastin.Material(law={"law": mine, "bulk": bulk} | constants)
        self.assertAlmostEqual(own.youngs_modulus / elastin.Material(law=built_in).youngs_modulus, 1, 10)
        for body in (BAR, CUBE27):
            positions = strained(body)
            expected = forces_of(body, "holzapfel_gasser_ogden", positions, elastin.Material(law=built_in))
            self.assertLess(abs(forces_of(body, mine, positions, own) - expected).max(), 1e-10 * abs(expected).max())
        around = {"around": {"through": [-0.05, 0, 0], "axis": "z"}}
        one, other = (elastin.run(BAR, strategy, experiment=PULL, material=material | around)
                      for strategy, material in (("holzapfel_gasser_ogden", built_in), (mine, {"law": mine, "bulk": bulk} | constants)))
        self.assertAlmostEqual(other["force"] / one["force"], 1, 9)

    def test_fibres_need_a_direction(self):
        mine = elastin.law("mine", lambda I1, I4, J, mu, k=1e4: mu / 2 * (I1 - 3) - mu * numpy.log(J) + k * (I4 - 1) ** 2
                           + mu * (J - 1) ** 2)
        result = elastin.run(BAR, mine, experiment=PULL, material=RUBBER)
        self.assertEqual(result.outcome, "unsuited")
        self.assertIn("`law: mine` and `direction`", result.cause)
        with self.assertRaisesRegex(elastin.InputError, "needs the direction of its fibres"):
            elastin.Simulation(BAR, mine, RUBBER).step(1e-6)
        with self.assertRaisesRegex(elastin.InputError, "key 'direction' is missing"):
            elastin.run(BAR, mine, experiment=PULL, material={"law": mine, "youngs_modulus": 1e4})
        with self.assertRaisesRegex(elastin.InputError, "are those of solids"):
            elastin.law("mine", lambda I4, mu: mu * (I4 - 1) ** 2, membrane=True)
        with self.assertRaisesRegex(TypeError, "its law 'mine' is one's own"):
            pickle.dumps(elastin.material({"law": mine, "youngs_modulus": 1e4, "direction": "x"}))

    def test_constants_of_a_material(self):
        """In a region they are others, and E follows from them."""
        c1, c2, bulk = 2e4, 5e3, 2e5
        mine = elastin.law("mine", lambda I1_bar, I2_bar, J, c1=1., c2=1., bulk=1.: c1 * (I1_bar - 3) + c2 * (I2_bar - 3)
                           + bulk / 2 * numpy.log(J) ** 2)
        scene = {"body": BAR, "experiment": PULL, "material": {"c1": c1, "c2": c2, "fields": {"regions": [
            {"molecules": {"box": {"from": [0, 0, 0], "to": [5e-3, 1, 1]}}, "constants": {"c1": 3 * c1}}]}}}
        one, other = (elastin.run(scene | {"material": scene["material"] | law}, law["law"]) for law in (
            {"law": "mooney_rivlin", "bulk_modulus": bulk}, {"law": mine, "bulk": bulk}))
        self.assertEqual(other.outcome, "converged")
        self.assertAlmostEqual(other["force"] / one["force"], 1, 8)

    def test_relaxing(self):
        """prony: goes with it, as with every law."""
        material = elastin.Material(120e3, 0.3, relaxation=[(0.5, 1.0)])
        mine = elastin.law("mine", neo_hookean)
        catalog = elastin.Catalog()
        catalog.add(mine)
        body = BAR
        one, other = (elastin.run(body, name, experiment=PULL, material=material, catalog=catalog)
                      for name in ("prony:mine", "prony:neo_hookean"))
        self.assertAlmostEqual(one["effective_modulus"] / other["effective_modulus"], 1, delta=1e-10)


class Slopes(unittest.TestCase):
    """Every operation: forces are the slopes of the energy, checked by differences of the energy itself."""

    ENERGIES = {
        "exp": lambda I1, J, mu: mu / 4 * (numpy.exp(2 * (I1 - 3 - 2 * numpy.log(J))) - 1) + mu * (J - 1) ** 2,
        "powers": lambda I1, J, mu: mu * ((I1 / 3) ** 1.5 - 1) - mu * numpy.log(J) + mu * (J - 1) ** 2
        + mu * (2 ** (J - 1) - 1 - numpy.log(2) * (J - 1)) + mu * (J ** J - J),
        "where": lambda I1, J, mu: mu / 2 * (I1 - 3) - mu * numpy.log(J)
        + elastin.where(J < 1, 3 * mu, mu) * (J - 1) ** 2,
        "trigonometry": lambda I1, J, mu: mu * numpy.tanh((I1 - 3 - 2 * numpy.log(J)) / 2)
        + mu * (numpy.cosh(J - 1) - numpy.cos(J - 1)) + mu * numpy.sinh(J - 1) ** 2
        + mu * (numpy.arctan(J - 1) ** 2 + numpy.sin(J - 1) ** 2),
        "roots": lambda I1, J, mu: mu * (numpy.sqrt(1 + (I1 - 3 - 2 * numpy.log(J))) - 1)
        + mu * abs(numpy.maximum(J, 1 / J) - 1) ** 2 + mu * numpy.expm1((J - 1) ** 2),
        "fibres": lambda I1, J, I4, I5, mu: mu / 2 * (I1 - 3) - mu * numpy.log(J) + mu * (J - 1) ** 2
        + mu * numpy.expm1((I4 - 1) ** 2) + mu * (I5 - 1) ** 2 / 4 + mu / 8 * (I4 - 1) * (I5 - 1)}
    DIRECTION = numpy.array([2, -1, 2]) / 3

    def test_against_differences(self):
        """Of the energy that a run reports, over a small displacement of one end."""
        cell = elastin.Body([[0, 0, 0], [1e-2, 0, 0], [0, 1e-2, 0], [0, 0, 1e-2]], tetrahedra=[[0, 1, 2, 3]])
        for name, energy in self.ENERGIES.items():
            law = elastin.law(name, energy)
            for seed, amount in ((1, 0.15), (2, 0.3)):
                numbers = numpy.random.default_rng(seed)
                gradient = numpy.eye(3) + amount * numbers.uniform(-1, 1, (3, 3))
                constants = {"law": law} | ({"direction": self.DIRECTION} if name == "fibres" else {})
                material = elastin.material(constants | {"youngs_modulus": RUBBER.youngs_modulus, "poissons_ratio": 0.3})
                forces = forces_of(cell, law, cell.positions @ gradient.T, material)
                expected = self.forces_by_differences(energy, cell, gradient)
                with self.subTest(energy=name, amount=amount):
                    self.assertLess(abs(forces - expected).max(), 3e-8 * abs(expected).max())

    def forces_by_differences(self, energy, cell, gradient):
        """-dW/dx of one tetrahedron, central differences of plain numbers through the same function."""
        mu, volume, edges = RUBBER.youngs_modulus / 2.6, 1e-6 / 6, (cell.positions[1:] - cell.positions[0]).T
        inverse, start = numpy.linalg.inv(edges), cell.positions @ gradient.T

        def stored(positions):
            F = (positions[1:] - positions[0]).T @ inverse
            C = F.T @ F
            a = self.DIRECTION
            known = {"I1": numpy.trace(C), "J": numpy.linalg.det(F), "I4": a @ C @ a, "I5": a @ C @ C @ a, "mu": mu}
            return volume * energy(*(known[name] for name in inspect.signature(energy).parameters))

        forces, step = numpy.zeros((4, 3)), 1e-6 * 1e-2 * 30
        for molecule in range(4):
            for axis in range(3):
                by = numpy.zeros((4, 3))
                by[molecule, axis] = step
                forces[molecule, axis] = -(8 * (stored(start + by) - stored(start - by))
                                           - (stored(start + 2 * by) - stored(start - 2 * by))) / (12 * step)
        return forces


class Wrong(unittest.TestCase):
    def said(self, energy, material=RUBBER):
        with self.assertRaises(elastin.InputError) as caught:
            elastin.run(BAR, elastin.law("mine", energy), experiment=PULL, material=material)
        return str(caught.exception)

    def test_words(self):
        self.assertRegex(self.said(lambda I1, J, m: I1), "argument 'm' has no default; did you mean 'mu'")
        self.assertIn("depends on no invariant", self.said(lambda I1: 5))
        self.assertIn("elastin.where", self.said(lambda J, mu: mu * J if J < 1 else mu))
        import math
        self.assertIn("numpy's functions", self.said(lambda J, mu: mu * math.log(J)))
        self.assertRegex(self.said(lambda J: numpy.hypot(J, 1)), "cannot take numpy.hypot; allowed: .*sqrt")
        self.assertIn("not of a str", self.said(lambda J: J * "a"))
        self.assertRegex(self.said(lambda I1, mu: mu / 2 * (I1 - 3)),
                         "law 'mine': the energy has a stress of .* at rest")
        self.assertIn("unstable at rest", self.said(lambda I1, J, mu: mu * numpy.log(J) - mu / 2 * (I1 - 3)))
        self.assertIn("unstable at rest", self.said(lambda J, mu: mu * (J - 1) ** 2))

    def test_parameters(self):
        """A law's own are set by scenes, within their range."""
        law = elastin.law("mine", lambda I1, J, mu, lam, factor=elastin.Parameter("factor", 1, low=0.1, high=10):
                          factor * neo_hookean(I1, J, mu, lam))
        catalog = elastin.Catalog()
        catalog.add(law)
        one, doubled = (elastin.run({"body": BAR, "material": RUBBER, "experiment": PULL,
                                     "stiffness": {"strategy": "mine", "factor": factor}}, catalog=catalog)
                        for factor in (1, 2))
        self.assertAlmostEqual(doubled["effective_modulus"] / one["effective_modulus"], 2, 8)
        with self.assertRaisesRegex(elastin.InputError, r"scene\['stiffness'\]\['factor'\]: .*at most 10"):
            elastin.run({"body": BAR, "material": RUBBER, "experiment": PULL,
                         "stiffness": {"strategy": "mine", "factor": 11}}, catalog=catalog)

    def test_stiffer_regions(self):
        """All of the energy grows with the region's factor, its own constants too."""
        scene = {"body": {"tetrahedra": {"kind": "kuhn", "cubes": [2, 1, 1], "size": [2e-2, 1e-2, 1e-2]},
                          "regions": [{"from": [0, 0, 0], "to": [1e-2, 1e-2, 1e-2], "stiffness": 5}]},
                 "material": RUBBER, "experiment": elastin.Tension(axis="x", strain=0.05)}
        mu, lam = 120e3 / 2.6, 120e3 * 0.3 / (1.3 * 0.4)
        mine = elastin.law("mine", lambda I1, J, mu=mu, lam=lam: neo_hookean(I1, J, mu, lam))
        one, other = (elastin.run(scene, strategy)["effective_modulus"] for strategy in ("neo_hookean", mine))
        self.assertAlmostEqual(one / other, 1, delta=1e-10)


if __name__ == "__main__":
    unittest.main()
