"""The table of a run of cargo-mutants: by folder how many changes the tests noticed, then those that they missed.

mutants.py OUTCOMES.json"""

import json
import sys
from collections import Counter, defaultdict
from pathlib import Path

areas: dict[str, Counter[str]] = defaultdict(Counter)
missed = []
for outcome in json.loads(Path(sys.argv[1]).read_text())["outcomes"]:
    if outcome["scenario"] == "Baseline":
        continue
    change, result = outcome["scenario"]["Mutant"], outcome["summary"]
    crate, _, rest = change["file"].removeprefix("crates/").partition("/src/")
    folder = rest.partition("/")[0] if "/" in rest else ""
    for area in (f"{crate}/{folder}".rstrip("/"), "all"):
        areas[area][result] += 1
    if result == "MissedMutant":
        missed.append(change["name"])

print("| where | noticed | missed | did not end | cannot be built | noticed of those built |")
print("|---|---:|---:|---:|---:|---:|")
for area in sorted(areas, key=lambda area: (area == "all", area)):
    count = areas[area]
    noticed = count["CaughtMutant"] + count["Timeout"]
    built = noticed + count["MissedMutant"]
    share = f"{100 * noticed / built:.0f} %" if built else ""
    row = (count["CaughtMutant"], count["MissedMutant"], count["Timeout"], count["Unviable"], share)
    print(f"| {area} | " + " | ".join(map(str, row)) + " |")
print(*(f"missed: {name}" for name in sorted(missed)), sep="\n")
