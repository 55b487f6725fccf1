"""A cube in tension: which modulus comes out of which lattice, and of which strategy. Draws tension_sweep.png."""
import sys

import elastin

scene = "scenes/tension/cube-27-face.yaml"
sizes = [2, 3, 4, 5, 6]
asked = elastin.Laboratory(scene).material.youngs_modulus
sweeps = {}
for strategy in ["standard", "angles", "lattice", "calibrated:standard"]:
    sweeps[strategy] = elastin.sweep(scene, "body.lattice.molecules", [[n, n, n] for n in sizes], strategy=strategy)
    moduli = sweeps[strategy]["effective_modulus"]
    print(f"{strategy:20}", *(f"{E / asked:8.4f}" for E in moduli))

try:
    import matplotlib
except ImportError:
    sys.exit("no plot: matplotlib is missing (apt-get install python3-matplotlib)")
matplotlib.use("Agg")
from matplotlib import pyplot

ax = pyplot.figure(layout="constrained").add_subplot()
for strategy, sweep in sweeps.items():
    ax.plot(sizes, sweep["effective_modulus"] / asked, "o-", label=strategy)
ax.axhline(1, color="grey", linewidth=0.8)
ax.set(xticks=sizes, xlabel="molecules along a side", ylabel="modulus of the cube / target modulus")
ax.legend()
ax.figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "tension_sweep.png")
