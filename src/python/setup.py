"""A wheel of what CMake builds. With ELASTIN_BUILD_DIR in the environment (relative to the project) it is taken from there;
else the module is built now, which takes some minutes, in build-wheel next to the other builds. Either must be built for the
Python that asks."""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py
from setuptools.dist import Distribution

ROOT = Path(__file__).resolve().parents[2]
VERSION = re.search(r"project\(elastin VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf8"))[1]


def built():
    """The folder of the package as CMake builds it."""
    given = os.environ.get("ELASTIN_BUILD_DIR")
    build = ROOT / (given or "build-wheel")
    if not given:
        left_out = [f"-DELASTIN_{name}=OFF" for name in ("TESTS", "BENCH", "C", "INSTALL")]
        if importlib.util.find_spec("pybind11"):
            left_out.append("-Dpybind11_DIR=" + importlib.import_module("pybind11").get_cmake_dir())
        subprocess.check_call(["cmake", "-S", ROOT, "-B", build, f"-DPython_EXECUTABLE={sys.executable}", "-DELASTIN_UNITY=ON",
                               *left_out])
        subprocess.check_call(["cmake", "--build", build, "--parallel", "--target", "elastin_python"])
    wanted = "_elastin" + sysconfig.get_config_var("EXT_SUFFIX")
    if not (build / "python/elastin" / wanted).exists():
        others = ", ".join(one.name for one in (build / "python/elastin").glob("_elastin*.so"))
        sys.exit(f"{build} has no {wanted}, the module for {sys.executable}"
                 + (f"; it has {others}, of another Python" if others else
                    ": CMake says why (Python's headers, numpy and pybind11 are needed)"))
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
