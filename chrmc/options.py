"""Method options checked by name before work starts, so that a typo is told in one line."""

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any


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
