"""The angle of fibres at which a block yields least to a force aslant: its gradient, and scipy's search by it."""
import numpy
import scipy.optimize

import elastin

SCENE = {"body": {"tetrahedra": {"kind": "kuhn", "cubes": [3, 3, 3], "size": ["10 mm", "10 mm", "10 mm"]}},
         "material": {"youngs_modulus": "10 kPa", "poissons_ratio": 0.3,
                      "fibre": {"direction": [0, 0, 1], "youngs_modulus": "40 kPa"}},
         "stiffness": "neo_hookean",
         "supports": [{"molecules": {"plane": {"point": [0, 0, 0], "normal": "z"}}, "fix": "all"}],
         "loads": [{"traction": {"traction": ["1 kPa", 0, "1 kPa"],
                                 "on": {"plane": {"point": [0, 0, "10 mm"], "normal": "z"}}}}],
         "experiment": {"kind": "loads"}}
KEYS = ["material.fibre.direction.0", "material.fibre.direction.2"]


def energy_and_slope(angle):
    """Elastic energy [J] with fibres at this angle [rad] to z, and its derivative: that by the direction, times the
    direction's own."""
    direction, turned = [numpy.sin(angle), numpy.cos(angle)], [numpy.cos(angle), -numpy.sin(angle)]
    at = dict(zip(KEYS, direction))
    return elastin.run(SCENE, set=at)["energy"], elastin.gradient(SCENE, of="energy", by=KEYS, set=at)[0] @ turned


def best_angle(start=0.2):
    """The angle [rad] at which the energy is least."""
    search = scipy.optimize.minimize(lambda angle: [1e6 * value for value in energy_and_slope(angle[0])], [start],
                                     jac=True, bounds=[(0, numpy.pi / 2)], method="L-BFGS-B")
    return search.x[0]


if __name__ == "__main__":
    print(f"fibres at {numpy.degrees(best_angle()):.1f} degrees to z")
