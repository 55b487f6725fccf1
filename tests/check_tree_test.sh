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

library() {  # name line…: its CMakeLists.txt
  put "src/$1/CMakeLists.txt" "elastin_library($1 x.cpp)" "${@:2}"
}

umbrella() {  # header…
  put include/elastin/elastin.h '#pragma once' "${@/#/#include \"elastin/}"
  sed -i '2,$s/$/"/' -- "$tree/include/elastin/elastin.h"
}

make_good_tree() {  # once by hand, which takes some hundred processes, then as a copy
  rm -rf -- "$tree"
  if [[ -d $work/good ]]; then cp -R -- "$work/good" "$tree"; return; fi
  mkdir -p -- "$tree"/{scenes,build-x,out,.ci}
  put CMakeLists.txt 'add_subdirectory(src/core)' 'add_subdirectory(src/openmp)' 'if(ELASTIN_CONTACT)' \
    '  add_subdirectory(src/contact)' 'endif()' 'add_subdirectory(src/mesh)' 'add_subdirectory(src/config)' \
    'add_subdirectory(src/lab)' \
    'add_subdirectory(src/command)' 'add_subdirectory(src/c)' 'add_subdirectory(src/python)'
  put README.md
  put .gitignore 'build*/' 'out/'
  put build-x/stray.h 'int x;'
  library core 'elastin_rooms(sources base geometry model laws forces linear solve simulation)' \
    'target_link_libraries(elastin_core PUBLIC Eigen3::Eigen)'
  library openmp 'target_link_libraries(elastin_openmp PUBLIC elastin_core)'
  library contact 'target_link_libraries(elastin_contact PUBLIC elastin_core PRIVATE fcl)'
  library mesh 'target_link_libraries(elastin_mesh PUBLIC elastin_core)'
  library config 'target_link_libraries(elastin_config PUBLIC elastin_core)'
  library lab 'elastin_rooms(sources run scene report' '              study)' \
    'target_link_libraries(elastin_lab PUBLIC elastin_core elastin_contact' \
    '                      PRIVATE elastin_mesh $<BUILD_INTERFACE:nlohmann_json::nlohmann_json>)'
  library command 'target_link_libraries(elastin_command PUBLIC elastin_lab)' \
    'target_link_libraries(elastin PRIVATE elastin_command elastin_openmp elastin_options)'
  library c 'target_link_libraries(elastin_c PRIVATE elastin_lab)'
  library python 'target_link_libraries(elastin_python PRIVATE elastin_lab)'
  umbrella contact/pairs.h core/base/types.h core/model/body.h
  put include/elastin/core/base/types.h '// Types.' '' '#pragma once' '#include <Eigen/Core>' \
    'namespace elastin {' 'enum class Kind : int { a };' 'struct Pair;' '}'
  put include/elastin/core/model/body.h '#pragma once' '#include "elastin/core/base/types.h"' \
    'namespace elastin {' 'class Body final : Base {' '  struct Kind {};' '};' 'struct Pair;' '}'
  put include/elastin/contact/pairs.h '#pragma once' 'namespace elastin { struct Body; }' 'namespace elastin::contact {' \
    'struct Pair {};' 'namespace shape { struct Mesh {}; }' '}'
  put src/openmp/openmp.cpp '#include <omp.h>' '#pragma omp parallel for'
  put src/core/linear/pcg.h '#pragma once' '#include "elastin/core/model/body.h"' 'namespace elastin { struct Pcg {}; }'
  put src/core/laws/uniform.h '#pragma once' '  static constexpr std::string_view name = "uniform";'
  put src/core/solve/newton.h '#pragma once'
  put src/core/simulation/catalog.cpp 'Table steppers() {' '  return {{"euler", "first order"}, {"verlet", "second order"},' \
    '          {"newmark", "two weights"}};' '}'
  put src/contact/pairs.cpp '#include <fcl/fcl.h>' '#include "elastin/contact/pairs.h"'
  put src/mesh/file.h '#pragma once' 'namespace elastin::mesh { struct Mesh {}; }'
  put src/lab/scene/load.h '#pragma once'
  put src/lab/scene/load.cpp '#include "lab/scene/load.h"' '#include <fmt/core.h>' '/* once:' '#include "gone.h"' \
    '*/' '// #include "gone.h"' '#include <sstream>' '#include "core/linear/pcg.h"' '#include "mesh/file.h"' \
    'void read() {' '  at("euler"), at("verlet"), at("newmark");' '  if (a == "euler" || a == "verlet") return;' '}'
  put src/config/reader.cpp '#include <yaml-cpp/yaml.h>'
  put src/lab/report/table.cpp '#include <nlohmann/json.hpp>' '#include "lab/scene/load.h"'
  put src/command/main.cpp '#include "lab/scene/load.h"'
  put include/elastin/c/elastin.h '#pragma once' '#include <stddef.h>'
  put src/c/handles.h '#pragma once' '#include "elastin/c/elastin.h"' '#include "lab/scene/load.h"'
  put src/python/bind.h '#pragma once' '#include <pybind11/numpy.h>' '#include "lab/scene/load.h"'
  put tests/contact/pairs_test.cpp '#include <fcl/fcl.h>'
  put tests/near.h '#pragma once'
  put tests/core/linear/pcg_test.cpp '#include "near.h"' '#include "core/linear/pcg.h"' '#include "elastin/elastin.h"'
  put tests/fuzz/fuzz_test.cpp '#include <iostream>' '#include "lab/scene/load.h"'
  cp -R -- "$tree" "$work/good"
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

broken_by() {  # place words path line… [-- path line…]: the good tree with other files
  local file=("${@:3}") next=() n
  make_good_tree
  for n in "${!file[@]}"; do
    [[ ${file[n]} == -- ]] && next=("${file[@]:n+1}") && file=("${file[@]:0:n}") && break
  done
  put "${file[@]}"
  ((${#next[@]} == 0)) || put "${next[@]}"
  expect "$1" "$2"
}

make_good_tree
expect

broken_by notes.txt:1 'top level' notes.txt
broken_by data:1 'top level' data/x
broken_by build.txt:1 'top level' build.txt

# Arrows between rooms and libraries.
broken_by src/core/solve/newton.cpp:2 'includes "core/simulation/step.h", and core/simulation is above core/solve' \
  src/core/solve/newton.cpp '#include "core/linear/pcg.h"' '#include "core/simulation/step.h"' \
  -- src/core/simulation/step.h '#pragma once'
broken_by src/core/base/sum.cpp:1 'includes "core/solve/newton.h", and core/solve is above core/base' \
  src/core/base/sum.cpp '#include "core/solve/newton.h"'
broken_by src/lab/scene/note.h:2 'includes "lab/study/plan.h", and lab/study is above lab/scene' \
  src/lab/scene/note.h '#pragma once' '#include "lab/study/plan.h"' -- src/lab/study/plan.h '#pragma once'
broken_by src/core/forces/drag.cpp:1 'includes "elastin/contact/pairs.h", but core does not link contact' \
  src/core/forces/drag.cpp '#include <elastin/contact/pairs.h>'
broken_by src/contact/grid.cpp:1 'includes "lab/scene/load.h", but contact does not link lab' \
  src/contact/grid.cpp '#include "lab/scene/load.h"'
broken_by src/command/main.cpp:1 'includes "mesh/file.h", but command does not link mesh' \
  src/command/main.cpp '#include "mesh/file.h"'
broken_by src/core/solve/newton.cpp:1 'includes "elastin/elastin.h", which is for programs' \
  src/core/solve/newton.cpp '#include "elastin/elastin.h"'
broken_by include/elastin/contact/pairs.h:2 'includes "elastin/core/model/body.h", but contact does not link PUBLIC core' \
  include/elastin/contact/pairs.h '#pragma once' '#include "elastin/core/model/body.h"' \
  -- src/contact/CMakeLists.txt 'target_link_libraries(elastin_contact PRIVATE elastin_core)'

make_good_tree
library contact 'target_link_libraries(elastin_contact PUBLIC elastin_core elastin_lab)'
expect src/contact/CMakeLists.txt:2 'links lab, which CMakeLists.txt adds after contact'

# Places.
broken_by src/extras/x.cpp:1 'no folder that is a library' src/extras/x.cpp
broken_by src/x.cpp:1 'no folder that is a library' src/x.cpp
broken_by src/core/x.cpp:1 'stands in no room of core' src/core/x.cpp
broken_by src/lab/extras/x.cpp:1 'stands in no room of lab' src/lab/extras/x.cpp
broken_by tests/core/solver/pcg_test.cpp:1 'there is no src/core/solver' tests/core/solver/pcg_test.cpp
broken_by tests/pcg_test.cpp:1 'tests mirror src' tests/pcg_test.cpp

# The header of all headers.
broken_by include/elastin/elastin.h:1 'does not include elastin/core/model/state.h' \
  include/elastin/core/model/state.h '#pragma once'
make_good_tree
umbrella contact/pairs.h core/base/types.h core/model/body.h c/elastin.h
expect include/elastin/elastin.h:5 'includes elastin/c/elastin.h, which is for C'
# Namespaces.
broken_by src/lab/scene/load.h:3 'is in namespace elastin; that of lab is elastin::lab' \
  src/lab/scene/load.h '#pragma once' '' 'namespace elastin {' 'void load();' '}'
broken_by src/core/solve/newton.h:2 'is in namespace elastin::lab; that of core is elastin' \
  src/core/solve/newton.h '#pragma once' 'namespace elastin::lab {' 'void solve(); }'

# Outside libraries.
broken_by src/core/solve/newton.cpp:1 '<fcl/fcl.h> outside src/contact' src/core/solve/newton.cpp '#include <fcl/fcl.h>'
broken_by src/lab/report/table.cpp:1 '<yaml-cpp/yaml.h> outside src/config' \
  src/lab/report/table.cpp '#include <yaml-cpp/yaml.h>'
broken_by include/elastin/c/elastin.h:2 'a header for C includes <vector>' \
  include/elastin/c/elastin.h '#pragma once' '#include <vector>'
broken_by src/lab/report/table.cpp:1 '<pybind11/stl.h> outside src/python' \
  src/lab/report/table.cpp '#include <pybind11/stl.h>'
broken_by src/mesh/surface.cpp:1 '<voro++/voro++.hh> outside src/mesh/voronoi.cpp' src/mesh/surface.cpp '#include <voro++/voro++.hh>'
broken_by src/core/model/hull.cpp:1 '<libqhull_r/qhull_ra.h> outside src/hull' src/core/model/hull.cpp '#include <libqhull_r/qhull_ra.h>'
broken_by src/core/solve/newton.cpp:1 '<omp.h> outside src/openmp' src/core/solve/newton.cpp '#include <omp.h>'
broken_by src/core/solve/newton.cpp:2 '#pragma omp outside src/openmp' \
  src/core/solve/newton.cpp 'void f() {' '  # pragma omp simd'
broken_by tools/bench/bench.cpp:1 '#pragma omp outside src/openmp' tools/bench/bench.cpp '#pragma omp parallel'

# Public headers.
for stream in iostream fstream sstream; do
  broken_by include/elastin/core/model/body.h:2 "a public header includes <$stream>" \
    include/elastin/core/model/body.h '#pragma once' "#include <$stream>"
done
broken_by include/elastin/core/model/body.h:2 '<yaml-cpp/yaml.h>' \
  include/elastin/core/model/body.h '#pragma once' '#include <yaml-cpp/yaml.h>'
broken_by include/elastin/core/model/body.h:2 'includes the private "core/base/sum.h"' \
  include/elastin/core/model/body.h '#pragma once' '#include "core/base/sum.h"' -- src/core/base/sum.h '#pragma once'

broken_by src/core/solve/newton.cpp:1 'relative to its own folder' src/core/solve/newton.cpp '#include "newton.h"'

broken_by src/core/solve/lean.h:1 'does not start with #pragma once' \
  src/core/solve/lean.h '#include "core/linear/pcg.h"' '#pragma once'
broken_by src/core/solve/lean.h:1 'does not start with #pragma once' src/core/solve/lean.h '// Nothing but words.'

# The graph and its picture name each arrow.
make_good_tree
cases=$((cases + 1))
"$check_tree" --graph "$tree" >"$work/graph"
"$check_tree" --picture "$tree" >"$work/picture"
if ! grep -qF '"core/linear" -> "core/model" [label=1]' "$work/graph" ||
  ! grep -qF '<title>core/linear to core/model: 1</title>' "$work/picture"; then
  failures=$((failures + 1))
  echo "the graph lacks the arrow from core/linear to core/model"
fi

make_good_tree
rm -r -- "$tree/src"
status=0
"$check_tree" "$tree" >"$work/output" 2>&1 || status=$?
cases=$((cases + 1))
[[ $status == 2 ]] || { failures=$((failures + 1)); echo "a folder without src/ gave exit $status"; }

echo "$cases cases, $failures wrong"
((failures == 0))
