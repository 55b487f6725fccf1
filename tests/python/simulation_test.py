"""A simulation of a body, without a scene, gives what the command gives: strategies by their whole name, preparation."""

import pickle
import tempfile
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
    tissue.fix([*low, *high], "xy")
    tissue.move_to(high, body.positions[high] + (0, 0, elongation))
    assert tissue.settle()
    force = tissue.reaction(high)[:, 2].sum()
    stress = force / (numpy.ptp(x) * numpy.ptp(body.positions[:, 1]))
    middle = abs(z - z.mean()) < 1e-9
    narrowing = -numpy.polyfit(x[middle], (tissue.positions - body.positions)[middle, 0], 1)[0]
    return stress / 1e-5, narrowing / 1e-5


CUBE_CORNERS = numpy.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]) * 1e-2
BODIES = {
    "tetrahedron4": elastin.Body(CUBE_CORNERS[[0, 1, 3, 4]], tetrahedra=[[0, 1, 2, 3]]),
    "hexahedron8": elastin.Body(CUBE_CORNERS, cells={"hexahedron8": [range(8)]}),
}


class Vibrations(unittest.TestCase):
    def test_a_mass_on_a_spring(self):
        mass, k = 2e-3, 50.0
        body = elastin.Body([[0, 0, 0], [0.01, 0, 0]], [[0, 1]], masses=[mass, mass])
        simulation = elastin.Simulation(body, "uniform", elastin.Material(1e3), parameters={"constant": k})
        simulation.fix(0)
        simulation.fix(1, free="x")
        frequencies, shapes = simulation.vibrations(1)
        numpy.testing.assert_allclose(frequencies, [numpy.sqrt(k / mass) / (2 * numpy.pi)], rtol=1e-6)
        numpy.testing.assert_allclose(abs(shapes[0, 1]), (1 / numpy.sqrt(mass), 0, 0), atol=1e-6)
        with self.assertRaisesRegex(elastin.InputError, "count: is 0"):
            simulation.vibrations(0)

    def test_settling_says_where_nothing_stays(self):
        body = elastin.lattice((3, 3, 3), 1e-3)
        for constant in (50.0, -50.0):
            simulation = elastin.Simulation(body, "uniform", elastin.Material(1e3), parameters={"constant": constant})
            self.assertEqual(simulation.settle().unstable, constant < 0)

    def test_an_unstable_equilibrium_has_frequencies_that_are_not_numbers(self):
        """Pushed together by a strain e, two springs in line let the molecule between them go sideways: k = -2 k e."""
        mass, k, e = 2e-3, 50.0, 0.1
        body = elastin.Body([[-0.01, 0, 0], [0, 0, 0], [0.01, 0, 0]], [[0, 1], [1, 2]], masses=[mass] * 3)
        simulation = elastin.Simulation(body, "uniform", elastin.Material(1e3), parameters={"constant": k})
        simulation.positions = body.positions * (1 - e)
        simulation.fix([0, 2])
        frequencies, shapes = simulation.vibrations(3)
        numpy.testing.assert_array_equal(numpy.isnan(frequencies), [True, True, False])
        self.assertAlmostEqual(frequencies[2], numpy.sqrt(2 * k / mass) / (2 * numpy.pi), delta=1e-4 * frequencies[2])
        numpy.testing.assert_allclose(abs(shapes[:2, 1, 0]), 0, atol=1e-9)


class States(unittest.TestCase):
    def test_cells_under_a_homogeneous_deformation_have_the_laws_stress(self):
        F = numpy.eye(3) + numpy.random.default_rng(3).uniform(-0.2, 0.2, (3, 3))
        E = (F.T @ F - numpy.eye(3)) / 2
        lame, shear = 1e4 * 0.3 / (1.3 * 0.4), 1e4 / 2.6
        stress = F @ (lame * numpy.trace(E) * numpy.eye(3) + 2 * shear * E) @ F.T / numpy.linalg.det(F)
        for shape, body in BODIES.items():
            tissue = elastin.Simulation(body, "st_venant_kirchhoff", elastin.Material(1e4, 0.3))
            tissue.positions = body.positions @ F.T
            state = tissue.cell_states()
            self.assertEqual(list(state), [shape])
            numpy.testing.assert_allclose(state[shape]["strain"][0], E, atol=1e-12)
            numpy.testing.assert_allclose(state[shape]["stress"][0], stress, rtol=1e-9, atol=1e-6)

    def test_springs_without_cells_have_no_states_of_cells(self):
        self.assertEqual(elastin.Simulation(elastin.body(LATTICE, SOFT), "lattice", SOFT).cell_states(), {})

    def test_stiffness_is_the_forces_derivative(self):
        for body in BODIES.values():
            tissue = elastin.Simulation(body, "neo_hookean", SOFT)
            random, step = numpy.random.default_rng(4), 1e-8
            at = body.positions + random.uniform(-5e-4, 5e-4, body.positions.shape)
            by = random.uniform(-1, 1, at.shape)
            tissue.positions = at
            data, columns, starts = tissue.stiffness()
            K = numpy.zeros((len(body), 3, len(body), 3))
            for row in range(len(body)):
                for i in range(starts[row], starts[row + 1]):
                    K[row, :, columns[i], :] = data[i]
            forces = []
            for sign in (1, -1):
                tissue.positions = at + sign * step * by
                forces.append(numpy.array(tissue.forces))
            differences = (forces[1] - forces[0]) / (2 * step)
            numpy.testing.assert_allclose(numpy.tensordot(K, by, 2), differences, rtol=1e-6, atol=1e-6 * abs(differences).max())

    def test_matrices_have_the_natural_frequencies(self):
        """Of scipy's kind of matrices, by numpy's eigenvalues: those of a free body, but its six rigid motions."""
        tissue = elastin.Simulation(next(iter(BODIES.values())), "neo_hookean", SOFT)

        def dense(data, indices, indptr):
            matrix = numpy.zeros(2 * [len(indptr) - 1])
            numpy.add.at(matrix, (numpy.repeat(numpy.arange(len(matrix)), numpy.diff(indptr)), indices), data)
            return matrix

        K, M = dense(*tissue.tangent()), dense(*tissue.mass_matrix())
        root = numpy.sqrt(numpy.diag(M))
        squares = numpy.linalg.eigvalsh(K / root / root[:, None])[6:10]
        numpy.testing.assert_allclose(tissue.vibrations(4)[0], numpy.sqrt(squares) / (2 * numpy.pi), rtol=1e-5)

    def test_placed_molecules_go_on_from_there(self):
        body = elastin.Body([[0, 0, 0], [0, 0, 1]], [[0, 1]], masses=[1, 1])
        tissue = elastin.Simulation(body, "uniform", SOFT, parameters={"constant": 0})
        tissue.step(0.5)
        tissue.velocities = [[1, 0, 0], [0, 2, 0]]
        tissue.step(0.25)
        numpy.testing.assert_allclose(tissue.positions, [[0.25, 0, 0], [0, 0.5, 1]], atol=1e-12)
        for wrong, said in (([[0, 0, 0]], "1 molecules for 2"), ([[0, 0, numpy.nan], [0, 0, 1]], "not finite")):
            with self.assertRaisesRegex(elastin.InputError, said):
                tissue.positions = wrong
        with self.assertRaisesRegex(elastin.InputError, "no molecule 2: the body has molecules 0 to 1"):
            tissue.fix([0, 2])
        self.assertEqual(tissue.reaction([0, 1]).tolist(), [[0, 0, 0], [0, 0, 0]])
        with self.assertRaisesRegex(elastin.InputError, "1 rows for 2 molecules"):
            tissue.move_to([0, 1], [[0, 0, 0]])

    def test_a_mask_stands_for_the_molecules_where_it_is_true(self):
        def sag(choose, **load):
            tissue = elastin.Simulation(elastin.lattice((3, 3, 4), 1e-3), "lattice", elastin.Material(5e3, 0.25))
            bottom, top = (tissue.body.positions[:, 2] == height for height in (0, tissue.body.positions[:, 2].max()))
            tissue.fix(choose(bottom))
            tissue.add_load("point", force=(0, 0, -1e-6), molecules=choose(top))
            tissue.settle()
            return tissue, choose(bottom), choose(top)

        numbers, bottom, _ = sag(numpy.flatnonzero)
        for choose in (lambda mask: mask, lambda mask: mask.tolist()):
            tissue, mask, top = sag(choose)
            numpy.testing.assert_array_equal(tissue.positions, numbers.positions)
            numpy.testing.assert_array_equal(tissue.reaction(mask), numbers.reaction(bottom))
            tissue.move_to(mask, numpy.zeros((9, 3)))
            tissue.release(mask)
            self.assertEqual(abs(tissue.reaction(mask)).max(), 0)
            for wrong in (mask[1:], list(mask) + [True]):
                for act in (tissue.fix, tissue.release, tissue.reaction):
                    with self.assertRaisesRegex(elastin.InputError, "a mask of 3[57] truth values; .* has 36"):
                        act(wrong)
            with self.assertRaisesRegex(elastin.InputError, "molecules: is a mask of 35"):
                tissue.add_load("point", force=(0, 0, 1), molecules=top[1:])
        with self.assertRaises(TypeError):
            numbers.fix(numpy.zeros((36, 2), bool))
        with self.assertRaises(TypeError):
            numbers.fix(True)
        chain = elastin.Simulation(elastin.lattice((1, 1, 4), 1e-3, ("axis",)), "standard", elastin.Material(5e3))
        with self.assertRaisesRegex(elastin.InputError, "connections: is a mask of 2 truth values"):
            chain.remove(connections=[True, False])
        chain.remove(connections=[False, False, True])
        self.assertEqual(chain.body.connections.tolist(), [[0, 1], [1, 2]])

    def test_loads_change_and_go_also_in_a_copy(self):
        body = elastin.Body([[0, 0, 0], [0, 0, 1]], [[0, 1]], masses=[1, 1])
        tissue = elastin.Simulation(body, "uniform", SOFT, parameters={"constant": 0})
        load = tissue.add_load("gravity", acceleration=(0, 0, -10))
        tissue.step(0.1)
        tissue.set_load(load, acceleration=(5, 0, 0))
        tissue.step(0.1)
        numpy.testing.assert_allclose(tissue.velocities, [[0.5, 0, -1]] * 2)
        other = tissue.add_load("gravity", acceleration=(0, 1, 0))
        tissue.remove_load(load)
        again = pickle.loads(pickle.dumps(tissue))
        for one in (tissue, again):
            one.step(0.1)
            numpy.testing.assert_allclose(one.velocities, [[0.5, 0.1, -1]] * 2)
            one.remove_load(other)
            with self.assertRaisesRegex(elastin.InputError, f"no load {other}"):
                one.set_load(other, acceleration=(0, 0, 0))

    def test_a_surface_is_drawn_with_the_body(self):
        body = BODIES["hexahedron8"]
        corners = numpy.array([[2, 2, 2], [8, 2, 2], [2, 8, 2], [2, 2, 8]]) * 1e-3
        surface = elastin.Surface(body, corners, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
        self.assertEqual((len(surface), surface.farthest), (4, 0))
        F = numpy.array([[1.1, 0.2, 0], [0, 0.9, 0.1], [-0.1, 0, 1.2]])
        points, normals = surface.draw(body.positions @ F.T)
        self.assertEqual((points.dtype, points.shape), (numpy.float32, (4, 3)))
        numpy.testing.assert_allclose(points, corners @ F.T, atol=1e-9)
        self.assertTrue(((points - points.mean(0)) * normals).sum(1).min() > 0)
        numpy.testing.assert_allclose((normals**2).sum(1), 1, rtol=1e-6)
        with self.assertRaisesRegex(elastin.InputError, "5 positions"):
            surface.draw(numpy.zeros((5, 3)))
        with self.assertRaisesRegex(elastin.InputError, "triangles: is 'all'; allowed: three numbers each"):
            elastin.Surface(body, corners, "all")

    def test_a_file_of_the_present_state(self):
        with tempfile.TemporaryDirectory() as folder:
            for shape, body in BODIES.items():
                tissue = elastin.Simulation(body, "neo_hookean", SOFT)
                tissue.positions = body.positions * 1.1
                tissue.to_vtu(f"{folder}/{shape}.vtu")
                again = elastin.read_mesh(f"{folder}/{shape}.vtu", "m")
                numpy.testing.assert_allclose(again.positions, body.positions * 1.1, rtol=1e-12)
                with open(f"{folder}/{shape}.vtu", encoding="utf8") as file:
                    self.assertRegex(file.read(), '(?s)green_strain.*NumberOfComponents="9".*stress')


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
