"""Writes the mesh fixtures of mesh_file_test.cpp: one box of 6 tetrahedra, 1 x 2 x 0.5, in each format and encoding,
by three writers that are not ours: Gmsh 4.8, meshio 5.0 and VTK 9.1.

    python3 make_fixtures.py        (needs the command gmsh, and the modules meshio and vtk)
"""
import pathlib
import subprocess

import meshio
from vtkmodules.vtkCommonDataModel import VTK_LINE, VTK_TETRA, VTK_TRIANGLE, VTK_VERTEX, vtkUnstructuredGrid
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkIOLegacy import vtkUnstructuredGridWriter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

here = pathlib.Path(__file__).parent

GEO = """
Point(1) = {0, 0, 0};
Extrude {1, 0, 0} { Point{1}; Layers{1}; }
Extrude {0, 2, 0} { Curve{1}; Layers{1}; }
Extrude {0, 0, 0.5} { Surface{5}; Layers{1}; }
"""

GROUPS = """
Physical Surface("base", 7) = {5};
Physical Volume("whole body", 8) = {1};
Physical Point("corner", 9) = {1};
"""


def gmsh_files():
    geo = here / "box.geo"
    geo.write_text(GEO)
    for name, options in {
        "gmsh_22.msh": ["-format", "msh22"],
        "gmsh_22_binary.msh": ["-format", "msh22", "-bin"],
        "gmsh_41.msh": ["-format", "msh41"],
        "gmsh_41_binary.msh": ["-format", "msh41", "-bin"],
        "gmsh_order_2.msh": ["-format", "msh41", "-order", "2"],
        "gmsh_1.msh": ["-format", "msh1", "-save_all"],
        "gmsh.unv": ["-format", "unv", "-save_all"],
        "gmsh.bdf": ["-format", "bdf", "-save_all"],
        "gmsh_order_2.unv": ["-format", "unv", "-order", "2", "-save_all"],
        "gmsh_order_2.bdf": ["-format", "bdf", "-order", "2", "-save_all"],
        "gmsh_20.vtk": ["-format", "vtk"],
        "gmsh_20_binary.vtk": ["-format", "vtk", "-bin"],
    }.items():
        subprocess.run(["gmsh", geo, "-3", "-v", "1", *options, "-o", here / name], check=True)
    geo.write_text(GEO + GROUPS)
    for name, options in {
        "gmsh_groups_22.msh": ["-format", "msh22"],
        "gmsh_groups_41.msh": ["-format", "msh41"],
        "gmsh_groups_41_binary.msh": ["-format", "msh41", "-bin"],
    }.items():
        subprocess.run(["gmsh", geo, "-3", "-v", "1", *options, "-o", here / name], check=True)
    geo.unlink()


def meshio_files(mesh):
    meshio.vtk.write(here / "meshio_42.vtk", mesh, fmt_version="4.2", binary=False)
    meshio.vtk.write(here / "meshio_42_binary.vtk", mesh, fmt_version="4.2", binary=True)
    meshio.vtk.write(here / "meshio_51.vtk", mesh, fmt_version="5.1", binary=False)
    meshio.vtk.write(here / "meshio_51_binary.vtk", mesh, fmt_version="5.1", binary=True)
    meshio.vtu.write(here / "meshio_ascii.vtu", mesh, binary=False)
    meshio.vtu.write(here / "meshio_base64.vtu", mesh, compression=None)
    meshio.vtu.write(here / "meshio_zlib.vtu", mesh, compression="zlib")


def vtk_grid(mesh):
    points = vtkPoints()
    points.SetDataTypeToDouble()
    for point in mesh.points:
        points.InsertNextPoint(*point)
    grid = vtkUnstructuredGrid()
    grid.SetPoints(points)
    types = {"vertex": VTK_VERTEX, "line": VTK_LINE, "triangle": VTK_TRIANGLE, "tetra": VTK_TETRA}
    for block in mesh.cells:
        for cell in block.data:
            grid.InsertNextCell(types[block.type], len(cell), [int(corner) for corner in cell])
    return grid


def vtk_files(grid):
    for mode in ("appended", "binary", "ascii"):
        for encoding in ("raw", "base64") if mode == "appended" else ("",):
            for packed in (False, True) if mode != "ascii" else (False,):
                writer = vtkXMLUnstructuredGridWriter()
                name = "_".join(word for word in ("vtk", mode, encoding, "zlib" if packed else "") if word)
                writer.SetFileName(str(here / (name + ".vtu")))
                writer.SetInputData(grid)
                writer.SetDataMode({"appended": writer.Appended, "binary": writer.Binary, "ascii": writer.Ascii}[mode])
                writer.SetEncodeAppendedData(encoding == "base64")
                writer.SetHeaderTypeToUInt64() if encoding == "raw" else writer.SetHeaderTypeToUInt32()
                if packed:
                    writer.SetCompressorTypeToZLib()
                    writer.SetBlockSize(64)  # several blocks, the last one not full
                else:
                    writer.SetCompressorTypeToNone()
                    if mode == "binary":
                        writer.SetByteOrderToBigEndian()
                writer.Write()
    for binary in (False, True):
        writer = vtkUnstructuredGridWriter()
        writer.SetFileName(str(here / ("vtk_51_binary.vtk" if binary else "vtk_51.vtk")))
        writer.SetInputData(grid)
        writer.SetFileTypeToBinary() if binary else writer.SetFileTypeToASCII()
        writer.Write()


gmsh_files()
box = meshio.read(here / "gmsh_41.msh")
box = meshio.Mesh(box.points, box.cells)
meshio_files(box)
vtk_files(vtk_grid(box))
