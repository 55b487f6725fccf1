"""A wheel of what CMake builds. With ELASTIN_BUILD_DIR in the environment it is taken from there; else the module is built
now, which takes some minutes, in build-wheel next to the other builds."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py
from setuptools.dist import Distribution

ROOT = Path(__file__).resolve().parents[2]
VERSION = re.search(r"project\(elastin VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf8"))[1]


def built():
    """The folder of the package as CMake builds it."""
    build = Path(os.environ.get("ELASTIN_BUILD_DIR") or ROOT / "build-wheel")
    if "ELASTIN_BUILD_DIR" not in os.environ:
        left_out = [f"-DELASTIN_{name}=OFF" for name in ("TESTS", "BENCH", "C", "INSTALL")]
        subprocess.check_call(["cmake", "-S", ROOT, "-B", build, f"-DPython_EXECUTABLE={sys.executable}", "-DELASTIN_UNITY=ON",
                               *left_out])
        subprocess.check_call(["cmake", "--build", build, "--parallel", "--target", "elastin_python"])
    if not list((build / "python/elastin").glob("_elastin*.so")):
        sys.exit(f"{build} has no Python module: CMake says why (python3-dev, python3-numpy and pybind11-dev are needed)")
    return build / "python/elastin"


class BuiltByCMake(build_py):
    def run(self):
        target = Path(self.build_lib) / "elastin"
        shutil.rmtree(target, ignore_errors=True)
        shutil.copytree(built(), target, ignore=shutil.ignore_patterns("__pycache__"))


class OfThisMachine(Distribution):
    def has_ext_modules(self):
        return True


setup(version=VERSION, packages=["elastin"], cmdclass={"build_py": BuiltByCMake}, distclass=OfThisMachine)
