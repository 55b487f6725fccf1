"""Sweeps over several keys, here and on workers."""

import concurrent.futures
import multiprocessing
import os
import pickle
import unittest

import elastin
from helpers import CUBE, runs_of_command

try:
    from distributed import Client, LocalCluster
except ImportError:
    Client = None

GRID = {"body.lattice.molecules": [[3, 3, 3], [4, 3, 3]], "material.youngs_modulus": [1e3, 5e3]}


def numbers(swept):
    """All that a sweep has found, but for times."""
    return [(result.scene, result.strategy, result.outcome, result.cause, result.measures, result.errors,
             result.warnings, result.newton_iterations, result.linear_iterations, result.positions.tolist(),
             {name: column.tolist() for name, column in result.curve.items()}) for result in swept]


def can_be_sent():
    try:
        pickle.dumps(elastin.run(CUBE))
    except TypeError:
        return False
    return True


class Grid(unittest.TestCase):
    def test_rows_are_those_of_the_command(self):
        swept = elastin.sweep(CUBE, GRID, strategy=["standard", "angles"])
        command = runs_of_command("compare", CUBE, "--strategies", "standard,angles", "--vary",
                                  "body.lattice.molecules=[[3, 3, 3], [4, 3, 3]]", "--vary",
                                  "material.youngs_modulus=[1000, 5000]")
        self.assertEqual(len(swept), 8)
        self.assertEqual([(result.strategy, dict(result.measures)) for result in swept],
                         [(run["strategy"], run["measures"]) for run in command])
        self.assertEqual(swept.changes[2], {"body.lattice.molecules": [3, 3, 3], "material.youngs_modulus": 5e3})
        self.assertEqual(swept.key, "body.lattice.molecules")

    def test_columns(self):
        swept = elastin.sweep(CUBE, GRID)
        columns = swept.columns()
        self.assertEqual(columns["material.youngs_modulus"], [1e3, 5e3, 1e3, 5e3])
        self.assertEqual(list(columns["effective_modulus"]), list(swept["effective_modulus"]))
        self.assertEqual({len(column) for column in columns.values()}, {4})
        self.assertIn("material.youngs_modulus", repr(swept).splitlines()[1])

    def test_one_key_is_as_it_was(self):
        one, two = elastin.sweep(CUBE, "material.youngs_modulus", [1e3, 5e3]), elastin.sweep(
            CUBE, {"material.youngs_modulus": (1e3, 5e3)})
        self.assertEqual(numbers(one), numbers(two))
        self.assertEqual(one.values, [1e3, 5e3])

    def test_wrong_input(self):
        with self.assertRaisesRegex(elastin.InputError, "youngs_modulus"):
            elastin.sweep(CUBE, {"material.youngs_modul": [1e3]})
        with self.assertRaisesRegex(elastin.InputError, "'material' would replace 'material.youngs_modulus'"):
            elastin.sweep(CUBE, {"material.youngs_modulus": [1e3], "material": [{"youngs_modulus": 2e3}]})
        with self.assertRaisesRegex(elastin.InputError, r"write a list of them, \['1 kPa'\]"):
            elastin.sweep(CUBE, "material.youngs_modulus", "1 kPa")


class Workers(unittest.TestCase):
    def hold_against_serial(self, client):
        told = []
        swept = elastin.sweep(os.path.relpath(CUBE), GRID, strategy=["standard", "angles"], client=client,
                              progress=told.append)
        self.assertEqual(numbers(swept), numbers(elastin.sweep(CUBE, GRID, strategy=["standard", "angles"])))
        self.assertEqual(told[-1], "8 of 8 rows")
        with self.assertRaisesRegex(elastin.InputError, "did you mean 'youngs_modulus'"):
            elastin.sweep(CUBE, {"material.youngs_modul": [1e3, 2e3]}, client=client)

    def test_threads(self):
        with concurrent.futures.ThreadPoolExecutor(2) as client:
            self.hold_against_serial(client)

    @unittest.skipUnless(can_be_sent(), "results cannot be sent from one process to another")
    def test_processes(self):
        spawn = multiprocessing.get_context("spawn")
        with concurrent.futures.ProcessPoolExecutor(2, mp_context=spawn) as client:
            self.hold_against_serial(client)

    @unittest.skipUnless(Client, "needs dask.distributed (Debian: python3-distributed)")
    def test_dask(self):
        processes = can_be_sent()
        with LocalCluster(2, processes=processes, threads_per_worker=1, dashboard_address=None) as cluster:
            with Client(cluster) as client:
                self.hold_against_serial(client)


if __name__ == "__main__":
    unittest.main()
