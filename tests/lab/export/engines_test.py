"""engines_test.py COMMAND: constants that are exported for engines, read again by parsers that are not Elastin's, and
engines as rows of a comparison.

LAMMPS, and node with its packages, take part where they are installed.
"""

import csv
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

COMMAND = pathlib.Path(sys.argv[1]).resolve()
BAR = """title: a bar
body: {lattice: {kind: cubic, molecules: [4, 4, 6], spacing: 10 mm, connections: [axis, face]}}
material: {youngs_modulus: 100 kPa, poissons_ratio: 0.25, density: 1000 kg/m3}
stiffness: lattice
strategies: [lattice]
experiment: {kind: tension, axis: z, force: 0.9 mN}
reference: none
"""
# One connection of a bar of E = 5 kPa, A = 9 cm2, L = 15 mm: k = E A / L = 300 N/m.
ONE = """body:
  lattice: {kind: cubic, molecules: [1, 1, 2], spacing: 15 mm, connections: [axis]}
  radius: 15 mm
material: {youngs_modulus: 5 kPa}
stiffness: standard
experiment: {kind: tension, axis: z, force: 1 N, fixed_grip: clamped, cross_section: 9 cm2, gauge_length: 15 mm}
reference: none
"""


def node_has(package):
    return f"node -e 'require(\"module\").createRequire(process.cwd() + \"/\").resolve(\"{package}\")'"


ENGINES = {"jolt": node_has("jolt-physics"), "rapier": node_has("@dimforge/rapier3d-compat"),
           "mujoco": node_has("@mujoco/mujoco"), "bullet": "pkg-config --exists bullet && command -v c++",
           "lammps": "command -v lmp"}
CELLS = "body.lattice={kind: cubic, molecules: [4, 4, 6], spacing: 10 mm, order: 1}"


def is_here(name):
    return subprocess.run(ENGINES[name], shell=True, capture_output=True).returncode == 0


def near(got, expected, tolerance=1e-9):
    assert abs(got - expected) <= tolerance * abs(expected), f"{got}, and not {expected}"


def elastin(*arguments, status=0):
    done = subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == status, f"{arguments}: {done.returncode} {done.stderr}"
    return done.stdout + done.stderr


def export(scene, name, *more):
    folder = scene.parent / f"{scene.stem}-{name}"
    elastin("export", scene, "--to", name, "--out", folder, *more)
    readme = (folder / "README.md").read_text()
    assert "Units: m, kg, s, N, Pa" in readme and "not in these files" in readme.lower(), readme
    return folder


def body_of(scene, *more):
    (path,) = export(scene, "json", *more).glob("*.json")
    return json.loads(path.read_text())


def check_schema(one):
    body = body_of(one)
    (spring,) = body["connections"]
    assert (spring["a"], spring["b"]) == (0, 1)
    near(spring["stiffness"], 300)
    near(spring["rest_length"], 0.015)
    assert body["supports"] == [{"molecule": 0, "fixed": [True] * 3, "displacement": [0, 0, 0]}]
    assert body["forces"] == [{"molecule": 1, "force": [0, 0, 1]}]


def check_parsers(bar):
    """Counts, masses and the sum of all spring constants."""
    body = body_of(bar)
    count, springs = len(body["positions"]), body["connections"]
    mass, stiffness = sum(body["masses"]), sum(one["stiffness"] for one in springs)
    near(mass, 1000 * 30e-3 * 30e-3 * 50e-3)
    assert count == 96 and len(body["cells"]) == 45

    def agree(molecules, masses, constants):
        constants = list(constants)
        assert (molecules, len(constants)) == (count, len(springs))
        near(sum(masses), mass, 1e-6)
        near(sum(constants), stiffness, 1e-6)

    folder = export(bar, "csv")
    rows = list(csv.DictReader((folder / "connections.csv").open()))
    molecules = list(csv.DictReader((folder / "molecules.csv").open()))
    agree(len(molecules), (float(one["mass_kg"]) for one in molecules),
          (1 / float(one["compliance_m_per_N"]) for one in rows))

    text = (export(bar, "lammps") / "body.data").read_text()
    part = {name: [row.split() for row in rows.strip().splitlines()]
            for name, rows in re.findall(r"\n(Bond Coeffs|Atoms|Bonds)[^\n]*\n\n(.*?)(?=\n\n|\Z)", text, re.S)}
    of_type = {row[0]: 2 * float(row[1]) for row in part["Bond Coeffs"]}
    sphere = [(float(row[6]), float(row[7])) for row in part["Atoms"]]
    agree(len(part["Atoms"]), (3.141592653589793 / 6 * d**3 * density for d, density in sphere),
          (of_type[row[1]] for row in part["Bonds"]))

    tree = ElementTree.parse(export(bar, "mujoco") / "body.xml")
    agree(len(tree.findall(".//body")), (float(one.get("mass")) for one in tree.iter("inertial")),
          (float(one.get("stiffness")) for one in tree.iter("spatial")))
    # Sliding grips: 16 molecules do not move along z; 2 and 1 more components keep the body from moving as a whole.
    assert len(list(tree.iter("joint"))) <= 3 * count - 16

    tree = ElementTree.parse(export(bar, "sofa") / "body.scn")
    numbers = tree.find(".//SpringForceField").get("spring").split()
    agree(len(tree.find(".//MechanicalObject").get("position").split()) // 3,
          map(float, tree.find(".//DiagonalMass").get("vertexMass").split()), map(float, numbers[2::5]))

    class Builder:
        masses, constants, spring_rest_length = [], [], []

        def add_particle(self, pos, vel, mass):
            self.masses.append(mass)
            return len(self.masses) - 1

        def add_spring(self, i, j, ke, kd, control):
            self.constants.append(ke)
            self.spring_rest_length.append(0)

    folder = export(bar, "newton")
    sys.path.insert(0, str(folder))
    import newton_body

    builder = Builder()
    free = dict(json.loads((folder / "body.json").read_text()), supports=[])
    assert newton_body.add_to(builder, free) == 0
    agree(len(builder.masses), builder.masses, builder.constants)

    text = (export(bar, "bullet") / "body.cpp").read_text()
    molecules = re.search(r"molecules\[\] = \{(.*?)\n\};", text, re.S)[1].strip().splitlines()
    links = re.search(r"connections\[\] = \{(.*?)\n\};", text, re.S)[1].strip().splitlines()
    last = lambda row: float(row.strip(" {},").split(",")[-1])
    agree(len(molecules), map(last, molecules), map(last, links))

    text = (export(bar, "usd") / "body.usda").read_text()
    array = lambda name: json.loads("[" + re.search(re.escape(name) + r" = \[(.*)\]", text)[1] + "]")
    agree(len(array("elastin:mass")), array("elastin:mass"), array("elastin:stiffness"))


def check_cells(bar):
    """A law of cells gives E and nu, and no springs. MuJoCo's flex counts lambda twice, and mu once."""
    cells = "--strategy", "neo_hookean", "--set", CELLS
    body = body_of(bar, *cells)
    assert not body["connections"] and body["cells"][0]["shape"] == "hexahedron8"
    near(body["tetrahedra"][0]["youngs_modulus"], 100e3)
    tree = ElementTree.parse(export(bar, "mujoco", *cells) / "body.xml")
    young, poisson = (float(tree.find(".//elasticity").get(key)) for key in ("young", "poisson"))
    near(young / (2 * (1 + poisson)), 100e3 / 2.5)
    near(2 * young * poisson / ((1 + poisson) * (1 - 2 * poisson)), 100e3 * 0.25 / (1.25 * 0.5))
    assert len(tree.find(".//flex").get("element").split()) == 4 * len(body["tetrahedra"])


def check_refusals(bar):
    order = "--set", "body.lattice={kind: cubic, molecules: [2, 2, 2], spacing: 10 mm, order: 1}"
    for arguments, words in [
        (("jolt", "--strategy", "neo_hookean", *order), "jolt takes spring constants, and this strategy has none"),
        (("jolt", "--strategy", "latice"), "lattice"),
        (("jold",), "jolt"),
        (("jolt", "--strategy", "lattice+volume", "--set", "material.poissons_ratio=0.3"), ""),
    ]:
        said = elastin("export", bar, "--to", *arguments, "--out", bar.parent / "refused", status=2 if words else 0)
        assert words in said, said
        assert words or "the volume term" in said, said
    assert "a folder is needed" in elastin("export", bar, "--to", "csv", "--out", "-", status=2)


def check_lammps(bar):
    """The equilibrium that LAMMPS finds with the constants has Elastin's modulus."""
    folder = export(bar, "lammps")
    subprocess.run(["lmp", "-in", "in.body", "-log", "none"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    rows = [list(map(float, row.split())) for row in (folder / "forces.dump").read_text().splitlines()[9:]]
    body = body_of(bar)
    top = [i for i, place in enumerate(body["positions"]) if place[2] > 0.0499]
    drawn = sum(rows[i][3] - body["positions"][i][2] for i in top) / len(top)
    elastin("run", bar, "--json", bar.parent / "run.json", "--quiet")
    (run,) = json.loads((bar.parent / "run.json").read_text())["runs"]
    near(0.9e-3 / 30e-3**2 / (drawn / 50e-3), modulus_of(run), 1e-4)
    near(sum(row[6] for i, row in enumerate(rows) if body["positions"][i][2] == 0), 0.9e-3, 1e-6)


def modulus_of(run):
    value = run["measures"]["effective_modulus"]
    return value["value"] if isinstance(value, dict) else value


def compare(scene, *arguments, status=0):
    """The rows of a comparison, by engine or strategy."""
    path = scene.parent / "runs.json"
    elastin("compare", scene, *arguments, "--json", path, "--quiet", status=status)
    return {run.get("engine", run["strategy"]): run for run in json.loads(path.read_text())["runs"]}


def check_engines(folder):
    """Engines find with Elastin's constants the modulus that Elastin finds, where nothing limits them."""
    examples = pathlib.Path(__file__).parents[3] / "scenes" / "engines"
    commands = [f"'{sys.executable}' '{examples}/own_engine.py'"]
    own = ["own_engine"]
    bar = folder / "drawn.yaml"
    bar.write_text(BAR.replace("0.9 mN", "0.9 N, fixed_grip: clamped"))
    if shutil.which("node"):
        (folder / "script.mjs").write_bytes((examples / "own_engine.mjs").read_bytes())
        commands.append(f"node '{folder}/script.mjs'")
        own.append("script")
    named = [name for name in ENGINES if is_here(name)]
    # Steps of 0.2 ms: the largest k dt^2 / m is 0.01, where position-based solvers converge in one pass.
    rows = compare(bar, *(word for one in commands for word in ("--engine", one)),
                   *(("--engines", ",".join(named)) if named else ()), "--engine-dt", "0.0002")
    assert rows["lattice"].get("engine") is None
    for name in own + named:
        assert (rows[name]["engine"], rows[name]["strategy"]) == (name, "lattice"), rows[name]
        assert rows[name]["engine_run"]["steps"] > 0, rows[name]
        near(modulus_of(rows[name]), modulus_of(rows["lattice"]), 1e-4 if name in own + ["lammps"] else 0.02)
    # Displacements are prescribed where an engine gives the reactions.
    bar.write_text(BAR.replace("force: 0.9 mN", "strain: 1 %"))
    rows = compare(bar, "--engine", commands[0])
    near(modulus_of(rows["own_engine"]), modulus_of(rows["lattice"]), 1e-4)


# Small steps with compliance, one pass over the connections as they stand in each of `iterations` substeps.
POSITION_BASED = """
import json, math, sys
request = json.loads(sys.stdin.readline())
body, n = request["body"], request["iterations"]
h, x = request["dt"] / n, [list(p) for p in body["positions"]]
w = [1 / m for m in body["masses"]]
for one in body["supports"]:
    w[one["molecule"]] = 0
pull = [[0, 0, 0] for _ in x]
for one in body["forces"]:
    pull[one["molecule"]] = one["force"]
v, energy, before = [[0] * 3 for _ in x], 0, None
for step in range(4000 * n):
    old = [list(p) for p in x]
    for p, u, f, a in zip(x, v, pull, w):
        for k in range(3):
            u[k] += h * f[k] * a
            p[k] += h * u[k]
    for one in body["connections"]:
        a, b = one["a"], one["b"]
        if w[a] + w[b] == 0:
            continue
        d = [q - p for p, q in zip(x[a], x[b])]
        length = math.hypot(*d)
        push = (one["rest_length"] - length) / (w[a] + w[b] + 1 / (one["stiffness"] * h * h)) / length
        for k in range(3):
            x[b][k] += w[b] * push * d[k]
            x[a][k] -= w[a] * push * d[k]
    v = [[(p - q) / h for p, q in zip(now, then)] for now, then in zip(x, old)]
    now = sum(c * c / a for u, a in zip(v, w) if a for c in u)
    if now < energy:
        v = [[0] * 3 for _ in x]
    energy = 0 if now < energy else now
    if step % 200 == 199:
        if before and max(abs(p - q) for a, b in zip(x, before) for p, q in zip(a, b)) < 1e-9:
            break
        before = [list(p) for p in x]
print(json.dumps({"engine": "position-based", "positions": x, "iterations": n, "steps": step}))
"""


def check_prediction(folder):
    """What a position-based engine delivers is what xpbd shows at the same iterations, steps and order."""
    bar = folder / "predicted.yaml"
    bar.write_text(BAR.replace("0.9 mN", "0.9 N, fixed_grip: clamped").replace("[4, 4, 6]", "[3, 3, 6]")
                   + "engines: {names: [xpbd], dt: 8 ms, iterations: 5}\n")
    (folder / "position_based.py").write_text(POSITION_BASED)
    for iterations in (1, 5, 20):
        rows = compare(bar, "--engine", f"'{sys.executable}' '{folder}/position_based.py'",
                       "--engine-iterations", iterations, *(["--engines", "xpbd,jolt"] if is_here("jolt") else []))
        row = rows["xpbd"]
        assert (row["strategy"], row["engine_run"]["time_step"]) == ("lattice", 0.008), row
        assert row["engine_run"]["iterations"] == iterations, row
        assert modulus_of(row) < (0.97 if iterations < 20 else 1.01) * modulus_of(rows["lattice"]), iterations
        near(modulus_of(rows["position_based"]), modulus_of(row), 1e-3)
        if "jolt" in rows:
            near(modulus_of(rows["jolt"]), modulus_of(row), 2e-2)


def check_flex(bar):
    """MuJoCo's flex has the modulus of the same tetrahedra here: both are of St. Venant and Kirchhoff."""
    for ratio in ("0", "0.25", "0.45"):
        rows = compare(bar, "--engines", "mujoco", "--engine-dt", "0.0005", "--set", "stiffness={strategy: st_venant_kirchhoff, volume: none}",
                       "--set", "strategies=[{strategy: st_venant_kirchhoff, volume: none}]", "--set",
                       f"material.poissons_ratio={ratio}", "--set", "experiment.force=90 N", "--set",
                       "body={tetrahedra: {kind: kuhn, cubes: [3, 3, 5], size: [0.3 m, 0.3 m, 0.5 m]}}")
        near(modulus_of(rows["mujoco"]), modulus_of(rows["st_venant_kirchhoff"]), 1e-4)


def check_version(folder):
    """A package of another version, whose functions are others, is a row that says so."""
    package = folder / "other" / "node_modules" / "jolt-physics"
    package.mkdir(parents=True)
    (package / "package.json").write_text('{"name": "jolt-physics", "version": "9.0.0", "main": "index.js"}')
    (package / "index.js").write_text("module.exports = async () => ({});")
    bar = folder / "version.yaml"
    bar.write_text(BAR.replace("0.9 mN", "0.9 N, fixed_grip: clamped"))
    done = subprocess.run([COMMAND, "compare", bar, "--engines", "jolt", "--json", "-"], capture_output=True, text=True,
                          cwd=folder / "other")
    ours, row = json.loads(done.stdout)["runs"]
    assert ours["outcome"] == "converged" and row["outcome"] == "unsuited", row
    assert "is not a constructor (its driver is written for jolt-physics 1.1.0)" in row["cause"], row["cause"]


def check_faults(bar):
    """Whatever an engine does, its row says it, and the others are there."""
    python = f"'{sys.executable}' -c"
    positions = "import json, sys; p = json.loads(sys.stdin.readline())['body']['positions']; "
    for name, command, outcome, words in [
        ("absent", "no-such-program absent", "diverged", "status 127"),
        ("crashing", f"{python} 'raise SystemError(42)' crashing", "diverged", "status 1: SystemError: 42"),
        ("killed", "kill -SEGV $$; : killed", "diverged", "signal: Segmentation fault"),
        ("hanging", "sleep 60; : hanging", "diverged", "no answer in 0.5 s"),
        ("silent", "true silent", "diverged", "no line with a JSON object"),
        ("empty", "echo {}; : empty", "diverged", "neither 'positions' nor 'error'"),
        ("few", f'{python} "{positions}print(json.dumps({{\'positions\': p[1:]}}))" few', "diverged", "95 of 96"),
        ("nan", f'{python} "{positions}p[7][2] = float(\'nan\'); print(json.dumps({{\'positions\': p}}))" nan', "diverged",
         "molecule 7 are not finite"),
        ("moving", f'{python} "{positions}print(json.dumps({{\'positions\': p, \'at_rest\': False, \'steps\': 9}}))" moving',
         "diverged", "not at rest after 9 steps"),
        ("unable", "echo '{\"error\": \"no sliding grips\"}'; : unable", "unsuited", "no sliding grips"),
    ]:
        rows = compare(bar, "--engine", command, "--engine-seconds", "0.5" if name == "hanging" else "60",
                       status=0 if outcome == "unsuited" else 1)
        row = rows[name]
        assert rows["lattice"]["outcome"] == "converged", rows["lattice"]
        assert row["outcome"] == outcome and words in row["cause"], (name, row["outcome"], row["cause"])
        assert "NaN" not in (bar.parent / "runs.json").read_text()
    row = compare(bar, "--engines", "jolt", "--set", "experiment.force=0.9 N", *("--engine-dt", "0.001"))["jolt"]
    assert row["outcome"] == "unsuited", row  # not installed, or for the grips that slide
    assert "npm install jolt-physics@1.1.0" in row["cause"] or "fixed_grip: clamped" in row["cause"], row
    for arguments, words in [
        (("--engines", "jold"), "engine 'jold' is not known here; did you mean 'jolt'?"),
        (("--engine", "python3 lattice.py"), "'lattice' is a strategy"),
        (("--engine", "a.py", "--engine", "b/a.py"), "'a' is there twice"),
        (("--engine-iterations", "0"), "engines.iterations: '0' is not a whole number of at least 1"),
        (("--engine-dt", "-1"), "engines.dt: '-1' is out of range: must be above 0 s"),
    ]:
        assert words in elastin("compare", bar, *arguments, status=2), arguments
    wrong = bar.parent / "wrong.yaml"
    wrong.write_text(BAR + "engines: {names: [xpbd, jold]}\n")
    assert "wrong.yaml:8:25: engines.names[1]: engine 'jold' is not known here; did you mean 'jolt'?" in elastin(
        "compare", wrong, status=2)


def check_calibration(folder):
    """One factor mends an engine that is too soft; of one that cannot be stiffer the limit is said."""
    examples = pathlib.Path(__file__).parents[3] / "scenes" / "engines"
    bar = folder / "calibrated.yaml"
    bar.write_text(BAR.replace("0.9 mN", "0.9 N, fixed_grip: clamped").replace("[4, 4, 6]", "[2, 2, 3]"))
    weakest = min(one["stiffness"] for one in body_of(bar)["connections"])
    for law, status, remedy in [
        ("k / 3", 0, ""),
        (f"min(k, {weakest / 2})", 1, "however large"),
        (f"min(k, {0.9 * weakest} / (60 * request['dt'])**2)", 1, "; with steps of 0.008333 s it reaches that"),
    ]:
        (folder / "softer.py").write_text(
            "import json, sys\nrequest = json.loads(sys.stdin.readline())\n"
            "for one in request['body']['connections']:\n    k = one['stiffness']\n"
            f"    one['stiffness'] = {law}\nprint(json.dumps(request))\n")
        command = f"'{sys.executable}' '{folder}/softer.py' | '{sys.executable}' '{examples}/own_engine.py'"
        rows = compare(bar, "--engine", command, "--engine-calibrate", status=status)
        row, wanted = rows["own_engine"], modulus_of(rows["lattice"])
        if status:
            assert row["outcome"] == "limit_reached" and "saturated" in row["cause"], row
            assert row["cause"].endswith(remedy), row["cause"]
            continue
        near(modulus_of(row), wanted, 2e-3)
        assert any("constants are 3 times" in warning for warning in row["warnings"]), row["warnings"]
    # One that finds no rest above half of the constants is at its limit below that.
    strongest = max(one["stiffness"] for one in body_of(bar)["connections"])
    (folder / "restless.py").write_text(
        "import json, subprocess, sys\nline = sys.stdin.readline()\nbody = json.loads(line)['body']\n"
        f"if max(one['stiffness'] for one in body['connections']) > {strongest / 2}:\n"
        "    print(json.dumps({'positions': body['positions'], 'at_rest': False, 'steps': 9}))\n"
        f"else:\n    subprocess.run([sys.executable, '{examples}/own_engine.py'], input=line, text=True)\n")
    rows = compare(bar, "--engine", f"'{sys.executable}' '{folder}/restless.py'", "--engine-calibrate", status=1)
    row, wanted = rows["restless"], modulus_of(rows["lattice"])
    assert row["outcome"] == "limit_reached" and "not at rest after 9 steps)" in row["cause"], row
    shown = row["measures"]["effective_modulus"] / wanted
    assert 0.5 / 1.5 <= shown <= 0.5 and f"no more than {shown:.4g} of" in row["cause"], (shown, row["cause"])


def main():
    with tempfile.TemporaryDirectory() as name:
        bar, one = pathlib.Path(name, "bar.yaml"), pathlib.Path(name, "one.yaml")
        bar.write_text(BAR)
        one.write_text(ONE)
        check_schema(one)
        check_parsers(bar)
        check_cells(bar)
        check_refusals(bar)
        check_engines(bar.parent)
        check_faults(bar)
        check_calibration(bar.parent)
        check_prediction(bar.parent)
        if is_here("mujoco"):
            check_flex(bar)
        if shutil.which("node"):
            check_version(bar.parent)
        if shutil.which("lmp"):
            check_lammps(bar)


main()
