"""Writes a compilation database with the first entry of each file: one_entry.py FROM TO."""

import json
import sys

source, target = sys.argv[1:]
with open(source, encoding="utf-8") as stream:
    entries = json.load(stream)
first = {}
for entry in entries:
    first.setdefault(entry["file"], entry)
with open(target, "w", encoding="utf-8") as stream:
    json.dump(list(first.values()), stream, indent=1)
