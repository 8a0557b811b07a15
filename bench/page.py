"""Parts of Markdown pages that programs write, between `<!-- NAME: written by ... -->` and `<!-- end of NAME -->`."""

from __future__ import annotations

import re


def split(text: str, name: str) -> tuple[str, str, str]:
    """The text up to a part, the part, and the text from its end on."""
    found = re.fullmatch(rf"(.*<!-- {name}: written by [^\n]* -->\n)(.*)(<!-- end of {name} -->.*)", text, re.DOTALL)
    if found is None:
        raise ValueError(f"the page has no part <!-- {name}: written by ... --> to <!-- end of {name} -->")
    before, part, after = found.groups()
    return before, part, after


def replaced(text: str, name: str, part: str) -> str:
    """The text with another part."""
    before, _, after = split(text, name)
    return before + part.rstrip("\n") + "\n" + after
