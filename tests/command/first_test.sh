#!/usr/bin/env bash
# The program that tools/run builds first finds what the whole one finds, and becomes it for what it has not.
#   first_test.sh FIRST WHOLE SOURCE
set -euo pipefail
first=$1 whole=$2 source=$3
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
fail() { echo "$1"; exit 1; }

# A copy, whose script of the whole program says how it was called.
mkdir "$work/first"
cp -- "$first" "$work/first/elastin"
ln -s -- "$(dirname -- "$whole")/../lib" "$work/lib"
printf '#!/bin/sh\necho whole "$@"\n' >"$work/first/whole"
chmod +x "$work/first/whole"
first=$work/first/elastin

told() { "$1" verify "$source"/scenes/tension/table1-*.yaml | sed 's/  *[^ ]* [µm]\?s$//; s/  */ /g'; }  # but for times, and widths by them
told "$whole" >"$work/whole.txt"
told "$first" >"$work/first.txt"
grep -q 'passed' "$work/whole.txt" || fail "nothing was verified"
diff "$work/whole.txt" "$work/first.txt" || fail "the two programs differ"

echo '<febio_spec version="4.0"/>' >"$work/model.feb"
while read -r words; do
  said=$("$first" $words) || fail "$words: code $?"
  [[ $said == "whole $words" ]] || fail "$words: $said"
done <<END
identify some.yaml --out folder
lab some.yaml --out page.html
run $work/model.feb --quiet
check $work/model.feb
END
echo "the same $(wc -l <"$work/first.txt") lines; 4 commands become the whole program"
