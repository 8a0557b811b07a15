#!/usr/bin/env python3
"""piezoid beside numpy, scipy, pyswarms and SysIdentPy: error and time for the same task on the same data, in one run.

    python3 bench/side_by_side.py           all parts, some minutes; writes bench/side_by_side.md
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

from beside import own

NEEDS = ["numpy>=2", "scipy>=1.14", "pandas>=2", "pyswarms==1.3.0", "sysidentpy==0.9.0"]
PAGE = Path(__file__).resolve().with_suffix(".md")

TEXT = """\
# Side by side

`python3 bench/side_by_side.py` repeats all measurements and writes this page.

## How it was measured

- {machine}. One thread each.
- {versions}.
- All in one process, on the same arrays. Calls alternate; a time is the median of 3 to 21 rounds; in each round short
  calls are repeated for 10 ms, and `ratio of times` is the median of the ratios of the rounds. The choice of an
  operator, the search of SysIdentPy's settings and each seed of a swarm take long and were run once.
- `error / peak` is the largest difference from a reference solution, computed in the widest floating-point type of
  numpy, divided by the peak of that solution. Values below 1e-9 are rounding and count as the same. `nrmse` is 100 rms
  error / standard deviation of a free run. Errors that differ by less than a thousandth count as the same, and so do
  times that differ by less than a quarter, which is their variation from run to run.

## Results

{table}

{facts}

## Free runs on validation records

nrmse [%] / rms error in % of peak-to-peak.

{unseen}

## Where piezoid is not ahead

Rows in which piezoid has a larger error, or is slower or equally fast.

{behind}

## Settings of the others

- **Filter.** piezoid and `lfilter` get the same coefficients, those of stable blocks fitted to the twin by output
  error. The input is white noise.
- **ARX.** The twin `pl140` with a PRBS of 1 V, 4095 samples. For numpy and scipy, building the regression matrix from
  slices, with a column of ones, is part of the time, because it is part of the time of piezoid too. Output error:
  `least_squares` (Levenberg-Marquardt) on `lfilter`, with the least-squares solution as start value, and free initial
  conditions and a constant. SysIdentPy has no output error; the free run of its ARX of the same order is compared
  instead.
- **Swarm.** 50 particles, {iterations} iterations, the same regression rows and search range. pyswarms has constant
  weights only, here c1 = c2 = {weights[c1]} and w = {weights[w]}, and its velocity is not clamped; the weights of
  piezoid change with the iteration (equations (5) to (7) of the paper), and its velocity is at most one fifth of the
  search range. pyswarms draws r1 and r2 for every dimension, piezoid once per particle, as in the paper. The errors
  compare two different searches. The times compare the same number of evaluations of the same cost. That cost is
  written for numpy in three ways: a loop over particles; all particles in one product, in arrays allocated in each
  iteration; the same in one array that is kept. For pyswarms only the search is timed; the time of piezoid also
  includes building the regression rows. HiGHS gets the linear program with sparse matrices.
- **Plays** in numpy: all plays of a sample together; and all samples between two reversals of the input together,
  because on such a monotone part the output of a play is a running maximum or minimum. The latter is the fastest known
  for inputs with few reversals. Numba and other compilers are not compared.
- **Bouc-Wen**: `solve_ivp` with its default method, with steps of at most one sampling period and rtol 1e-6; and the
  exact solution for a monotone input, sample by sample in a Python loop.
- **SysIdentPy 0.9**: polynomial NARX by FROLS and least squares, inputs u or u, du and sign du, degrees 1 to 3, 2 to 16
  lags, 5 to 33 terms: {settings} settings. The setting with the best free run on a record that was not used for its fit
  (the 5 Hz sine of the twin, or the last 30 % of the record of the stack) is selected. It is then fitted to all
  records, which are scaled to their range and concatenated. Its free run starts from measured samples.
  `best in hindsight` is the setting with the smallest maximum error on the validation records. A user cannot select it,
  because it needs the validation data.
- **Bouc-Wen by hand**: free-run least squares (`least_squares`, numeric Jacobian) of Bouc-Wen by Euler's method and a
  resonance, or a first-order lag if the sampling rate is too low to show the resonance. Each record has its own
  constant. Start values: a resonance at the peak of the frequency response, and two values of beta.
- **piezoid**: `pz.identify` with the records and the operator only. `chosen` tries all operators.
- **Twin**: a PRBS of 1 V, rising sines of 1, 5 and 20 Hz to 28 V and of 80 Hz to 20 V. Sensor noise is 0.01 % of
  peak-to-peak. All records start at rest; the multisine is faded in over 50 ms, because a jump would reach the current
  limit of the driver, which is not given to any model here. If the multisine starts with that jump, the error of
  `preisach` is ten times as large.
- **Stack**: a measured PICMA P-885.91 (github.com/yan9a/DiscreteBacklashOperator), a 1 Hz sine of constant amplitude as
  training data, a rising sine as validation data. It drifts, so the mean error is removed. The first 1.5 s of each
  record are left out of the error.
"""


def main() -> None:
    """Runs all, prints the tables, and writes the page."""
    import logging

    from beside import fits, identification, problems, rivals, table

    logging.disable()
    page = problems.Page(quick="--quick" in sys.argv)
    for part in (problems.filters, problems.blocks, problems.swarms, problems.plays, problems.bouc_wen):
        print(part.__name__, file=sys.stderr)
        part(page)
    for bench in (identification.twin(), identification.measured()):
        if bench is None:
            skipped = "The measured stack was skipped: PIEZOID_DATA names no folder that holds picma-p885."
            print(f"SKIPPED: {skipped}", file=sys.stderr)
            page.facts.append(skipped)
            continue
        print(f"identification, {bench.name}", file=sys.stderr)
        identification.identification(page, bench)
    load = f", load {os.getloadavg()[0]:.1f} at the end" if hasattr(os, "getloadavg") else ""
    packages = ["numpy", "scipy", "pyswarms", "sysidentpy"]
    text = TEXT.format(
        machine=f"{own.processor()}, {os.cpu_count()} cores, {platform.machine()}, {platform.system()}{load}",
        versions=", ".join([f"Python {platform.python_version()}", *[f"{name} {version(name)}" for name in packages]]),
        table=table.markdown(table.HEADS, [row.cells() for row in page.rows], 3),
        facts="\n".join(f"- {fact}" for fact in page.facts),
        unseen="\n\n".join(table.markdown(heads, rows, 1) for heads, *rows in page.unseen),
        behind=table.behind(page.rows),
        iterations=rivals.ITERATIONS,
        weights=rivals.WEIGHTS,
        settings=len(fits.SETTINGS),
    )
    print(text)
    if not page.quick:
        PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    # numpy reads the number of threads once, on import.
    os.environ.update(own.ONE_THREAD)
    if "--here" not in sys.argv:
        own.inside(NEEDS, checkout=True)
    with tempfile.TemporaryDirectory() as elsewhere:
        os.chdir(elsewhere)  # pyswarms writes a log into the working directory
        main()
