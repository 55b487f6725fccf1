"""An engine of `elastin compare`: LAMMPS with the in.body in the request's folder. apt-get install lammps"""

import json
import pathlib
import re
import subprocess
import sys
import time

request = json.loads(sys.stdin.readline())
body, folder = request["body"], pathlib.Path(request["folder"])
start = time.perf_counter()
done = subprocess.run(["lmp", "-in", "in.body", "-log", "none"], cwd=folder, capture_output=True, text=True)
if done.returncode:
    error = re.search(r"ERROR.*", done.stdout + done.stderr)
    sys.exit(error[0] if error else f"lmp ended with {done.returncode}")
rows = [list(map(float, row.split())) for row in (folder / "forces.dump").read_text().splitlines()[9:]]
reactions = [[0.0] * 3 for _ in rows]
for support in body["supports"]:
    for axis in range(3):
        if support["fixed"][axis]:
            reactions[support["molecule"]][axis] = -rows[support["molecule"]][4 + axis]
steps = re.search(r"Iterations, force evaluations = (\d+)", done.stdout)
steps = int(steps[1]) if steps else 0
answer = {
    "engine": "LAMMPS " + re.search(r"LAMMPS \((.*?)\)", done.stdout)[1],
    "positions": [row[1:4] for row in rows],
    "reactions": reactions,
    "steps": steps,
    "at_rest": steps < 200000,
    "seconds_per_step": (time.perf_counter() - start) / max(steps, 1),
}
print(json.dumps(answer))
