"""Method options checked by name before work starts, so that a typo is told in one line."""

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from difflib import get_close_matches
from numbers import Integral, Real
from types import NoneType
from typing import Any, get_args

from chrmc.ranges import short


def meant(name: str, names: Iterable[str]) -> str:
    """ " (did you mean NAME?)" for the name that is most like the one given, or nothing."""
    found = get_close_matches(str(name), list(names), n=1)
    return f" (did you mean {found[0]}?)" if found else ""


def option_names(function: Callable[..., Any]) -> tuple[list[str], bool]:
    """Keyword-only option names of a method, and whether it passes others on."""
    parameters = inspect.signature(function).parameters.values()
    names = [p.name for p in parameters if p.kind is p.KEYWORD_ONLY]
    return names, any(p.kind is p.VAR_KEYWORD for p in parameters)


def check_options(
    kind: str,
    function: Callable[..., Any],
    options: Mapping[str, Any],
    elsewhere: Callable[[str], Sequence[str]] = lambda option: (),
    handed_on: Sequence[str] | None = None,
) -> None:
    """ValueError for an option that a method does not take.

    elsewhere : option to the names of methods that have it
    handed_on : names that it hands on to where they are known; None for any
    """
    names, others = option_names(function)
    if others and handed_on is not None:
        names, others = [*names, *(name for name in handed_on if name not in names)], False
    unknown = [] if others else sorted(set(options) - set(names))
    if unknown:
        takes = f"it takes {', '.join(names)}" if names else "it takes none"
        having = elsewhere(unknown[0])
        who = f"; {', '.join(having)} {'has' if len(having) == 1 else 'have'} it" if having else ""
        alike = meant(unknown[0], names)
        raise ValueError(f"{kind} has no option {unknown[0]!r}{alike}; {takes}{who}")
    declared = inspect.signature(function).parameters
    for name in options.keys() & declared.keys():
        _check_number(f"{kind}'s option {name}", options[name], declared[name].annotation)


def _check_number(name: str, value: Any, declared: Any) -> None:
    """ValueError where a number is declared, or a whole one, and something else given; other types
    are the method's own to check."""
    kinds = set(get_args(declared)) or {declared}
    if not kinds & {int, float} or not kinds <= {int, float, bool, NoneType}:
        return
    if (value is None and NoneType in kinds) or (isinstance(value, bool) and bool in kinds):
        return
    wanted: Any = Real if float in kinds else Integral
    if isinstance(value, bool) or not isinstance(value, wanted) or value != value:
        what = "a finite number" if float in kinds else "a whole number"
        raise ValueError(f"{name} must be {what}, not {short(value)}")
