#!/usr/bin/python3
"""How often the 95 % intervals of c1 and c2 hold the constants that made the data: a quarter of a cruciform, scatter of
2 % of the largest displacement on points of its face and 2 % of the largest force on both forces, one fit a repeat.

    cruciform_coverage.py build/bin/elastin [REPEATS] [FIRST]

A repeat takes some 2 s of processor time; FIRST is the number of the first draw, so that several processes share them.
"""
import base64, json, re, struct, subprocess, sys, tempfile, zlib
from pathlib import Path

import numpy as np

MADE_WITH = {"c1": 3.51e6, "c2": 0.93e6}
LOADS, POINTS, READINGS = 2, 24, 20  # readings of each force at each load
ELASTIN = Path(sys.argv[1]).resolve()
REPEATS = int(sys.argv[2]) if len(sys.argv) > 2 else 1000
FIRST = int(sys.argv[3]) if len(sys.argv) > 3 else 0

SCENE = f"""
title: a small quarter of a cruciform
body:
  mesh: {{file: cruciform.inp, length_unit: mm}}
material: {{law: mooney_rivlin, c1: 3.4 MPa, c2: 1 MPa, bulk_modulus: 4 GPa}}
stiffness: mooney_rivlin
supports:
  - {{symmetry: x}}
  - {{symmetry: y}}
  - {{symmetry: z}}
experiment:
  kind: loads
  moved:
    - {{molecules: {{set: RIGHT}}, displacement: [12 mm, 0, 0]}}
    - {{molecules: {{set: TOP}}, displacement: [0, 6 mm, 0]}}
  read:
    - {{name: right, molecules: {{set: RIGHT}}}}
    - {{name: top, molecules: {{set: TOP}}}}
  load_steps: {LOADS}
identify:
  tests:
    - {{name: right, kind: specimen, file: forces.csv, columns: {{right: 'force [N]'}}, measure: right_reaction_x}}
    - {{name: top, kind: specimen, file: forces.csv, columns: {{top: 'force [N]'}}, measure: top_reaction_y}}
    - {{name: camera, kind: points, file: points.csv}}
"""


def cruciform():
    """Hexahedra of 5 x 5 x 2 mm: a middle of 2 x 2 and two arms of 3, in a file of Abaqus."""
    middle, arm = 2, 3
    number, text = {}, "*NODE\n"
    cells = [(x, y) for x in range(middle + arm) for y in range(middle + arm) if min(x, y) < middle]
    for x, y in cells:
        for corner in [(x + i, y + j, k) for k in (0, 1) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]:
            if corner not in number:
                number[corner] = len(number) + 1
                text += f"{number[corner]}, {5 * corner[0]}, {5 * corner[1]}, {2 * corner[2]}\n"
    text += "*ELEMENT, TYPE=C3D8, ELSET=ALL\n"
    for count, (x, y) in enumerate(cells):
        corners = [(x + i, y + j, k) for k in (0, 1) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
        text += ", ".join(str(n) for n in [count + 1, *(number[c] for c in corners)]) + "\n"
    for name, axis in (("RIGHT", 0), ("TOP", 1)):
        text += f"*NSET, NSET={name}\n" + ", ".join(str(n) for c, n in number.items() if c[axis] == middle + arm) + "\n"
    return text


def array_of(text, name):
    """An array of numbers of ParaView's XML, blocks by zlib."""
    block = re.search(rf'<DataArray type="Float64" Name="{name}"[^>]*>\s*([^<]+)<', text).group(1).strip()
    count = struct.unpack("<Q", base64.b64decode(block[:12])[:8])[0]
    header = (3 + count) * 8
    length = -(-header // 3) * 4
    sizes = struct.unpack(f"<{3 + count}Q", base64.b64decode(block[:length])[:header])[3:]
    data, at, all_bytes = base64.b64decode(block[length:]), 0, b""
    for size in sizes:
        all_bytes += zlib.decompress(data[at:at + size])
        at += size
    return np.frombuffer(all_bytes)


def made(folder):
    """Loads, both forces, points at rest [mm] and their displacements at each load [mm], without scatter."""
    (folder / "scene.yaml").write_text(SCENE)
    (folder / "cruciform.inp").write_text(cruciform())
    constants = [f"--set=material.{name}={value} Pa" for name, value in MADE_WITH.items()]
    subprocess.run([ELASTIN, "run", "scene.yaml", *constants, "--out", "exact"], cwd=folder, check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    curve = json.loads((folder / "exact/runs.json").read_text())
    run = curve["runs"][0]["curve"]
    forces = np.array([[point[name] for name in ("right_reaction_x", "top_reaction_y")] for point in run])
    places = [1e3 * array_of(path.read_text(), "positions").reshape(-1, 3)
              for path in sorted((folder / "exact").glob("*.vtu"))]
    rest = places[0]
    face = np.flatnonzero(rest[:, 2] > rest[:, 2].max() - 1e-6)
    face = face[np.linspace(0, len(face) - 1, POINTS).astype(int)]
    return np.arange(1, LOADS + 1) / LOADS, forces, rest[face], [at[face] - rest[face] for at in places[1:]]


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        loads, forces, rest, moved = made(folder)
        largest = max(np.abs(u).max() for u in moved)
        held, off = {key: 0 for key in MADE_WITH}, {key: [] for key in MADE_WITH}
        for repeat in range(FIRST, FIRST + REPEATS):
            draw = np.random.default_rng(repeat)
            lines = ["load_factor,right,top"]
            for load, force in zip(loads, forces):
                seen = force + 0.02 * forces.max(axis=0) * draw.standard_normal((READINGS, 2))
                lines += [f"{load:.9g},{right:.9g},{top:.9g}" for right, top in seen]
            (folder / "forces.csv").write_text("\n".join(lines) + "\n")
            lines = ["load_factor,x [mm],y [mm],z [mm],ux [mm],uy [mm],uz [mm]"]
            for load, u in zip(loads, moved):
                u = u + 0.02 * largest * draw.standard_normal(u.shape)
                lines += [",".join(f"{v:.9g}" for v in (load, *place, *by)) for place, by in zip(rest, u)]
            (folder / "points.csv").write_text("\n".join(lines) + "\n")
            subprocess.run([ELASTIN, "identify", "scene.yaml", "--out", "answer"], cwd=folder, check=True,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            answer = json.loads(next((folder / "answer").glob("*.json")).read_text())
            for number in answer["parameters"]:
                key, low, high = number["name"], number["low"], number["high"]
                held[key] += low < MADE_WITH[key] < high
                off[key].append((number["value"] - MADE_WITH[key]) / ((high - low) / 2))
            done = repeat + 1 - FIRST
            if done % 10 == 0 or done == REPEATS:
                print(done, *(f"{key} {100 * held[key] / done:.1f} % (mean off {np.mean(off[key]):+.3f} half widths)"
                              for key in held), flush=True)


main()
