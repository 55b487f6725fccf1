#!/usr/bin/env bash
# The lab in a browser: web_test.sh WHAT BUILD ELASTIN [BITS]. Leaves with 77, which ctest takes as skipped, where the
# core was not built for browsers (tools/setup --web) or there is no node or Chromium.
#   bits      native steps and those of the module are bitwise identical, every strategy with every stepper
#   hand      drag, push, pin, pause, step, keys     strategies    E in the page is that of the command
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

# Pairs of strategy and E [Pa] of a scene's own experiment.
moduli() {
  "$elastin" compare "$1" --strategies "$2" --json - 2>/dev/null | node -e '
    const {runs} = JSON.parse(require("node:fs").readFileSync(0, "utf8"));
    for (const run of runs) console.log(run.strategy, run.measures.effective_modulus.value ?? run.measures.effective_modulus);'
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
    for case in tension/cube-27-face.yaml:standard,lattice tension/tet-block.yaml:van_gelder,neo_hookean; do
      page "$scenes/${case%:*}"
      mapfile -t pairs < <(moduli "$scenes/${case%:*}" "${case#*:}")
      ((${#pairs[@]} == 2)) || { echo "the command gave ${pairs[*]}"; exit 1; }
      node "$here/lab_test.js" "$chromium" strategies "$folder/lab.html" ${pairs[@]}
    done
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
  hand | rest | painters | wild | access | refused)
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
