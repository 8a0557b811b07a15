"""Options of the library as keywords of functions: their names, defaults and documentation come from `_options`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from inspect import Parameter, cleandoc, signature
from typing import Any, TypeVar

from ._options import DEFAULTS

F = TypeVar("F", bound=Callable[..., Any])


def takes(options: type[Any]) -> Callable[[F], F]:
    """Puts the options into the signature of a function, and into its docstring in place of `{options}`."""
    lines = cleandoc(options.__doc__ or "").split("\n\n", 1)[1].splitlines()
    types = {name: getattr(kind, "__forward_arg__", kind) for name, kind in options.__annotations__.items()}
    keywords = [
        Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=types[name])
        for name, default in DEFAULTS[options.__name__].items()
    ]

    def described(function: F) -> F:
        indent = "        " if "." in function.__qualname__ else "    "
        function.__doc__ = (function.__doc__ or "").replace("{options}", f"\n{indent}".join(lines))
        own = signature(function)
        parameters = [p for p in own.parameters.values() if p.kind is not Parameter.VAR_KEYWORD]
        setattr(function, "__signature__", own.replace(parameters=[*parameters, *keywords]))
        setattr(function, "__options__", [p.name for p in keywords])
        return function

    return described


def known(function: Callable[..., Any], values: Mapping[str, object]) -> dict[str, Any]:
    """The options that were given to a function; any other keyword is a `TypeError` that names all."""
    options: list[str] = getattr(function, "__options__")
    for name in values:
        if name not in options:
            own = [p.name for p in signature(function).parameters.values() if p.kind is Parameter.KEYWORD_ONLY]
            names = [*options, *(keyword for keyword in own if keyword not in options)]
            raise TypeError(f"unexpected keyword {name!r}: options are {', '.join(names)}")
    return dict(values)
