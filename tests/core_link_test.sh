#!/usr/bin/env bash
# elastin::core needs Eigen and nothing else: neither it nor a program of it alone may name FCL, YAML or contact.
#   core_link_test.sh LIBRARY
set -euo pipefail

symbols=$(nm -C "$1" 2>/dev/null)
[[ $symbols == *elastin::solve_static* ]] || { echo "$1: no symbols of elastin::core to look at"; exit 1; }
if grep -E 'fcl::|octomap::|YAML::|fmt::|qh_|elastin::make_contact|elastin::ContactSearch' <<<"$symbols"; then
  echo "$1: elastin::core names a library or floor that it must do without"
  exit 1
fi
