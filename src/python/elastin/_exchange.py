"""Bodies and results for other programs: pandas, VTU files, meshio, PyVista."""

import base64
import importlib
import os
import struct
import zlib

import numpy

from . import _elastin
from ._elastin import Body, InputError

# As meshio calls the shapes of the table; all of them number their nodes as VTK does.
MESHIO = {"triangle": "triangle3", "triangle6": "triangle6", "quad": "quadrilateral4", "quad8": "quadrilateral8",
          "quad9": "quadrilateral9", "tetra": "tetrahedron4", "tetra10": "tetrahedron10", "wedge": "prism6",
          "hexahedron": "hexahedron8", "hexahedron20": "hexahedron20", "hexahedron27": "hexahedron27"}
PLANE = ("triangle3", "triangle6", "quadrilateral4", "quadrilateral8", "quadrilateral9")
METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}


def package(name, what):
    """An optional package, or ImportError that says how to get it."""
    try:
        return importlib.import_module(name)
    except ImportError as missing:
        debian = "" if name == "pyvista" else f"apt-get install python3-{name}, or "
        raise ImportError(f"{what} needs {name}: {debian}pip install {name}; every number is in numpy arrays "
                          "without it") from missing


def frame(rows):
    return package("pandas", "to_frame()").DataFrame(rows)


def frame_of_curve(result):
    """The curve as a pandas DataFrame: a row a load step or frame, a column a measure, and `at`, the load factor or time
    [s]."""
    return package("pandas", "to_frame()").DataFrame(result.curve)


def frame_of_results(results):
    rows = []
    for result in results:
        errors = {f"error_{name}": error for name, error in result.errors.items()}
        rows.append({"scene": result.scene, "strategy": result.strategy, "outcome": result.outcome,
                     "cause": result.cause} | result.measures | errors
                    | {"build_seconds": result.build_seconds, "solve_seconds": result.solve_seconds})
    return frame(rows)


class Grid:
    """Points, cells by shape with the connections as lines at the end, and fields on them."""

    def __init__(self, body, positions=None, tensions=None, states=None):
        self.points = numpy.array(body.positions if positions is None else positions)
        self.blocks = list(body.cells.items())
        self.blocks.append(("line", numpy.array(body.connections)))
        self.point_data = {"mass": numpy.array(body.masses), "radius": numpy.array(body.radii)}
        if positions is not None:
            self.point_data["displacement"] = self.points - body.positions
        self.cell_data = {}
        self.blocks = [(name, cells) for name, cells in self.blocks if len(cells)]
        if tensions is not None and len(tensions):
            self.cell_data["tension"] = [numpy.zeros(len(cells)) for _, cells in self.blocks]
            self.cell_data["tension"][-1][:len(tensions)] = tensions
        for ours, theirs in (("strain", "green_strain"), ("stress", "stress")) if states else ():
            self.cell_data[theirs] = [states[name][ours].reshape(-1, 9) if name in states else numpy.zeros((len(cells), 9))
                                      for name, cells in self.blocks]


def vtu_text(grid):
    """[VTK File Formats, XML formats, "binary"]: each array one block, packed by zlib, in base64."""
    def array(name, values, kind):
        values = numpy.ascontiguousarray(values, {"Float64": "<f8", "Int64": "<i8", "UInt8": "u1"}[kind])
        components = f' NumberOfComponents="{values.shape[1]}"' if values.ndim == 2 else ""
        packed = zlib.compress(values.tobytes()) if values.size else b""
        head = struct.pack("<4Q", 1, values.nbytes, 0, len(packed)) if values.size else struct.pack("<3Q", 0, 0, 0)
        text = (base64.b64encode(head) + base64.b64encode(packed)).decode()
        return (f'<DataArray type="{kind}" Name="{name}"{components} format="binary">\n{text}\n'
                "</DataArray>\n")

    kinds = _elastin._cell_kinds() | {"line": 3}
    sizes = numpy.concatenate([numpy.full(len(cells), cells.shape[1]) for _, cells in grid.blocks])
    types = numpy.concatenate([numpy.full(len(cells), kinds[name]) for name, cells in grid.blocks])
    nodes = numpy.concatenate([cells.ravel() for _, cells in grid.blocks])
    return ('<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
            'header_type="UInt64" compressor="vtkZLibDataCompressor">\n<UnstructuredGrid>\n'
            f'<Piece NumberOfPoints="{len(grid.points)}" NumberOfCells="{len(sizes)}">\n'
            f"<Points>\n{array('Points', grid.points, 'Float64')}</Points>\n<Cells>\n"
            f"{array('connectivity', nodes, 'Int64')}{array('offsets', numpy.cumsum(sizes), 'Int64')}"
            f"{array('types', types, 'UInt8')}</Cells>\n<PointData>\n"
            + "".join(array(name, values, "Float64") for name, values in grid.point_data.items())
            + "</PointData>\n<CellData>\n"
            + "".join(array(name, numpy.concatenate(values), "Float64") for name, values in grid.cell_data.items())
            + "</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n")


def write_vtu(grid, path):
    with open(path, "w", encoding="utf8") as stream:
        stream.write(vtu_text(grid))


def meshio_mesh(grid):
    meshio = package("meshio", "to_meshio()")
    names = {ours: theirs for theirs, ours in MESHIO.items()} | {"line": "line"}
    return meshio.Mesh(grid.points, [(names[name], cells) for name, cells in grid.blocks], grid.point_data,
                       grid.cell_data)


def pyvista_grid(grid):
    pyvista = package("pyvista", "to_pyvista()")
    kinds = _elastin._cell_kinds() | {"line": 3}
    made = pyvista.UnstructuredGrid({kinds[name]: cells for name, cells in grid.blocks}, grid.points)
    for name, values in grid.point_data.items():
        made.point_data[name] = values
    for name, values in grid.cell_data.items():
        made.cell_data[name] = numpy.concatenate(values)
    return made


def last_state(result):
    if len(result.positions) == 0:
        raise ValueError(f"there is no state to hand over: {result.outcome}: {result.cause}")
    return Grid(result.body, result.positions, result.tensions)


def body_to_vtu(body, path):
    """Writes the body at rest as a VTU file: its cells, its connections as lines, mass and radius of its molecules."""
    write_vtu(Grid(body), path)


def result_to_vtu(result, path):
    """Writes the last state as a VTU file, with displacements [m] and the tensions of the connections [N]. Where states
    were kept, also each of them, PATH-000.vtu …, and PATH.pvd with their load factors or times."""
    write_vtu(last_state(result), path)
    if not result.states:
        return
    base = os.path.splitext(os.fspath(path))[0]
    rows = []
    for number, (at, positions) in enumerate(result.states):
        name = f"{base}-{number:03d}.vtu"
        write_vtu(Grid(result.body, positions), name)
        rows.append(f'<DataSet timestep="{at!r}" file="{os.path.basename(name)}"/>\n')
    with open(base + ".pvd", "w", encoding="utf8") as stream:
        stream.write('<?xml version="1.0"?>\n<VTKFile type="Collection" version="1.0" byte_order="LittleEndian">\n'
                     "<Collection>\n" + "".join(rows) + "</Collection>\n</VTKFile>\n")


def body_to_meshio(body):
    """A meshio.Mesh of the body at rest."""
    return meshio_mesh(Grid(body))


def result_to_meshio(result):
    """A meshio.Mesh of the last state, with displacements and tensions."""
    return meshio_mesh(last_state(result))


def of_now(simulation):
    return Grid(simulation.body, simulation.positions, numpy.array(simulation.tensions), simulation.cell_states())


def simulation_to_vtu(simulation, path):
    """Writes the present state as a VTU file: displacements [m], tensions of the connections [N], and of cells Green and
    Lagrange's strain and Cauchy's stress [Pa]."""
    write_vtu(of_now(simulation), path)


def simulation_to_meshio(simulation):
    """A meshio.Mesh of the present state, with the fields of to_vtu."""
    return meshio_mesh(of_now(simulation))


def simulation_to_pyvista(simulation):
    """A pyvista.UnstructuredGrid of the present state, with the fields of to_vtu."""
    return pyvista_grid(of_now(simulation))


def body_to_pyvista(body):
    """A pyvista.UnstructuredGrid of the body at rest."""
    return pyvista_grid(Grid(body))


def result_to_pyvista(result):
    """A pyvista.UnstructuredGrid of the last state, with displacements and tensions."""
    return pyvista_grid(last_state(result))


def body_from_meshio(mesh, length_unit="m", **options):
    """The body of a meshio.Mesh, or of a file that meshio reads, in length_unit "m", "cm", "mm", "um" or "nm". Its solid
    cells; without such cells its surface cells; without these its lines as connections. Points that nothing
    uses are left out. Options go to Body: density, thickness."""
    if isinstance(mesh, (str, os.PathLike)):
        mesh = package("meshio", "from_meshio()").read(mesh)
    if length_unit not in METRES:
        raise InputError(f"length_unit: '{length_unit}'" + _elastin._suggestion(length_unit, list(METRES)))
    cells, lines = {}, []
    for block in mesh.cells:
        if block.type == "line":
            lines.append(block.data)
        elif block.type != "vertex":
            if block.type not in MESHIO:
                raise InputError(f"cells of meshio's type '{block.type}'"
                                 + _elastin._suggestion(block.type, list(MESHIO)))
            cells.setdefault(MESHIO[block.type], []).append(block.data)
    if any(name not in PLANE for name in cells):
        cells = {name: blocks for name, blocks in cells.items() if name not in PLANE}
    cells = {name: numpy.concatenate(blocks) for name, blocks in cells.items()}
    lines = numpy.concatenate(lines) if lines and not cells else None
    used = [block.ravel() for block in cells.values()] + ([lines.ravel()] if lines is not None else [])
    if not used:
        raise InputError("the mesh has neither cells nor lines")
    used = numpy.unique(numpy.concatenate(used))
    number = numpy.zeros(len(mesh.points), int)
    number[used] = numpy.arange(len(used))
    points = numpy.zeros((len(used), 3))
    points[:, :numpy.shape(mesh.points)[1]] = numpy.asarray(mesh.points)[used]
    cells = {name: number[block] for name, block in cells.items()}
    if set(cells) <= {"triangle3", "tetrahedron4"}:
        names = {"triangle3": "triangles", "tetrahedron4": "tetrahedra"}
        options |= {names[name]: block for name, block in cells.items()}
    else:
        options["cells"] = cells
    return Body(points * METRES[length_unit], None if lines is None else number[lines], **options)
