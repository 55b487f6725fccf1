#!/usr/bin/env bash
# What a README quotes as a file is that file: a line <!-- PATH --> before a block of code says which, from the root.
#   readme_test.sh ROOT            fails where a quote differs from its file
#   readme_test.sh ROOT --write    puts the files into the documents as they are
set -euo pipefail
cd -- "$1"

with_files() {  # document: its text with every quoted file as it is
  awk '
    quoted == 1 && /^```/ { print; while ((getline line < path) > 0) print line; close(path); quoted = 2; next }
    quoted == 2 { if (/^```/) { print; quoted = 0 } next }
    { print }
    /^<!-- [^ ]+ -->$/ { path = $2; quoted = 1 }' "$1"
}

quotes=0
while IFS= read -r document; do
  while IFS=: read -r line path; do
    [[ -r $path ]] || { echo "$document:$line: quotes $path, which is not in the tree"; exit 1; }
    quotes=$((quotes + 1))
  done < <(grep -nE '^<!-- [^ ]+ -->$' "$document" | sed 's/<!-- \(.*\) -->/\1/')
  if [[ ${2-} == --write ]]; then
    with_files "$document" >"$document.new"
    mv -- "$document.new" "$document"
  elif ! difference=$(diff -- "$document" <(with_files "$document")); then
    printf '%s: a quote is not its file (<), which reads (>):\n%s\n' "$document" "$difference"
    exit 1
  fi
done < <(find . -name 'build*' -prune -o -name '*.md' -print | LC_ALL=C sort)
((quotes >= 3)) || { echo "the documents quote $quotes files; three or more are expected"; exit 1; }
