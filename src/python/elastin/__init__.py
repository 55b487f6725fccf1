"""Elastin: soft tissue as molecules joined by connections, and the modulus it really has.

Quantities are in SI units. Arrays of places are (n, 3), one row a molecule; views never copy.

    import elastin
    result = elastin.run("scenes/tension/cube-1000.yaml", strategy="lattice")
    result["effective_modulus"]                                   # [Pa]
    elastin.compare("scenes/tension/cube-1000.yaml")              # every strategy of the scene, side by side
    elastin.sweep("scenes/tension/cube-1000.yaml", "material.youngs_modulus", [1e3, 5e3, 1e4])
    elastin.identify("scenes/identify/treloar-ogden.yaml")        # the material of measured curves

    bar = elastin.body({"tetrahedra": {"kind": "kuhn", "cubes": [2, 2, 6], "size": ["4 mm", "4 mm", "12 mm"]}})
    mine = elastin.law("mine", lambda I1, J, mu, lam: mu/2*(I1 - 3) - mu*numpy.log(J) + lam/2*(J - 1)**2)
    elastin.compare(bar, ["neo_hookean", mine], experiment=elastin.Tension(axis="z", strain=0.15, grips="clamped"),
                    material=elastin.Material(5e3, 0.3))          # no file: bodies, dicts, laws of one's own

    body = elastin.lattice((5, 5, 5), spacing=1e-3)
    tissue = elastin.Simulation(body, "lattice", elastin.Material(5e3))
    tissue.add_load("gravity", acceleration=(0, 0, -9.81))
    tissue.step(1e-3)
"""

import os as _os

import numpy as _numpy  # here, where Python says that it is missing: the library below cannot

# Threads that wait shall soon sleep: one that spins keeps a busy machine from running the one it waits for. OpenMP
# reads this when it is loaded.
if "OMP_WAIT_POLICY" not in _os.environ:
    _os.environ.setdefault("GOMP_SPINCOUNT", "3000")

from ._elastin import (Body, Catalog, InputError, Load, Material, MissingFileError, Parameter, Result, Row, Simulation, SimulationState,
                       StaticResult, StepError, StepResult, Stepper, Strategy, Surface, TopologyReport, Trajectory, __version__, linear_solvers, loads,
                       material_laws, measures, numbered_in_space, of_labels, of_parts, order_in_space, set_threads, steppers, threads)
from . import _bodies, _simulation  # the methods that Python adds to classes of C++
from ._bodies import body, lattice, material, read_mesh
from ._experiments import CLASSES as _experiments, Experiment, experiments
from ._identify import Identification, identify
from ._laboratory import Comparison, Laboratory, Verdicts, compare, export, gradient, measure, run, strategies, verify
from ._law import law, where
from ._own import load, stepper
from ._pictures import View
from ._simulation import step_all
from ._sweep import Sweep, sweep

globals().update(_experiments)

__all__ = ["Body", "Catalog", "Comparison", "Experiment", "Identification", "InputError", "Laboratory", "Load", "Material", "MissingFileError", "Parameter", "Result",
           "Row", "Simulation", "SimulationState", "StaticResult", "StepError", "StepResult", "Stepper", "Strategy", "Surface", "Sweep",
           "TopologyReport", "Trajectory", "Verdicts", "View", "body", "compare", "experiments", "export", "gradient", "identify", "lattice", "law", "linear_solvers", "load",
           "loads", "material", "material_laws", "measure", "measures", "numbered_in_space", "of_labels", "of_parts", "order_in_space", "read_mesh", "run",
           "set_threads", "step_all", "stepper", "steppers", "strategies", "sweep", "threads", "verify", "where", *_experiments]
