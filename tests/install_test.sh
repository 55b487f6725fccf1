#!/usr/bin/env bash
# Each way to install Elastin that needs no network, tried in an empty folder: one line a way with its seconds and its size.
#   install_test.sh BUILD [deb]      deb: also Debian's packages, whose compression takes a minute
#   CPM_CMAKE=FILE                   also CPM, whose CPM.cmake is this file
set -euo pipefail
build=$(readlink -f -- "$1")
source=$(dirname -- "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")")
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT

try() {  # way, folder of which the size counts, function
  local begin=$EPOCHREALTIME log=$work/log
  mkdir -p -- "$work/empty" && cd -- "$work/empty"
  "$3" >"$log" 2>&1 || { echo "$1: failed"; tail -n 20 -- "$log"; exit 1; }
  printf '%-28s %6.1f s %8s  works\n' "$1" "$(awk "BEGIN {print $EPOCHREALTIME - $begin}")" "$(du -sLh -- "$2" | cut -f1)"
  cd / && rm -rf -- "$work/empty"
}
prefix=$work/prefix
CMAKE_GENERATOR=$(sed -n 's/^CMAKE_GENERATOR:[A-Z]*=//p' "$build/CMakeCache.txt")  # make may be missing
export CMAKE_GENERATOR LC_ALL=C
export LD_LIBRARY_PATH='' CMAKE_PREFIX_PATH=$prefix PKG_CONFIG_PATH=$prefix/lib/pkgconfig:$prefix/lib64/pkgconfig

installed() {
  cmake --install "$build" --prefix "$prefix" && "$prefix/bin/elastin" run "$source/scenes/tension/table1-a.yaml"
}
found_by_cmake() {  # libelastin_slim
  printf '%s\n' 'cmake_minimum_required(VERSION 3.22)' 'project(host C)' 'find_package(elastin CONFIG REQUIRED COMPONENTS c_slim)' \
    "add_executable(host $source/tests/examples/embed.c)" 'target_link_libraries(host elastin::c_slim m)' >CMakeLists.txt
  cmake -B build && cmake --build build && build/host
}
found_by_pkg_config() {
  # shellcheck disable=SC2046  # flags are words
  cc "$source/tests/examples/embed.c" -o host $(pkg-config --cflags --libs elastin-c-slim) -lm -Wl,-rpath,"$(pkg-config --variable=libdir elastin-c-slim)"
  ./host
}
python_of_prefix() {
  PYTHONPATH=$(dirname "$(dirname "$(find "$prefix" -name '_elastin*.so')")") \
    "$(sed -n 's/^_\?Python_EXECUTABLE:[A-Z]*=//p' "$build/CMakeCache.txt" | head -n 1 | grep . || echo /usr/bin/python3)" \
    -c "import elastin; print(elastin.run('$source/scenes/tension/table1-a.yaml'))"
}
npm_package() {
  npm install --offline --no-audit --no-fund "$build/web/npm"
  node -e 'require("elastin").load().then(e => e.lattice([3, 3, 3], 0.1, {density: 1000}).simulate("lattice", {youngs_modulus: 1e3}).step(1e-3))'
}
inside() {  # lines of CMake; configured alone: CI builds the sources inside another project (consumer_test.sh subdirectory)
  printf '%s\n' 'cmake_minimum_required(VERSION 3.22)' 'project(host CXX)' "$@" 'add_executable(host host.cpp)' \
    'target_link_libraries(host elastin::core)' >CMakeLists.txt
  echo 'int main() {}' >host.cpp
  env -u CMAKE_PREFIX_PATH cmake -B build && grep -rq elastin_core build/CMakeFiles
}
fetched() { inside 'include(FetchContent)' "FetchContent_Declare(elastin SOURCE_DIR $source)" 'FetchContent_MakeAvailable(elastin)'; }
by_cpm() { inside "include($CPM_CMAKE)" "CPMAddPackage(NAME elastin SOURCE_DIR $source)"; }
debian_packages() {
  (cd -- "$build" && cpack -G DEB -B "$work/made")
  mkdir root "$work/deb" && mv -- "$work"/made/*.deb "$work/deb"
  for package in "$work"/deb/*.deb; do dpkg-deb -x "$package" root; done
  LD_LIBRARY_PATH=$(find "$PWD/root" -name 'libelastin*.so.*' -printf '%h:') "$(find root -name elastin -type f -perm -u+x | head -n 1)" --version
}

try "cmake --install" "$prefix" installed
try "find_package(elastin c_slim)" "$(readlink -f "$(find "$prefix" -name libelastin_slim.so)")" found_by_cmake
try "pkg-config elastin-c-slim" "$(readlink -f "$(find "$prefix" -name libelastin_slim.so)")" found_by_pkg_config
if [[ -n $(find "$prefix" -name '_elastin*.so') ]]; then
  try "Python of the prefix" "$(dirname "$(find "$prefix" -name '_elastin*.so')")" python_of_prefix
fi
if [[ -e $build/web/npm/elastin.wasm ]] && command -v npm >/dev/null; then try "npm install" "$build/web/npm" npm_package; fi
try "FetchContent (configure)" "$source/src/core" fetched
[[ -z ${CPM_CMAKE-} ]] || try "CPM (configure)" "$source/src/core" by_cpm
[[ ${2-} != deb ]] || try "Debian packages" "$work/deb" debian_packages
