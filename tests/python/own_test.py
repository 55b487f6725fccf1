"""Loads, steppers and experiments of one's own."""

import pickle
import unittest

import elastin
import numpy

MATERIAL = elastin.Material(5e3, 0.25)


def cube():
    return elastin.lattice((4, 4, 4), 1e-3)


class Refused(Exception):
    pass


def leap(positions, velocities, forces, masses, dt):
    velocities = velocities + dt * forces(positions, velocities) / masses[:, None]
    return positions + dt * velocities, velocities


def weight(body, gravity=9.81):
    return numpy.outer(body.masses, (0, 0, -gravity))


class Loads(unittest.TestCase):
    def test_a_trap_moves_a_free_body_by_weight_over_stiffness(self):
        """Every molecule hangs on a spring of its own, so that nothing is strained: m g / k."""
        body = cube()
        stiffness = 2e-3 * body.masses / body.masses.mean()

        def pull(positions, softness=1.0):
            return -stiffness[:, None] / softness * (positions - body.positions)

        def energy(positions, softness=1.0):
            return (stiffness / softness / 2 * ((positions - body.positions)**2).sum(axis=1)).sum()

        for trap in (elastin.load("trap", pull), elastin.load("trap", pull, energy)):
            simulation = elastin.Simulation(body, "lattice", MATERIAL)
            simulation.add_load("gravity", acceleration=(0, 0, -9.81))
            number = simulation.add_load(trap, softness=2.0)
            simulation.settle()
            sinking = 2 * 9.81 * body.masses.mean() / 2e-3
            numpy.testing.assert_allclose(body.positions - simulation.positions, numpy.tile((0, 0, sinking), (64, 1)),
                                          atol=1e-6 * sinking)
            simulation.set_load(number, softness=1.0)
            simulation.settle()
            numpy.testing.assert_allclose((body.positions - simulation.positions)[:, 2], sinking / 2, rtol=1e-6)
            with self.assertRaisesRegex(elastin.InputError, "no 'softnes'; did you mean 'softness'"):
                simulation.add_load(trap, softnes=2.0)

    def test_weight_and_drag_are_those_of_the_table(self):
        """Forces of nothing, and of velocities alone, in explicit and in implicit steps."""
        drag = elastin.load("drag", lambda body, velocities, rate=20.0: -rate * body.masses[:, None] * velocities)
        for stepper in ("symplectic_euler", "velocity_verlet", "backward_euler"):
            ends = []
            for own in (False, True):
                simulation = elastin.Simulation(cube(), "lattice", MATERIAL, stepper=stepper)
                simulation.fix(numpy.arange(16))
                if own:
                    simulation.add_load(elastin.load("mine", weight))
                    simulation.add_load(drag)
                else:
                    simulation.add_load("gravity", acceleration=(0, 0, -9.81))
                    simulation.add_load("rayleigh", mass=20.0)
                simulation.step(1e-3, 20)
                ends.append(simulation.positions - simulation.body.positions)
            numpy.testing.assert_allclose(ends[1], ends[0], atol=1e-7 * abs(ends[0]).max())

    def test_what_a_load_raises_comes_out_of_steps_equilibria_and_runs(self):
        def refuse(positions):
            raise Refused

        for stepper in ("symplectic_euler", "newmark"):
            simulation = elastin.Simulation(cube(), "lattice", MATERIAL, stepper=stepper)
            number = simulation.add_load(elastin.load("refusing", refuse))
            for act in (lambda: simulation.step(1e-3), simulation.settle, lambda: simulation.forces):
                self.assertRaises(Refused, act)
            numpy.testing.assert_array_equal(simulation.positions, simulation.body.positions)
            simulation.remove_load(number)
            self.assertTrue(simulation.step(1e-3))
        with self.assertRaises(Refused):
            elastin.run(cube(), "lattice", material=MATERIAL, experiment=elastin.Loads(),
                        supports=[{"molecules": list(range(16)), "fix": ["x", "y", "z"]}], loads=[elastin.load("refusing", refuse)])
        simulation = elastin.Simulation(cube(), "lattice", MATERIAL)
        simulation.add_load(elastin.load("short", lambda positions: positions[1:]))
        with self.assertRaisesRegex(elastin.InputError, "forces: has 63 rows; the body has 64 molecules"):
            simulation.step(1e-3)

    def test_it_sees_the_simulation_that_calls_it_and_changes_nothing_there(self):
        state = None
        for stepper in ("symplectic_euler", "velocity_verlet", "backward_euler"):
            for act in (lambda s: s.remove_load(1), lambda s: s.set_load(1), lambda s: s.add_load("gravity", acceleration=(0, 0, -1)),
                        lambda s: s.couple(0, (0, 0, 0), 1), lambda s: s.add_contact(1e6), lambda s: s.vibrations(1),
                        lambda s: s.host_forces, lambda s: s.forces, lambda s: s.reaction(0), lambda s: s.step(1e-3),
                        lambda s: s.settle(), lambda s: s.fix(3), lambda s: s.cut_plane((0, 0, 0), (1, 0, 0)),
                        lambda s: s.restore(state), lambda s: s.trajectory(1e-4, 1), lambda s: s.stiffness(),
                        lambda s: setattr(s, "positions", s.body.positions)):
                simulation = elastin.Simulation(cube(), "lattice", MATERIAL, stepper=stepper)
                state = simulation.save()
                simulation.fix(0)

                def pull(positions):
                    self.assertEqual(simulation.time, 0)
                    self.assertEqual(len(simulation.positions), len(simulation.velocities))
                    act(simulation)
                    return 0 * positions

                simulation.add_load(elastin.load("pulls", pull))
                with self.assertRaisesRegex(RuntimeError, "must not use the simulation that calls it"):
                    simulation.step(1e-3)
                self.assertEqual(simulation.time, 0)

    def test_a_scene_takes_it(self):
        """As it is, or by its name with a value, as gravity of the same size."""
        catalog = elastin.Catalog()
        catalog.add(elastin.load("weighs", weight))
        scene = {"experiment": elastin.Loads(), "supports": [{"molecules": list(range(16)), "fix": ["x", "y", "z"]}]}
        sag = [elastin.run(cube(), "lattice", material=MATERIAL, loads=[load], catalog=with_own, **scene)["largest_displacement"]
               for load, with_own in (({"gravity": [0, 0, -9.81]}, None),
                                      (elastin.load("weighs", weight), None), ({"weighs": {"gravity": 9.81}}, catalog),
                                      ({"weighs": {"gravity": 19.62}}, catalog))]
        numpy.testing.assert_allclose(sag[1:3], sag[0], rtol=1e-6)
        self.assertGreater(sag[3], 1.9 * sag[0])

    def test_arguments_without_a_meaning_are_refused(self):
        with self.assertRaisesRegex(elastin.InputError, "argument 'position' has no default; did you mean 'positions'"):
            elastin.load("mine", lambda position: position)

    def test_a_simulation_with_it_can_be_pickled(self):
        simulation = elastin.Simulation(cube(), "lattice", MATERIAL, stepper=elastin.stepper("leap", leap))
        simulation.fix(numpy.arange(16))
        simulation.add_load(elastin.load("weighs", weight), gravity=5.0)
        simulation.step(1e-4, 5)
        again = pickle.loads(pickle.dumps(simulation))
        for one in (simulation, again):
            one.step(1e-4, 5)
        numpy.testing.assert_array_equal(again.positions, simulation.positions)


class Steppers(unittest.TestCase):
    def test_a_load_without_an_energy_does_work_in_the_lab(self):
        """The weight of a free body as a function of nothing: it falls as under gravity, and its work is what it has then."""
        scene = dict(body={"lattice": {"kind": "cubic", "molecules": [3, 3, 3], "spacing": "1 cm", "connections": ["axis", "face"]}},
                     material={"youngs_modulus": "5 kPa", "density": "1000 kg/m3"}, stiffness="lattice", experiment={"kind": "motion"},
                     loads=[elastin.load("mine", weight)])
        for stepper in ("velocity_verlet", "newmark"):
            run = elastin.run(scene, time={"duration": "0.1 s", "stepper": stepper, "step": "1 ms"})
            self.assertEqual(str(run.outcome), "converged", run.cause)
            self.assertAlmostEqual(run.measures["centre_displacement"], 9.81 * 0.1 ** 2 / 2, delta=1e-9)
            self.assertAlmostEqual(run.measures["work"] / run.measures["kinetic_energy"], 1, delta=1e-9)

    def test_the_stepper_by_its_former_names(self):
        """scheme and scheme_parameters choose what stepper and stepper_parameters do."""
        ends = []
        for names in (("stepper", "stepper_parameters"), ("scheme", "scheme_parameters")):
            simulation = elastin.Simulation(cube(), "lattice", MATERIAL, **dict(zip(names, ("backward_euler", {"newton_iterations": 1}))))
            simulation.add_load("gravity", acceleration=(0, 0, -9.81))
            simulation.step(1e-3, 3)
            ends.append(simulation.positions.copy())
        self.assertTrue(numpy.array_equal(*ends))
        other = elastin.Simulation(cube(), "lattice", MATERIAL)
        other.add_load("gravity", acceleration=(0, 0, -9.81))
        other.step(1e-3, 3)
        self.assertFalse(numpy.array_equal(other.positions, ends[1]))

    def test_it_steps_as_the_same_method_in_cpp(self):
        """With supports that stay and that move, and in as many substeps."""
        ends = []
        for stepper in ("symplectic_euler", elastin.stepper("leap", leap)):
            simulation = elastin.Simulation(cube(), "lattice", MATERIAL, stepper=stepper)
            simulation.add_load("gravity", acceleration=(0, 0, -9.81))
            simulation.fix(numpy.arange(32))
            simulation.move_to(numpy.arange(16), simulation.positions[:16] + (1e-4, 0, 0))
            substeps = [simulation.step(2e-3).substeps for _ in range(10)]
            ends.append((simulation.positions - simulation.body.positions, simulation.velocities.copy(), substeps))
        numpy.testing.assert_allclose(ends[1][0], ends[0][0], atol=1e-12 * abs(ends[0][0]).max())
        numpy.testing.assert_allclose(ends[1][1], ends[0][1], atol=1e-10 * abs(ends[0][1]).max())
        self.assertEqual(ends[1][2], ends[0][2])

    def test_a_scene_in_time_takes_it(self):
        scene = {"body": cube(), "material": MATERIAL, "stiffness": "lattice", "experiment": elastin.Drop(height=1e-3, gravity=9.81),
                 "time": {"duration": "5 ms", "frames": 5}}
        ends = [elastin.run(scene, set=None, time=scene["time"] | {"stepper": stepper}).positions
                for stepper in ("symplectic_euler", elastin.stepper("leap", leap))]
        numpy.testing.assert_allclose(ends[1], ends[0], rtol=1e-9, atol=1e-15)

    def test_what_goes_wrong_leaves_the_state(self):
        def refuse(positions, dt):
            raise Refused

        kept = []

        def wild(positions, velocities, forces, speed=numpy.inf):
            kept.append(forces)
            return positions + speed, velocities

        refusing = elastin.Simulation(cube(), "lattice", MATERIAL, stepper=elastin.stepper("refusing", refuse))
        self.assertRaises(Refused, refusing.step, 1e-4)
        simulation = elastin.Simulation(cube(), "lattice", MATERIAL, stepper=elastin.stepper("wild", wild))
        with self.assertRaisesRegex(elastin.StepError, "no finite positions"):
            simulation.step(1e-4)
        numpy.testing.assert_array_equal(simulation.positions, simulation.body.positions)
        with self.assertRaisesRegex(elastin.InputError, "within the step alone"):
            kept[0](simulation.positions, simulation.velocities)
        calm = elastin.Simulation(cube(), "lattice", MATERIAL, stepper=elastin.stepper("wild", wild), stepper_parameters={"speed": 1e-6})
        self.assertTrue(calm.step(1e-4))


class Squeeze(elastin.Experiment):
    """The top is pressed down on the bottom."""

    measures = {"force": "N", "height_left": "m"}

    def __init__(self, depth, load_steps=1, free=""):
        self.depth, self.load_steps, self.free = depth, load_steps, free

    def hold(self, body):
        z = body.positions[:, 2]
        self.bottom, self.top = numpy.flatnonzero(z == z.min()), numpy.flatnonzero(z == z.max())
        return [(self.bottom, (0, 0, 0), self.free), (self.top, (0, 0, -self.depth), self.free)]

    def measure(self, body, positions, reactions):
        return {"force": reactions[self.bottom, 2].sum(), "height_left": numpy.ptp(positions[:, 2])}


class Experiments(unittest.TestCase):
    def test_it_measures_what_the_same_experiment_of_the_table_does(self):
        own = elastin.run(cube(), "lattice", material=MATERIAL, experiment=Squeeze(3e-4, 2))
        known = elastin.run(cube(), "lattice", material=MATERIAL,
                            experiment=elastin.Compression(axis="z", displacement=3e-4, grips="clamped", load_steps=2))
        self.assertEqual(own.outcome, "converged")
        self.assertAlmostEqual(abs(own["force"] / known["force"]), 1, delta=1e-8)
        self.assertAlmostEqual(own["height_left"], 2.7e-3, delta=1e-12)
        numpy.testing.assert_allclose(own.curve["height_left"], [2.85e-3, 2.7e-3])
        self.assertEqual(own.main, ["force", "height_left"])

    def test_all_strategies_side_by_side(self):
        compared = elastin.compare(cube(), ["lattice", "standard"], experiment=Squeeze(1e-4), material=MATERIAL)
        self.assertRegex(repr(compared), r"lattice +1\.5758 mN +2\.9000 mm ")
        self.assertEqual(elastin.sweep(cube(), "material.youngs_modulus", [1e3, 2e3], strategy="lattice", experiment=Squeeze(1e-4),
                                       material=MATERIAL)["force"].shape, (2,))

    def test_a_mask_says_which_molecules_it_holds(self):
        class Masked(Squeeze):
            def hold(self, body):
                return [(numpy.isin(numpy.arange(len(body.positions)), molecules), *more)
                        for molecules, *more in super().hold(body)]

        class Short(Squeeze):
            def hold(self, body):
                return [(numpy.ones(3, bool), (0, 0, 0))]

        one, other = (elastin.run(cube(), "lattice", material=MATERIAL, experiment=kind(1e-4)) for kind in (Masked, Squeeze))
        self.assertEqual(dict(one.measures), dict(other.measures))
        with self.assertRaisesRegex(elastin.InputError, "hold: is a mask of 3 truth values"):
            elastin.run(cube(), "lattice", material=MATERIAL, experiment=Short(1e-4))

    def test_slips_are_said(self):
        class Wrong(Squeeze):
            def measure(self, body, positions, reactions):
                return {"froce": 1.0}

        class Twice(Squeeze):
            def hold(self, body):
                return [([0, 1], (0, 0, 0)), ([1], (0, 0, 1e-4))]

        class Unit(Squeeze):
            measures = {"force": "kN"}

        for wrong, message in ((Wrong, "froce"), (Twice, "Twice|twice.hold: molecule 1 is held twice"), (Unit, "'kN' of force is no SI unit")):
            with self.subTest(wrong=wrong.__name__), self.assertRaisesRegex(elastin.InputError, message):
                elastin.run(cube(), "lattice", material=MATERIAL, experiment=wrong(1e-4))


if __name__ == "__main__":
    unittest.main()
