"""A wheel that pip makes of the module, installed into an empty environment: it runs a scene from there."""

import importlib.util
import os
import subprocess
import sys
import tempfile
import unittest

import elastin
from helpers import CUBE, SOURCE

BUILD = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(elastin.__file__))))
THERE = all(importlib.util.find_spec(name) for name in ("pip", "setuptools", "wheel", "venv", "ensurepip"))


@unittest.skipUnless(THERE, "pip, setuptools, wheel or venv is missing")
class Wheel(unittest.TestCase):
    def said_by(self, *command, **environment):
        clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        ended = subprocess.run(command, env=clean | environment, capture_output=True, text=True, check=False)
        self.assertEqual(ended.returncode, 0, ended.stdout + ended.stderr)
        return ended.stdout

    def test_installed_into_an_empty_environment(self):
        """numpy alone comes from the system: there may be no network."""
        with tempfile.TemporaryDirectory() as folder:
            sources = os.path.join(folder, "src", "python")  # setuptools writes next to what it builds
            import shutil
            shutil.copytree(f"{SOURCE}/src/python", sources)
            shutil.copy(f"{SOURCE}/CMakeLists.txt", folder)
            self.said_by(sys.executable, "-m", "pip", "wheel", "--no-index", "--no-build-isolation", "--no-deps",
                         "--wheel-dir", folder, sources, ELASTIN_BUILD_DIR=BUILD)
            (wheel,) = [name for name in os.listdir(folder) if name.endswith(".whl")]
            self.assertTrue(wheel.startswith(f"elastin-{elastin.__version__}-cp3"))
            place = os.path.join(folder, "venv")
            self.said_by(sys.executable, "-m", "venv", place)
            python = os.path.join(place, "bin", "python")
            self.said_by(python, "-m", "pip", "install", "--no-index", "--no-deps", os.path.join(folder, wheel))
            numpy = os.path.dirname(os.path.dirname(importlib.util.find_spec("numpy").origin))
            program = ("import sys; sys.path.append(sys.argv[1]); import elastin; "
                       "print(elastin.__file__); print(elastin.run(sys.argv[2])['effective_modulus'])")
            file, modulus = self.said_by(python, "-c", program, numpy, CUBE).split()
            self.assertTrue(os.path.realpath(file).startswith(os.path.realpath(place)), file)
            self.assertEqual(float(modulus), elastin.run(CUBE)["effective_modulus"])


if __name__ == "__main__":
    unittest.main()
