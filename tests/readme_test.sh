#!/usr/bin/env bash
# What README quotes as a file is that file: a line <!-- PATH --> before a block of code says which.
#   readme_test.sh ROOT
set -euo pipefail
cd -- "$1"

quoted=0
while IFS=: read -r line path; do
  block=$(awk -v from="$line" 'NR <= from { next } /^```/ { if (inside) exit; inside = 1; next } inside' README.md)
  if ! difference=$(diff <(printf '%s\n' "$block") "$path"); then
    printf 'README.md:%s: is not %s:\n%s\n' "$line" "$path" "$difference"
    exit 1
  fi
  quoted=$((quoted + 1))
done < <(grep -n '^<!-- .* -->$' README.md | sed 's/<!-- \(.*\) -->/\1/')
((quoted >= 3)) || { echo "README.md quotes $quoted files; three or more are expected"; exit 1; }
