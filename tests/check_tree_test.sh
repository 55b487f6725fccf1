#!/usr/bin/env bash
# Each rule of tools/check_tree fires on a small tree that breaks it, and only it; the tree without the fault passes.
set -euo pipefail

check_tree=$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/../tools/check_tree
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
tree="$work/a tree"
cases=0 failures=0

put() {  # path line…
  mkdir -p -- "$(dirname -- "$tree/$1")"
  printf '%s\n' "${@:2}" >"$tree/$1"
}

make_good_tree() {
  rm -rf -- "$tree"
  mkdir -p -- "$tree"/{scenes,build-x,out,.ci}
  put CMakeLists.txt
  put README.md
  put .gitignore 'build*/' 'out/'
  put build-x/stray.h 'int x;'
  put include/elastin/elastin.h '#pragma once' '#include "elastin/contact/pairs.h"' '#include "elastin/core/model/body.h"'
  put include/elastin/base/types.h '// Types.' '' '#pragma once' '#include <Eigen/Core>'
  put include/elastin/model/body.h '#pragma once' '#include "elastin/core/base/types.h"'
  put include/elastin/contact/pairs.h '#pragma once'
  put src/base/parallel.h '#pragma once' '#include <omp.h>' '#pragma omp parallel for'
  put src/solve/pcg.h '#pragma once' '#include "core/parallel/parallel.h"' '#include "elastin/core/model/body.h"'
  put src/contact/pairs.cpp '#include <fcl/fcl.h>' '#include "elastin/contact/pairs.h"'
  put src/scene/load.h '#pragma once'
  put src/scene/load.cpp '#include "scene/load.h"' '#include <yaml-cpp/yaml.h>' '/* once:' '#include "gone.h"' '*/' \
    '// #include "gone.h"' '#include <sstream>' '#include "solve/pcg.h"'
  put include/elastin/face/elastin.h '#pragma once' '#include <stddef.h>'
  put src/face/handles.h '#pragma once' '#include "elastin/c/elastin.h"' '#include "scene/load.h"'
  put src/python/bind.h '#pragma once' '#include <pybind11/numpy.h>' '#include "scene/load.h"'
  put tests/contact/pairs_test.cpp '#include <fcl/fcl.h>'
  put tools/bench/contact.cpp '#include <fcl/fcl.h>'
  put tests/near.h '#pragma once'
  put tests/solve/pcg_test.cpp '#include "near.h"' '#include "solve/pcg.h"' '#include "elastin/elastin.h"'
  put tools/elastin.cpp '#include <iostream>' '#include "scene/load.h"'
}

expect() {  # file:line words, or nothing where the tree is good
  local output status=0
  output=$("$check_tree" "$tree" 2>&1) || status=$?
  cases=$((cases + 1))
  if (($# == 0)); then
    [[ $status == 0 && -z $output ]] && return
  else  # one violation, one line, at the right place, in the right words
    [[ $status == 1 && $output == "$1: "*"$2"* && $output != *$'\n'* ]] && return
  fi
  failures=$((failures + 1))
  printf 'expected %s\ngot (exit %s) %s\n\n' "${*:-no violation}" "$status" "${output:-nothing}"
}

broken_by() {  # place words path line…: the good tree with one more or other file
  make_good_tree
  put "${@:3}"
  expect "$1" "$2"
}

make_good_tree
expect

broken_by notes.txt:1 'top level' notes.txt
broken_by data:1 'top level' data/x
broken_by build.txt:1 'top level' build.txt

broken_by src/solve/newton.cpp:2 'solve (floor 2) includes "scene/load.h" from scene (floor 4)' \
  src/solve/newton.cpp '#include "solve/pcg.h"' '#include "scene/load.h"'
broken_by src/model/shape.cpp:1 'model (floor 0) includes "solve/pcg.h"' src/model/shape.cpp '#include "solve/pcg.h"'
broken_by src/forces/drag.cpp:1 'forces (floor 1) includes "elastin/contact/pairs.h"' \
  src/forces/drag.cpp '#include <elastin/contact/pairs.h>'
broken_by include/elastin/model/mesh.h:2 'model (floor 0) includes "elastin/contact/pairs.h" from contact (floor 3)' \
  include/elastin/model/mesh.h '#pragma once' '#include "elastin/contact/pairs.h"'
broken_by src/solve/newton.cpp:1 'solve (floor 2) includes "elastin/elastin.h"' \
  src/solve/newton.cpp '#include "elastin/elastin.h"'
broken_by src/contact/grid.cpp:1 'contact (floor 3) includes "scene/load.h"' src/contact/grid.cpp '#include "scene/load.h"'
make_good_tree
put include/elastin/scene/scene.h '#pragma once'
put include/elastin/elastin.h '#pragma once' '#include "elastin/scene/scene.h"'
expect include/elastin/elastin.h:2 'from scene (floor 4)'
broken_by src/base/sum.cpp:1 'base includes "elastin/model/body.h" from model' \
  src/base/sum.cpp '#include "elastin/core/model/body.h"'
broken_by src/extras/x.cpp:1 'no folder that has a floor' src/extras/x.cpp
broken_by src/x.cpp:1 'no folder that has a floor' src/x.cpp
broken_by include/elastin/version.h:1 'no folder that has a floor' include/elastin/version.h '#pragma once'

broken_by src/solve/newton.cpp:1 '<fcl/fcl.h> outside src/contact' src/solve/newton.cpp '#include <fcl/fcl.h>'
broken_by src/report/table.cpp:1 '<yaml-cpp/yaml.h> outside src/scene' src/report/table.cpp '#include <yaml-cpp/yaml.h>'
broken_by include/elastin/face/elastin.h:2 'a header for C includes <vector>' \
  include/elastin/face/elastin.h '#pragma once' '#include <vector>'
broken_by src/report/table.cpp:1 '<pybind11/stl.h> outside src/python' src/report/table.cpp '#include <pybind11/stl.h>'
broken_by src/scene/load.h:2 'scene (floor 4) includes "python/bind.h" from python (floor 5)' \
  src/scene/load.h '#pragma once' '#include "python/bind.h"'
broken_by src/solve/newton.cpp:1 '<omp.h> outside src/base/parallel' src/solve/newton.cpp '#include <omp.h>'
broken_by src/solve/newton.cpp:2 '#pragma omp outside src/base/parallel' src/solve/newton.cpp 'void f() {' '  # pragma omp simd'
broken_by tools/bench/bench.cpp:1 '#pragma omp outside src/base/parallel' tools/bench/bench.cpp '#pragma omp parallel'

for stream in iostream fstream sstream; do
  broken_by include/elastin/model/mesh.h:2 "a public header includes <$stream>" \
    include/elastin/model/mesh.h '#pragma once' "#include <$stream>"
done
broken_by include/elastin/model/mesh.h:2 '<yaml-cpp/yaml.h>' \
  include/elastin/model/mesh.h '#pragma once' '#include <yaml-cpp/yaml.h>'
broken_by include/elastin/base/parallel.h:2 '<omp.h>' include/elastin/base/parallel.h '#pragma once' '#include <omp.h>'
broken_by include/elastin/contact/fcl.h:2 '<fcl/fcl.h>' \
  include/elastin/contact/fcl.h '#pragma once' '#include <fcl/fcl.h>'
broken_by include/elastin/simulation/step.h:2 'includes the private "solve/pcg.h"' \
  include/elastin/simulation/step.h '#pragma once' '#include "solve/pcg.h"'

broken_by src/solve/newton.cpp:1 '"solve/gone.h", which is not in the tree' src/solve/newton.cpp '#include "solve/gone.h"'
broken_by src/solve/newton.cpp:1 '"elastin/gone.h", which is not in the tree' \
  src/solve/newton.cpp '#include <elastin/gone.h>'
broken_by tests/solve/pcg_test.cpp:1 '"gone.h", which is not in the tree' tests/solve/pcg_test.cpp '#include "gone.h"'
broken_by src/solve/newton.cpp:1 'relative to its own folder' src/solve/newton.cpp '#include "pcg.h"'

broken_by src/solve/lean.h:1 'does not start with #pragma once' src/solve/lean.h '#include "solve/pcg.h"' '#pragma once'
broken_by src/solve/lean.h:1 'does not start with #pragma once' src/solve/lean.h '// Nothing but words.'

make_good_tree
rm -r -- "$tree/src"
status=0
"$check_tree" "$tree" >"$work/output" 2>&1 || status=$?
cases=$((cases + 1))
[[ $status == 2 ]] || { failures=$((failures + 1)); echo "a folder without src/ gave exit $status"; }

echo "$cases cases, $failures wrong"
((failures == 0))
