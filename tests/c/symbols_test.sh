#!/usr/bin/env bash
# Fails where the shared library shows another symbol than those of the list, or lacks one.
#   tests/c/symbols_test.sh LIBRARY LIST
set -euo pipefail
diff <(nm -D --defined-only "$1" | awk '{ print $NF }' | LC_ALL=C sort) "$2" ||
  { echo "symbols_test: < $1, > $2" >&2; exit 1; }
