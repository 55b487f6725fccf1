#!/usr/bin/env python3
"""Writes the images of this folder next to this file: waist.nrrd, a round bar along z, 12 mm thick in its middle and 18 mm
at its ends, in voxels of a quarter of a millimetre; kidney.nrrd, a bean of two labels, cut off at both ends, in voxels of
3 mm; foam.nrrd, an open-celled foam of square struts; ball.nrrd and torus.nrrd, a ball 20 mm thick and a ring around z
10 mm thick, cut by two planes at 0.8 of their heights; organ.nrrd, a bent ellipsoid, cut off at both ends."""
import gzip
import math
import os


def write(name, size, step, value):
    """Labels value(x, y, z) at the middles of voxels, x, y and z in mm from the middle of the image."""
    axes = [[step * (i + 0.5 - count / 2) for i in range(count)] for count in size]
    labels = bytes(value(x, y, z) for z in axes[2] for y in axes[1] for x in axes[0])
    with open(os.path.join(os.path.dirname(os.path.realpath(__file__)), name + ".nrrd"), "wb") as file:
        file.write(("NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: %d %d %d\n"
                    "space directions: (%g,0,0) (0,%g,0) (0,0,%g)\nspace origin: (%g,%g,%g)\nencoding: gzip\n\n" %
                    (*size, step, step, step, *(axis[0] for axis in axes))).encode())
        file.write(gzip.compress(labels, mtime=0))


def kidney(x, y, z):
    x += 0.01 * z * z - 3
    if (x / 17) ** 2 + (y / 10) ** 2 + (z / 17) ** 2 < 1:
        return 2
    return (x / 30) ** 2 + (y / 19) ** 2 + (z / 34) ** 2 < 1


def foam(x, y, z):
    """Struts of 3 mm along x, y and z through the middles of cells of 10.5 mm."""
    return sum(abs(c % 10.5 - 5.25) < 1.5 for c in (x, y, z)) > 1


def organ(x, y, z):
    return ((x + 0.01 * z * z) / 30) ** 2 + (y / 19) ** 2 + (z / 34) ** 2 < 1


write("ball", (80, 80, 64), 0.25, lambda x, y, z: x * x + y * y + z * z < 100)
write("torus", (208, 208, 64), 0.125, lambda x, y, z: (math.hypot(x, y) - 8) ** 2 + z * z < 25)
write("organ", (140, 84, 88), 21 / 44, organ)
write("foam", (28, 28, 28), 0.75, foam)
write("waist", (80, 80, 48), 0.25, lambda x, y, z: math.hypot(x, y) < 6 + z * z / 12)
write("kidney", (22, 14, 14), 3, kidney)
