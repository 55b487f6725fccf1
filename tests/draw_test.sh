#!/usr/bin/env bash
# tools/draw draws every connection of the states that --out writes, and says which file it cannot read.
#   draw_test.sh ELASTIN
set -euo pipefail
elastin=$1
root=$(dirname -- "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")")
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT

drawn() {  # file: how many connections its picture has
  "$root/tools/draw" "$1" | grep -c '^<path '
}

"$elastin" run "$root/scenes/tension/table1-b.yaml" --quiet --out "$work"  # 27 molecules, 54 connections [M03]
[[ $(drawn "$work/table1-b-standard-001.vtu") == 54 ]] || { echo "table1-b: not 54 connections are drawn"; exit 1; }

# Two cubes of twelve tetrahedra each: 20 edges, 8 spokes in each cube, and a diagonal on each of 11 faces.
"$elastin" run "$root/scenes/tutorial/strip.yaml" --quiet --out "$work" --set 'body.tetrahedra.cubes=[2, 1, 1]' \
  --set 'expect=[]'
[[ $(drawn "$work/strip-neo_hookean+volume-005.vtu") == 47 ]] || { echo "strip: not 47 connections are drawn"; exit 1; }

# Arrays of more than 1 MiB are in several blocks. 18 boxes a side: their edges, a diagonal of each side and one of each box.
printf '%s\n' 'body: {lattice: {kind: cubic, molecules: [19, 19, 19], spacing: 1 mm, order: 1}}' 'material: {youngs_modulus: 1 kPa}' \
  'stiffness: neo_hookean' 'experiment: {kind: tension, axis: z, strain: 1 %}' >"$work/boxes.yaml"
"$elastin" run "$work/boxes.yaml" --quiet --out "$work"
[[ $(drawn "$work/boxes-neo_hookean-001.vtu") == $((3 * 19 * 19 * 18 + 3 * 18 * 18 * 19 + 18 * 18 * 18)) ]] ||
  { echo "boxes: not all connections are drawn"; exit 1; }

if "$root/tools/draw" "$work/none.vtu" 2>"$work/said"; then exit 1; fi
grep -q 'none.vtu: cannot be read' "$work/said"
