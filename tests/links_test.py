#!/usr/bin/env python3
"""Every relative link in the documents leads to a file or folder of the tree, and every anchor to a heading.

  links_test.py ROOT
"""
import os
import re
import sys

LINK = re.compile(r"\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#{1,6} +(.*?) *#*$")


def text_lines(path):
    """The lines outside blocks of code, with their numbers."""
    inside = False
    with open(path, encoding="utf-8") as stream:
        for number, line in enumerate(stream, 1):
            if line.startswith("```"):
                inside = not inside
            elif not inside:
                yield number, line.rstrip("\n")


def anchors(path):
    """What GitHub makes of the headings: small letters, no punctuation, hyphens for blanks, -1 for the second."""
    seen, found = {}, set()
    for _, line in text_lines(path):
        heading = HEADING.match(line)
        if not heading:
            continue
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading.group(1)).lower()
        slug = re.sub(r"[^\w\- ]", "", words).replace(" ", "-")
        count = seen.get(slug, 0)
        seen[slug] = count + 1
        found.add(slug if count == 0 else f"{slug}-{count}")
    return found


def fault(root, document, target):
    """What is wrong with a link, or ""."""
    if re.match(r"[a-z]+:", target):
        return ""  # the network's
    path, _, anchor = target.partition("#")
    file = os.path.normpath(os.path.join(os.path.dirname(document), path)) if path else document
    if os.path.relpath(file, root).startswith(".."):
        return "leaves the tree"
    if not os.path.exists(file):
        return "there is no such file"
    if anchor and (not file.endswith(".md") or anchor not in anchors(file)):
        return "there is no such heading"
    return ""


def main(root):
    documents = []
    for folder, folders, files in os.walk(root):
        folders[:] = [name for name in folders if name != ".git" and not name.startswith("build") and name != "out"]
        documents += [os.path.join(folder, name) for name in files if name.endswith(".md")]
    links = wrong = 0
    for document in sorted(documents):
        for number, line in text_lines(document):
            for target in LINK.findall(re.sub(r"`[^`]*`", "", line)):
                links += 1
                what = fault(root, document, target)
                if what:
                    wrong += 1
                    print(f"{os.path.relpath(document, root)}:{number}: {target}: {what}")
    print(f"{links} links in {len(documents)} documents, {wrong} wrong")
    return 1 if wrong or links == 0 else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
