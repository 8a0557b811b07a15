#!/usr/bin/env python3
"""The paper's swarm problem, side by side: piezoid against pyswarms 1.3.0 with a vectorised numpy cost.

    python3 bench/swarm.py [PAIRS]

50 particles, 500 iterations, 4093 rows, 5 parameters, one thread each; the rows, the search box and the fitness are the
same. numpy computes the fitness in one array that is kept. pyswarms has constant weights (1.5, 1.5, 0.65), and its
velocity is not clamped.

The script creates the virtual environment bench/.venv and builds the binary that it times. Each pair runs one search of
each, in turn. Only the search is timed, without start-up and reading. Printed are the median of each, their ratio, and
the time that a core would need at its peak rate of multiply-adds for the same number of evaluations.
"""

import json
import os
import statistics
import subprocess
import sys
import time

from beside import own

NEEDS = ["numpy>=2", "scipy>=1.14", "pyswarms==1.3.0"]


def build():
    """Builds piezoid's side and returns the path of the binary."""
    command = ["cargo", "build", "--profile", "dist", "--quiet", "--package", "piezoid-bench", "--message-format=json"]
    lines = subprocess.run(command, cwd=own.ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()
    binaries = [json.loads(line).get("executable") for line in lines]
    return next(path for path in reversed(binaries) if path)


def main():
    os.chdir(own.HOME)  # pyswarms writes a log into the working directory
    import numpy as np

    from beside import rivals

    pairs = int(sys.argv[1]) if len(sys.argv) > 1 else 7
    binary = build()
    rows = subprocess.run([binary, "rows"], check=True, stdout=subprocess.PIPE, text=True).stdout
    data = np.array([[float(cell) for cell in line.split(",")] for line in rows.splitlines()])
    y, psi = data[:, 0].copy(), np.ascontiguousarray(data[:, 1:].T)

    def theirs(seed):
        start = time.perf_counter()
        cost = rivals.swarm(y, psi, seed)
        return time.perf_counter() - start, cost

    def ours(seed):
        return json.loads(subprocess.run([binary, "run", str(seed)], check=True, stdout=subprocess.PIPE).stdout)

    print(f"{len(y)} rows, {rivals.PARTICLES} particles, {rivals.ITERATIONS} iterations, {pairs} pairs", file=sys.stderr)
    ours(0), theirs(0)  # warm-up
    left, right = [], []
    for seed in range(1, pairs + 1):
        left.append(ours(seed))
        right.append(theirs(seed))
    times = [[run["seconds"] for run in left], [seconds for seconds, _ in right]]
    costs = [[run["cost"] for run in left], [cost for _, cost in right]]
    for name, seconds, cost in zip(["piezoid", "pyswarms 1.3.0"], times, costs):
        spread = f"{1e3 * min(seconds):8.2f} to {1e3 * max(seconds):8.2f}"
        print(f"{name:15}{1e3 * statistics.median(seconds):9.2f} ms ({spread}), worst cost {max(cost):.6f} um")
    ratio = statistics.median(b / a for a, b in zip(*times))
    peak = statistics.median(run["multiply_adds"] / run["peak_multiply_adds_per_second"] for run in left)
    print(f"piezoid is {ratio:.0f} times as fast (median of pairs)")
    print(f"bound: {1e3 * peak:.2f} ms, all multiply-adds of all evaluations at this core's peak")


if __name__ == "__main__":
    own.inside(NEEDS)
    main()
