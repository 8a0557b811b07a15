#!/usr/bin/env python3
"""Is piezoid more accurate and faster than numpy, scipy, pyswarms and SysIdentPy, for the same task on the same data?

    python3 bench/side_by_side.py           all parts, some minutes; writes the tables of bench/side_by_side.md
    python3 bench/side_by_side.py --quick   a short test; writes nothing
    --here                                  in this Python, with its packages, instead of bench/.venv

PIEZOID_DATA names the folder that holds the measured stack, `picma-p885`; without it that part is skipped.
"""

from __future__ import annotations

import os
import platform
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

import page
from beside import own

NEEDS = ["numpy>=2", "scipy>=1.14", "pandas>=2", "pyswarms==1.3.0", "sysidentpy==0.9.0"]
PAGE = Path(__file__).resolve().with_suffix(".md")

def main() -> None:
    """Runs all, prints the tables, and writes the page."""
    import logging

    from beside import fits, identification, problems, rivals, table

    logging.disable()
    results = problems.Page(quick="--quick" in sys.argv)
    for part in (problems.filters, problems.blocks, problems.swarms, problems.plays, problems.bouc_wen):
        print(part.__name__, file=sys.stderr)
        part(results)
    for bench in (identification.twin(), identification.measured()):
        if bench is None:
            skipped = "The measured stack was skipped: PIEZOID_DATA names no folder that holds picma-p885."
            print(f"SKIPPED: {skipped}", file=sys.stderr)
            results.facts.append(skipped)
            continue
        print(f"identification, {bench.name}", file=sys.stderr)
        identification.identification(results, bench)
    load = f", load {os.getloadavg()[0]:.1f} at the end" if hasattr(os, "getloadavg") else ""
    packages = ["numpy", "scipy", "pyswarms", "sysidentpy"]
    machine = f"{own.processor()}, {os.cpu_count()} cores, {platform.machine()}, {platform.system()}{load}"
    versions = ", ".join([f"Python {platform.python_version()}", *[f"{name} {version(name)}" for name in packages]])
    weights = f"c1 = c2 = {rivals.WEIGHTS['c1']} and w = {rivals.WEIGHTS['w']}"
    measured = {
        "machine": f"- {machine}. One thread each.\n- {versions}.\n- Swarms of {rivals.PARTICLES} particles and "
        f"{rivals.ITERATIONS} iterations, pyswarms with {weights}; {len(fits.SETTINGS)} settings of SysIdentPy.",
        "results": "\n\n".join(
            [
                table.markdown(table.HEADS, [row.cells() for row in results.rows], 3),
                "\n".join(f"- {fact}" for fact in results.facts),
            ]
        ),
        "free runs": "\n\n".join(table.markdown(heads, rows, 1) for heads, *rows in results.unseen),
        "behind": table.behind(results.rows),
    }
    text = PAGE.read_text(encoding="utf-8")
    for name, part in measured.items():
        text = page.replaced(text, name, part)
    print(text)
    if not results.quick:
        PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    # numpy reads the number of threads once, on import.
    os.environ.update(own.ONE_THREAD)
    if "--here" not in sys.argv:
        own.inside(NEEDS)
    with tempfile.TemporaryDirectory() as elsewhere:
        os.chdir(elsewhere)  # pyswarms writes a log into the working directory
        main()
