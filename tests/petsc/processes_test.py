#!/usr/bin/env python3
"""Several processes find the equilibria that one finds, and end together.

  processes_test.py ROOT ELASTIN

The plain engine is the independent solver: another Newton iteration, other preconditioners in single precision. Exit
code 77 (skipped) without mpiexec.
"""
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time

ROOT, ELASTIN = sys.argv[1:3]
TIGHT = "solver: {tolerance: 1e-13, displacements: %s}\n"
LATTICE = "body: {lattice: {kind: cubic, molecules: [7, 6, 9], spacing: 1 cm, connections: [axis, face]}}\n"
TETRAHEDRA = "body: {tetrahedra: {kind: body_centred, cubes: [3, 3, 4], size: [30 mm, 30 mm, 40 mm]}}\n"
PACKING = "body: {packing: {size: [20 mm, 20 mm, 20 mm], distance: 2.5 mm, seed: 1, connections: {within: 4 mm}}}\n"
MESH = "body: {mesh: {file: %s/scenes/tension/dogbone.msh, length_unit: mm}}\n" % ROOT
PULLED = "experiment: {kind: tension, axis: z, displacement: %s, fixed_grip: clamped, loaded_grip: clamped%s}\n"
LOADED = "experiment: {kind: tension, axis: z, force: 40 mN%s}\n"
SOFT = "material: {youngs_modulus: 10 kPa, poissons_ratio: %s, density: 1000 kg/m3}\nstiffness: %s\n"
SCENES = {
    "springs-small": LATTICE + SOFT % (0.25, "lattice") + LOADED % "" + TIGHT % "small",
    "springs-large": LATTICE + SOFT % (0.25, "lattice") + PULLED % ("15 mm", ", load_steps: 2") + TIGHT % "large",
    "boxes-small": LATTICE + SOFT % (0.25, "lattice") + LOADED % "" +  # whose free motions the plain engine feels at 1e-13
                   "solver: {linear_solver: multigrid, displacements: small, tolerance: 1e-10}\n",
    "weight-large": LATTICE + SOFT % (0.25, "lattice") + PULLED % ("5 mm", "") + TIGHT % "large" +
                    "loads: [{gravity: {acceleration: [0 m/s2, 3 m/s2, -9.81 m/s2]}}]\n",
    "volume-small": LATTICE + SOFT % (0.45, "lattice+volume") + LOADED % "" + TIGHT % "small",
    "volume-large": LATTICE + SOFT % (0.45, "lattice+volume") + PULLED % ("10 mm", "") +
                    TIGHT.replace("{", "{linear_solver: multigrid, ") % "large",
    "solid-small": TETRAHEDRA + SOFT % (0.3, "neo_hookean") + LOADED % "" + TIGHT % "small",
    "solid-large": TETRAHEDRA + SOFT % (0.3, "neo_hookean") + PULLED % ("10 mm", "") + TIGHT % "large",
    "averaged-large": TETRAHEDRA + SOFT % (0.45, "neo_hookean+volume") + PULLED % ("5 mm", "") + TIGHT % "large",
    "packing-small": PACKING + SOFT % (0.25, '"calibrated:standard"') +
                     "experiment: {kind: tension, axis: z, displacement: 1 mm, grip_depth: 0.5 mm}\n" + TIGHT % "small",
    "packing-large": PACKING + SOFT % (0.25, "standard") +
                     "experiment: {kind: tension, axis: z, displacement: 1 mm, grip_depth: 0.5 mm}\n" + TIGHT % "large",
    "mesh-small": MESH + SOFT % (0.25, "van_gelder") + PULLED % ("1 mm", ", gauge: [22 mm, 38 mm]") + TIGHT % "small",
    "mesh-large": MESH + SOFT % (0.25, "neo_hookean") + PULLED % ("1 mm", ", gauge: [22 mm, 38 mm]") + TIGHT % "large",
}
AGREEMENT = 1e-10  # between numbers of processes, as the tolerance of 1e-13 allows
# The plain engine's solves end elsewhere within the tolerance; what is measured sees that, and its own cancellation.
OTHER_ENGINE = 1e-8
BALANCE = "reaction_balance"  # a remainder: rounding alone

failures = []


def check(holds, what):
    if not holds:
        failures.append(what)
        print("FAILED: " + what)


def environment():
    return dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_btl_vader_single_copy_mechanism="none",
                OMPI_MCA_plm="isolated", OMPI_MCA_mpi_yield_when_idle="1")


def command(processes, *arguments):
    return (["mpiexec", "-n", str(processes)] if processes else []) + [ELASTIN, *arguments]


def run(processes, *arguments, seconds=300, **variables):
    return subprocess.run(command(processes, *arguments), env=dict(environment(), **variables), capture_output=True,
                          text=True, timeout=seconds)


def runs_of(processes, files, **variables):
    engine = ["--set", "solver.engine=petsc"] if processes == 1 else []
    done = run(processes, "run", *files, "--json", "-", *engine, **variables)
    check(done.returncode == 0, f"{processes} processes: exit code {done.returncode}: {done.stderr.strip()}")
    return {one["scene"]: one for one in json.loads(done.stdout)["runs"]} if done.returncode == 0 else {}


def compare(name, own, other, tolerance, what):
    for measure, value in own["measures"].items():
        if measure == BALANCE:
            continue
        there = other["measures"].get(measure)
        close = there is not None and abs(value - there) <= tolerance * max(abs(value), abs(there))
        check(close, f"{name}: {measure} is {value!r} {what} and {there!r} otherwise")


def check_measures(folder):
    files = []
    for name, text in SCENES.items():
        files.append(os.path.join(folder, name + ".yaml"))
        with open(files[-1], "w", encoding="utf-8") as file:
            file.write(text)
    plain, one, two, four = (runs_of(processes, files) for processes in (0, 1, 2, 4))
    for name in SCENES if plain and one and two and four else []:
        for processes, shared in ((1, one), (2, two), (4, four)):
            check("petsc" not in plain[name]["solver"] and f"on {processes} process" in shared[name]["solver"],
                  f"{name}: solvers {plain[name]['solver']}, {shared[name]['solver']}")
        compare(name, two[name], plain[name], OTHER_ENGINE, "on 2 processes, by the plain engine")
        for processes, shared in ((2, two), (4, four)):
            compare(name, shared[name], one[name], AGREEMENT, f"on {processes} processes")
            iterations = [run[name]["linear_iterations"] for run in (one, shared)]
            check(abs(iterations[1] - iterations[0]) <= max(1, one[name]["iterations"]),
                  f"{name}: {iterations} linear iterations on 1 and {processes} processes")


def check_preconditioner(folder):
    """Whatever PETSc preconditions with, the equilibrium is the same."""
    names = ["springs-small", "volume-small", "solid-large"]
    files = [os.path.join(folder, name + ".yaml") for name in names]
    plain, shared = runs_of(0, files), runs_of(2, files, PETSC_OPTIONS="-elastin_pc_type gamg")
    for name in names if plain and shared else []:
        check("gamg" in shared[name]["solver"], f"{name}: solver {shared[name]['solver']}, not by gamg")
        compare(name, shared[name], plain[name], OTHER_ENGINE, "by gamg")


def check_buckling():
    """The straight column is an equilibrium and no minimum: the force that the scene expects is that of the bent one."""
    done = run(1, "run", os.path.join(ROOT, "scenes/hard/buckling.yaml"), "--set", "solver.engine=petsc")
    check(done.returncode == 0, f"buckling: exit code {done.returncode}, {done.stdout}{done.stderr}")


def check_refusals(folder):
    scene = os.path.join(folder, "springs-small.yaml")
    def refused(words, processes, *arguments):
        done = run(processes, *arguments)
        said = done.stderr + done.stdout
        check(done.returncode == 2 and words in said and said.count(words) == 1,
              f"{arguments}: exit code {done.returncode}, not once '{words}':\n{said}")
    refused("did you mean 'petsc'?", 0, "run", scene, "--set", "solver.engine=petcs")
    refused("'direct' does not go with engine: petsc", 0, "run", scene, "--set", "solver.engine=petsc", "--set",
            "solver.linear_solver=direct")
    refused("can only `run` scenes together", 2, "compare", scene)
    refused("leaves all but one of the 2 processes without work", 2, "run", scene, "--set", "solver.engine=threads")
    refused("unknown key", 2, "run", scene, "--set", "solver.toleranc=1e-3")
    contact = os.path.join(ROOT, "scenes/contact/indentation-flat.yaml")
    refused("without contact, which stays on one process", 0, "run", contact, "--set", "solver.engine=petsc")


def check_files(folder):
    """Process 0 alone writes."""
    out = os.path.join(folder, "out")
    done = run(2, "run", os.path.join(folder, "springs-small.yaml"), "--out", out)
    check(done.returncode == 0 and done.stdout.count("effective") <= 1 and os.path.exists(out + "/runs.json"),
          f"--out on 2 processes: exit code {done.returncode}, {done.stdout}{done.stderr}")


def check_kill(folder):
    """A process that is killed ends the run: mpiexec says so, and nobody waits."""
    long_run = os.path.join(folder, "long.yaml")
    with open(long_run, "w", encoding="utf-8") as file:
        file.write(LATTICE.replace("[7, 6, 9]", "[30, 30, 30]") + SOFT % (0.25, "lattice") +
                   PULLED % ("100 mm", ", load_steps: 1000") + TIGHT % "large")
    started = subprocess.Popen(command(2, "run", long_run, "--quiet"), env=environment(), stderr=subprocess.PIPE,
                               text=True, start_new_session=True)
    try:
        children = []
        while len(children) < 2 and started.poll() is None:
            time.sleep(0.2)
            with open(f"/proc/{started.pid}/task/{started.pid}/children", encoding="utf-8") as file:
                children = file.read().split()
        time.sleep(3)
        check(started.poll() is None, "the long run was over before it could be killed")
        os.kill(int(children[-1]), signal.SIGKILL)
        said = started.communicate(timeout=60)[1]
        check(started.returncode != 0 and "exited on signal 9" in said,
              f"a killed process: exit code {started.returncode}: {said}")
    except subprocess.TimeoutExpired:
        check(False, "a killed process left the others waiting")
    finally:
        if started.poll() is None:
            os.killpg(started.pid, signal.SIGKILL)


def main():
    if not shutil.which("mpiexec"):
        sys.exit(77)
    with tempfile.TemporaryDirectory() as folder:
        check_measures(folder)
        check_preconditioner(folder)
        check_buckling()
        check_refusals(folder)
        check_files(folder)
        check_kill(folder)
    sys.exit(1 if failures else 0)


main()
