"""Bodies as scenes describe them."""

import os
import warnings

from . import _elastin, _yaml


def body(description, material=None):
    """A body as a scene has it under `body:`: elastin.body({"lattice": {"kind": "cubic", "molecules": [5, 5, 5],
    "spacing": 1e-3}}). Every shape of the scenes is there, with the same keys and messages; files are named from the
    working directory. The material, by default one of 1000 kg/m^3, gives it its mass."""
    made, remarks = _elastin._body_of_scene(_yaml.text(description), material or _elastin.Material(1.0))
    for remark in remarks:
        warnings.warn(remark, stacklevel=2)
    return made


def lattice(molecules, spacing, connections=("axis", "face"), *, radius=None, density=1000.0):
    """A cubic lattice of (nx, ny, nz) molecules, `spacing` [m] apart (a number, or one along x, y and z), joined along
    "axis", "face" and "space" diagonals. radius [m], by default half the shortest connection; density [kg/m^3]."""
    shape = {"kind": "cubic", "molecules": list(molecules), "spacing": spacing, "connections": list(connections)}
    described = {"lattice": shape} if radius is None else {"lattice": shape, "radius": radius}
    return body(described, _elastin.Material(1.0, density=density))


def read_mesh(path, length_unit, *, radius=None, density=1000.0, thickness=0.0):
    """The body of a mesh file, .msh, .vtk or .vtu of tetrahedra or triangles, or .obj, .stl, .ply, whose numbers are in
    length_unit "m", "cm", "mm", "um" or "nm"; triangles have a thickness [m]."""
    described = {"mesh": {"file": _yaml.quoted(os.fspath(path)), "length_unit": length_unit}}
    if radius is not None:
        described["radius"] = radius
    return body(described, _elastin.Material(1.0, density=density, thickness=thickness))
