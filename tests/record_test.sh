#!/usr/bin/env bash
# tools/record writes what a command of a few lines says of three scenes, and finds each kind of difference between two
# records, and no other.
set -euo pipefail

record=$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/../tools/record
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
cd -- "$work"
export TMPDIR=$work
cases=0 failures=0

expect() {  # exit code, words… that the output has ("!words": has not), then -- and the arguments
  local code=$1 output status=0 words=() word wrong=""
  shift
  while [[ $1 != -- ]]; do words+=("$1"); shift; done
  shift
  output=$("$record" "$@" 2>&1) || status=$?
  cases=$((cases + 1))
  [[ $status == "$code" ]] || wrong+=" exit code $status"
  for word in "${words[@]}"; do
    if [[ $word == !* ]]; then
      [[ $output != *"${word#!}"* ]] || wrong+=" there is '${word#!}'"
    else
      [[ $output == *"$word"* ]] || wrong+=" there is no '$word'"
    fi
  done
  [[ -n $wrong ]] || return 0
  failures=$((failures + 1))
  printf 'record %s:%s\n%s\n\n' "$*" "$wrong" "$output"
}

# --- comparing
changed() {  # sed script: before.json changed by it is after.json
  sed "$1" before.json >after.json
  ! cmp -s before.json after.json || { echo "'$1' changes nothing"; exit 1; }
}

cat >before.json <<'END'
{
"a/bar.yaml": {"of": "1 2",
 "run": {"state": "finished", "exit_code": 0, "runs": [
  {"strategy": "angles", "outcome": "converged", "cause": "", "iterations": 7, "warnings": ["thin"],
   "measures": {"force": 2.5, "axial_force": 4e-14, "poissons_ratio": 3e-16, "height": 1e-3, "speed": null},
   "errors": {"effective_modulus": 2e-16},
   "curve": [{"height": 0.0}, {"height": 5e-4}, {"height": 1e-3}]}]},
 "compare": {"state": "finished", "exit_code": 0, "runs": [
  {"strategy": "angles", "outcome": "converged", "measures": {"force": 2.5}, "variant": {"cubes": "1"}},
  {"strategy": "angles", "outcome": "converged", "measures": {"force": 2.6}, "variant": {"cubes": "2"}},
  {"strategy": "curve", "outcome": "diverged", "cause": "gone", "measures": {"height": 1e30}}]},
 "verify": {"state": "finished", "exit_code": 1, "runs": []}},
"b.yaml": {"of": "1 3",
 "run": {"state": "finished", "exit_code": 2, "message": "no such key", "runs": []},
 "compare": {"state": "timed out", "runs": [{"strategy": "curve", "outcome": "converged", "iterations": 41}]},
 "verify": {"state": "not run", "runs": []}}
}
END

expect 0 '0 differences in 0 of 2 scenes' '2 of 6 commands compared in part' 'not run: b.yaml compare' -- --diff before.json before.json

changed 's/"force": 2.6/"force": 2.6000000000001/'
expect 1 'a/bar.yaml  compare  angles 2  measures.force  2.6  2.6000000000001  3.8e-14' '1 differences in 1 of 2' -- \
  --diff before.json after.json --tolerance 1e-14
expect 0 -- --diff before.json after.json
changed 's/"force": 2.6/"force": 2.60000000002/'
expect 1 '7.7e-12' -- --diff before.json after.json
expect 0 '0 differences in 0 of 1 scenes' -- --diff before.json after.json --scenes 'scenes/b*'

# Zero but for rounding; a diverged run's size says nothing of the others.
changed 's/4e-14/1e-14/; s/3e-16/9e-16/; s/2e-16/-1e-16/'
expect 0 -- --diff before.json after.json
changed 's/4e-14/4e-11/'
expect 1 'measures.axial_force' -- --diff before.json after.json
changed 's/"height": 1e-3, /"height": 1.0000001e-3, /; s/5e-4/5.0001e-4/; s/"height": 1e-3}/"height": 1.00001e-3}/'
expect 1 'measures.height  0.001' 'curve[1].height' 'curve[2].height' '3 differences' '2.0e-05' -- --diff before.json after.json --all
expect 1 'measures.height' 'curve[1].height' '!curve[2].height' '2 differences' -- --diff before.json after.json

changed 's/"iterations": 7/"iterations": 8/'
expect 1 'a/bar.yaml  run  angles  iterations  7  8' -- --diff before.json after.json --tolerance 1
changed 's/"outcome": "diverged"/"outcome": "inverted"/'
expect 1 'a/bar.yaml  compare  curve  outcome  diverged  inverted' -- --diff before.json after.json
changed 's/"exit_code": 1/"exit_code": 0/'
expect 1 'a/bar.yaml  verify  –  exit_code  1  0' -- --diff before.json after.json
changed 's/"speed": null/"speed": 0.5/'
expect 1 'measures.speed  null  0.5' -- --diff before.json after.json
changed 's/, "speed": null//'
expect 1 'measures.speed  null  –' -- --diff before.json after.json
changed 's/, {"height": 5e-4}//; s/{"height": 1e-3}\]/{"height": 5e-4}]/'
expect 1 'curve, how many  3  2' '1 differences' -- --diff before.json after.json

# A run, a scene, or a command's end is missing.
changed 's/{"strategy": "angles", .*"variant": {"cubes": "2"}},//'
expect 1 'compare  angles 2  run  there  missing' '1 differences' -- --diff before.json after.json
expect 1 'compare  angles 2  run  missing  there' '1 differences' -- --diff after.json before.json
python3 -c 'import json
record = json.load(open("before.json")); del record["b.yaml"]; json.dump(record, open("after.json", "w"))'
expect 1 'b.yaml  –  –  scene  there  missing' -- --diff before.json after.json
changed 's/"finished", "exit_code": 1/"timed out"/'
expect 1 'a/bar.yaml  verify  –  state  finished  timed out' -- --diff before.json after.json
expect 0 'or was not run: a/bar.yaml verify' -- --diff after.json before.json
changed 's/41/42/'  # of a run that was over before time ran out
expect 1 'b.yaml  compare  curve  iterations  41  42' -- --diff before.json after.json
changed 's/41/41, "errors": {"height_to_reference": 1}/'  # added when all runs of a study are over
expect 0 -- --diff before.json after.json

# Words
changed 's/gone/lost/; s/thin/slender/; s/no such key/unknown key/; s/"cubes": "2"/"cells": "2"/'
expect 0 -- --diff before.json after.json
expect 1 'cause  gone  lost' 'warnings  ["thin"]  ["slender"]' 'message  no such key  unknown key' '4 differences' -- \
  --diff before.json after.json --words
changed 's/\["thin"\]/["thin", "long"]/'
expect 1 'warnings, how many  1  2' -- --diff before.json after.json

# --- recording, by a command that says what the scene's text is
mkdir -p tree/scenes/c
echo 2.5 >tree/scenes/c/good.yaml
echo slow >tree/scenes/slow.yaml
echo wrong >tree/scenes/wrong.yaml
cat >command <<'END'
#!/usr/bin/env bash
echo "$*" >>../calls
text=$(<"$2")
[[ $text != wrong ]] || { echo "$2: no scene" >&2; exit 2; }
cat >"$4" <<JSON
{"runs": [{"strategy": "curve", "outcome": "converged", "cause": "", "threads": 2, "seconds": {"build": $RANDOM},
 "measures": {"force": ${text/slow/1}, "seconds": 3}, "time": {"steps": 4, "seconds": $RANDOM}}]}
JSON
while [[ $text == slow ]]; do :; done
END
chmod +x command
recorded=(--tree tree --exe command --timeout 1)

expect 0 'c/good.yaml, ' 'slow.yaml  compare  timed out' 'wrong.yaml  run  exit code 2' \
  '3 scenes: 3 commands exit code 0, 3 commands exit code 2, 3 commands timed out' -- first.json "${recorded[@]}" --jobs 3
expect 0 '!c/good.yaml, ' '3 scenes: ' -- first.json "${recorded[@]}"
expect 0 'c/good.yaml, ' '1 scenes: ' -- first.json "${recorded[@]}" --again --scenes c/good.yaml
expect 0 'slow.yaml  run  not run' -- second.json "${recorded[@]}" --skip first.json
expect 0 '0 differences in 0 of 3 scenes' '3 of 9 commands compared in part' -- --diff first.json second.json --words
[[ $(grep -c . calls) == 18 ]] || { failures=$((failures + 1)); echo "not 18 calls:"; cat calls; }
if ! python3 - <<'END'
import json
good, slow, wrong = (json.load(open("first.json"))[scene] for scene in ("c/good.yaml", "slow.yaml", "wrong.yaml"))
run = {"strategy": "curve", "outcome": "converged", "cause": "", "measures": {"force": 2.5, "seconds": 3}}
assert good["run"] == {"state": "finished", "exit_code": 0, "runs": [{**run, "time": {"steps": 4}}]}, good["run"]
assert good["verify"]["runs"] == [run], good["verify"]
assert slow["run"]["state"] == "timed out" and slow["run"]["runs"][0]["measures"]["force"] == 1, slow["run"]
assert wrong["run"]["message"] == "scenes/wrong.yaml: no scene" and not wrong["run"]["runs"], wrong["run"]
END
then failures=$((failures + 1)); fi

echo 2.6 >tree/scenes/c/good.yaml
expect 0 'c/good.yaml, ' '!wrong.yaml, ' -- first.json "${recorded[@]}"
expect 1 'c/good.yaml  verify  curve  measures.force  2.6  2.5' '3 differences' -- --diff first.json second.json

# --- two commands
sed 's/"force": \$/"force": 1\$/' command >other
chmod +x other
expect 1 'c/good.yaml  run  curve  measures.force  2.6  12.6' "the records are $work/record-" '3 differences in 1 of 1' -- \
  --between command other --tree tree --timeout 1 --scenes c/good.yaml
expect 0 '0 differences' -- --between command command --tree tree --timeout 1 --scenes c/good.yaml

# --- a comparison of steppers
cat >steppers <<'END'
#!/usr/bin/env bash
echo "{\"steppers\": [{\"strategy\": \"curve\", \"rows\": [{\"stepper\": \"xpbd\", \"iterations\": 2, \"step\": 0.5, \"outcome\": \"converged\",
 \"at_rest\": {\"force\": 3}, \"seconds_per_step\": $RANDOM}]}]}" >"$4"
END
sed "s/: 3}/: 4}/" steppers >others
chmod +x steppers others
expect 0 '0 differences' -- --between steppers steppers --tree tree --timeout 1 --scenes c/good.yaml
expect 1 'c/good.yaml  run  curve, xpbd, 2 iterations, step 0.5  at_rest.force  3  4' -- \
  --between steppers others --tree tree --timeout 1 --scenes c/good.yaml

# --- wrong use
expect 2 'takes two records' -- --diff first.json
expect 2 'no scene is called d/*' -- third.json "${recorded[@]}" --scenes 'd/*'
expect 2 'is not there' -- third.json --tree tree --exe gone
expect 2 'gone.json' -- --diff gone.json first.json

echo "$cases cases, $failures wrong"
((failures == 0))
