"""The body in body.json as particles, springs and tetrahedra of Newton: add_to(newton.ModelBuilder()). pip install newton"""

import json
import pathlib


def add_to(builder, data, damping=0.0):
    """Adds particles (held ones have no mass), and springs, or of a law of cells tetrahedra. Gives the first number."""
    held = {support["molecule"] for support in data["supports"]}
    first = None
    for number, (place, mass) in enumerate(zip(data["positions"], data["masses"])):
        particle = builder.add_particle(pos=tuple(place), vel=(0.0, 0.0, 0.0), mass=0.0 if number in held else mass)
        first = particle if first is None else first
    for one in data["connections"]:
        builder.add_spring(first + one["a"], first + one["b"], ke=one["stiffness"], kd=damping, control=0.0)
        builder.spring_rest_length[-1] = one["rest_length"]  # in place of the distance
    if not data["connections"]:
        for cell in data["tetrahedra"]:
            young, poisson = cell["youngs_modulus"], cell["poissons_ratio"]
            builder.add_tetrahedron(
                *(first + node for node in cell["nodes"]),
                k_mu=young / (2 * (1 + poisson)),
                k_lambda=young * poisson / ((1 + poisson) * (1 - 2 * poisson)),
                k_damp=damping,
            )
    return first


if __name__ == "__main__":
    import newton

    model_builder = newton.ModelBuilder()
    add_to(model_builder, json.loads(pathlib.Path(__file__).with_name("body.json").read_text()))
    print(model_builder.particle_count, "particles,", len(model_builder.spring_rest_length), "springs")
