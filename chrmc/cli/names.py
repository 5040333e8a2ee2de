"""Names that options take: what --help and shell completion say of them.

The lists are made when they are asked for, so that a command that needs no method loads none.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import click
from click.shell_completion import CompletionItem

_NOT_SET = {"cache", "measure"}
"""Options that only Python can give."""


class Name(click.ParamType):
    """One of some names, or anything else that the option's use may know, such as FILE.py:NAME."""

    name = "NAME"

    def __init__(self, names: Callable[[], Iterable[str]]) -> None:
        self.names = names

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """The names that begin so; files too, where none does."""
        found = [CompletionItem(n) for n in self.names() if n.startswith(incomplete)]
        return found or [CompletionItem(incomplete, type="file")]


class NamedOption(click.Option):
    """An option whose --help ends with a list."""

    def __init__(self, *args: Any, listing: Callable[[], str], **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.listing = listing

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        """The option and its help, with the list."""
        record = super().get_help_record(ctx)
        return None if record is None else (record[0], f"{record[1]} {self.listing()}")


def scene_names() -> Sequence[str]:
    """The built-in scenes."""
    from chrmc.scene.load import BUILT_IN

    return BUILT_IN


def cgh_names() -> list[str]:
    """The CGH methods."""
    from chrmc.cgh import METHODS

    return ["auto", *METHODS]


def compensation_names() -> list[str]:
    """The video methods."""
    from chrmc.compensation import COMPENSATIONS

    return ["auto", *COMPENSATIONS, "ch-rmc"]


def settings() -> dict[str, list[str]]:
    """Method to the options that --set gives it."""
    from chrmc.cgh import METHODS, method_named
    from chrmc.compensation import COMPENSATIONS, compensation_named
    from chrmc.options import option_names

    functions: dict[str, Callable[..., Any]] = {n: method_named(n).field for n in METHODS}
    functions |= {n: compensation_named(n) for n in COMPENSATIONS}
    found = {n: [o for o in option_names(f)[0] if o not in _NOT_SET] for n, f in functions.items()}
    return {name: options for name, options in found.items() if options}


def settings_listing() -> str:
    """`settings` in words."""
    return "; ".join(f"{name}: {', '.join(options)}" for name, options in settings().items()) + "."
