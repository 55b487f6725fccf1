#!/usr/bin/env python3
"""The site of tools/docs is built without a warning, and each of its links leads to a page, a file or a heading that is there.

  docs_test.py ROOT BUILD      77 where a Debian package for it is missing
"""
import glob
import os
import re
import subprocess
import sys
from urllib.parse import unquote


def main(root, build):
    needs = subprocess.run(["/usr/bin/python3", "-c", "import sphinx, myst_parser, elastin"], capture_output=True, text=True, check=False,
                           env=os.environ | {"PYTHONPATH": f"{build}/python"})
    if needs.returncode:
        print(f"skipped: {needs.stderr.strip().splitlines()[-1]} (Debian: python3-sphinx python3-myst-parser; the module: tools/setup)")
        return 77
    subprocess.run([f"{root}/tools/docs", "--quick"], check=True, env=os.environ | {"ELASTIN_BUILD_DIR": build})
    html = f"{build}/docs/html"
    names, links = {}, []
    for page in glob.glob(f"{html}/**/*.html", recursive=True):
        with open(page, encoding="utf8") as stream:
            text = stream.read()
        names[page] = set(re.findall(r'\bid="([^"]*)"', text))
        links += [(page, link) for link in re.findall(r'\b(?:href|src)="([^"]*)"', text) if not re.match(r"[a-z]+:", link)]
    dead = []
    for page, link in links:
        path, _, heading = unquote(link).partition("#")
        file = os.path.normpath(os.path.join(os.path.dirname(page), path.split("?")[0])) if path else page
        if not os.path.exists(file) or heading and file in names and heading not in names[file]:
            dead.append(f"{os.path.relpath(page, html)}: {link}")
    print(*sorted(set(dead)), f"{len(links)} links in {len(names)} pages, {len(dead)} dead", sep="\n")
    python = open(f"{html}/python.html", encoding="utf8").read()
    for name in ("Simulation.settle", "compare", "Tension", "InputError"):  # of C++, of Python, of the table of experiments, an error
        assert f'id="elastin.{name}"' in python, f"python.html does not describe {name}"
    index = open(f"{html}/genindex.html", encoding="utf8").read()
    for name in ("Simulation", "add_part", "elastin_step", "elastin_arrays", "ElasticTerms"):  # of C++ and of C
        assert re.search(rf">{name}<", index), f"the index of C++ and C lacks {name}"
    return 1 if dead or len(links) < 1000 else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
