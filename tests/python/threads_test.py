"""Steps let other threads run; simulations in several threads; Ctrl-C; observers."""

import os
import signal
import sys
import threading
import time
import unittest

import numpy

import elastin


def tissue(number=0):
    simulation = elastin.Simulation(elastin.lattice((6, 6, 6), 1e-3), "lattice", elastin.Material(5e3))
    simulation.add_load("gravity", acceleration=(0, 0.1 * number, -9.81))
    simulation.fix(0)
    return simulation


class Stop(Exception):
    pass


class Threads(unittest.TestCase):
    def test_many_simulations_in_one_call(self):
        """Each goes where its own steps bring it, to the last bit; one that fails is named, and the others go on."""
        many, alone = [tissue(i) for i in range(5)], [tissue(i) for i in range(5)]
        results = elastin.step_all(many, 1e-3, 20, threads=3)
        self.assertTrue(all(results) and len(results) == 5)
        for one, other in zip(many, alone):
            other.step(1e-3, 20)
            numpy.testing.assert_array_equal(one.positions, other.positions)
        many[3].host_forces[7] = 1e300
        with self.assertRaisesRegex(elastin.StepError, "simulation 3: ") as caught:
            elastin.step_all(many, 1e-3, 2)
        self.assertFalse(caught.exception.result)
        self.assertAlmostEqual(many[4].time, 22e-3)
        self.assertAlmostEqual(many[3].time, 20e-3)
        self.assertRaises(elastin.InputError, elastin.step_all, [many[0], many[0]], 1e-3)
        self.assertRaises(elastin.InputError, elastin.step_all, many, 1e-3, 0)

    def test_ctrl_c_ends_many_simulations(self):
        many = [tissue(i) for i in range(4)]
        threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            elastin.step_all(many, 1e-3, 10**9)

    def test_a_step_gives_the_interpreter_free(self):
        """The interpreter would not take it from a thread by itself: what the other thread does, it does in a step."""
        interval = sys.getswitchinterval()
        sys.setswitchinterval(1000)
        self.addCleanup(sys.setswitchinterval, interval)
        simulation, steps, asked, ended = tissue(), [0], threading.Event(), []

        def see(_):
            steps[0] += 500
            if asked.is_set() or steps[0] > 500_000:
                raise Stop

        simulation.observe(see, every=500)

        def work():
            try:
                simulation.step(1e-5, 10_000_000)
            except Stop:
                ended.append(steps[0])

        thread = threading.Thread(target=work)
        thread.start()
        while steps[0] == 0:
            threading.Event().wait(0.001)
        self.assertEqual(ended, [])
        asked.set()
        thread.join()
        self.assertLess(ended[0], 500_000)

    def test_the_same_bits_in_many_threads(self):
        alone = []
        for number in range(3):
            simulation = tissue(number)
            simulation.step(1e-4, 300)
            alone.append(simulation.positions.tobytes())
        together = [tissue(number) for number in range(3)]
        threads = [threading.Thread(target=simulation.step, args=(1e-4, 300)) for simulation in together]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual([simulation.positions.tobytes() for simulation in together], alone)

    def test_threads_take_turns_at_one_simulation(self):
        simulation = tissue()
        threads = [threading.Thread(target=simulation.step, args=(1e-4, 100)) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        again = tissue()
        again.step(1e-4, 400)
        self.assertEqual(simulation.positions.tobytes(), again.positions.tobytes())


class Interruptions(unittest.TestCase):
    def test_ctrl_c_ends_many_steps(self):
        simulation = tissue()
        simulation.observe(lambda seen: os.kill(os.getpid(), signal.SIGINT) if seen.time > 1e-3 else None, every=100)
        with self.assertRaises(KeyboardInterrupt):
            simulation.step(1e-5, 100_000_000)
        self.assertTrue(simulation.step(1e-5))

    def test_ctrl_c_ends_a_run(self):
        from helpers import SOURCE
        with self.assertRaises(KeyboardInterrupt):
            elastin.run(f"{SOURCE}/scenes/tension/cube-1000.yaml",
                        progress=lambda doing: os.kill(os.getpid(), signal.SIGINT))

    def test_ctrl_c_ends_an_equilibrium_and_vibrations_in_the_middle(self):
        """Neither takes steps: a timer, not progress, asks them to stop."""
        from helpers import SOURCE
        body = elastin.lattice([40, 40, 40], 1e-3)
        heavy = elastin.Simulation(body, "lattice", elastin.Material(10e3))
        heavy.fix(numpy.flatnonzero(body.positions[:, 2] == 0))
        heavy.add_load("gravity", acceleration=(0, 0, -1e3))
        large = elastin.Laboratory(f"{SOURCE}/scenes/dynamics/vibration-cube-clamped.yaml",
                                   set={"body.tetrahedra.cubes": [16, 16, 16]})
        for act in (heavy.settle, lambda: large.run("neo_hookean")):
            timer = threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT))
            with self.assertRaises(KeyboardInterrupt):
                timer.start()
                act()
                timer.join()

    def test_ctrl_c_ends_fits_in_the_middle(self):
        """Of spring constants in a constructor, and of materials to curves of specimens."""
        from helpers import SOURCE
        body = elastin.lattice([12, 12, 12], 1e-3)
        for act in (lambda: elastin.Simulation(body, "fitted:standard", elastin.Material(10e3)),
                    lambda: elastin.identify(f"{SOURCE}/scenes/identify/cruciform.yaml")):
            begun = []

            def interrupt():
                begun.append(time.monotonic())
                os.kill(os.getpid(), signal.SIGINT)

            timer = threading.Timer(0.5, interrupt)
            with self.assertRaises(KeyboardInterrupt):
                timer.start()
                act()
                timer.join()
            self.assertLess(time.monotonic() - begun[0], 5)  # on a busy machine; 1 s on a quiet one

    def test_what_an_observer_raises_comes_out_of_the_step(self):
        simulation = tissue()

        def refuse(seen):
            raise Stop(seen.time)

        simulation.observe(refuse, every=3)
        with self.assertRaises(Stop) as caught:
            simulation.step(1e-4, 10)
        self.assertAlmostEqual(caught.exception.args[0], 3e-4)
        self.assertAlmostEqual(simulation.time, 3e-4)

    def test_an_observer_must_not_step(self):
        simulation = tissue()
        simulation.observe(lambda seen: seen.step(1e-4))
        with self.assertRaisesRegex(elastin.InputError, "must not step"):
            simulation.step(1e-4)


class Hands(unittest.TestCase):
    def test_fix_move_and_reaction(self):
        """The support of the one molecule that is held bears the weight of all, at rest."""
        simulation = tissue()
        self.assertTrue(simulation.settle())
        weight = 9.81 * simulation.body.masses.sum()
        self.assertAlmostEqual(simulation.reaction(0)[2] / weight, 1, delta=1e-6)
        position = simulation.positions[0] + (0, 0, 1e-6)
        simulation.move_to(0, position)
        simulation.step(1e-4)
        self.assertEqual(list(simulation.positions[0]), list(position))
        simulation.release(0)
        self.assertEqual(list(simulation.reaction(0)), [0, 0, 0])

    def test_free_directions(self):
        simulation = tissue(1)
        simulation.release(0)
        simulation.fix(7, free="z")
        x, y, z = simulation.positions[7].copy()
        simulation.step(1e-3, 5)
        self.assertEqual(list(simulation.positions[7][:2]), [x, y])
        self.assertLess(simulation.positions[7][2], z)
        with self.assertRaisesRegex(elastin.InputError, "'w' is no axis"):
            simulation.fix(7, free="w")

    def test_coupling(self):
        simulation = tissue()
        position = simulation.positions[215] + (1e-4, 0, 0)
        coupling = simulation.couple(215, position, stiffness=0.5)
        self.assertAlmostEqual(simulation.coupling_force(coupling)[0], 0.5e-4, delta=1e-12)
        simulation.move_coupling(coupling, simulation.positions[215])
        simulation.decouple(coupling)
        with self.assertRaisesRegex(elastin.InputError, f"no coupling {coupling}: it was taken off"):
            simulation.coupling_force(coupling)

    def test_trouble_is_an_outcome(self):
        simulation = elastin.Simulation(elastin.lattice((3, 3, 3), 1e-3), "lattice", elastin.Material(5e3),
                                        max_substeps=2)
        before = simulation.positions.copy()
        ended = simulation.step(10, check=False)
        self.assertFalse(ended)
        self.assertEqual(ended.outcome, "limit_reached")
        self.assertIn("substeps", ended.cause)
        self.assertTrue((simulation.positions == before).all())


if __name__ == "__main__":
    unittest.main()
