"""The notebook of the examples, cell by cell, as a notebook runs it."""

import ast
import contextlib
import importlib.util
import io
import os
import re
import time
import unittest

import elastin
from helpers import SOURCE

HAS_MATPLOTLIB = importlib.util.find_spec("matplotlib") is not None
if HAS_MATPLOTLIB:
    import matplotlib
    matplotlib.use("Agg")


def cells(path):
    """(kind, source) of each: "code" or "markdown"."""
    with open(path, encoding="utf8") as stream:
        parts = re.split(r"(?m)^# %%(.*)\n", stream.read())[1:]
    return [("markdown" if "[markdown]" in head else "code", source) for head, source in zip(parts[::2], parts[1::2])]


def shown(value):
    """What a notebook would show of it."""
    rich = getattr(value, "_repr_html_", None)
    return rich() if rich else repr(value)


@unittest.skipUnless(HAS_MATPLOTLIB, "matplotlib is missing")
class Tour(unittest.TestCase):
    def test_cell_by_cell(self):
        names, told, missing = {"__name__": "__main__"}, [], []
        listed = cells(f"{SOURCE}/tests/examples/tour.py")
        self.assertEqual(len(listed), 40)
        for number, (kind, source) in enumerate(listed, 1):
            if kind == "markdown":
                self.assertTrue(all(line.startswith("#") for line in source.strip().splitlines()))
                continue
            begin = time.perf_counter()
            tree = ast.parse(source)
            last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
            said = io.StringIO()
            try:
                with contextlib.redirect_stdout(said):
                    exec(compile(tree, f"cell {number}", "exec"), names)
                    value = eval(compile(ast.Expression(last.value), f"cell {number}", "eval"), names) if last else None
            except ImportError as error:  # an optional package
                self.assertRegex(str(error), "needs (pandas|meshio)")
                missing.append(number)
                continue
            if value is not None:
                self.assertTrue(shown(value))
            told.append(f"cell {number}: {time.perf_counter() - begin:.2f} s")
        print("\n".join(told))
        self.check(names)

    def check(self, names):
        """What the cells show is so."""
        positions = abs(names["both"]["mine"].positions - names["both"]["neo_hookean"].positions).max()
        self.assertLess(positions, 1e-12)
        found = {one["name"]: one for one in names["found"]["parameters"]}
        self.assertTrue(found["c1"]["low"] < 0.18e6 < found["c1"]["high"])
        self.assertLess(abs(names["result"]["effective_modulus"] / 120e3 - 1), 0.2)
        self.assertIn("effective_modulus_to_reference", names["clamped"][1].errors)
        self.assertEqual({result.outcome for result in names["comparison"]}, {"converged"})
        self.assertIn("<script", names["page"])
        self.assertTrue(os.path.exists(names["folder"] / "bar.vtu"))
        import shutil
        shutil.rmtree(names["folder"])
        from matplotlib import pyplot
        pyplot.close("all")


if __name__ == "__main__":
    unittest.main()
