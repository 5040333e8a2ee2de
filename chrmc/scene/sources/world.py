"""Several things in front of the SLM, as a user describes them: files, sizes, places, motions."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from chrmc.ranges import Range, short
from chrmc.scene.surface.shading import Lamp

SHADINGS = ("diffuse", "unlit")
MOTIONS = ("own", "turntable", "poses", "none")
SMALLEST, LARGEST = 1e-12, 1e12
"""Of numbers in a description of a scene: what is made of them stays a number."""


@dataclass(frozen=True)
class Turning:
    """How an entry moves.

    kind : "own" (the file's animation), "turntable", "poses" or "none"
    axis : of a turntable, in the scene's axes (y down); degrees : per frame, right-handed
    file : of the poses; scale : metres here per unit there, default the entry's own scale
    """

    kind: str = "own"
    axis: tuple[float, float, float] = (0.0, 1.0, 0.0)
    degrees: float = 6.0
    file: Path | None = None
    scale: float | None = None


@dataclass(frozen=True)
class Entry:
    """One file, or text, in the scene.

    source : a path, or "text:WORDS"
    size : metres of its largest side; scale : metres per unit of the file; at most one of them
    up : which axis of the file points up, default as its kind usually has it
    place : (x, y, z) metres of its middle; None in each for the default
    turn : degrees about the scene's x, y and z axes, in this order, about its middle
    """

    source: str
    name: str | None = None
    size: float | None = None
    scale: float | None = None
    up: str | None = None
    place: tuple[float | None, float | None, float | None] = (None, None, None)
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)
    motion: Turning = field(default_factory=Turning)


@dataclass(frozen=True)
class World:
    """Things with what they share; see `chrmc.scene.sources.world_toml` for the words."""

    name: str
    entries: tuple[Entry, ...]
    frames: int | None = None
    rate: float | None = None
    wavelength: float | None = None
    shading: str = "diffuse"
    lamp: Lamp = field(default_factory=Lamp)
    density: float | None = None
    points: int | None = None
    notes: tuple[str, ...] = ()

    @property
    def files(self) -> list[Path]:
        """All that entries and their motions are read from."""
        sources = [Path(t.source) for t in self.entries if not t.source.startswith("text:")]
        return sources + [t.motion.file for t in self.entries if t.motion.file is not None]


def world_of(sources: list[str]) -> World:
    """The world that a command line's words mean: files, each at a depth where `@` says so."""
    entries: list[Entry] = []
    names: dict[str, int] = {}
    for words in sources:
        source, depth = split_depth(words)
        stem = source[5:] if source.startswith("text:") else Path(source).stem
        names[stem] = names.get(stem, 0) + 1
        name = stem if names[stem] == 1 else f"{stem} {names[stem]}"
        entries.append(Entry(source, name, place=(None, None, depth)))
    return World("+".join(names), tuple(entries))


def split_depth(words: str) -> tuple[str, float | None]:
    """A source and the depth in metres behind its last `@`."""
    source, sign, text = words.rpartition("@")
    if not sign:
        return words, None
    try:
        depth = _metres(text)
    except ValueError:
        if Path(words).exists():
            return words, None
        raise ValueError(f"{words!r}: {text!r} is no depth; write FILE@0.22 (metres)") from None
    if not 1e-6 <= depth < 1e3:
        raise ValueError(f"{words!r}: {depth:g} m is no depth; 220 mm is 0.22")
    return source, depth


def _metres(text: str) -> float:
    for unit, metres in (("mm", 1e-3), ("um", 1e-6), ("µm", 1e-6), ("cm", 1e-2), ("m", 1.0)):
        if text.endswith(unit):
            return float(text.removesuffix(unit)) * metres
    return float(text)


def triple(value: Any, key: str) -> tuple[float, float, float]:
    """Three numbers."""
    if not isinstance(value, list | tuple) or len(value) != 3:
        raise ValueError(f"{key} must be three numbers, not {short(value)}")
    x, y, z = (number(v, key) for v in value)
    return x, y, z


def number(value: Any, key: str, positive: bool = False) -> float:
    """A number as descriptions of scenes hold it: metres, degrees, pixels."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{key} must be a number, not {short(value)}")
    return Range(key, SMALLEST if positive else -LARGEST, LARGEST, unit="").of(value)
