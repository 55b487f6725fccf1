#!/usr/bin/env bash
# No program or library of a build may look for libraries in the folder that it is started in: every entry of a run path
# is absolute or begins with $ORIGIN, and none is empty, which means the present folder.
#   run_path_test.sh BUILD_FOLDER
set -euo pipefail
shopt -s nullglob globstar

fail() { echo "$1"; exit 1; }
foreign() {  # RUN_PATH: whether an entry is neither absolute nor below $ORIGIN
  local path=$1:
  while [[ $path ]]; do
    [[ ${path%%:*} == /* || ${path%%:*} == '$ORIGIN'* ]] || return 0
    path=${path#*:}
  done
  return 1
}
for wrong in '$ORIGIN/../lib::::' ':/usr/lib' 'lib' '/usr/lib:.'; do foreign "$wrong" || fail "'$wrong' passes"; done
for good in '$ORIGIN/../lib/elastin' '/usr/lib:$ORIGIN'; do ! foreign "$good" || fail "'$good' does not pass"; done

looked=0
for file in "$1"/bin/* "$1"/**/*.so "$1"/**/*.so.*; do
  [[ -f $file && ! -L $file ]] || continue
  dynamic=$(readelf -d "$file" 2>/dev/null) || continue
  looked=$((looked + 1))
  while read -r path; do
    ! foreign "$path" || fail "$file: run path '$path'"
  done < <(sed -nE 's/.*\((RPATH|RUNPATH)\).*\[(.*)\]$/\2/p' <<<"$dynamic")
done
[[ $looked -gt 0 ]] || fail "$1: no programs to look at"
echo "$looked programs and libraries"
