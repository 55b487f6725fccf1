# %% [markdown]
# # A tour of Elastin in Python
# From arrays to a comparison, pictures, a law of one's own, a fit to measured data and an animation. Open it as a notebook
# (VS Code and Spyder do, `jupytext --to ipynb` makes one for Jupyter), or run it as a program.

# %%
import tempfile
from pathlib import Path

import numpy

import elastin

folder = Path(tempfile.mkdtemp())

# %% [markdown]
# ## A body from arrays
# A bar of 30 × 10 × 10 mm: a grid of molecules, and six tetrahedra in each box of it. Quantities are in SI units.

# %%
counts = (7, 3, 3)
grid = numpy.stack(numpy.meshgrid(*(numpy.arange(n) for n in counts), indexing="ij"), axis=-1)
positions = grid.reshape(-1, 3) * 5e-3
number = numpy.arange(len(positions)).reshape(counts)

# %%
corners = {(i, j, k): number[i:counts[0] - 1 + i, j:counts[1] - 1 + j, k:counts[2] - 1 + k].ravel()
           for i in (0, 1) for j in (0, 1) for k in (0, 1)}
paths = [[(0, 0, 0), one, two, (1, 1, 1)] for one, two in (
    ((1, 0, 0), (1, 1, 0)), ((1, 0, 0), (1, 0, 1)), ((0, 1, 0), (1, 1, 0)),
    ((0, 1, 0), (0, 1, 1)), ((0, 0, 1), (1, 0, 1)), ((0, 0, 1), (0, 1, 1)))]
tetrahedra = numpy.concatenate([numpy.stack([corners[corner] for corner in path], axis=1) for path in paths])

# %%
bar = elastin.Body(positions, tetrahedra=tetrahedra, density=1100)
bar

# %%
bar.masses.sum(), bar.connections[:3], bar.rest_lengths[:3]

# %%
bar.plot()

# %% [markdown]
# ## A comparison
# A material, an experiment, and the strategies that are to show this material on this body. No file is needed.

# %%
rubber = elastin.Material(youngs_modulus=120e3, poissons_ratio=0.3, density=1100)
rubber

# %%
pull = elastin.Tension(axis="x", strain=0.15, load_steps=3)
pull

# %%
help(elastin.Tension)

# %%
comparison = elastin.compare(bar, ["standard", "lloyd", "van_gelder", "calibrated:standard", "neo_hookean"],
                             experiment=pull, material=rubber)
comparison

# %%
comparison.to_frame()

# %%
comparison.plot()

# %%
comparison.plot_curves()

# %% [markdown]
# Where the grips clamp, the material's E is not what is right: the solid itself on finer and finer cells is. The comparison
# computes it, as the command does.

# %%
clamped = elastin.compare(bar, ["standard", "neo_hookean"], experiment=elastin.Tension(axis="x", strain=0.05, grips="clamped"),
                          material=rubber, set={"reference": [{"computed": {"uncertainty": 0.02, "most_cells": 20000}}]})
{result.strategy: result.errors for result in clamped}

# %% [markdown]
# ## One result

# %%
result = elastin.run(bar, "neo_hookean", experiment=pull, material=rubber, keep_states=True)
result

# %%
result["effective_modulus"], result["poissons_ratio"], result.outcome

# %%
result.plot()

# %%
[(at, float(abs(where - bar.positions).max())) for at, where in result.states]

# %%
result.to_vtu(folder / "bar.vtu")
sorted(path.name for path in folder.iterdir())

# %%
again = elastin.Body.from_meshio(result.to_meshio())
again

# %% [markdown]
# ## A law of one's own
# Its energy density as a function of invariants; the names of the arguments say which. Slopes follow by the rules of
# differentiation, and the law runs in C++.

# %%
mine = elastin.law("mine", lambda I1, J, mu, lam: mu / 2 * (I1 - 3) - mu * numpy.log(J) + lam / 2 * (J - 1) ** 2)
both = elastin.compare(bar, ["neo_hookean", mine], experiment=pull, material=rubber)
both

# %%
abs(both["mine"].positions - both["neo_hookean"].positions).max()

# %%
def stiffening(I1_bar, J, mu, kappa, b=elastin.Parameter("b", 2.0, low=0, high=100, text="how fast it stiffens")):
    """Exponential in the change of shape, as Demiray's, with a volume term."""
    return mu / (2 * b) * (numpy.exp(b * (I1_bar - 3)) - 1) + kappa / 2 * numpy.log(J) ** 2


tissue_law = elastin.law("stiffening", stiffening, summary="exponential, isotropic", source="Demiray 1972")
tissue_law

# %%
far = elastin.Tension(axis="x", strain=0.6, load_steps=6)
elastin.compare(bar, ["neo_hookean", tissue_law], experiment=far, material=rubber).plot_curves()

# %% [markdown]
# A spring rule of one's own is a function that gives each connection its constant; it may ask others.

# %%
standard = elastin.Catalog()["standard"]
softer = elastin.Strategy("softer", lambda body, material, factor: factor * standard.constants(body, material),
                          parameters=[elastin.Parameter("factor", 0.5, low=0.1, high=1)])
elastin.compare(bar, ["standard", softer, "neo_hookean"], experiment=pull, material=rubber)

# %% [markdown]
# ## A fit
# Measured data are columns with units in a CSV file; here those of a rubber with c1 = 0.18 MPa and c2 = 0.02 MPa.

# %%
stretch = numpy.linspace(1.1, 3, 12)
stress = 2 * (stretch - stretch**-2) * (0.18 + 0.02 / stretch)
noise = 1 + 0.01 * numpy.random.default_rng(7).standard_normal(len(stretch))
numpy.savetxt(folder / "uniaxial.csv", numpy.column_stack([stretch, stress * noise]), delimiter=",",
              header="stretch,nominal_stress [MPa]", comments="")

# %%
found = elastin.identify({"material": {"law": "mooney_rivlin", "c1": "0.5 MPa", "c2": "0.1 MPa"},
                          "identify": {"tests": [{"kind": "uniaxial", "file": folder / "uniaxial.csv"}]}})
{one["name"]: (one["value"], one["low"], one["high"]) for one in found["parameters"]}

# %%
constants = {one["name"]: one["value"] for one in found["parameters"]}
fitted = elastin.Material(law={"law": "mooney_rivlin", "bulk_modulus": 50e6} | constants, density=1100)
cube = elastin.body({"lattice": {"kind": "cubic", "molecules": [3, 3, 3], "spacing": 5e-3, "order": 2}}, fitted)
drawn = elastin.run(cube, "mooney_rivlin+volume", experiment=elastin.Tension(strain=1, load_steps=8), material=fitted)
ax = drawn.plot_curve()
ax.plot(stretch[stretch < 2] - 1, 1e6 * (stress * noise)[stretch < 2], "k+", label="measured")
ax.legend()

# %% [markdown]
# ## In time
# Contact, several bodies and moving tools: everything that a scene says, a dict says. Wrong keys are answered by place and
# nearest name.

# %%
try:
    elastin.run(bar, "neo_hookean", experiment={"kind": "tension", "axsi": "x", "displacement": "1 mm"}, material=rubber)
except elastin.InputError as error:
    print(error)

# %%
wobble = elastin.Simulation(bar, "neo_hookean", rubber, stepper="backward_euler")
wobble.add_load("gravity", acceleration=(0, 0, -9.81))
for molecule in numpy.flatnonzero(bar.positions[:, 0] == 0):
    wobble.fix(molecule)
wobble.settle()
wobble

# %%
animation = wobble.animate(2e-3, 20, scale=3)
page = animation.to_jshtml()
len(page)
