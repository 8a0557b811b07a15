"""A model in words, for a terminal."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .model import Model

WIDTH = 100
"""Width of lines, as on the command line."""


def summary(model: Model) -> str:
    """What it is, how good it is and where, its parameters, remarks."""
    verdict = model.verdict
    lines = [_paragraph(model._core.line + "."), _paragraph(f"{_capital(str(verdict or 'no verdict in its file'))}.")]
    u, y = model.units
    if model.input_range:
        low, high = model.input_range
        lines.append(f"Identified for inputs from {low:.4g} to {high:.4g} {u}; offset {model.offset:.4g} {y}.")
    found = model.parameters
    if len(found):
        width = max(map(len, found["name"]))
        lines += ["", f"{'parameter':{width}}  {'value':>12}  {'standard error':>14}"]
        for name, value, error in found[["name", "value", "error"]].itertuples(index=False):
            known = isinstance(error, (int, float)) and error == error
            lines.append(f"{name:{width}}  {value:>12.4g}  {f'{error:.2g}' if known else '-':>14}")
    notes = model.notes
    return "\n".join([*lines, *([""] if notes else []), *(_paragraph(f"note: {note}", "  ") for note in notes)])


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _paragraph(text: str, indent: str = "") -> str:
    return fill(text, WIDTH, subsequent_indent=indent, break_on_hyphens=False)
