"""Lengths on the command line: a number with its unit (252mm, 8um, 532nm), or metres."""

import re
from dataclasses import dataclass
from math import isfinite
from typing import Any

import click

METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?"
MOST_DEPTHS = 100_000
_BARE_MOST = 10.0
"""Metres that a number without a unit may say: what is larger was meant in a smaller unit."""


@dataclass(frozen=True)
class Kind:
    """What a length is of: its name in messages, its plausible range in metres, and the unit that
    people write it in."""

    name: str
    low: float
    high: float
    unit: str


WAVELENGTH = Kind("wavelength", 1e-8, 1e-3, "nm")
PITCH = Kind("pixel pitch", 1e-7, 1e-2, "um")
DEPTH = Kind("depth", 1e-6, 1e3, "mm")
FOCAL = Kind("focal length", 1e-4, 100.0, "mm")
WIDTH = Kind("width on the bench", 1e-7, 1.0, "mm")
PLACE = Kind("place", -5.0, 5.0, "mm")
ON_BENCH = Kind("place on the bench", -1.0, 1.0, "mm")
DOT = Kind("radius", 0.0, 0.1, "um")
OFFSET = Kind("distance", 1e-9, 10.0, "mm")


def parse_length(text: object, kind: Kind) -> float:
    """Metres of a written length.

    Raises ValueError for what is no length, or none that is plausible for its kind, with the
    likely intention.
    """
    parts = split_length(text)
    if parts is None:
        raise ValueError(f"{text!r} is no length: write it with its unit, such as {example(kind)}")
    number, unit = parts
    # To 15 digits, so that 638nm and 638e-9 are one number.
    metres = float(f"{float(number) * METRES[unit or 'm']:.15g}")
    bare = not unit and abs(metres) >= _BARE_MOST
    if isfinite(metres) and kind.low <= metres <= kind.high and not bare:
        return metres
    meant = "" if unit else _likely(number, kind)
    said = f"{number} {unit or 'm'}"
    raise ValueError(
        f"{said} is no plausible {kind.name}"
        + (f": did you mean {meant}?" if meant else f" ({shown(kind.low)} to {shown(kind.high)})")
    )


def split_length(text: object) -> tuple[str, str] | None:
    """Number and unit ("" for none) as written; None for what is no length."""
    plain = str(text).strip().lower().replace("\u00b5", "u").replace("\u03bc", "u")
    match = re.fullmatch(rf"({_NUMBER})\s*([a-z]*)", plain, re.ASCII)
    if match is None or (match[2] and match[2] not in METRES):
        return None
    return match[1], match[2]


def _likely(number: str, kind: Kind) -> str:
    """The number in the unit that makes it plausible, or nothing."""
    for unit in dict.fromkeys((kind.unit, "um", "mm", "nm")):
        metres = float(number) * METRES[unit]
        if kind.low <= metres <= kind.high:
            return f"{number}{unit} ({metres:g})"
    return ""


def example(kind: Kind) -> str:
    """A length of a kind as one writes it."""
    return {"nm": "532nm", "um": "8um", "mm": "252mm"}[kind.unit]


def shown(metres: float) -> str:
    """A length in the largest unit that leaves at least 1 of it."""
    for unit, size in METRES.items():
        if unit != "cm" and abs(metres) >= size:
            break
    return f"{metres / size:.6g} {unit.replace('u', 'µ')}"


class Length(click.ParamType):
    """A length of a kind, as an option's type."""

    name = "LENGTH"

    def __init__(self, kind: Kind) -> None:
        self.kind = kind

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        try:
            return parse_length(value, self.kind)
        except ValueError as error:
            self.fail(str(error), param, ctx)


class Lengths(Length):
    """One length of a kind, or several parted by commas as a tuple."""

    name = "LENGTH[,LENGTH…]"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        parts = value if isinstance(value, list | tuple) else str(value).split(",")
        found = tuple(super(Lengths, self).convert(part, param, ctx) for part in parts)
        return found if len(found) > 1 else found[0]


def parse_lengths(text: str, sign: str | None, kind: Kind, option: str) -> list[float]:
    """Lengths parted by a sign, or a single one; ValueError in the name of an option."""
    try:
        return [parse_length(part, kind) for part in (text.split(sign) if sign else [text])]
    except ValueError as error:
        raise ValueError(f"{option} {text}: {error}") from None


def parse_depths(text: str) -> tuple[list[float], int]:
    """[near, far] and how many depths, of NEAR:FAR:COUNT."""
    asked, _, count = text.rpartition(":")
    ends = parse_lengths(asked, ":", DEPTH, "--depths") if asked else []
    number = int(count) if count.isdecimal() and len(count) < 10 else 0
    if len(ends) != 2 or not ends[0] < ends[1] or not 2 <= number <= MOST_DEPTHS:
        raise ValueError(
            f"--depths {text}: must be NEAR:FAR:COUNT, NEAR < FAR, COUNT 2 to "
            f"{MOST_DEPTHS}, such as 245mm:270mm:51"
        )
    return ends, number
