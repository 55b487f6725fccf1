"""Results for other programs: pickle, pandas, VTU, meshio."""

import importlib.util
import os
import pickle
import tempfile
import unittest
import unittest.mock
import sys

import numpy

import elastin
from helpers import CUBE, SOURCE, runs_of_command

BAR = elastin.body({"tetrahedra": {"kind": "body_centred", "cubes": [4, 2, 2], "size": [20e-3, 10e-3, 10e-3]}})
RUBBER = elastin.Material(120e3, 0.3, 1100)
PULL = elastin.Tension(axis="x", strain=0.1, load_steps=2)


def there(*names):
    return all(importlib.util.find_spec(name) for name in names)


def again(thing):
    return pickle.loads(pickle.dumps(thing))


class Pickled(unittest.TestCase):
    def same_body(self, one, other):
        for name in ("positions", "masses", "radii", "connections", "rest_lengths", "triangles", "tetrahedra"):
            self.assertEqual(getattr(one, name).tobytes(), getattr(other, name).tobytes(), name)
        self.assertEqual(one.proper_connections, other.proper_connections)
        self.assertEqual({name: cells.tolist() for name, cells in one.cells.items()},
                         {name: cells.tolist() for name, cells in other.cells.items()})

    def test_bodies(self):
        second = elastin.body({"tetrahedra": {"kind": "kuhn", "cubes": [1, 1, 1], "size": [1, 1, 1], "order": 2}})
        for body in (BAR, second, elastin.lattice((3, 4, 5), 1e-3), elastin.Laboratory(
                f"{SOURCE}/scenes/tissue/knee.yaml").body):
            self.same_body(body, again(body))

    def test_materials(self):
        """Whatever they are of: the same measures of the same test."""
        materials = {
            "neo_hookean": RUBBER,
            "curve": elastin.Material(curve=[(0, 0), (0.1, 1e4), (0.2, 3e4)], poissons_ratio=0.3),
            "yeoh": elastin.Material(law={"law": "yeoh", "terms": [2e4, 1e3], "bulk_modulus": 1e6}),
            "prony:neo_hookean": elastin.Material(1e5, relaxation=[(0.4, 1.0)], instantaneous=True)}
        for strategy, material in materials.items():
            with self.subTest(strategy=strategy):
                one = elastin.run(BAR, strategy, experiment=PULL, material=material)
                other = elastin.run(BAR, strategy, experiment=PULL, material=again(material))
                self.assertEqual(one.outcome, "converged")
                self.assertEqual(one.measures, other.measures)

    def test_results(self):
        result = elastin.run(BAR, "neo_hookean", experiment=PULL, material=RUBBER, keep_states=True)
        copy = again(result)
        self.assertEqual(copy.measures, result.measures)
        self.assertEqual(copy.errors, result.errors)
        self.assertEqual((copy.scene, copy.strategy, copy.outcome, copy.warnings, copy.good),
                         (result.scene, result.strategy, result.outcome, result.warnings, result.good))
        self.assertEqual(copy.positions.tobytes(), result.positions.tobytes())
        self.assertEqual(copy.tensions.tobytes(), result.tensions.tobytes())
        self.assertEqual({name: column.tolist() for name, column in copy.curve.items()},
                         {name: column.tolist() for name, column in result.curve.items()})
        self.assertEqual([(at, where.tolist()) for at, where in copy.states],
                         [(at, where.tolist()) for at, where in result.states])
        self.same_body(copy.body, result.body)
        comparison = elastin.compare(CUBE, ["lattice", "standard"])
        self.assertEqual(repr(again(comparison)), repr(comparison))

    def steps_on_alike(self, simulation):
        copy = again(simulation)
        self.assertEqual(copy.time, simulation.time)
        for one in (simulation, copy):
            one.step(1e-4, 20)
        self.assertEqual(copy.positions.tobytes(), simulation.positions.tobytes())
        self.assertEqual(copy.velocities.tobytes(), simulation.velocities.tobytes())

    def test_simulations_go_on_with_the_same_bits(self):
        """With loads, supports, couplings, own forces, own laws; of a body and of a scene."""
        mine = elastin.law("mine", lambda I1, J, mu, lam: mu / 2 * (I1 - 3) - mu * numpy.log(J) + lam / 2 * (J - 1)**2)
        for strategy in ("lattice", mine, "calibrated:standard"):
            body = elastin.lattice((3, 3, 4), 1e-3) if strategy == "lattice" else BAR
            tissue = elastin.Simulation(body, strategy, RUBBER, stepper="backward_euler")
            tissue.add_load("gravity", acceleration=(0, 0, -9.81))
            tissue.fix(0)
            tissue.couple(5, body.positions[5] + (1e-4, 0, 0), 1.0)
            tissue.host_forces[7] = 0, 1e-5, 0
            tissue.step(1e-4, 10)
            self.steps_on_alike(tissue)
        laboratory = elastin.Laboratory({"body": BAR, "material": RUBBER, "stiffness": "neo_hookean",
                                         "experiment": elastin.Tension(axis="x", force=1e-2),
                                         "loads": [{"gravity": {"acceleration": [0, 0, -9.81]}}]})
        tissue = laboratory.simulation()
        tissue.step(1e-4, 5)
        self.steps_on_alike(tissue)

    def test_states_strategies_and_catalogs(self):
        tissue = elastin.Simulation(BAR, "neo_hookean", RUBBER)
        tissue.step(1e-5, 3)
        self.assertEqual(again(tissue.save()).positions.tobytes(), tissue.positions.tobytes())
        self.assertEqual(again(elastin.Catalog()["lattice+volume"]).name, "lattice+volume")
        catalog = elastin.Catalog()
        catalog.add(elastin.law("mine", lambda I1, J, mu: mu / 2 * (I1 - 3 - 2 * numpy.log(J)) + mu * (J - 1)**2))
        self.assertEqual(again(catalog).names, catalog.names)

    def test_what_cannot_be_read_back(self):
        data = pickle.dumps(BAR)
        with self.assertRaises(Exception):
            pickle.loads(data[:-40] + data[-20:])

    def test_a_flipped_bit_is_refused(self):
        body = pickle.dumps(BAR)
        simulation = pickle.dumps(elastin.Simulation(BAR, "neo_hookean", RUBBER))
        numbers = BAR.__reduce_ex__(2)[2]  # the bytes that are the body, without what pickle puts around them
        for data in (body, simulation):
            begin = data.index(numbers[:64]) if isinstance(numbers, bytes) else data.index(numbers[0][:64])
            for at in range(begin, begin + 3000, 29):
                damaged = data[:at] + bytes([data[at] ^ 16]) + data[at + 1:]
                with self.assertRaisesRegex(elastin.InputError, "Body is damaged: its checksum does not hold"):
                    pickle.loads(damaged)


class Steps(unittest.TestCase):
    def test_a_refused_step_raises(self):
        simulation = elastin.Simulation(elastin.lattice((3, 3, 3), 1e-3), "lattice", elastin.Material(5e3),
                                        max_substeps=2)
        before = simulation.positions.copy()
        with self.assertRaisesRegex(elastin.StepError, "limit_reached: ") as caught:
            simulation.step(10)
        self.assertEqual(caught.exception.result.outcome, "limit_reached")
        self.assertEqual(again(caught.exception).result.cause, caught.exception.result.cause)
        self.assertTrue((simulation.positions == before).all())
        self.assertFalse(simulation.step(10, check=False))

    def test_an_equilibrium_that_is_not_found_raises(self):
        simulation = elastin.Simulation(elastin.lattice((3, 3, 3), 1e-3, ["axis"]), "standard", elastin.Material(5e3))
        simulation.add_load("gravity", acceleration=(1, 0, -9.81))  # nothing holds it
        with self.assertRaises(elastin.StepError):
            simulation.settle()
        self.assertFalse(simulation.settle(check=False))


class Frames(unittest.TestCase):
    @unittest.skipUnless(there("pandas"), "pandas is missing")
    def test_columns(self):
        result = elastin.run(BAR, "neo_hookean", experiment=PULL, material=RUBBER)
        frame = result.to_frame()
        self.assertEqual(list(frame["stress"]), list(result.curve["stress"]))
        self.assertEqual(len(frame), 2)
        comparison = elastin.compare(CUBE, ["lattice", "neo_hookean"])
        frame = comparison.to_frame()
        self.assertEqual(list(frame["strategy"]), ["lattice", "neo_hookean"])
        self.assertEqual(frame["effective_modulus"][0], comparison[0]["effective_modulus"])
        self.assertEqual(frame["outcome"][1], "unsuited")
        verdicts = elastin.verify(CUBE).to_frame()
        self.assertIn("verdict", verdicts)

    def test_without_the_package(self):
        result = elastin.run(CUBE)
        for name, call in (("pandas", result.to_frame), ("meshio", result.to_meshio), ("pyvista", result.to_pyvista)):
            with unittest.mock.patch.dict(sys.modules, {name: None}):
                with self.assertRaisesRegex(ImportError, f"needs {name}: .*pip install {name}"):
                    call()


class States(unittest.TestCase):
    def test_of_each_load_step(self):
        result = elastin.run(BAR, "neo_hookean", experiment=PULL, material=RUBBER, keep_states=True)
        self.assertEqual([at for at, _ in result.states], [0, 0.5, 1])
        self.assertEqual(result.states[0][1].tobytes(), BAR.positions.tobytes())
        self.assertEqual(result.states[-1][1].tobytes(), result.positions.tobytes())
        self.assertEqual(elastin.run(CUBE).states, [])


class Files(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = os.path.join(folder.name, "state.vtu")
        self.result = elastin.run(BAR, "neo_hookean", experiment=PULL, material=RUBBER, keep_states=True)

    def test_elastin_reads_its_own(self):
        BAR.to_vtu(self.path)
        back = elastin.read_mesh(self.path, "m")
        self.assertEqual(back.positions.tobytes(), BAR.positions.tobytes())
        self.assertEqual(back.tetrahedra.tolist(), BAR.tetrahedra.tolist())

    @unittest.skipUnless(there("meshio"), "meshio is missing")
    def test_vtu_says_what_the_result_says(self):
        import meshio
        self.result.to_vtu(self.path)
        mesh = meshio.read(self.path)
        self.assertEqual(mesh.points.tolist(), self.result.positions.tolist())
        self.assertEqual(mesh.point_data["displacement"].tolist(),
                         (self.result.positions - BAR.positions).tolist())
        self.assertEqual(mesh.cells_dict["tetra"].tolist(), BAR.tetrahedra.tolist())
        tensions = mesh.cell_data_dict["tension"]["line"]
        self.assertEqual(tensions.tolist(), self.result.tensions.tolist())
        base = os.path.splitext(self.path)[0]
        with open(base + ".pvd", encoding="utf8") as stream:
            self.assertEqual(stream.read().count("<DataSet"), 3)
        self.assertEqual(meshio.read(base + "-002.vtu").points.tolist(), self.result.positions.tolist())

    @unittest.skipUnless(there("meshio"), "meshio is missing")
    def test_meshio_both_ways(self):
        """Bodies of tetrahedra, hexahedra of both orders, triangles; the stiffness in the same test is the same."""
        for shape in ({"tetrahedra": {"kind": "kuhn", "cubes": [2, 1, 1], "size": [2, 1, 1], "order": 2}},
                      {"lattice": {"kind": "cubic", "molecules": [3, 3, 3], "spacing": 1, "order": 1}},
                      {"lattice": {"kind": "cubic", "molecules": [3, 3, 3], "spacing": 1, "order": 2}},
                      {"tetrahedra": {"kind": "kuhn", "cubes": [2, 1, 1], "size": [2, 1, 1]}}):
            body = elastin.body(shape)
            back = elastin.Body.from_meshio(body.to_meshio())
            self.assertEqual({name: len(cells) for name, cells in back.cells.items()},
                             {name: len(cells) for name, cells in body.cells.items()})
            self.assertAlmostEqual(back.masses.sum() / body.masses.sum(), 1, 12)
            one, other = (elastin.run(each, "neo_hookean", experiment=elastin.Tension(strain=0.01), material=RUBBER)
                          for each in (body, back))
            self.assertAlmostEqual(one["effective_modulus"] / other["effective_modulus"], 1, 9)
        disc = elastin.body({"disc": {"radius": 1, "rings": 3}}, elastin.Material(1, thickness=1e-2))
        back = elastin.Body.from_meshio(disc.to_meshio(), "mm", thickness=1e-2)
        self.assertAlmostEqual(numpy.ptp(back.positions) / numpy.ptp(disc.positions), 1e-3, 12)

    @unittest.skipUnless(there("meshio"), "meshio is missing")
    def test_what_meshio_has_and_elastin_not(self):
        import meshio
        points = numpy.eye(5, 3)
        with self.assertRaisesRegex(elastin.InputError, "meshio's type 'pyramid'.*allowed: .*hexahedron20"):
            elastin.Body.from_meshio(meshio.Mesh(points, [("pyramid", [[0, 1, 2, 3, 4]])]))
        with self.assertRaisesRegex(elastin.InputError, "neither cells nor lines"):
            elastin.Body.from_meshio(meshio.Mesh(points, [("vertex", [[0]])]))
        with self.assertRaisesRegex(elastin.InputError, "length_unit: 'inch'"):
            elastin.Body.from_meshio(meshio.Mesh(points, [("line", [[0, 1]])]), "inch")
        chain = elastin.Body.from_meshio(meshio.Mesh(points, [("line", [[0, 1], [1, 2]])]))
        self.assertEqual((len(chain), chain.connections.tolist()), (3, [[0, 1], [1, 2]]))

    def test_the_commands_files_hold_the_same_state(self):
        """What `elastin run --out` writes of the scene, this one writes too: tensions on the same connections."""
        run = runs_of_command("run", CUBE)[0]
        self.assertEqual(elastin.run(CUBE).measures, run["measures"])


class Pictures(unittest.TestCase):
    def test_html_has_a_table_and_a_small_picture(self):
        import xml.etree.ElementTree as tree
        result = elastin.run(BAR, "neo_hookean", experiment=PULL, material=RUBBER)
        tissue = elastin.Simulation(elastin.lattice((4, 4, 4), 1e-3), "lattice", elastin.Material(5e3))
        for thing, shapes in ((BAR, "polygon"), (result, "polygon"), (tissue, "line"),
                              (elastin.Laboratory(CUBE), "line")):
            html = thing._repr_html_()
            root = tree.fromstring(html)
            self.assertGreater(len(root.findall(".//{http://www.w3.org/2000/svg}" + shapes)), 20)
            self.assertTrue(root.findall(".//table"))
            self.assertLess(len(html), 400_000)
        self.assertEqual(elastin.run(CUBE, "neo_hookean")._repr_html_().count("<svg"), 0)


if __name__ == "__main__":
    unittest.main()
