"""Arrays are views: never copied, never moved, never outliving what they show."""

import gc
import sys
import unittest
import weakref

import numpy

import elastin

MATERIAL = elastin.Material(5e3)


def tissue(**options):
    simulation = elastin.Simulation(elastin.lattice((4, 4, 4), 1e-3), "lattice", MATERIAL, **options)
    simulation.add_load("gravity", acceleration=(0, 0, -9.81))
    return simulation


def address(array):
    return array.__array_interface__["data"][0]


class Views(unittest.TestCase):
    NAMES = ("positions", "velocities", "forces", "tensions", "host_forces")

    def test_addresses_stay(self):
        simulation = tissue()
        before = {name: address(getattr(simulation, name)) for name in self.NAMES}
        self.assertEqual(len(set(before.values())), len(self.NAMES))
        saved = simulation.save()
        for _ in range(20):
            self.assertTrue(simulation.step(1e-4))
            self.assertEqual({name: address(getattr(simulation, name)) for name in self.NAMES}, before)
        simulation.restore(saved)
        simulation.settle(check=False)  # nothing holds it
        self.assertEqual({name: address(getattr(simulation, name)) for name in self.NAMES}, before)

    def test_a_view_follows_the_steps(self):
        simulation = tissue()
        positions = simulation.positions
        first = positions.copy()
        simulation.step(1e-3)
        self.assertFalse((positions == first).all())
        self.assertTrue((positions == simulation.positions).all())

    def test_shapes(self):
        simulation = tissue()
        for name in ("positions", "velocities", "forces", "host_forces"):
            array = getattr(simulation, name)
            self.assertEqual((array.shape, array.dtype), ((64, 3), numpy.dtype(float)))
            self.assertTrue(array.flags.c_contiguous)
        self.assertEqual(simulation.tensions.shape, (len(simulation.body.connections),))

    def test_what_may_be_written(self):
        simulation = tissue()
        for array in (simulation.positions, simulation.velocities, simulation.forces, simulation.tensions,
                      simulation.body.positions, simulation.body.masses, simulation.body.connections):
            with self.assertRaises(ValueError):
                array[0] = 0
            with self.assertRaises(ValueError):
                array.flags.writeable = True
        simulation.host_forces[5] = 0, 0, 1e-6
        self.assertEqual(list(simulation.host_forces[5]), [0, 0, 1e-6])

    def test_host_forces_act(self):
        """Free fall under weight is stopped by its opposite."""
        simulation = tissue()
        simulation.host_forces[:, 2] = 9.81 * simulation.body.masses
        simulation.step(1e-3, 10)
        self.assertLess(abs(simulation.velocities).max(), 1e-12)

    def test_a_view_outlives_the_name_of_its_simulation(self):
        simulation = tissue()
        simulation.step(1e-3)
        views = [getattr(simulation, name) for name in self.NAMES] + [simulation.body.positions]
        copies = [view.copy() for view in views]
        gone = weakref.ref(simulation)
        del simulation
        gc.collect()
        self.assertIsNotNone(gone())
        for view, copy in zip(views, copies):
            self.assertTrue((view == copy).all())
        del views, view
        gc.collect()
        self.assertIsNone(gone())

    def test_a_result_keeps_its_body(self):
        from helpers import CUBE
        result = elastin.run(CUBE)
        positions, ends = result.positions, result.body.connections
        self.assertEqual(address(result.positions), address(positions))
        del result
        gc.collect()
        self.assertEqual(positions[ends].shape, (len(ends), 2, 3))


class References(unittest.TestCase):
    def test_views_give_back_what_they_take(self):
        simulation = tissue()
        before = sys.getrefcount(simulation)
        for _ in range(1000):
            simulation.positions, simulation.forces, simulation.host_forces, simulation.body
        self.assertEqual(sys.getrefcount(simulation), before)

    def test_observers_are_let_go_with_the_simulation(self):
        simulation = tissue()

        def see(seen):
            steps.append(seen is simulation)

        steps = []
        before = sys.getrefcount(see)
        simulation.observe(see, every=2)
        simulation.step(1e-4, 6)
        self.assertEqual(steps, [True] * 3)
        self.assertEqual(sys.getrefcount(see), before + 1)
        see.__closure__[0].cell_contents = None  # it names the simulation, which keeps it
        simulation = None
        gc.collect()
        self.assertEqual(sys.getrefcount(see), before)

    def test_strategies_are_let_go(self):
        def rule(body, material):
            return numpy.full(body.proper_connections, 1.0)

        before = sys.getrefcount(rule)
        strategy = elastin.Strategy("rule", rule)
        simulation = elastin.Simulation(elastin.lattice((3, 3, 3), 1e-3), strategy, MATERIAL)
        simulation.step(1e-4)
        del strategy, simulation
        gc.collect()
        self.assertEqual(sys.getrefcount(rule), before)


class SavedStates(unittest.TestCase):
    def test_the_steps_after_it_have_the_same_bits(self):
        simulation = tissue()
        simulation.fix(0)
        simulation.step(1e-3, 5)
        saved = simulation.save()
        simulation.step(1e-3, 5)
        first = simulation.positions.copy()
        simulation.restore(saved)
        self.assertEqual(simulation.time, saved.time)
        simulation.step(1e-3, 5)
        self.assertEqual(first.tobytes(), simulation.positions.tobytes())


if __name__ == "__main__":
    unittest.main()
