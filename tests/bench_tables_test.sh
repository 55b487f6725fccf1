#!/usr/bin/env bash
# The tables of tools/bench/README.md are what the committed rows say, and a table that is not is found.
#   bench_tables_test.sh ROOT
set -euo pipefail
cd -- "$1"
tools/bench/tables --check

work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
mkdir -p -- "$work/tools/bench"
cp -R -- tools/bench/tables tools/bench/rows tools/bench/README.md "$work/tools/bench/"
"$work/tools/bench/tables" --check >/dev/null
sed -i 2d "$work"/tools/bench/rows/*-static.csv
if "$work/tools/bench/tables" --check >"$work/said"; then
  echo "a row that was taken away after its table was made is not noticed"
  exit 1
fi
grep -q '^tools/bench/README.md:[0-9]*: is not what ' "$work/said"
"$work/tools/bench/tables" --write
"$work/tools/bench/tables" --check >/dev/null
