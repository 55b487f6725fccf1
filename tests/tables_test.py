#!/usr/bin/env python3
"""Tables of the documents are what the command `elastin` says.

  tables_test.py ROOT ELASTIN             fails where the key reference or a table is not what the command says
  tables_test.py ROOT ELASTIN --write     puts them into the documents

In a document a line <!-- table: COMMAND --> names the command, and <!-- table: end --> ends its table; the key reference
stands between <!-- keys: begin --> and <!-- keys: end -->. Of the hard cases the test leaves out the times, and the columns
of --choices, which take minutes; --write makes them all.
"""
import glob
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

PAPER = "elastin compare scenes/tension/table1-*.yaml scenes/tension/table2.yaml"
HARD = "elastin verify scenes/hard/*.yaml --choices --markdown"
MISTAKES = "elastin check, on each mistake of tests/lab/scene/mistakes.txt"
REALITY = "elastin compare scenes/reality"
REST = "elastin compare scenes/rest"
BROUGHT = "elastin check, on each file of tests/mesh/data/brought"
NUMBER = re.compile(r"[-+−]?\d+(?:\.\d+)?(?:e[-+]\d+)?")


def output(elastin, command):
    """What a command of the documents prints. Exit code 1 is a verdict, not a failure of the command."""
    words = [file for word in shlex.split(command)[1:]
             for file in (sorted(glob.glob(word)) if "*" in word else [word])]
    ran = subprocess.run([elastin] + words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False)
    if ran.returncode not in (0, 1):
        sys.exit(f"`{command}` ends with exit code {ran.returncode}")
    return ran.stdout.decode()


def percent(part):
    text = f"{100 * part:+.2f}" if abs(part) < 0.01 else f"{100 * part:+.0f}"
    return ("0.00" if float(text) == 0 else text.replace("-", "−")) + " %"


def paper_cell(run, unit, digits):
    """"published → measured (difference)" """
    wanted = next(one for one in run["expectations"] if one["measure"] == "effective_modulus")
    text = f"{wanted['expected'] / unit:.{digits}f} → {wanted['measured'] / unit:.{digits}f}"
    return text + f" ({percent(wanted['difference'])})"


def paper_table(elastin):
    """Published and measured moduli, from the expectations of the scenes."""
    runs = json.loads(output(elastin, PAPER + " --json -"))["runs"]
    cells = {}
    for run in runs:
        table2 = run["scene"] == "table2"
        cell = paper_cell(run, 1e3 if table2 else 1, 3 if table2 else 2)
        divided = run["strategy"] == "divided"
        cells.setdefault(run["scene"], {})["angles_update" if divided else run["strategy"]] = \
            "(k/3.75) " * divided + cell
    columns = ["standard", "statistical", "angles", "angles_update"]
    lines = ["| scene | standard | statistical | angles | angles (update) |", "|---|---|---|---|---|"]
    for scene, row in cells.items():
        name = "Table 2" if scene == "table2" else scene[-1]
        lines.append("| " + " | ".join([name] + [row[column] for column in columns]) + " |")
    return "\n".join(lines) + "\n"


def same_text(one, other):
    """Whether two cells say the same: equal words, and numbers that are as near as two machines' are."""
    if NUMBER.sub("#", one) != NUMBER.sub("#", other):
        return False
    pairs = zip(NUMBER.findall(one), NUMBER.findall(other))
    return all(abs(a - b) <= 2e-4 + 0.02 * max(abs(a), abs(b))
               for a, b in ((float(x.replace("−", "-")), float(y.replace("−", "-"))) for x, y in pairs))


def same_cases(written, made):
    """Whether two tables of cases agree in case, strategy, verdict and error or cause."""
    rows, wanted = ([line.split(" | ")[:4] for line in text.splitlines() if not line.startswith("|---")]
                    for text in (written, made))
    return len(rows) == len(wanted) and all(len(a) == len(b) and all(map(same_text, a, b)) for a, b in zip(rows, wanted))


def written(text):
    """The bytes that a line of mistakes.txt stands for: \\t, \\n, \\r, \\\\ and \\xNN."""
    signs = {b"t": b"\t", b"n": b"\n", b"r": b"\r", b"\\": b"\\"}
    return re.sub(rb"\\(x..|.)", lambda match: signs.get(match[1]) or bytes([int(match[1][1:], 16)]), text.encode())


def mistakes_table(elastin):
    """What the command answers to a scene with one mistake: its message, or that the scene is taken as it is."""
    with open("tests/lab/scene/mistakes.txt", encoding="utf-8") as stream:
        scene, *groups = [part for part in stream.read().split("\n\n") if not part.startswith("# Mistakes")]
    lines = []
    with tempfile.TemporaryDirectory() as folder:
        for group in groups:
            title, *mistakes = group.strip("\n").split("\n")
            lines += ["", f"| {title[2:].lower()} | answer |", "|---|---|"]
            for mistake in mistakes:
                right, wrong = mistake.split(" => ")
                text = (scene + "\n").encode()
                if written(right) not in text:
                    sys.exit(f"mistakes.txt: the scene has no '{right}'")
                with open(os.path.join(folder, "scene.yaml"), "wb") as stream:
                    stream.write(text.replace(written(right), written(wrong), 1))
                ran = subprocess.run([elastin, "check", "scene.yaml"], cwd=folder, stdout=subprocess.DEVNULL,
                                     stderr=subprocess.PIPE, check=False)
                answer = ran.stderr.decode().strip().replace("elastin: scene.yaml:", "", 1)
                if ran.returncode != 2:
                    answer = "*taken as it is meant*" + (": " + answer if answer else "")
                allowed = re.sub(r"allowed( here)?: [^()]*", r"allowed\1: …", answer)
                lines.append("| `" + wrong.replace("|", "\\|") + "` | " + allowed.replace("|", "\\|").replace("*", "\\*").replace(
                    "\\*taken as it is meant\\*", "*taken as it is meant*") + " |")
    return "\n".join(lines[1:]) + "\n"


def brought_table(elastin):
    """What is read of each mesh and surface, what is said of it, or why it is refused."""
    lines = ["| file | read | said |", "|---|---|---|"]
    for file in sorted(glob.glob("tests/mesh/data/brought/*[!t]")):
        name = os.path.basename(file)
        body = f"fill: {{spacing: 2 mm, file: {name}" if name.startswith("surf_") else f"mesh: {{file: {name}"
        text = (f"title: t\nbody: {{{body}, length_unit: mm}}}}\nmaterial: {{youngs_modulus: 10 kPa, poissons_ratio: 0.3}}\n"
                "stiffness: neo_hookean\nexperiment: {kind: tension, axis: x, strain: 0.1 %}\n")
        with tempfile.TemporaryDirectory() as folder:
            for other in glob.glob("tests/mesh/data/brought/*"):
                shutil.copy(other, folder)
            with open(os.path.join(folder, "scene.yaml"), "w", encoding="utf-8") as stream:
                stream.write(text)
            ran = subprocess.run([elastin, "check", "scene.yaml"], cwd=folder, stdout=subprocess.PIPE,
                                 stderr=subprocess.PIPE, check=False)
        rows = re.findall(r"^  (.{22})(.*)$", ran.stdout.decode(), re.M)
        read = [f"{value.split(',')[0]} {kind.strip()}" for kind, value in rows
                if kind.strip() in ("molecules", "hexahedra", "tetrahedra", "triangles")]
        said = [re.sub(rf"^(scene.yaml: )?(body.fill: )?{re.escape(name)}:? |, masses scaled.*|, with their molecules", "", value)
                for kind, value in rows if kind.strip() in ("note", "warning") and (name in value or "winding" in value)]
        said = [re.sub("^filled: .*% of the surface's", "inside:", one) for one in said]
        if ran.returncode == 2:
            read, said = ["refused"], [ran.stderr.decode().strip().split(name + ":", 1)[-1]]
        lines.append(f"| `{name}` | {', '.join(read)} | {'; '.join(said)} |")
    return "\n".join(lines) + "\n"


SPRINGS = ["standard", "lloyd", "calibrated:standard", "calibrated:van_gelder", "calibrated:patch+volume"]


def reality_table(elastin):
    """Errors over the scatter of what was measured: the largest of a scene's references, a row a scene."""
    scenes = {}
    for run in json.loads(output(elastin, REALITY + " --json -"))["runs"]:
        scenes.setdefault(glob.glob(f"scenes/reality/*/{run['scene']}.yaml")[0], []).append(run)
    lines = ["| experiment | its law | neo_hookean | " + " | ".join(SPRINGS) + " |", "|---" * (len(SPRINGS) + 3) + "|"]
    for path, runs in sorted(scenes.items()):
        cells = {}
        for run in runs:
            errors = [error for name, error in run.get("errors", {}).items() if name.endswith("_over_scatter")]
            name = run["strategy"].replace("prony:", "").replace("patch+volume", "patch").replace("patch", "patch+volume")
            name = name if name in SPRINGS or "calibrated:" + name not in SPRINGS else "calibrated:" + name
            kind = name if name in SPRINGS else "neo_hookean" if name.startswith("neo_hookean") else "its law"
            text = f"{max(errors):.2f}" if errors else run["outcome"].replace("_", " ")
            law = f" ({run['strategy']})" if kind == "its law" else ""
            cells.setdefault(kind, f"**{text}**{law}" if errors and max(errors) <= 1 else text + law)
        with open(path, encoding="utf-8") as stream:
            star = "*" if re.search("%.* is taken", stream.read()) else ""
        lines.append(f"| [{runs[0]['title']}](../{path}){star} | " +
                     " | ".join(cells.get(name, "") for name in ["its law", "neo_hookean"] + SPRINGS) + " |")
    return "\n".join(lines) + "\n"


def rest_table(elastin):
    """Cells and springs on bodies that are stressed where they lie: the error of each, and its seconds of solving."""
    lines = ["| case | strategy | measure | error | solved in |", "|---|---|---|---|---|"]
    for run in json.loads(output(elastin, REST + " --json -"))["runs"]:
        if "references" not in run:
            continue
        measure = run["references"][0]["measure"]
        error = run.get("errors", {}).get(measure + "_to_reference")
        text = percent(error) if error is not None else run["outcome"].replace("_", " ")
        lines.append(f"| `{run['scene']}` | {run['strategy']} | `{measure}` | {text} | {run['seconds']['solve']:.2f} s |")
    return "\n".join(lines) + "\n"


def block(text, begin, end):
    """Where the text between two lines begins and ends."""
    start = text.find(begin + "\n")
    stop = text.find(end + "\n", start)
    if start < 0 or stop < 0:
        sys.exit(f"no document has the lines {begin} and {end}")
    return start + len(begin) + 1, stop


def main(root, elastin, write):
    os.chdir(root)
    checks = [("scenes/README.md", "<!-- keys: begin -->", "<!-- keys: end -->",
               lambda: output(elastin, "elastin list --keys"), lambda old, new: old == new),
              ("tests/README.md", f"<!-- table: {PAPER} -->", "<!-- table: end -->",
               lambda: paper_table(elastin), lambda old, new: old == new),
              ("tests/README.md", f"<!-- table: {HARD} -->", "<!-- table: end -->",
               lambda: output(elastin, HARD if write else HARD.replace(" --choices", "")), same_cases),
              ("tests/README.md", f"<!-- table: {REALITY} -->", "<!-- table: end -->",
               lambda: reality_table(elastin), same_cases),
              ("tests/README.md", f"<!-- table: {REST} -->", "<!-- table: end -->",
               lambda: rest_table(elastin), same_cases),
              ("tests/README.md", f"<!-- table: {MISTAKES} -->", "<!-- table: end -->",
               lambda: mistakes_table(elastin), lambda old, new: old == new),
              ("tests/README.md", f"<!-- table: {BROUGHT} -->", "<!-- table: end -->",
               lambda: brought_table(elastin), same_cases)]
    stale = []
    for document, begin, end, make, same in checks:
        with open(document, encoding="utf-8") as stream:
            text = stream.read()
        start, stop = block(text, begin, end)
        made = make()
        if write:
            with open(document, "w", encoding="utf-8") as stream:
                stream.write(text[:start] + made + text[stop:])
        elif not same(text[start:stop], made):
            line = text.count("\n", 0, start)
            stale.append(f"{document}:{line}: is not what the command says; tests/tables_test.py --write mends it")
            for old, new in zip(text[start:stop].splitlines(), made.splitlines()):
                if old != new and not same(old, new):
                    stale.append(f"  - {old}\n  + {new}")
                    break
    print("\n".join(stale) if stale else f"{len(checks)} tables are what the command says")
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], os.path.abspath(sys.argv[2]), "--write" in sys.argv[3:]))
