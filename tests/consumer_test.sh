#!/usr/bin/env bash
# The outside project of tests/consumer, built as its users would; the tests at the end of CMakeLists.txt call it.
#   consumer_test.sh install BUILD        installs to a fresh prefix, moves that, builds the project on it
#   consumer_test.sh alone BUILD          its program on elastin::core needs Eigen and nothing else
#   consumer_test.sh law BUILD            its own law stands in the command's comparison next to the others
#   consumer_test.sh parts BUILD          its own stepper, load, and experiment with a measure of its own give the closed forms
#   consumer_test.sh c BUILD              the example in C runs on the installed shared library
#   consumer_test.sh pkg-config BUILD     the same program by pkg-config
#   consumer_test.sh subdirectory BUILD   the project with Elastin's sources inside, as a shared library: builds the core, a few minutes
set -euo pipefail

what=$1 build=$(readlink -f -- "$2")
source=$(dirname -- "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")")
work=$build/consumer
compiler=$(sed -n 's/^CMAKE_CXX_COMPILER:[A-Z]*=//p' "$build/CMakeCache.txt")
generator=$(sed -n 's/^CMAKE_GENERATOR:[A-Z]*=//p' "$build/CMakeCache.txt")
launcher=$(sed -n 's/^CMAKE_CXX_COMPILER_LAUNCHER:[A-Z]*=//p' "$build/CMakeCache.txt")
fail() { echo "$*"; exit 1; }

build_project() {  # folder, flags for cmake…
  local folder=$1
  shift
  rm -rf -- "$folder"
  cmake -S "$source/tests/consumer" -B "$folder" -G "$generator" -DCMAKE_CXX_COMPILER="$compiler" \
    -DCMAKE_CXX_COMPILER_LAUNCHER="$launcher" "$@"
  cmake --build "$folder" --parallel 2
}

# Its shared libraries and symbols are those of a program that knows Eigen and nothing else.
links_eigen_alone() {
  local program=$1 needed symbols
  needed=$(readelf -d "$program" | sed -n 's/.*(NEEDED).*\[\(.*\)\].*/\1/p')
  ! grep -vE '^(libstdc\+\+|libm|libgcc_s|libc|ld-linux.*)\.so' <<<"$needed" || fail "$program needs more than C++"
  symbols=$(nm -C "$program")
  grep -q elastin::solve_static <<<"$symbols" || fail "$program: no symbols of elastin::core to look at"
  ! grep -iE 'fcl::|octomap::|YAML::|GOMP_|omp_get|__kmpc|fmt::|qh_|pugi::' <<<"$symbols" ||
    fail "$program has symbols of a library that elastin::core does without"
}

case $what in
  install)
    rm -rf -- "$work"
    cmake --install "$build" --prefix "$work/first" >/dev/null
    mv -- "$work/first" "$work/prefix"  # the place it was installed to must not matter
    ! grep -rlF -e "$source" -e "$build" -e libvoro --include='*.cmake' --include='*.pc' "$work/prefix" ||
      fail "the installed package names a place on this machine"
    if [[ -e $build/web/bin/elastin.wasm ]]; then  # goes with the command
      "$work/prefix/bin/elastin" lab "$source/scenes/tension/table1-a.yaml" --out "$work/lab.html" >/dev/null
    fi
    build_project "$work/build" -DCMAKE_PREFIX_PATH="$work/prefix"
    ;;
  alone)
    "$work/build/core_alone"
    links_eigen_alone "$work/build/core_alone"
    # In a shared library of its user's the core is nobody else's business.
    "$compiler" -shared -o "$work/plugin.so" -Wl,--whole-archive "$work"/prefix/lib*/libelastin_core.a \
      -Wl,--no-whole-archive
    ! nm -DC --defined-only "$work/plugin.so" | grep elastin:: || fail "elastin::core shows its symbols"
    ;;
  law)
    cd -- "$work/build"
    table=$(NO_COLOR=1 ./own_law compare "$source/tests/consumer/cube.yaml") || fail "$table"
    [[ $table == *$'\n'"  columns   10.000 kPa"* ]] || fail "no row of the program's own law: $table"
    ;;
  parts) "$work/build/own_parts" "$source"/tests/consumer/{ratchet,hanging}.yaml ;;
  c)
    "$work/build/from_c"
    # A program in C needs neither Eigen nor C++ to find the library.
    mkdir -p -- "$work/slim"
    cat >"$work/slim/CMakeLists.txt" <<END
cmake_minimum_required(VERSION 3.22)
project(slim C)
find_package(elastin 0.2 CONFIG REQUIRED COMPONENTS c_slim)
add_executable(from_c $source/tests/examples/embed.c)
target_link_libraries(from_c PRIVATE elastin::c_slim m)
END
    cmake -S "$work/slim" -B "$work/slim/build" -DCMAKE_PREFIX_PATH="$work/prefix" -DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON
    cmake --build "$work/slim/build"
    "$work/slim/build/from_c"
    ;;
  pkg-config)
    export PKG_CONFIG_PATH=$work/prefix/lib/pkgconfig:$work/prefix/lib64/pkgconfig
    # shellcheck disable=SC2046  # flags are words
    $launcher "$compiler" -std=c++20 -c "$source/tests/consumer/core_alone.cpp" -o "$work/core_alone.o" \
      $(pkg-config --cflags elastin-core)
    # shellcheck disable=SC2046
    "$compiler" "$work/core_alone.o" -o "$work/core_alone" $(pkg-config --libs elastin-core)
    "$work/core_alone"
    links_eigen_alone "$work/core_alone"
    # Compiled for wider vectors it would crash: Eigen there frees memory in another way than the library takes it.
    if [[ $(uname -m) == x86_64 ]]; then
      # shellcheck disable=SC2046
      refusal=$("$compiler" -std=c++20 -mavx -fsyntax-only -x c++ $(pkg-config --cflags elastin-core) \
        -include elastin/core/base/types.h /dev/null 2>&1 || true)
      [[ $refusal == *"compiled for other vectors"* ]] || fail "a program with other alignment is not refused: $refusal"
    fi
    ;;
  subdirectory)
    build_project "$work/subdirectory" -DELASTIN_SOURCE="$source" -DELASTIN_UNITY=ON -DELASTIN_WERROR=ON -DBUILD_SHARED_LIBS=ON \
      -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG=-O0 \
      -DCMAKE_DISABLE_FIND_PACKAGE_fcl=ON -DCMAKE_DISABLE_FIND_PACKAGE_yaml-cpp=ON
    [[ ! -e $work/subdirectory/bin ]] || fail "Elastin changed where the project's programs go"
    "$work/subdirectory/core_alone"
    links_eigen_alone "$(find "$work/subdirectory" -name 'libelastin_core.so')"
    ;;
  *) fail "unknown: $what" ;;
esac
