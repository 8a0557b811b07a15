"""Timing of alternating calls, and the rows and tables of the page."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

BATCH = 0.01
"""Short calls are repeated for this time per measurement [s]."""

ROUNDING = 1e-9
"""Errors below this are rounding."""

EQUAL = 1e-3
"""Errors that differ by less than this share count as the same."""

EVEN = 1.25
"""Times that differ by less than this factor count as the same, because they vary from run to run."""


@dataclass(frozen=True)
class Took:
    """The result of a call, and its time in each round [s]."""

    result: Any
    times: list[float]

    @property
    def seconds(self) -> float:
        """Median time [s]."""
        return statistics.median(self.times)


def in_turn(*calls: Callable[[], Any], repeats: int = 7) -> list[Took]:
    """Runs all calls in turn, `repeats` times; if `repeats` is more than 1, one more run before them warms up."""
    results, numbers = [], []
    for call in calls if repeats > 1 else ():
        start = time.perf_counter()
        results.append(call())
        numbers.append(1 + int(BATCH / (time.perf_counter() - start)))
    times: list[list[float]] = [[] for _ in calls]
    for _ in range(repeats):
        for k, call in enumerate(calls):
            number = numbers[k] if numbers else 1
            start = time.perf_counter()
            for _ in range(number):
                result = call()
            times[k].append((time.perf_counter() - start) / number)
            if repeats == 1:
                results.append(result)
    return [Took(result, t) for result, t in zip(results, times)]


@dataclass(frozen=True)
class Row:
    """One comparison."""

    problem: str
    other: str
    measure: str
    ours: float
    theirs: float
    mine: Took
    rival: Took

    @property
    def error(self) -> str:
        """Verdict on the error of piezoid: ahead, same, behind."""
        near = abs(self.ours - self.theirs) <= EQUAL * min(self.ours, self.theirs)
        if near or max(self.ours, self.theirs) < ROUNDING:
            return "same"
        return "ahead" if self.ours < self.theirs else "behind"

    @property
    def ratio(self) -> float:
        """Ratio of times, other / piezoid: the median over rounds. Within a round both have the same load."""
        return statistics.median(b / a for a, b in zip(self.mine.times, self.rival.times))

    @property
    def time(self) -> str:
        """Verdict on the time of piezoid."""
        if 1 / EVEN <= self.ratio <= EVEN:
            return "same"
        return "ahead" if self.ratio > 1.0 else "behind"

    def cells(self) -> list[str]:
        """Cells of its row in the table."""
        errors = [figure(self.ours), figure(self.theirs), self.error]
        times = [duration(self.mine.seconds), duration(self.rival.seconds), plain(self.ratio), self.time]
        return [self.problem, self.other, self.measure, *errors, *times]


HEADS = [
    "task",
    "compared with",
    "measure of error",
    "error",
    "other's error",
    "verdict on error",
    "time",
    "other's time",
    "ratio of times",
    "verdict on time",
]


def markdown(heads: Iterable[str], rows: Iterable[Iterable[str]], words: int) -> str:
    """A Markdown table; the first `words` columns hold text, the others numbers."""
    heads = list(heads)
    rule = ["---" if k < words or not head else "--:" for k, head in enumerate(heads)]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in [heads, rule, *map(list, rows)])


def figure(value: float) -> str:
    """An error with three digits."""
    return f"{value:.3g}" if value < 1e3 else f"{value:.0f}" if value < 1e9 else "diverges"


def duration(seconds: float) -> str:
    """A time with three digits and its unit."""
    unit, scale = next(((u, s) for u, s in [("s", 1.0), ("ms", 1e3)] if seconds * s >= 1.0), ("us", 1e6))
    return f"{plain(seconds * scale)} {unit}"


def plain(value: float) -> str:
    """Three digits without an exponent."""
    return f"{value:.0f}" if value >= 100 else f"{value:.1f}" if value >= 10 else f"{value:.2f}"


def counted(n: int) -> str:
    """A number of samples."""
    return f"{n:,} sample{'s' * (n != 1)}".replace(",", " ")


def behind(rows: Iterable[Row]) -> str:
    """The rows where piezoid is behind in error or not ahead in time, one line each."""
    lines = []
    for row in rows:
        where = f"- {row.problem}, against {row.other}: "
        if row.error == "behind":
            lines.append(f"{where}in error, {figure(row.ours)} against {figure(row.theirs)} ({row.measure})")
        if row.time != "ahead":
            lines.append(f"{where}in time, {duration(row.mine.seconds)} against {duration(row.rival.seconds)}")
    return "\n".join(lines) or "Nowhere."
