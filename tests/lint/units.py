"""Which .cpp files clang-tidy reads: units.py DATABASE < "LINES<tab>FILE" of changed files.

A changed .cpp stands for itself. A changed header that the changed .cpp files do not include directly is read
through one that does: its twin of the same name if there is one, else the first in order of name; a header that no
.cpp includes directly is left out. Printed with the most changed lines first; equal ones in order of name.
"""

import json
import os
import re
import sys

with open(sys.argv[1], encoding="utf-8") as stream:
    compiled = sorted({os.path.relpath(entry["file"]) for entry in json.load(stream)})
compiled = [file for file in compiled if not file.startswith("..") and file.endswith(".cpp")]
changed = {}
for line in sys.stdin:
    lines, file = line.rstrip("\n").split("\t", 1)
    changed[file] = int(lines)


def included_by(file):
    with open(file, encoding="utf-8", errors="replace") as stream:
        return set(re.findall(r'^\s*#\s*include\s+"([^"]+)"', stream.read(), re.MULTILINE))


includes = {file: included_by(file) for file in compiled if os.path.exists(file)}
weight = {file: lines for file, lines in changed.items() if file in includes}
for header, lines in sorted(changed.items()):
    if not header.endswith(".h"):
        continue
    users = [file for file in includes if header in includes[file]]
    if not users or any(file in changed for file in users):
        continue
    twin = os.path.splitext(header)[0] + ".cpp"
    user = twin if twin in users else users[0]
    weight[user] = weight.get(user, 0) + lines
for file in sorted(weight, key=lambda name: (-weight[name], name)):
    print(file)
