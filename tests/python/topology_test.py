"""Simulations that are cut, touched by tools and loaded at run time."""
import os
import pickle
import runpy
import unittest

import numpy

import elastin
from helpers import SOURCE


def hanging(molecules=6):
    tissue = elastin.Simulation(elastin.lattice((molecules,) * 3, 1e-3), "lattice", elastin.Material(1e4),
                                stepper="backward_euler")
    for molecule in range(molecules ** 2):
        tissue.fix(molecule)
    return tissue


class Touched(unittest.TestCase):
    """A block of tissue on a plate that is pressed into it by a hundredth of a millimetre."""

    def on(self, plate):
        simulation = elastin.Simulation(elastin.lattice((5, 5, 5), 1e-3), "lattice", elastin.Material(5e3))
        simulation.add_contact(1e8, [{"name": "plate", "position": (3e-3, 2e-3, -0.99e-3)} | plate])
        return simulation

    def test_points_and_torque_are_those_of_the_force(self):
        on_box = self.on({"shape": "box", "x": 0.02, "y": 0.02, "z": 2e-3})
        force, torque, points = on_box.contact_forces()["plate"], on_box.contact_torques()["plate"], on_box.contact_points()
        numpy.testing.assert_allclose(force, (0, 0, -1e8 * 1e-5 * 16e-6), rtol=1e-9)  # stiffness, depth, area
        numpy.testing.assert_allclose(-points["force"].sum(axis=0), force, rtol=1e-12)
        # The middle of the face is 1 mm away from the middle of the plate.
        numpy.testing.assert_allclose(torque, (0, 1e-3 * force[2], 0), atol=1e-9 * abs(force[2]))
        self.assertEqual(set(points["obstacle"]), {"plate"})

    def test_tools_of_points(self):
        size = numpy.array((0.02, 0.02, 2e-3))
        corners = numpy.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * size / 2
        sides = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
        known = self.on({"shape": "box", "x": size[0], "y": size[1], "z": size[2]}).contact_forces()["plate"]
        for plate in ({"shape": "convex", "points": corners}, {"shape": "mesh", "points": corners, "triangles": sides}):
            numpy.testing.assert_allclose(self.on(plate).contact_forces()["plate"], known, rtol=1e-9, atol=1e-12)
        for wrong, message in (({"shape": "mesh", "points": corners}, "a mesh needs triangles"),
                               ({"shape": "convex", "points": corners[:3]}, "needs points"),
                               ({"shape": "mesh", "points": corners, "triangles": [(0, 1, 9)]}, "no point 9"),
                               ({"shape": "box", "points": corners}, "points are of a convex or a mesh")):
            with self.assertRaisesRegex(elastin.InputError, message):
                self.on(wrong)


class Topology(unittest.TestCase):
    def test_what_a_cut_leaves(self):
        tissue = hanging()
        tissue.step(1e-3)
        tissue.add_load("gravity", acceleration=(0, 2, -9.81))
        tissue.step(1e-3, 5)
        before, shown, mass = tissue.positions, numpy.array(tissue.positions), tissue.body.masses.sum()
        body = tissue.body
        cut = tissue.cut_plane((2e-3, 0, 0), (1, 0, 0))
        self.assertTrue(cut)
        self.assertEqual(cut.split_molecules, 36)
        self.assertEqual(len(tissue.positions), 252)
        self.assertAlmostEqual(tissue.body.masses.sum() / mass, 1, delta=1e-14)
        self.assertEqual(list(cut.molecule_from[:216]), list(range(216)))
        self.assertEqual(len(tissue.origin), 252)
        self.assertEqual((len(body.surface), len(tissue.body.surface)), (2 * 25 * 6, 2 * 25 * 8))  # a cube, two halves
        tissue.step(1e-3, 3)
        numpy.testing.assert_array_equal(before, shown)  # a view of what was
        self.assertEqual(len(body.positions), 216)
        self.assertFalse(tissue.cut_plane((1, 0, 0), (1, 0, 0)))

    def test_a_cut_goes_through_pickle_and_back(self):
        tissue = hanging()
        tool = tissue.add_tool((2.5e-3, 2.5e-3, 7e-3))
        tissue.add_contact(2e7, [{"shape": "sphere", "radius": 2e-3, "tool": tool}])
        whole = tissue.save()
        tissue.cut_blade([(-1, -1, 2e-3), (-1, 1, 2e-3)], [(2.1e-3, -1, 2e-3), (2.1e-3, 1, 2e-3)])
        tissue.move_tool(tool, (2.5e-3, 2.5e-3, 6.9e-3))
        tissue.step(1e-3, 5)
        self.assertGreater(tissue.contact_forces()["sphere0"][2], 0)
        again = pickle.loads(pickle.dumps(tissue))
        for each in (tissue, again):
            each.step(1e-3, 5)
        numpy.testing.assert_array_equal(tissue.positions, again.positions)
        tissue.restore(whole)
        self.assertEqual(len(tissue.positions), 216)

    def test_a_budget_is_recorded_and_replayed(self):
        def swinging(budget):
            tissue = elastin.Simulation(elastin.lattice((4, 4, 4), 1e-3), "lattice", elastin.Material(1e4),
                                        stepper="block_descent", budget=budget)
            tissue.add_load("gravity", acceleration=(0, 0, -9.81))
            tissue.fix(0)
            return tissue
        tissue, replay = swinging(1e-3), swinging(0)
        for _ in range(10):
            tissue.step(1e-3)
            replay.set_effort(tissue.effort)
            replay.step(1e-3)
        numpy.testing.assert_array_equal(tissue.positions, replay.positions)
        off, motion = tissue.iteration_error(1e-3)
        self.assertTrue(0 <= off < motion)

    def test_two_materials(self):
        cube = elastin.lattice((4, 4, 4), 1e-3)
        tissue = elastin.Simulation(elastin.of_parts([("soft", cube, 0), ("stiff", cube, 1)]), "lattice",
                                    [elastin.Material(5e3), elastin.Material(5e4)], stepper="backward_euler")
        for molecule in [*range(48, 64), *range(112, 128)]:
            tissue.fix(molecule)
        tissue.add_load("gravity", acceleration=(0, 0, -9.81))
        tissue.settle()
        self.assertAlmostEqual(tissue.positions[0, 2] / tissue.positions[64, 2], 10, delta=0.2)
        with self.assertRaisesRegex(ValueError, "several parts"):
            tissue.cut_plane((1e-3, 0, 0), (1, 0, 0))

    def test_a_material_for_each_label(self):
        """Forces are those of the cells of each label by themselves, with their own law."""
        laws = {2: elastin.Material(2e4, 0.3), 7: elastin.Material(law={"law": "yeoh", "terms": [3e3, 500.], "bulk_modulus": 2e4})}
        for shape in ({"tetrahedra": {"kind": "kuhn", "cubes": [2, 2, 3], "size": [2e-2, 2e-2, 3e-2]}},
                      {"lattice": {"kind": "cubic", "molecules": [3, 3, 4], "spacing": 1e-2, "order": 2}}):
            body = elastin.body(shape)
            (name, cells), = body.cells.items()

            def of_cells(own, positions):
                return elastin.Body(positions, **{"tetrahedra": own} if name == "tetrahedron4" else {"cells": {name: own}})

            labels = numpy.random.default_rng(3).choice(list(laws), len(cells))
            parted, molecule_from = elastin.of_labels(of_cells(cells, body.positions), labels)
            numpy.testing.assert_array_equal(parted.positions, body.positions[molecule_from])
            moved = body.positions + numpy.random.default_rng(4).uniform(-1e-3, 1e-3, body.positions.shape)
            tissue = elastin.Simulation(parted, "neo_hookean", [laws[label] for label in sorted(laws)])
            tissue.positions = moved[molecule_from]
            expected = numpy.zeros(moved.shape)
            for label, law in laws.items():
                own = cells[labels == label]
                used = numpy.unique(own)
                alone = elastin.Simulation(of_cells(numpy.searchsorted(used, own), body.positions[used]),
                                           "yeoh" if law.law else "neo_hookean", law)
                alone.positions = moved[used]
                expected[used] += alone.forces
            numpy.testing.assert_allclose(tissue.forces, expected[molecule_from], atol=1e-12 * abs(expected).max(), rtol=1e-9)
        with self.assertRaisesRegex(ValueError, "labels: has 3 values; the body has"):
            elastin.of_labels(of_cells(cells, body.positions), [1, 2, 3])

    def test_what_is_refused(self):
        tissue = hanging(3)
        with self.assertRaisesRegex(ValueError, "two ends of the blade"):
            tissue.cut_blade([(0, 0, 0)], [(0, 0, 0)])
        with self.assertRaisesRegex(ValueError, "sphere"):
            tissue.add_contact(1e7, [{"shape": "sphre", "radius": 1e-3}])
        with self.assertRaisesRegex(ValueError, "radius"):
            tissue.add_contact(1e7, [{"shape": "sphere", "radios": 1e-3}])
        with self.assertRaisesRegex(ValueError, "strain of 0"):
            tissue.tear(0)

    def test_the_example(self):
        runpy.run_path(os.path.join(SOURCE, "tests", "examples", "cut.py"))


if __name__ == "__main__":
    unittest.main()
