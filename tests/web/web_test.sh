#!/usr/bin/env bash
# The lab in a browser: web_test.sh WHAT BUILD ELASTIN [BITS]. Leaves with 77, which ctest takes as skipped, where the
# core was not built for browsers (tools/setup --web) or there is no node or Chromium.
#   bits      native steps and those of the module are bitwise identical, every strategy with every stepper
#   hand      drag, push, pin, pause, step, keys     strategies    E in the page and its error are those of the command
#   settings  how the page begins, wrong addresses   words         what is said of what it does not have or cannot test
#   rest      nothing is drawn while nothing moves                painters    card and processor draw the same
#   wild      a minute at random                     access        labels, contrast, widths     refused    what is said where it cannot run
#   npm       the package in node: closed forms, its errors, its types           module   the package in a browser
#   wrong     a body that is too large, a folder without the module
set -euo pipefail
what=$1 build=$2 elastin=$3 bits=${4:-}
here=$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")
scenes=$here/../../scenes
skip() { echo "skipped: $*"; exit 77; }
[[ -e $build/web/bin/elastin.wasm ]] || skip "no $build/web/bin/elastin.wasm; tools/setup --web builds it"
command -v node >/dev/null || skip "no node"
folder=$(mktemp -d)
trap 'rm -rf -- "$folder"' EXIT

browser() {
  chromium=$(command -v chromium || command -v chromium-browser || command -v google-chrome) || skip "no Chromium"
}
page() { "$elastin" lab "$1" --module "$build/web/bin" --out "$folder/lab.html"; }

# Strategy, E [Pa] and its error, or none, of a scene's own experiment.
moduli() {
  "$elastin" compare "$1" --strategies "$2" --json - 2>/dev/null | node -e '
    const {runs} = JSON.parse(require("node:fs").readFileSync(0, "utf8"));
    for (const {strategy, measures, errors} of runs)
      console.log(strategy, measures.effective_modulus.value ?? measures.effective_modulus, errors?.effective_modulus ?? "none");'
}

case $what in
  bits)
    # The module has no Voro++ to make Voronoi cells; patch takes them where it can, and cubes' faces on the lattice.
    # What goes by the energy of neo_hookean takes the logarithm of the system's library, which rounds otherwise.
    same() { grep -v -e ' voronoi ' -e '^tetrahedra patch ' -e ' neo_hookean.* energy_momentum ' "$1"; }
    "$bits" 1000 >"$folder/native" &
    node "$here/bits.js" "$build/web/bin" 1000 >"$folder/web"
    wait $!
    (($(same "$folder/native" | wc -l) > 100))
    diff <(same "$folder/native") <(same "$folder/web")
    ;;
  npm) node "$here/npm_test.js" "$build/web/npm" ;;
  module)
    browser
    node "$here/module_test.js" "$chromium" "$build/web/npm"
    ;;
  strategies)
    browser
    cat >"$folder/held.yaml" <<'SCENE'
body: {tetrahedra: {kind: kuhn, cubes: [6, 2, 2], size: [30 mm, 10 mm, 10 mm]}}
material: {youngs_modulus: 10 kPa, poissons_ratio: 0.45, density: 1000 kg/m3}
stiffness: neo_hookean
experiment: {kind: tension, axis: x, strain: 0.1}
supports: [{molecules: {side: -y}, fix: [x, y, z]}]
loads: [{gravity: [9.81 m/s2, 0, 0]}]
reference: none
SCENE
    cat >"$folder/swollen.yaml" <<'SCENE'
body: {tetrahedra: {kind: kuhn, cubes: [3, 1, 1], size: [30 mm, 10 mm, 10 mm]}}
material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, density: 1000 kg/m3}
stiffness: neo_hookean
experiment: {kind: tension, axis: x, strain: 0.01}
rest: {swelling: 1.2, factor: 1}
reference: none
SCENE
    for case in "$folder/swollen.yaml=neo_hookean,st_venant_kirchhoff" "$folder/held.yaml=neo_hookean,standard" "$scenes/tension/cube-27-face.yaml=standard,lattice" \
      "$scenes/tension/tet-block.yaml=van_gelder,neo_hookean" "$scenes/material/ligament.yaml=standard,lattice" \
      "$scenes/tissue/rubber-mullins.yaml=mullins:ogden,ogden"; do
      page "${case%=*}"
      mapfile -t runs < <(moduli "${case%=*}" "${case#*=}")
      ((${#runs[@]} == 2)) || { echo "the command gave ${runs[*]}"; exit 1; }
      node "$here/lab_test.js" "$chromium" strategies "$folder/lab.html" ${runs[@]}
    done
    ;;
  words)
    browser
    cat >"$folder/second-order.yaml" <<'SCENE'
body: {tetrahedra: {kind: kuhn, cubes: [3, 1, 1], size: [30 mm, 10 mm, 10 mm], order: 2}}
material: {youngs_modulus: 10 kPa, poissons_ratio: 0.3, density: 1000 kg/m3}
stiffness: neo_hookean
experiment: {kind: loads, read: [{name: tip, molecules: {side: x}}]}
supports: [{molecules: {side: -x}}]
SCENE
    page "$folder/second-order.yaml"
    node "$here/lab_test.js" "$chromium" words "$folder/lab.html" "without the scene's supports" 'E is 9.999 kPa'
    node "$here/lab_test.js" "$chromium" refused_stepper "$folder/lab.html"
    page "$scenes/membrane/sphere-60mpa-1mm.yaml"
    node "$here/lab_test.js" "$chromium" words "$folder/lab.html" 'does not resist this pull' -- 'nPa' 'per cent off'
    cat >"$folder/several.yaml" <<'SCENE'
bodies:
  - {name: low, tetrahedra: {kind: kuhn, cubes: [2, 2, 2], size: [10 mm, 10 mm, 10 mm]}, material: {youngs_modulus: 30 kPa}}
  - {name: high, tetrahedra: {kind: kuhn, cubes: [2, 2, 2], size: [10 mm, 10 mm, 10 mm]}, at: [0, 0, 10 mm]}
ties: [{between: [low, high], within: 0.1 mm}]
material: {youngs_modulus: 10 kPa, poissons_ratio: 0, density: 1000 kg/m3}
stiffness: "calibrated:standard"
calibrate: {experiment: {kind: material}}
experiment: {kind: tension, axis: z, strain: 0.05}
SCENE
    page "$folder/several.yaml" 2>"$folder/warnings"
    grep -q 'warning: the page leaves out calibration, of calibrated:standard' "$folder/warnings"
    node "$here/lab_test.js" "$chromium" words "$folder/lab.html" 'low E = 30.0 kPa' 'high E = 10.0 kPa' "× the scene's" \
      'No error: the bodies are of several materials' 'calibration, of calibrated:standard' -- 'Dashed' 'per cent off'
    ;;
  wrong)
    said=$("$elastin" lab "$scenes/tension/cube-1000.yaml" --module "$build/web/bin" --out "$folder/a.html" \
      --set 'body.lattice.molecules=[40, 40, 40]' 2>&1) && exit 1
    grep -q 'a page takes at most' <<<"$said"
    said=$("$elastin" lab "$scenes/tension/cube-1000.yaml" --module "$folder" --out "$folder/a.html" 2>&1) && exit 1
    grep -q 'tools/setup --web' <<<"$said"
    said=$("$elastin" lab --out "$folder/a.html" 2>&1) && exit 1
    [[ ! -e $folder/a.html ]]
    ;;
  hand | rest | painters | settings | wild | access | refused)
    browser
    case $what in
      hand | rest | painters) page "$scenes/tension/cube-1000.yaml" ;;  # at rest until it is dragged
      *) page "$scenes/dynamics/labelle-jello.yaml" ;;
    esac
    more=()
    [[ $what != wild ]] || more=("${ELASTIN_WILD_SECONDS:-60}" 1)
    node "$here/lab_test.js" "$chromium" "${what/hand/drag}" "$folder/lab.html" "${more[@]}"
    ;;
  *) echo "unknown: $what"; exit 2 ;;
esac
