"""Writes a compilation database with the first entry of each file, without precompiled headers, which are one
compiler's own: one_entry.py FROM TO."""

import json
import re
import sys

source, target = sys.argv[1:]
with open(source, encoding="utf-8") as stream:
    entries = json.load(stream)
first = {}
for entry in entries:
    if "command" in entry:
        entry["command"] = re.sub(r" (-Winvalid-pch|-fpch-preprocess|-include \S*cmake_pch\S*)", "", entry["command"])
    if "cmake_pch" not in entry["file"]:
        first.setdefault(entry["file"], entry)
with open(target, "w", encoding="utf-8") as stream:
    json.dump(list(first.values()), stream, indent=1)
