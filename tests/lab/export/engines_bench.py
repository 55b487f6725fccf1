"""engines_bench.py COMMAND [--calibrate] [BODY …]: the bench of engines as a table in Markdown, the one in tests/README.md: of the modulus
that the constants have in Elastin, how much does each engine show?  --calibrate: after one factor on the constants."""

import json
import pathlib
import subprocess
import sys

SCENES = pathlib.Path(__file__).parents[3] / "scenes" / "engines"
COMMAND, *options = sys.argv[1:]
BODIES = [word for word in options if word[0] != "-"] or ["lattice", "tetrahedra", "organ"]


def cell(run, own):
    if run["outcome"] == "unsuited":
        return "–"
    shown = run["measures"].get("effective_modulus")
    if "saturated" in run["cause"]:
        return "at most " + run["cause"].split("no more than ")[1].split(" ")[0]
    if run["outcome"] != "converged" or not shown:
        return "unstable" if "unstable" in run["cause"] else "no rest"
    if any("invert" in warning for warning in run["warnings"]):
        return "inverts"
    factor = f" (× {run.get('calibration_factor', 1):.3g})" if "--calibrate" in options else ""
    return f"{shown / own:.3g}{factor}"


def table():
    versions, lines = {}, []
    for body in BODIES:
        words = [COMMAND, "compare", SCENES / f"bench-{body}.yaml", "--quiet", "--json", "-"]
        if "--calibrate" in options:
            words += ["--engine-calibrate", "--engines", "jolt,rapier,mujoco,bullet,lammps"]
        runs = json.loads(subprocess.run(words, capture_output=True, text=True).stdout)["runs"]
        own, rows, moduli = {}, {}, []
        for run in runs:
            asked = run["variant"]["material.youngs_modulus"]
            if "engine" not in run:
                own[asked] = run["measures"]["effective_modulus"]
                moduli.append(asked)
                continue
            versions[run["engine"]] = run["engine_run"]["version"] or versions.get(run["engine"], "")
            row = rows.setdefault(run["engine"], [run["engine_run"]["iterations"] or "", [], []])
            row[1].append(cell(run, own[asked]))
            row[2].append(1e3 * run["engine_run"]["seconds_per_step"])
        if not lines:
            lines = ["| body | engine | iterations | " + " | ".join(moduli) + " | ms a step |", "|---" * (len(moduli) + 4) + "|"]
        for name, (iterations, cells, times) in rows.items():
            lines.append(f"| {body} | `{name}` | {iterations} | " + " | ".join(cells) + f" | {sorted(times)[len(times) // 2]:.3g} |")
    return lines + ["", "Versions: " + ", ".join(text for text in versions.values() if text) + "."]


print("\n".join(table()))
