"""Bodies from arrays, from descriptions and files; materials; strategies of one's own; errors."""

import os
import pickle
import tempfile
import unittest

import numpy

import elastin
from helpers import CUBE, SOURCE, said_by_command

CORNERS = numpy.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float) * 1e-2
PAIRS = [[0, 1], [1, 2], [2, 0], [0, 3]]


class Labels(unittest.TestCase):
    def test_two_halves_in_series(self):
        """Cells of two moduli one behind the other, which do not get thinner: 1/E is the mean of theirs."""
        plain = elastin.body({"tetrahedra": {"kind": "kuhn", "cubes": [2, 2, 6], "size": [4e-3, 4e-3, 12e-3]}})
        for cells in ({"tetrahedra": plain.tetrahedra}, {"cells": {"tetrahedron4": plain.tetrahedra}}):
            upper = plain.positions[plain.tetrahedra].mean(axis=1)[:, 2] > 6e-3
            body = elastin.Body(plain.positions, stiffness=numpy.where(upper, 3.0, 1.0), **cells)
            result = elastin.run(body, "neo_hookean", material=elastin.Material(5e3, 0.0),
                                 experiment=elastin.Tension(axis="z", strain=1e-5, grips="sliding"))
            self.assertAlmostEqual(result["effective_modulus"], 5e3 * 1.5, delta=0.5)
            again = pickle.loads(pickle.dumps(body))
            self.assertEqual(elastin.run(again, "standard", material=elastin.Material(5e3), experiment=elastin.Tension(axis="z", strain=1e-5))["force"],
                             elastin.run(body, "standard", material=elastin.Material(5e3), experiment=elastin.Tension(axis="z", strain=1e-5))["force"])
        for wrong, message in ((numpy.ones(3), "stiffness: has 3 values; the body has 144 cells"), (numpy.zeros(144), "above 0")):
            with self.assertRaisesRegex(elastin.InputError, message):
                elastin.Body(plain.positions, tetrahedra=plain.tetrahedra, stiffness=wrong)


class Bodies(unittest.TestCase):
    def test_from_arrays(self):
        body = elastin.Body(CORNERS, PAIRS, masses=[1, 2, 3, 4], radii=[1e-3] * 4)
        self.assertEqual(body.positions.tobytes(), CORNERS.tobytes())
        self.assertEqual(body.connections.tolist(), PAIRS)
        self.assertEqual(body.masses.tolist(), [1, 2, 3, 4])
        self.assertEqual(body.rest_lengths.tolist(), [1e-2, numpy.hypot(1e-2, 1e-2), 1e-2, 1e-2])

    def test_a_rest_of_its_own(self):
        """A tetrahedron whose rest is larger than it lies becomes that large, from wherever it begins."""
        growth = numpy.array([numpy.diag([1.1, 1.2, 1])])
        body = elastin.Body(CORNERS, tetrahedra=[[0, 1, 2, 3]], density=1000, growth=growth)
        tissue = elastin.Simulation(body, "neo_hookean", elastin.Material(1e3, 0.3))
        for molecule, free in ((0, ""), (1, "x"), (2, "xy")):
            tissue.fix(molecule, free)
        tissue.positions = CORNERS * (1, 1, 0.9)
        self.assertEqual(tissue.positions.tolist(), (CORNERS * (1, 1, 0.9)).tolist())
        tissue.settle()
        numpy.testing.assert_allclose(tissue.positions, CORNERS * (1.1, 1.2, 1), atol=1e-9)
        with self.assertRaisesRegex(elastin.InputError, "positions: 1 molecules for 4"):
            tissue.positions = CORNERS[:1]
        for wrong, words in ((growth[0], "has shape"), (numpy.concatenate([growth, growth]), "2 matrices; allowed: 1"),
                             (-growth, "determinant"), ([["a"]], "growth")):
            with self.assertRaisesRegex(elastin.InputError, words):
                elastin.Body(CORNERS, tetrahedra=[[0, 1, 2, 3]], density=1000, growth=wrong)
        again = elastin.Simulation(pickle.loads(pickle.dumps(body)), "neo_hookean", elastin.Material(1e3, 0.3))
        for molecule, free in ((0, ""), (1, "x"), (2, "xy")):
            again.fix(molecule, free)
        again.settle()
        numpy.testing.assert_allclose(again.positions, CORNERS * (1.1, 1.2, 1), atol=1e-9)

    def test_numbered_along_a_curve(self):
        grid = numpy.stack(numpy.meshgrid(*3 * [numpy.arange(8.)], indexing="ij"), -1).reshape(-1, 3)
        points = grid[numpy.random.default_rng(3).permutation(len(grid))]
        order = elastin.order_in_space(points)
        self.assertEqual(sorted(order), list(range(len(grid))))
        steps = numpy.linalg.norm(numpy.diff(points[order], axis=0), axis=1)
        self.assertLess(steps.mean(), 2)  # at random about 5
        with self.assertRaisesRegex(elastin.InputError, "positions: has numbers that are not finite"):
            elastin.order_in_space([[0, 0, numpy.nan]])

    def test_a_body_is_numbered_in_space(self):
        body = elastin.body({"lattice": {"kind": "cubic", "molecules": [4, 4, 4], "spacing": 1e-3}})
        ordered, molecule_from, connection_from = elastin.numbered_in_space(body)
        numpy.testing.assert_array_equal(ordered.positions, body.positions[molecule_from])
        numpy.testing.assert_array_equal(numpy.sort(molecule_from[ordered.connections], axis=1),
                                         numpy.sort(body.connections[connection_from], axis=1))

    def test_a_material_as_scenes_write_it_gives_masses(self):
        shape = {"tetrahedra": {"kind": "kuhn", "cubes": [2, 2, 2], "size": [0.01, 0.01, 0.01]}}
        for material in ({"youngs_modulus": 1000, "poissons_ratio": 0.3, "density": 1200},
                         "{youngs_modulus: 1000, poissons_ratio: 0.3, density: 1200}"):
            self.assertAlmostEqual(elastin.body(shape, material).masses.sum(), 1200e-6, 12)
        with self.assertRaisesRegex(elastin.InputError, "did you mean"):
            elastin.body(shape, {"youngs_modulu": 1000})

    def test_cells_give_connections_and_masses(self):
        body = elastin.Body(CORNERS, tetrahedra=[[0, 2, 1, 3]])  # inverted: it is reordered
        self.assertEqual(len(body.connections), 6)
        self.assertEqual(sorted(body.tetrahedra[0]), [0, 1, 2, 3])
        a, b, c, d = CORNERS[body.tetrahedra[0]]
        self.assertGreater(numpy.dot(b - a, numpy.cross(c - a, d - a)), 0)
        self.assertAlmostEqual(body.masses.sum(), 1000 * 1e-6 / 6)

    def test_sides_of_cells_next_to_connections(self):
        body = elastin.Body(CORNERS, PAIRS, tetrahedra=[[0, 1, 2, 3]])
        self.assertEqual(body.proper_connections, 4)
        self.assertEqual(len(body.connections), 6)

    def test_any_array_of_numbers_will_do(self):
        body = elastin.Body((CORNERS * 100).astype(numpy.float32).tolist(), numpy.array(PAIRS, numpy.uint8))
        self.assertEqual(body.positions.tolist(), (CORNERS * 100).tolist())
        self.assertEqual(elastin.Body(numpy.asfortranarray(CORNERS), PAIRS).positions.tolist(), CORNERS.tolist())

    def test_wrong_arrays_are_named(self):
        def said(*arguments, **options):
            with self.assertRaises(elastin.InputError) as caught:
                elastin.Body(*arguments, **options)
            return str(caught.exception)

        self.assertEqual(said(CORNERS.T, PAIRS), "positions: has shape (3, 4); allowed: (n, 3)")
        self.assertEqual(said(CORNERS, [[0, 4]]), "connections[0]: there is no molecule 4; allowed: 0 to 3")
        self.assertEqual(said(CORNERS, [[0, 1], [2, 2]]), "connections[1]: names molecule 2 twice")
        self.assertEqual(said(CORNERS, [[0, 1.5]]),
                         "connections: is no array of whole numbers; allowed: whole numbers of molecules, (n, 2)")
        self.assertEqual(said(CORNERS, PAIRS, masses=[1, 1, 0, 1]),
                         "masses[2]: is 0; allowed: finite numbers above 0 kg")
        self.assertEqual(said(CORNERS, PAIRS, masses=[1]), "masses: has 1 numbers; allowed: 4, one a molecule")
        self.assertEqual(said(CORNERS, PAIRS, rest_lengths=[1]),
                         "rest_lengths: has 1 numbers; allowed: 4, one a connection")
        self.assertEqual(said([[0, 0, numpy.nan]]), "positions[0]: is not finite")
        self.assertEqual(said("ab"), "positions: cannot be read as an array of numbers")
        flat = CORNERS * (1, 1, 0)
        self.assertEqual(said(flat, tetrahedra=[[0, 1, 2, 3]]), "tetrahedra[0]: is flat")

    def test_the_materials_density_where_none_is_stated(self):
        heavy = elastin.Material(1e4, 0.25, density=1200)
        arrays = {"positions": CORNERS, "tetrahedra": [[0, 1, 2, 3]]}
        for make, volume in ((lambda **d: elastin.Body(**arrays, **d), 1e-6 / 6),
                             (lambda **d: elastin.lattice((3, 3, 3), 1e-2, **d), 8e-6)):
            for density, expected in (({}, 1200), ({"density": 900}, 900)):
                body = make(**density)
                moved = elastin.Simulation(body, "standard", heavy)
                self.assertAlmostEqual(moved.body.masses.sum() / (expected * volume), 1, 12)
                again = elastin.Simulation(moved.body, "standard", elastin.Material(1e4, 0.25, density=1))
                self.assertEqual(list(again.body.masses), list(moved.body.masses))

    def test_a_lattice_is_the_scenes(self):
        body = elastin.lattice((3, 3, 3), 7.5e-3)
        scene = elastin.Laboratory(CUBE).body
        for name in ("positions", "masses", "radii", "connections", "rest_lengths"):
            self.assertEqual(getattr(body, name).tobytes(), getattr(scene, name).tobytes(), name)

    def test_every_shape_of_the_scenes(self):
        block = elastin.body({"tetrahedra": {"kind": "kuhn", "cubes": [1, 1, 1], "size": [1, 1, 1]}},
                             elastin.Material(1e3, density=600))
        self.assertAlmostEqual(block.masses.sum(), 600)
        mesh = elastin.read_mesh(f"{SOURCE}/scenes/tension/dogbone.msh", "mm")
        self.assertEqual(len(mesh), len(elastin.Laboratory(f"{SOURCE}/scenes/tension/dogbone.yaml").body))
        with self.assertRaisesRegex(elastin.InputError, r"body\['lattice'\]\['kind'\]: .*did you mean 'cubic'"):
            elastin.body({"lattice": {"kind": "cubik", "molecules": [2, 2, 2], "spacing": 1}})
        with self.assertRaisesRegex(elastin.InputError, "thickness"):
            elastin.body({"disc": {"radius": 1, "rings": 2}})


class Materials(unittest.TestCase):
    def test_ranges(self):
        for options, said in (({"youngs_modulus": -1}, "youngs_modulus: is -1; allowed: finite numbers above 0 Pa"),
                              ({}, "give youngs_modulus"),
                              ({"youngs_modulus": 1, "poissons_ratio": 0.6}, "-0.99 to 0.5")):
            with self.assertRaisesRegex(elastin.InputError, said):
                elastin.Material(**options)

    def test_curve(self):
        material = elastin.Material(curve=[(0, 0), (0.1, 100), (0.2, 300)])
        self.assertGreater(material.youngs_modulus, 0)
        with self.assertRaisesRegex(elastin.InputError, "point 1: the stress must be greater"):
            elastin.Material(curve=[(0, 0), (0.1, -100)])

    def test_law(self):
        rubber = elastin.Material(law={"law": "ogden", "convention": "febio", "bulk_modulus": 1e9,
                                       "terms": [(6e5, 1.3), (4e4, -2)]})
        mu = (6e5 + 4e4) / 2  # half the sum of c
        self.assertAlmostEqual(rubber.youngs_modulus / (9e9 * mu / (3e9 + mu)), 1, 12)
        self.assertEqual(rubber.law, "ogden")
        self.assertEqual(elastin.Material(law={"law": "yeoh", "terms": [100, 5]}).poissons_ratio, 0.5)
        self.assertIn("ogden", [row.name for row in elastin.material_laws()])
        fibres = {"law": "transversely_isotropic", "c1": 1e3, "c4": 40, "c5": 1e5, "lambda_max": 1.06,
                  "direction": [0, 0, 2]}
        self.assertAlmostEqual(elastin.Material(law=fibres).youngs_modulus, 6e3, 6)
        for law, said in (({"law": "odgen"}, "did you mean 'ogden'"), ({"terms": []}, "needs a 'law'"),
                          ({"law": "mooney_rivlin", "c_1": 1}, "did you mean 'c1'"),
                          ({"law": "mooney_rivlin", "c1": -1}, "unstable at rest"),
                          ({"law": "neo_hookean_log"}, "needs youngs_modulus")):
            with self.assertRaisesRegex(elastin.InputError, said):
                elastin.Material(law=law)
        with self.assertRaisesRegex(elastin.InputError, "shares of the instantaneous stiffness sum to 1.2"):
            elastin.Material(1e3, relaxation=[(0.7, 1), (0.5, 2)], instantaneous=True)
        with self.assertRaisesRegex(elastin.InputError, "it follows from the constants"):
            elastin.Material(1e3, law={"law": "yeoh", "terms": [100]})


    def test_in_words(self):
        """A material as scenes have it, with the same keys: of steps, of runs, and of errors."""
        law = {"law": "ogden", "terms": [[2e3, 1.5], [-100, -2]], "bulk_modulus": 1e5}
        one, other = elastin.Material(law=law), elastin.material(law)
        self.assertEqual((one.youngs_modulus, one.poissons_ratio), (other.youngs_modulus, other.poissons_ratio))
        self.assertEqual(elastin.material("{law: yeoh, terms: [1 kPa], bulk_modulus: 1 MPa}").law, "yeoh")
        body = elastin.Body([[0, 0, 0], [1e-2, 0, 0], [0, 1e-2, 0], [0, 0, 1e-2]], tetrahedra=[[0, 1, 2, 3]])
        sunk = []
        for strategy, material in (("ogden", one), ("ogden", law),
                                   ("prony:mullins:ogden", law | {"relaxation": {"terms": [[0.5, 1.0]]},
                                                                  "softening": {"r": 2, "m": 9}})):
            tissue = elastin.Simulation(body, strategy, material)
            tissue.add_load("gravity", acceleration=[0, 0, -9.81])
            for molecule in range(3):
                tissue.fix(molecule)
            tissue.step(1e-3, 20)
            sunk.append(tissue.positions[3, 2])
        self.assertEqual(sunk[0], sunk[1])
        self.assertGreater(sunk[2], sunk[0])  # the given moduli are those after a long time
        for wrong, said in ((law | {"terns": []}, r"material\['terns'\].*unknown key"),
                            ({"law": "odgen"}, "did you mean 'ogden'"), ({}, "key 'youngs_modulus' is missing")):
            with self.assertRaisesRegex(elastin.InputError, said):
                elastin.material(wrong)

    def test_fields(self):
        """E that grows along a bar of one row of cells: springs in series, in any part of which the force is the same."""
        graded = {"youngs_modulus": 1e4, "poissons_ratio": 0.0, "fields": {"stiffness": {"expression": "1 + z / 0.01"}}}
        bar = elastin.body({"tetrahedra": {"kind": "kuhn", "cubes": [1, 1, 8], "size": [0.01, 0.01, 0.04]}})
        pulled = elastin.run(bar, "neo_hookean", material=graded, experiment=elastin.Tension(axis="z", force=1e-4),
                             reference="none", solver={"displacements": "small"})
        layers = sum(0.005 / (1e4 * 1e-4 * (1 + (layer + 0.5) / 2)) for layer in range(8))
        self.assertAlmostEqual(pulled.measures["elongation"] / (1e-4 * layers), 1, delta=0.01)


class OwnStrategies(unittest.TestCase):
    def setUp(self):
        lattice = elastin.Catalog()["lattice"]
        self.asked = []

        def constants(body, material, factor):
            self.asked.append((len(body), material.youngs_modulus, factor))
            return factor * lattice.constants(body, material)

        self.own = elastin.Strategy("own", constants, summary="the lattice's, times a factor",
                                    parameters=[elastin.Parameter("factor", 1, low=0.1, high=10)])

    def test_it_is_a_row_of_the_comparison(self):
        result = elastin.compare(CUBE, ["lattice", self.own])
        self.assertEqual(result["own"].measures, result["lattice"].measures)
        self.assertEqual(self.asked, [(27, 5e3, 1)])

    def test_it_can_be_calibrated_and_takes_parameters(self):
        catalog = elastin.Catalog()
        catalog.add(self.own)
        result = elastin.run(CUBE, "calibrated:own", catalog=catalog)
        self.assertAlmostEqual(result["effective_modulus"] / 5e3, 1, delta=1e-4)
        doubled = elastin.run(CUBE, set={"stiffness": {"strategy": "own", "factor": 2}}, catalog=catalog)
        self.assertAlmostEqual(doubled["effective_modulus"] / 1e4, 1, delta=1e-3)
        with self.assertRaisesRegex(elastin.InputError, "stiffness.factor: '11' is out of range: must be at least 0.1"):
            elastin.run(CUBE, set={"stiffness": {"strategy": "own", "factor": 11}}, catalog=catalog)
        with self.assertRaisesRegex(elastin.InputError, "a strategy 'own' already"):
            catalog.add(self.own)

    def test_what_it_raises_comes_out(self):
        def broken(body, material):
            raise ZeroDivisionError("on purpose")

        with self.assertRaisesRegex(ZeroDivisionError, "on purpose"):
            elastin.run(CUBE, elastin.Strategy("broken", broken))
        with self.assertRaisesRegex(elastin.InputError, "gives 2 constants; allowed: 126, one a connection"):
            elastin.run(CUBE, elastin.Strategy("short", lambda body, material: [1, 2]))
        unsuited = elastin.Strategy("none", broken, unsuited=lambda body: "never")
        self.assertEqual(elastin.run(CUBE, unsuited).cause, "never")

    def test_the_catalog(self):
        catalog = elastin.Catalog()
        self.assertEqual([strategy.name for strategy in elastin.strategies()], catalog.names)
        uniform = catalog["uniform"]
        self.assertEqual(uniform.kind, "spring rule")
        self.assertTrue(uniform.parameters and all(p.low <= p.default <= p.high for p in uniform.parameters))
        with self.assertRaisesRegex(elastin.InputError, "did you mean 'lattice'"):
            catalog["latice"]


class Errors(unittest.TestCase):
    """The same words as the command's."""

    def test_wrong_scenes(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = os.path.join(folder, "scene.yaml")
            with open(CUBE, encoding="utf8") as stream:
                text = stream.read()
            for wrong in (text.replace("poissons_ratio", "poison_ratio"), text.replace("5 kPa", "5 kg"),
                          text.replace("kind: tension", "kind: tensoin"), text + "\n: :", "body: {}"):
                with open(scene, "w", encoding="utf8") as stream:
                    stream.write(wrong)
                self.same(scene)

    def test_wrong_use(self):
        self.same(CUBE + "x")
        for change in ("stiffness=latice", "material.youngs_modulus=-5", "material.youngs=5", "nonsense"):
            self.same(CUBE, change)

    def same(self, scene, *changes):
        options = [word for change in changes for word in ("--set", change)]
        with self.subTest(scene=scene, changes=changes):
            with self.assertRaises(elastin.InputError) as caught:
                elastin.run(scene, set=list(changes))
            self.assertEqual(str(caught.exception), said_by_command("run", scene, *options))
            self.assertIsInstance(caught.exception, ValueError)

    def test_a_measure_that_was_not_taken(self):
        result = elastin.run(CUBE)
        with self.assertRaisesRegex(KeyError, "did you mean 'effective_modulus'"):
            result["efective_modulus"]
        self.assertIsNone(result.get("frequency"))


if __name__ == "__main__":
    unittest.main()
