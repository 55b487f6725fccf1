"""Bodies as scenes describe them."""

import logging
import os
import warnings

from . import _elastin, _exchange, _own, _pictures, _scenes, _tables
from ._elastin import Body

_log = logging.getLogger("elastin")


def body(description, material=None):
    """A body as a scene has it under `body:`: elastin.body({"lattice": {"kind": "cubic", "molecules": [5, 5, 5],
    "spacing": 1e-3}}), a dict or its YAML. Every shape of the scenes is there, with the same keys and messages; files are
    named from the working directory. The material, or what `material` takes, gives it its mass, by default that with which
    the body is used. What makes results doubtful is a warning; how a file was read goes to the logger "elastin"."""
    if material is not None and not isinstance(material, _elastin.Material):
        material = _read_material(material)
    return _made(description, material or _elastin.Material(1.0), material is None)


def _made(description, material, assumed):
    if isinstance(description, str):
        made, remarks, notes = _elastin._body_of_scene(description, material, assumed)
    else:
        held = _scenes.Held(description, "body")
        with held.messages():
            made, remarks, notes = _elastin._body_of_scene(held.source, material, assumed)
    for remark in remarks:
        warnings.warn(remark, stacklevel=2)
    for note in notes:
        _log.info(note)
    return made


def material(description):
    """A material as a scene has it under `material:`: elastin.material({"law": "ogden", "terms": [[6.3e5, 1.3]],
    "bulk_modulus": 1e9, "relaxation": {"terms": [[0.5, 1.0]]}}), a dict or its YAML, with the same keys and messages: laws,
    curves, fibres, muscle, relaxation, softening. Plain numbers are SI; files are named from the working
    directory."""
    if isinstance(description, str):
        return _elastin._material_of_scene(description)
    held = _scenes.Held(description, "material")
    with held.messages():
        return _elastin._material_of_scene(held.source, _own.catalog_with(None, held.own))


_read_material = material


def lattice(molecules, spacing, connections=("axis", "face"), *, radius=None, density=None):
    """A cubic lattice of (nx, ny, nz) molecules, `spacing` [m] apart (a number, or one along x, y and z), joined along
    "axis", "face" and "space" diagonals. radius [m], by default half the shortest connection; density [kg/m^3], by default
    that of the material with which the body is used."""
    shape = {"kind": "cubic", "molecules": list(molecules), "spacing": spacing, "connections": list(connections)}
    described = {"lattice": shape} if radius is None else {"lattice": shape, "radius": radius}
    return _made(described, _with(density), density is None)


def read_mesh(path, length_unit, *, radius=None, density=None, thickness=0.0):
    """The body of a mesh file, of any kind that body.mesh of a scene reads, whose numbers are in length_unit "m", "cm",
    "mm", "um" or "nm"; triangles have a thickness [m]. radius and density as for lattice."""
    described = {"mesh": {"file": os.fspath(path), "length_unit": length_unit}}
    if radius is not None:
        described["radius"] = radius
    return _made(described, _with(density, thickness=thickness), density is None)


def _with(density, **others):
    return _elastin.Material(1.0, **others, **({} if density is None else {"density": density}))


def _plot(body, ax=None, **options):
    """The body at rest in 3D. Options go to Line3DCollection."""
    from . import _plots
    return _plots.state(body.positions, body, None, "", ax, options)


def _view(body):
    """The body at rest in 3D: a View."""
    return _pictures.View(_elastin._view(body))


Body._repr_html_ = lambda body: _tables.with_picture(_tables.of_body(body), _pictures.of_body(body))
Body.from_meshio = staticmethod(_exchange.body_from_meshio)
for _name, _method in (("plot", _plot), ("view", _view), ("to_vtu", _exchange.body_to_vtu), ("to_meshio", _exchange.body_to_meshio),
                       ("to_pyvista", _exchange.body_to_pyvista)):
    _method.__name__, _method.__qualname__ = _name, f"Body.{_name}"
    setattr(Body, _name, _method)
