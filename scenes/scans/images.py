#!/usr/bin/env python3
"""Writes waist.nrrd next to this file: a round bar along z, 12 mm thick in its middle and 18 mm at its ends, in voxels of
a quarter of a millimetre."""
import gzip
import math
import os

SIZE, STEP = (80, 80, 48), 0.25  # voxels; mm

x, y, z = ([STEP * (i + 0.5 - count / 2) for i in range(count)] for count in SIZE)
filled = bytes(math.hypot(a, b) < 6 + c * c / 12 for c in z for b in y for a in x)
with open(os.path.join(os.path.dirname(os.path.realpath(__file__)), "waist.nrrd"), "wb") as file:
    file.write(("NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: %d %d %d\n"
                "space directions: (%g,0,0) (0,%g,0) (0,0,%g)\nspace origin: (%g,%g,%g)\nencoding: gzip\n\n" %
                (*SIZE, STEP, STEP, STEP, x[0], y[0], z[0])).encode())
    file.write(gzip.compress(filled, mtime=0))
