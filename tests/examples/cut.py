"""A moving block of tissue is cut half through by a blade, its flap is lifted, and a probe presses on it."""
import numpy
import elastin

# 40 x 20 x 10 mm of tetrahedra, 1000 kg/m3, held at its bottom.
block = elastin.lattice((17, 9, 5), 2.5e-3)
tissue = elastin.Simulation(block, "lattice", elastin.Material(8e3), stepper="backward_euler",
                            stepper_parameters={"newton_iterations": 2})
for molecule in numpy.flatnonzero(tissue.body.positions[:, 2] == 0):
    tissue.fix(molecule)
tissue.add_load("gravity", acceleration=(0, 0, -9.81))
tissue.add_load("rayleigh", mass=20)
mass = tissue.body.masses.sum()

probe = tissue.add_tool((0.03, 0.01, 0.02))
tissue.add_contact(2e7, [{"shape": "sphere", "radius": 4e-3, "tool": probe, "name": "probe"}])

corner = numpy.argmin(numpy.linalg.norm(tissue.body.positions - (0, 0, 0.01), axis=1))
drawn = tissue.body.surface
hook = None
for frame in range(120):
    if frame == 20:  # from one side, 5 mm below the top, as far as the middle
        cut = tissue.cut_blade([(-0.001, -1, 0.005), (-0.001, 1, 0.005)], [(0.02, -1, 0.005), (0.02, 1, 0.005)])
        print(f"{cut.split_molecules} molecules split, {len(tissue.body.surface) - len(drawn)} triangles more to draw")
        hook = tissue.couple(corner, tissue.positions[corner], 50, 0.05)
    if hook:
        tissue.move_coupling(hook, (-1e-3, 0, 0.01 + 1e-4 * (frame - 20)))
    tissue.move_tool(probe, (0.03, 0.01, 0.0135 - 1e-3 * numpy.sin(frame * 0.02)))
    tissue.step(2e-3)

lifted = 1e3 * (tissue.positions[corner, 2] - 0.01)
print(f"flap lifted by {lifted:.2f} mm with {1e3 * numpy.linalg.norm(tissue.coupling_force(hook)):.1f} mN, "
      f"the probe pressed with {1e3 * numpy.linalg.norm(tissue.contact_forces()['probe']):.1f} mN")
assert cut and lifted > 1 and tissue.contact_forces()["probe"][2] > 0 and abs(tissue.body.masses.sum() / mass - 1) < 1e-13
