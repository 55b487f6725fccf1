"""An engine of one's own for `elastin compare SCENE --engine 'python3 scenes/engines/own_engine.py'`.

Springs in explicit steps, slowed down until nothing moves. Reads the request from standard input, prints the answer.
"""

import json
import math
import sys
import time

request = json.loads(sys.stdin.readline())
body = request["body"]
springs = [(one["a"], one["b"], one["rest_length"], one["stiffness"]) for one in body["connections"]]
x = [list(place) for place in body["positions"]]
v = [[0.0] * 3 for _ in x]
fixed = [[False] * 3 for _ in x]
for support in body["supports"]:
    fixed[support["molecule"]] = support["fixed"]
    x[support["molecule"]] = [a + b for a, b in zip(x[support["molecule"]], support["displacement"])]
loads = [[0.0] * 3 for _ in x]
for load in body["forces"]:
    loads[load["molecule"]] = load["force"]
stiffness = [0.0] * len(x)
for a, b, _, k in springs:
    stiffness[a] += 2 * k
    stiffness[b] += 2 * k
dt = min(request["dt"], 0.9 * min(2 / math.sqrt(k / m) for k, m in zip(stiffness, body["masses"]) if k > 0))
keep, steps, start = 0.98, 0, time.perf_counter()
while steps < request["most_steps"]:
    force = [list(load) for load in loads]
    for a, b, length, k in springs:
        span = [q - p for p, q in zip(x[a], x[b])]
        now = math.hypot(*span)
        for axis in range(3):
            pull = k * (1 - length / now) * span[axis]
            force[a][axis] += pull
            force[b][axis] -= pull
    scale = max(abs(f) for row in force for f in row)  # of loads and reactions
    loose = max(abs(f) for row, held in zip(force, fixed) for f, still in zip(row, held) if not still)
    if loose < 1e-6 * scale:
        break
    for i, row in enumerate(x):
        for axis in range(3):
            if not fixed[i][axis]:
                v[i][axis] = keep * v[i][axis] + dt * force[i][axis] / body["masses"][i]
                row[axis] += dt * v[i][axis]
    steps += 1
reactions = [[-f if still else 0.0 for f, still in zip(row, held)] for row, held in zip(force, fixed)]
print(json.dumps({"engine": "forty lines of Python", "positions": x, "reactions": reactions, "steps": steps,
                  "at_rest": steps < request["most_steps"],
                  "seconds_per_step": (time.perf_counter() - start) / max(steps, 1)}))
