"""Rows of a long bench that are done, kept in a file."""

from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, ClassVar, Generic, Protocol, TypeVar

from chrmc.files import read_json, write_json
from chrmc.ranges import real


class Row(Protocol):
    """A dataclass of what JSON holds."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def key(self) -> tuple[Any, ...]:
        """What it is asked for by."""


Kind = TypeVar("Kind", bound=Row)


def _row(kind: type[Kind], content: dict[str, Any]) -> Kind:
    """A row of text and finite numbers; ValueError or TypeError for anything else."""
    row = kind(**content)
    for one in fields(row):
        value = getattr(row, one.name)
        if one.type == "str" or one.type is str:
            if not isinstance(value, str):
                raise TypeError
        else:
            real(one.name, value)
    return row


class KeptRows(Generic[Kind]):
    """What came of a long bench so far, in a file, so that it goes on where it was stopped.

    path : without one nothing is stored
    made_with : machine and settings; what was made with others is refused
    anew : begin without the rows that are there, which stand until the first new one
    """

    def __init__(
        self, path: Path | None, made_with: Sequence[str], kind: type[Kind], anew: bool = False
    ) -> None:
        self.path, self.made_with = path, list(made_with)
        self._rows: dict[tuple[Any, ...], Kind] = {}
        if path is None or not path.exists():
            return
        stored = read_json(path, "record of a bench")
        try:
            before, rows = list(stored["made_with"]), [_row(kind, row) for row in stored["rows"]]
        except (KeyError, TypeError, ValueError):
            raise ValueError(f"{path} is no record of a bench: remove it") from None
        if anew:
            return
        if before != self.made_with:
            raise ValueError(
                f"{path} was made with {'; '.join(map(str, before))}, not "
                f"{'; '.join(self.made_with)}: remove it, or name another --out"
            )
        self._rows = {row.key: row for row in rows}

    def of(self, *key: Any) -> Kind | None:
        """A row, as far as it came."""
        return self._rows.get(key)

    def take(self, row: Kind) -> None:
        """Keep a row, in place of what there was of it."""
        self._rows[row.key] = row
        if self.path is not None:
            rows = [asdict(one) for one in self._rows.values()]
            write_json(self.path, {"made_with": self.made_with, "rows": rows})
