#!/usr/bin/env python3
"""Several processes find the equilibria that one finds, and end together.

  processes_test.py ROOT ELASTIN

The plain engine is the independent solver: another Newton iteration, other preconditioners in single precision. Exit
code 77 (skipped) without mpiexec.
"""
import array
import base64
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree
import zlib

ROOT, ELASTIN = sys.argv[1:3]
TIGHT = "solver: {tolerance: 1e-13, displacements: %s}\n"
LATTICE = "body: {lattice: {kind: cubic, molecules: [7, 6, 9], spacing: 1 cm, connections: [axis, face]}}\n"
HEXAHEDRA = "body: {lattice: {kind: cubic, molecules: [5, 4, 9], spacing: 1 cm, order: 1}}\n"
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
    "hexahedra-small": HEXAHEDRA + SOFT % (0.3, "neo_hookean") + LOADED % "" + TIGHT % "small",
    "hexahedra-large": HEXAHEDRA + SOFT % (0.45, "neo_hookean+volume") + PULLED % ("10 mm", "") +
                       TIGHT.replace("{", "{linear_solver: multigrid, ") % "large",
    "second-order-large": TETRAHEDRA.replace("size:", "order: 2, size:") + SOFT % (0.3, "neo_hookean") +
                          PULLED % ("5 mm", "") + TIGHT % "large",
    "packing-small": PACKING + SOFT % (0.25, '"calibrated:standard"') +
                     "experiment: {kind: tension, axis: z, displacement: 1 mm, grip_depth: 0.5 mm}\n" + TIGHT % "small",
    "packing-large": PACKING + SOFT % (0.25, "standard") +
                     "experiment: {kind: tension, axis: z, displacement: 1 mm, grip_depth: 0.5 mm}\n" + TIGHT % "large",
    "mesh-small": MESH + SOFT % (0.25, "van_gelder") + PULLED % ("1 mm", ", gauge: [22 mm, 38 mm]") + TIGHT % "small",
    "mesh-large": MESH + SOFT % (0.25, "neo_hookean") + PULLED % ("1 mm", ", gauge: [22 mm, 38 mm]") + TIGHT % "large",
}
SMALL_LATTICE = SOFT % (0.25, "lattice") + TIGHT % "small"
SOLID = TETRAHEDRA + SOFT % (0.3, "neo_hookean")
SIDE = "{side: %s}"
# Other experiments, supports and loads: on the plain engine to AGREEMENT too.
OTHERS = {
    "shear-small": LATTICE + SMALL_LATTICE + "experiment: {kind: shear, axis: z, direction: x, strain: 2 %}\n",
    "shear-large": SOLID + TIGHT % "large" +
                   "experiment: {kind: shear, axis: z, direction: y, displacement: 8 mm, load_steps: 2}\n",
    "shear-affine": SOLID + TIGHT % "large" +
                    "experiment: {kind: shear, axis: z, direction: y, strain: 0.1, sides: affine}\n",
    "torsion-large": LATTICE + SOFT % (0.25, "lattice") + TIGHT % "large" +
                     "experiment: {kind: torsion, axis: z, angle: 20 deg}\n",
    "hydrostatic-small": LATTICE + SMALL_LATTICE + "experiment: {kind: hydrostatic, strain: -1 %}\n",
    "hydrostatic-affine": SOLID + TIGHT % "large" + "experiment: {kind: hydrostatic, strain: -5 %, sides: affine}\n",
    "bending-small": LATTICE + SMALL_LATTICE + "experiment: {kind: bending, axis: z, direction: x, force: 1 mN}\n",
    "bending-large": SOLID + TIGHT % "large" +
                     "experiment: {kind: bending, axis: z, direction: x, gravity: 9.81 m/s2, force: 2 mN}\n",
    "biaxial-large": SOLID + TIGHT % "large" + "experiment: {kind: biaxial, strain: [5 %, 8 %]}\n",
    "planar-small": LATTICE + SMALL_LATTICE + "experiment: {kind: planar, strain: 2 %}\n",
    "compression-large": SOLID + TIGHT % "large" +
                         "experiment: {kind: compression, axis: z, strain: 5 %, fixed_grip: clamped}\n",
    "supports-small": LATTICE + SMALL_LATTICE + LOADED % "" +
                      "supports: [{symmetry: x}, {molecules: [3, 100, 370], fix: [y]}, {molecules: " + SIDE % "-y" +
                      ", fix: [y]}, {molecules: {nearest: [3 cm, 2 cm, 4 cm]}}]\n",
    "supports-large": SOLID + TIGHT % "large" + PULLED % ("5 mm", "") +
                      "supports: [{molecules: {box: {from: [0 mm, 0 mm, 10 mm], to: [1 mm, 30 mm, 30 mm]}}, fix: [x]}]\n",
    "mesh-supports": MESH + SOFT % (0.25, "neo_hookean") + TIGHT % "large" +
                     PULLED % ("1 mm", ", gauge: [22 mm, 38 mm]") +
                     "supports: [{molecules: {plane: {point: [0 mm, 0 mm, 30 mm], normal: z, within: 2 mm}}, fix: [z]}]\n",
    "loads-large": SOLID + TIGHT % "large" + PULLED % ("5 mm", "") +
                   "loads: [{point: {molecules: " + SIDE % "x" + ", force: [0 mN, 1 mN, 0 mN]}}, " +
                   "{face: {side: y, traction: [0 Pa, 20 Pa, 5 Pa]}}, {quadratic_drag: {density: 1 kg/m3, " +
                   "drag_coefficient: 1}}]\n",
}
BENT = "experiment: {kind: %s, fixture: {kind: bending, axis: z, direction: x, force: %s}%s}\n"
STRETCHED = "experiment: {kind: release, fixture: {kind: tension, axis: z, displacement: %s, fixed_grip: clamped}}\n"
RAMPED = ("experiment: {kind: relaxation, ramp: 20 ms, fixture: {kind: tension, axis: z, displacement: %s, "
          "fixed_grip: clamped}}\n")
TIME = "time: {duration: %s, frames: 8%s}\n"
# Through time. Explicit steps add a molecule's forces in one order on any number of processes.
EXPLICIT = {
    "release-verlet": LATTICE + SOFT % (0.25, "lattice") + STRETCHED % "5 mm" + TIGHT % "large" + TIME % ("0.1 s", ""),
    "release-euler": SOLID + BENT % ("release", "2 mN", "") + TIGHT % "large" +
                     TIME % ("50 ms", ", stepper: symplectic_euler"),
    "averaged-verlet": TETRAHEDRA + SOFT % (0.45, "neo_hookean+volume") + RAMPED % "2 mm" + TIGHT % "large" +
                       TIME % ("50 ms", ", stepper: velocity_verlet"),
    "hexahedra-verlet": HEXAHEDRA + SOFT % (0.3, "neo_hookean") + RAMPED % "2 mm" + TIGHT % "large" +
                        TIME % ("50 ms", ", stepper: velocity_verlet"),
    "relaxation-verlet": LATTICE + SOFT % (0.25, "lattice") + TIGHT % "large" +
                         TIME % ("0.2 s", ", stepper: velocity_verlet") +
                         "experiment: {kind: relaxation, ramp: 0.1 s, fixture: {kind: shear, axis: z, direction: x, "
                         "strain: 5 %}}\nloads: [{rayleigh: {mass: 5 1/s, stiffness: 1 ms}}, {damping: 1 mN s/m}]\n",
    "shake-verlet": PACKING + SOFT % (0.25, "standard") + TIGHT % "large" + TIME % ("0.1 s", "") +
                    "experiment: {kind: shake, axis: z, direction: x, amplitude: 1 mm, frequency: 20 1/s, "
                    "grip_depth: 0.5 mm}\n",
    "drop-verlet": LATTICE + SOFT % (0.25, "lattice") + TIGHT % "large" + TIME % ("0.1 s", "") +
                   "experiment: {kind: drop, speed: 1 m/s, height: 1 cm, gravity: 9.81 m/s2, "
                   "stiffness: 200 N/m, damping: 0.1 N s/m}\n"
                   "loads: [{stokes_drag: {viscosity: 0.1 Pa s}}]\n",
}
IMPLICIT = {
    "release-newmark": SOLID + BENT % ("release", "100 mN", "") + TIGHT % "large" + TIME % ("50 ms", ""),
    "creep-backward": LATTICE + SOFT % (0.25, "lattice") + BENT % ("creep", "100 mN", "") + TIGHT % "large" +
                      TIME % ("0.2 s", ", stepper: backward_euler, step: 5 ms") + "loads: [{damping: 2 mN s/m}]\n",
    "cyclic-alpha": MESH + SOFT % (0.25, "neo_hookean") + TIGHT % "large" +
                    TIME % ("20 ms", ", stepper: generalized_alpha, step: 0.5 ms") +
                    "experiment: {kind: cyclic, frequency: 50 1/s, fixture: {kind: tension, axis: z, "
                    "displacement: 0.5 mm, gauge: [22 mm, 38 mm]}}\n",
    "drop-newmark": HEXAHEDRA + SOFT % (0.3, "neo_hookean") + TIGHT % "large" +
                    TIME % ("60 ms", ", step: 1 ms") +
                    "experiment: {kind: drop, speed: 1 m/s, height: 1 cm, gravity: 9.81 m/s2}\n",
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
        # A force across the load may vanish: then both are rounding of the force.
        least = 1e-12 * abs(own["measures"].get("force", 0)) if measure == "axial_force" else 0
        close = there is not None and abs(value - there) <= max(tolerance * max(abs(value), abs(there)), least)
        check(close, f"{name}: {measure} is {value!r} {what} and {there!r} otherwise")


def written(folder, scenes):
    """The files of scenes."""
    files = []
    for name, text in scenes.items():
        files.append(os.path.join(folder, name + ".yaml"))
        with open(files[-1], "w", encoding="utf-8") as file:
            file.write(text)
    return files


def run_each(folder, scenes):
    """The runs by name, of the plain engine and on 1, 2 and 4 processes; and the names, none where one could not run."""
    files = written(folder, scenes)
    runs = [runs_of(processes, files) for processes in (0, 1, 2, 4)]
    return runs, list(scenes) if all(runs) else []


def check_measures(folder):
    (plain, one, two, four), names = run_each(folder, SCENES)
    for name in names:
        for processes, shared in ((1, one), (2, two), (4, four)):
            check("petsc" not in plain[name]["solver"] and f"on {processes} process" in shared[name]["solver"],
                  f"{name}: solvers {plain[name]['solver']}, {shared[name]['solver']}")
        compare(name, two[name], plain[name], OTHER_ENGINE, "on 2 processes, by the plain engine")
        for processes, shared in ((2, two), (4, four)):
            compare(name, shared[name], one[name], AGREEMENT, f"on {processes} processes")
            newton, linear = ([run[name][key] for run in (one, shared)] for key in ("iterations", "linear_iterations"))
            check(abs(newton[1] - newton[0]) <= 1, f"{name}: {newton} Newton iterations on 1 and {processes} processes")
            # At this tolerance rounding may need one more solve.
            check(newton[0] != newton[1] or abs(linear[1] - linear[0]) <= max(1, newton[0]),
                  f"{name}: {linear} linear iterations on 1 and {processes} processes")


def check_others(folder):
    (plain, one, two, four), names = run_each(folder, OTHERS)
    for name in names:
        for processes, shared in ((1, one), (2, two), (4, four)):
            check(f"on {processes} process" in shared[name]["solver"] and
                  (processes == 1 or any("its share of the body" in note for note in shared[name]["notes"])),
                  f"{name}: {shared[name]['solver']}, {shared[name].get('notes')}")
            compare(name, shared[name], plain[name], AGREEMENT, f"on {processes} processes, not by the plain engine")


# What is left of energies that cancel: measured against the largest energy.
REMAINDERS = {"energy_balance": "energy"}


def compare_in_time(name, own, other, tolerance, what):
    """Rows of the time history, each measure against its largest value."""
    check(len(own["curve"]) == len(other["curve"]), f"{name}: {len(own['curve'])} rows {what}, {len(other['curve'])}")
    for key, value in other["curve"][-1].items():
        if not isinstance(value, float):
            continue
        rows = [(a.get(key), b.get(key)) for a, b in zip(own["curve"], other["curve"])]
        largest = max(abs(row.get(REMAINDERS.get(key, key)) or 0) for row in other["curve"])
        check(all((a is None and b is None) or abs(a - b) <= tolerance * largest for a, b in rows),
              f"{name}: {key} {what} and otherwise: {rows}, largest {largest}")


def displacements_of(folder, name):
    """Of the last state, by the place at rest."""
    last = sorted(file for file in os.listdir(folder) if file.startswith(name) and file.endswith(".pvtu"))[-1]
    root = xml.etree.ElementTree.parse(os.path.join(folder, last)).getroot()
    found = {}
    for piece in root.iter("Piece"):
        for place, values in by_rest(arrays_of(os.path.join(folder, piece.get("Source"))), "displacement").items():
            found.setdefault(place, set()).add(tuple(values))
    return found


def check_steps(folder):
    """Through time: the same on any number of processes, of explicit steps from rest bit by bit."""
    files = written(folder, {**EXPLICIT, **IMPLICIT})

    def runs(processes):
        out = os.path.join(folder, f"steps-{processes}")
        engine = ["--set", "solver.engine=petsc"] if processes == 1 else []
        done = run(processes, "run", *files, "--json", out + ".json", "--out", out, *engine)
        check(done.returncode == 0, f"steps on {processes} processes: exit code {done.returncode}: {done.stderr.strip()}")
        if done.returncode != 0:
            return {}, out
        with open(out + ".json", encoding="utf-8") as file:
            return {one["scene"]: one for one in json.load(file)["runs"]}, out
    (plain, _), (one, first), (two, second), (four, fourth) = (runs(processes) for processes in (0, 1, 2, 4))
    for name in list(EXPLICIT) + list(IMPLICIT) if plain and one and two and four else []:
        for processes, shared in ((1, one), (2, two), (4, four)):
            compare_in_time(name, shared[name], plain[name], AGREEMENT if name in EXPLICIT else OTHER_ENGINE,
                            f"on {processes} processes, by the plain engine")
            check(processes == 1 or any("its share of the body" in note for note in shared[name]["notes"]),
                  f"{name}: {shared[name].get('notes')}")
            compare_in_time(name, shared[name], one[name], AGREEMENT, f"on {processes} processes, on one")
        explicit = one[name]["time"]["stepper"] in ("velocity_verlet", "symplectic_euler")
        check(explicit == (name in EXPLICIT), f"{name}: steps by {one[name]['time']['stepper']}")
        if name in EXPLICIT and not name.startswith("release"):  # which begins with an equilibrium
            alone = displacements_of(first, name)
            for where in (second, fourth):
                together = displacements_of(where, name)
                check(all(len(values) == 1 for values in together.values()), f"{name}: ghosts are not what they ghost")
                check(alone == together, f"{name}: the states of {where} are not those of one process, bit by bit")


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
    timed = os.path.join(folder, "release-newmark.yaml")
    refused("'multigrid' does not go with steps in time", 2, "run", timed, "--set", "solver.linear_solver=multigrid")
    refused("write no restart files", 2, "run", timed, "--set", "time.checkpoint=2")
    refused("would choose different steps", 2, "run", timed, "--set", "time.step=1 ms", "--set", "time.budget=1 ms",
            "--set", "time.stepper=newmark")
    scattered = os.path.join(folder, "scattered.yaml")
    with open(timed, encoding="utf-8") as text, open(scattered, "w", encoding="utf-8") as file:
        file.write(text.read() + "initial: {scatter: {amount: 0.1 mm}}\n")
    refused("`initial` is read on the whole body; write engine: threads", 2, "run", scattered)
    done = run(2, "run", timed, "--set", "time.stepper=xpbd")
    check(done.returncode == 1 and "those that step shares are symplectic_euler" in done.stdout + done.stderr,
          f"xpbd: exit code {done.returncode}: {done.stdout}{done.stderr}")
    contact = os.path.join(ROOT, "scenes/contact/indentation-flat.yaml")
    refused("without contact, which stays on one process", 0, "run", contact, "--set", "solver.engine=petsc")


def numbers_of(item):
    """The numbers of a DataArray of packed blocks."""
    text = "".join(item.text.split())
    counts = array.array("Q", base64.b64decode(text[:44])[:24])
    sizes = array.array("Q")
    if counts[0]:
        head = -(-8 * (3 + counts[0]) // 3) * 4  # letters
        sizes = array.array("Q", base64.b64decode(text[:head]))[3:]
        packed = base64.b64decode(text[head:])
    data, at = b"", 0
    for size in sizes:
        data += zlib.decompress(packed[at:at + size])
        at += size
    kinds = {"Float64": "d", "Int64": "q", "Int32": "i", "UInt8": "B"}
    return array.array(kinds[item.get("type")], data)


def arrays_of(path):
    """By name: components, and numbers."""
    root = xml.etree.ElementTree.parse(path).getroot()
    return {item.get("Name"): (int(item.get("NumberOfComponents")), numbers_of(item)) for item in root.iter("DataArray")}


def by_rest(arrays, name):
    """Values of molecules by where they were at rest, in micrometres."""
    positions, displacement = arrays["positions"][1], arrays["displacement"][1]
    components, values = arrays[name]
    return {tuple(round(1e6 * (positions[i + k] - displacement[i + k])) for k in range(3)):
            values[components * (i // 3):components * (i // 3 + 1)] for i in range(0, len(positions), 3)}


def check_files(folder):
    """Process 0 writes the tables, each process its piece of the states: together they are the file of one process."""
    for name in ("springs-small", "volume-large", "solid-large"):
        scene, out, plain = (os.path.join(folder, name + end) for end in (".yaml", "-2", "-0"))
        for processes, where in ((2, out), (0, plain)):
            done = run(processes, "run", scene, "--out", where)
            check(done.returncode == 0 and done.stdout.count("effective_modulus") <= 1 and
                  os.path.exists(where + "/runs.json"),
                  f"{name}, --out on {processes} processes: exit code {done.returncode}, {done.stdout}{done.stderr}")
        whole_file = sorted(file for file in os.listdir(plain) if file.endswith(".vtu"))[-1]
        together = os.path.join(out, whole_file.replace(".vtu", ".pvtu"))
        if not os.path.exists(together):
            check(False, f"{name}: no {together}, but {sorted(os.listdir(out))}")
            continue
        root = xml.etree.ElementTree.parse(together).getroot()
        pieces = [arrays_of(os.path.join(out, piece.get("Source"))) for piece in root.iter("Piece")]
        whole = arrays_of(os.path.join(plain, whole_file))
        declared = {item.get("Name") for item in root.iter("PDataArray")}
        check(len(pieces) == 2 and all(declared | {"connectivity", "offsets", "types"} == set(piece) == set(whole)
                                       for piece in pieces), f"{name}: the pieces have other arrays than {declared}")
        for kind in (3, 10):
            counts = [list(arrays["types"][1]).count(kind) for arrays in [whole] + pieces]
            check(counts[0] == sum(counts[1:]) and (counts[0] == 0 or min(counts) > 0),
                  f"{name}: of cells of type {kind} there are {counts} in the whole and the pieces")
        for point_array in ("displacement", "elastic_force", "mass"):
            expected = by_rest(whole, point_array)
            size = max(abs(value) for values in expected.values() for value in values)
            places = set()
            for piece in pieces:
                for place, values in by_rest(piece, point_array).items():
                    places.add(place)
                    check(place in expected and
                          all(abs(a - b) <= 1e-7 * size for a, b in zip(values, expected[place])),
                          f"{name}: {point_array} at {place} is {list(values)}, not {expected.get(place)}")
            check(places == set(expected), f"{name}: the pieces have {len(places)} of {len(expected)} molecules")
        for cell_array in ("strain", "tension") + (("von_mises",) if "von_mises" in whole else ()):
            sums = [sum(abs(value) for value in arrays[cell_array][1]) for arrays in [whole] + pieces]
            check(abs(sums[0] - sum(sums[1:])) <= 1e-7 * sums[0], f"{name}: the sums of {cell_array} are {sums}")


def check_shares(folder):
    """Each process has its share of a body alone, or says why not."""
    def note_of(text, processes=2):
        scene = os.path.join(folder, "shared.yaml")
        with open(scene, "w", encoding="utf-8") as file:
            file.write(text)
        done = run(processes, "run", scene, "--json", "-")
        check(done.returncode == 0, f"exit code {done.returncode}: {done.stderr}")
        one = json.loads(done.stdout)["runs"][0] if done.returncode == 0 else {"notes": []}
        return next((note for note in one["notes"] if note.startswith("each of")), "none"), one
    for name in SCENES:
        note, one = note_of(SCENES[name])
        made = "which it made alone" if LATTICE in SCENES[name] else "from the first"
        check("its share of the body" in note and made in note, f"{name}: {note}")
        plain = json.loads(run(0, "run", os.path.join(folder, name + ".yaml"), "--json", "-").stdout)["runs"][0]
        for count in ("molecules", "connections", "cells"):
            check(one.get(count) == plain.get(count), f"{name}: {count} {one.get(count)}, not {plain.get(count)}")
    homogenised = "experiment: {kind: material}\n"
    with open(os.path.join(ROOT, "scenes/scans/ball.yaml"), encoding="utf-8") as file:
        ball = file.read().replace("file: ball.nrrd", f"file: {ROOT}/scenes/scans/ball.nrrd")
    for text, why in ((PACKING + SOFT % (0.25, "voronoi") + LOADED % "" + TIGHT % "small", "its Voronoi cells are those"),
                      (LATTICE + SOFT % (0.25, "patch") + LOADED % "" + TIGHT % "small", "equations join all"),
                      (LATTICE + SOFT % (0.25, "lattice") + homogenised + TIGHT % "small",
                       "the experiment is measured on"),
                      (MESH + SOFT % (0.25, "van_gelder") + LOADED % "" + TIGHT % "small" +
                       "supports: [{molecules: {set: specimen}, fix: [x]}]\n", "sets of molecules are read"),
                      (ball, "sets of molecules are read")):
        scene = os.path.join(folder, "whole.yaml")
        with open(scene, "w", encoding="utf-8") as file:
            file.write(text)
        done = run(2, "run", scene, "--json", "-")
        check(why in done.stdout + done.stderr, f"not '{why}': {done.stdout}{done.stderr}")


PEAK = """import resource, subprocess, sys
code = subprocess.call(sys.argv[2:], stdout=subprocess.DEVNULL)
with open(sys.argv[1], "a") as file: file.write("%d\\n" % resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
sys.exit(code)
"""


def check_memory(folder):
    """What each process holds of a large body falls with their number: here 50³ molecules compared with 9³."""
    text = SOFT % (0.25, "lattice") + PULLED % ("1 mm", "") + "solver: {displacements: small, tolerance: 1e-6}\n"
    script = os.path.join(folder, "peak.py")
    with open(script, "w", encoding="utf-8") as file:
        file.write(PEAK)
    def peak(side, processes):
        scene, peaks = (os.path.join(folder, f"memory-{side}-{processes}{end}") for end in (".yaml", ".txt"))
        with open(scene, "w", encoding="utf-8") as file:
            file.write(LATTICE.replace("[7, 6, 9]", f"[{side}, {side}, {side}]") + text)
        done = subprocess.run(["mpiexec", "-n", str(processes), sys.executable, script, peaks, ELASTIN, "run", scene,
                               "--set", "solver.engine=petsc", "--quiet"], env=environment(), timeout=300,
                              capture_output=True, text=True)
        check(done.returncode == 0, f"{processes} processes: exit code {done.returncode}: {done.stderr}")
        with open(peaks, encoding="utf-8") as file:
            return max(int(line) for line in file)
    one, four = (peak(50, processes) - peak(9, processes) for processes in (1, 4))
    check(four < 0.4 * one, f"a process holds {four} kB of 50³ molecules with 4 processes, {one} kB alone")


def check_broken_files(folder):
    """What one process cannot read or write ends all, and is said once."""
    mesh = os.path.join(folder, "cut.msh")
    with open(os.path.join(ROOT, "scenes/tension/dogbone.msh"), "rb") as file:
        whole = file.read()
    with open(mesh, "wb") as file:
        file.write(whole[:len(whole) // 2])
    scene = os.path.join(folder, "cut.yaml")
    with open(scene, "w", encoding="utf-8") as file:
        file.write(SCENES["mesh-small"].replace(ROOT + "/scenes/tension/dogbone.msh", mesh))
    done = run(2, "run", scene, seconds=60)
    check(done.returncode == 2 and done.stderr.count("cut.msh") == 1,
          f"a cut mesh: exit code {done.returncode}, not named once: {done.stdout}{done.stderr}")
    out = os.path.join(folder, "taken")
    taken = os.path.join(out, "springs-small-lattice-001.p1.vtu")
    os.makedirs(os.path.join(taken, "inside"))
    done = run(2, "run", os.path.join(folder, "springs-small.yaml"), "--out", out, seconds=60)
    check(done.returncode == 2 and done.stderr.count(taken + ": cannot write") == 1 and
          not os.path.exists(taken.replace(".p1.vtu", ".pvtu")) and
          os.path.exists(taken.replace("001.p1.vtu", "000.pvtu")),
          f"a piece that cannot be written: exit code {done.returncode}, {sorted(os.listdir(out))}: {done.stderr}")
    done = run(2, "run", os.path.join(folder, "springs-small.yaml"), "--json", "/dev/full", seconds=60)
    check(done.returncode != 0 and done.stderr.count("No space left on device") == 1,
          f"a full disk: exit code {done.returncode}, not named once: {done.stdout}{done.stderr}")


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
        check_others(folder)
        check_steps(folder)
        check_preconditioner(folder)
        check_buckling()
        check_refusals(folder)
        check_files(folder)
        check_shares(folder)
        check_memory(folder)
        check_broken_files(folder)
        check_kill(folder)
    sys.exit(1 if failures else 0)


main()
