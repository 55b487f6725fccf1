#!/usr/bin/env python3
"""What the documents show and do not quote from a file: command lines, Python, C++. Files that they quote are tests of their own, and
tests/web/npm_test.js runs the example in JavaScript.

  snippets_test.py ROOT BUILD
"""
import functools
import glob
import os
import re
import subprocess
import sys
import tempfile

DOCUMENTS = "README.md scenes/README.md include/elastin/README.md src/README.md tests/README.md tools/bench/README.md".split()
COMMAND = re.compile(r"(?:tools/run|(?:build/bin/|\./)?\belastin) ([a-z]+) (.*)")
CPP_NAMES = """
#include <vector>
#include "elastin/contact/contact.h"
#include "elastin/core/model/embedded_surface.h"
#include "elastin/core/simulation/simulation.h"
#include "elastin/mesh/voronoi.h"
using namespace elastin;
"""
CPP_ARGUMENTS = "Body body, const Catalog& catalog, const Material& material, Simulation& tissue, const Positions& points, " \
                "const Cells<3>& triangles, contact::ContactOptions touch, const Vector3& next"
PYTHON_NAMES = """
import sys, types, concurrent.futures, numpy, elastin
try: import dask.distributed
except ImportError:  # the document says that an executor will do, too
    sys.modules["dask"] = sys.modules["dask.distributed"] = types.SimpleNamespace(Client=lambda: concurrent.futures.ThreadPoolExecutor(2))
bone = elastin.body({"tetrahedra": {"kind": "kuhn", "cubes": [1, 1, 3], "size": ["4 mm", "4 mm", "12 mm"]}})
positions, tetrahedra, material = bone.positions, bone.tetrahedra, elastin.Material(5e3, 0.3)
muscle = elastin.Body(positions + [4e-3, 0, 0], tetrahedra=tetrahedra)
bar, pull = bone, elastin.Tension(axis="z", strain=0.15, grips="clamped")
"""


def blocks(path):
    """(line, language, text) of each block that is not quoted from a file; an indented one has the language ""."""
    lines, found, inside = open(path, encoding="utf8").read().split("\n"), [], None
    for number, line in enumerate(lines, 1):
        if inside is None and line.startswith("```"):
            inside, start, quoted = line[3:], number, lines[number - 2].startswith("<!-- ")
        elif inside is not None and line.startswith("```"):
            if not quoted:
                found.append((start, inside, "\n".join(lines[start:number - 1])))
            inside = None
        elif inside is None and line.startswith("    ") and line.strip():
            if found and found[-1][1] == "" and found[-1][0] + found[-1][2].count("\n") + 1 >= number - 1 and lines[number - 2][:4].strip() == "":
                found[-1] = (found[-1][0], "", found[-1][2] + "\n" * (number - found[-1][0] - found[-1][2].count("\n")) + line[4:])
            else:
                found.append((number, "", line[4:]))
    return found


@functools.lru_cache
def help_of(program, command):
    return subprocess.run([program, command, "--help"], capture_output=True, text=True, check=False)


def faults_of_commands(root, build, document, shown):
    """A command line names a command, options and scenes that are there."""
    for start, _, text in shown:
        for line in text.replace("\\\n", " ").split("\n"):
            asked = COMMAND.match(line)
            if not asked:
                continue
            told = help_of(f"{build}/bin/elastin", asked[1])
            if told.returncode:
                yield f"{document}:{start}: there is no command '{asked[1]}'"
            for option in re.findall(r"(?<=\s)--[a-z][-a-z]*", asked[2].split("#")[0]):
                if not re.search(rf"{option}\b", told.stdout):
                    yield f"{document}:{start}: {asked[1]} has no {option}"
            for scene in re.findall(r"\bscenes/\S+", asked[2]):
                if not glob.glob(f"{root}/{scene}"):
                    yield f"{document}:{start}: there is no {scene}"
            COUNTS["command lines"] += 1


def faults_of_features(root, build, python):
    """Each cell of the table of features names what is there, or says after a dash why nothing is."""
    read = lambda *paths: "\n".join(open(path, encoding="utf8").read() for path in paths)
    text = read(f"{root}/include/elastin/README.md").split("## Features in each language")[1].split("\n## ")[0]
    sources = [read(f"{root}/scenes/README.md"), read(*glob.glob(f"{root}/include/**/*.h", recursive=True), *glob.glob(f"{root}/src/core/**/*.h", recursive=True)),
               read(f"{root}/tests/c/symbols.txt"), None, read(f"{root}/src/web/npm/index.d.ts")]
    of_python = []
    for row in re.findall(r"^\| (?!feature|-)(.*) \|$", text, re.M):
        feature, *cells = row.split(" | ")
        COUNTS["rows of features"] += 1
        for column, (cell, source) in enumerate(zip(cells, sources)):
            names = [] if cell.startswith("— ") else re.findall(r"`([^`]+)`", cell)
            if not names and not re.match(r"— \w", cell) or len(cells) != len(sources):
                yield f"features: {feature}: column {column + 1} neither names something nor says why not"
            for name in names:
                if source is None:
                    of_python.append(name)
                elif name.startswith("elastin "):
                    yield from faults_of_commands(root, build, "features", [(feature, "", name + " ")])
                elif not re.search(rf"\b{name}\b", source):
                    yield f"features: {feature}: column {column + 1} has no {name}"
    if python:
        yield from fault_of("features: Python", root, build, [python], ".py", "import elastin\n" + "".join(f"elastin.{name}\n" for name in of_python))


def fault_of(what, root, build, command, suffix, text):
    with tempfile.NamedTemporaryFile("w", suffix=suffix, encoding="utf8") as stream:
        stream.write(text)
        stream.flush()
        ended = subprocess.run([*command, stream.name], capture_output=True, text=True, check=False, cwd=root,
                               env=os.environ | {"PYTHONPATH": f"{build}/python"})
    return [f"{what}: {(ended.stderr or ended.stdout)[-1500:]}"] if ended.returncode else []


COUNTS = {"rows of features": 0, "command lines": 0, "pieces of Python": 0, "pieces of C++": 0}


def main(root, build, python):
    cache = open(f"{build}/CMakeCache.txt", encoding="utf8").read()
    compiler = re.search(r"^CMAKE_CXX_COMPILER:\w+=(.*)", cache, re.M).group(1)
    eigen = re.search(r"^Eigen3_DIR:\w+=(.*)/share/eigen3/cmake", cache, re.M)
    faults, cpp = list(faults_of_features(root, build, python)), CPP_NAMES
    for document in DOCUMENTS:
        shown = blocks(f"{root}/{document}")
        faults += faults_of_commands(root, build, document, shown)
        for start, language, text in shown:
            if language == "python" and python:
                COUNTS["pieces of Python"] += 1
                faults += fault_of(f"{document}:{start}", root, build, [python], ".py", PYTHON_NAMES + text)
            if document.startswith("include/") and language == "" and re.search(r";\s*(//.*)?$", text, re.M):
                COUNTS["pieces of C++"] += 1
                text = re.sub(r"^…$", "", text, flags=re.M).replace("…", ";")
                cpp += f'void shown_{start}({CPP_ARGUMENTS}) {{\n#line {start} "{document}"\n{text}\n}}\n'
    if "ELASTIN_CONTACT:BOOL=OFF" not in cache:
        flags = ["-std=c++20", "-fsyntax-only", f"-I{root}/include", f"-I{eigen[1] if eigen else '/usr'}/include/eigen3"]
        faults += fault_of("C++", root, build, [compiler, *flags], ".cpp", cpp)
    for file in [*DOCUMENTS, *(os.path.relpath(path, root) for pattern in ("tests/examples/*.*", "include/**/*.h")
                              for path in glob.glob(f"{root}/{pattern}", recursive=True))]:
        if re.search(r"\bmodel\(\)\.add\(", open(f"{root}/{file}", encoding="utf8").read()):
            faults.append(f"{file}: a simulation with loads that are added to its model() directly refuses a cut")
    print(*faults, ", ".join(f"{count} {what}" for what, count in COUNTS.items()), sep="\n")
    return 1 if faults or COUNTS["command lines"] < 15 or COUNTS["pieces of C++"] < 5 else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
