#!/usr/bin/env python3
"""A fleet on Dask: throughput of two workers against one process, and the results if one of them is killed.

    pip install piezoid[fleet] && python3 bench/fleet.py [ACTUATORS]

1000 actuators, drawn within 20 % of the twin `pl140`. Each is measured and identified on a worker. The records are
0.8 s of a PRBS of 1 V, and 0.8 s of a sine of 5 Hz that rises to 28 V, both at 2 kHz. The model is a Prandtl-Ishlinskii
operator, creep and a linear block of order 2.

Three runs: in this process; on two worker processes of one thread each; and on these again, while one of them is killed
(SIGKILL) after a third of the actuators. All rows must arrive and be bit-identical; otherwise the exit status is 1.
"""

import os
import signal
import sys
import time
from functools import partial

import piezoid as pz

TS = 5e-4


def measured(index):
    """The records of an actuator, simulated on the worker."""
    twin = pz.plants["pl140"].drawn(0.2, seed=1, index=index)
    small = pz.excite.prbs(ts=TS, duration=0.8, amplitude=1)
    rich = pz.excite.rising_sine(ts=TS, duration=0.8, amplitude=28, frequency=5)
    return {"small_signal": twin.measure(small, ts=TS), "large_signal": twin.measure(rich, ts=TS)}


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    actuators = {f"pl140-{index}": partial(measured, index) for index in range(count)}

    def identified(what, client=None, progress=None):
        start = time.perf_counter()
        table = pz.fleet.identify(actuators, client, operator="prandtl-ishlinskii", order=2, progress=progress)
        seconds = time.perf_counter() - start
        print(
            f"{what:24}{seconds:7.1f} s, {count / seconds:6.1f} actuators/s; {len(table)} rows, {table.error.notna().sum()} errors, "
            f"from {table.worker.nunique()} processes",
            flush=True,
        )
        return table, seconds

    print(f"{count} actuators, {os.cpu_count()} cores", flush=True)
    alone, one = identified("one process")
    with pz.fleet.local(2) as client:
        client.run(measured, 0)  # both workers import their modules before the timed run
        shared, two = identified("two workers", client)
        killed = []

        def kill_one(_, done, total):
            if not killed and done >= total / 3:
                killed.append(next(iter(client.run(os.getpid).values())))
                os.kill(killed[0], signal.SIGKILL)

        hurt, _ = identified("two workers, one killed", client, kill_one)
    lasting = alone.columns.drop(["attempts", "seconds", "worker"])
    same = all(table[lasting].equals(alone[lasting]) and list(table.index) == list(actuators) for table in (shared, hurt))
    whole = bool(killed) and all(table.error.isna().all() for table in (alone, shared, hurt))
    print(f"two workers are {one / two:.2f} times as fast as one process")
    print(f"largest rms error: {alone.rms_pp_percent.max():.2f} % of peak-to-peak, median {alone.rms_pp_percent.median():.2f} %")
    print(f"all rows without an error: {'yes' if whole else 'NO'}; equal to the bit: {'yes' if same else 'NO'}")
    return 0 if whole and same else 1


if __name__ == "__main__":
    sys.exit(main())
