"""A video in colours on disk: an ordinary video for each laser, and one file that binds them.

`colour.json` holds the lasers' wavelengths in their order, each with its scale, at which its grey
range ends: the lasers' light is in balance when all have equal power (`chrmc.generation.colour`).
The video of 532 nm lies in the folder 532nm.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.colour import primaries
from chrmc.files import read_json, write_json
from chrmc.ranges import WAVELENGTH_RANGE, short
from chrmc.slm import SLM
from chrmc.store.manifest import FORMAT, SCALE
from chrmc.store.video import COLOUR, Entry, Video, ranges
from chrmc.store.video import open_video as open_channel

MOST = 16
"""Lasers."""


@dataclass(frozen=True)
class Plan:
    """What `colour.json` holds: lasers' wavelengths (metres), and the scale of each."""

    wavelengths: tuple[float, ...]
    scales: tuple[float, ...]

    @property
    def folders(self) -> list[str]:
        """Names of the lasers' folders."""
        return [channel_name(w) for w in self.wavelengths]


@dataclass(frozen=True, repr=False)
class ColourVideo:
    """A stored video in colours.

    folder : what `open_video` was given
    channels : the video of each laser, in the lasers' order; all of one scene and one panel
    """

    folder: Path
    channels: tuple[Video, ...]

    def __repr__(self) -> str:
        lasers = ", ".join(f"{w * 1e9:g}" for w in self.wavelengths)
        return (
            f"ColourVideo({str(self.folder)!r}, frames {ranges(self.numbers) or 'none yet'} of "
            f"{self.scene.get('name', 'a scene')}, {self.slm.width} × {self.slm.height}, "
            f"{lasers} nm)"
        )

    def __len__(self) -> int:
        return len(self.numbers)

    @property
    def wavelengths(self) -> tuple[float, ...]:
        """Of the lasers, metres."""
        return tuple(channel.wavelength for channel in self.channels)

    @property
    def slm(self) -> SLM:
        """The panel."""
        return self.channels[0].slm

    @property
    def scene(self) -> dict[str, Any]:
        """As the first laser's manifest has it."""
        return self.channels[0].scene

    @property
    def numbers(self) -> list[int]:
        """Frames that are there for every laser."""
        shared = set.intersection(*(set(channel.numbers) for channel in self.channels))
        return sorted(shared)

    def entry(self, number: int) -> Entry:
        """The first laser's record of a frame: places and sizes are those of all."""
        if number not in self.numbers:
            raise ValueError(
                f"{self.folder} has no frame {number} in all its colours; it has "
                f"{ranges(self.numbers) or 'none'}"
            )
        return self.channels[0].entry(number)

    def read(self, number: int) -> NDArray[np.uint8]:
        """(H, W, lasers) grey levels of a frame."""
        self.entry(number)
        return np.stack([channel.read(number) for channel in self.channels], axis=-1)


def open_video(folder: str | Path) -> Video | ColourVideo:
    """Read a stored video, of one laser or several; one-line ValueError or OSError for none."""
    folder = Path(folder)
    plan = read_plan(folder)
    if plan is None:
        return open_channel(folder)
    channels = []
    for name, wavelength in zip(plan.folders, plan.wavelengths, strict=True):
        if not (folder / name).is_dir():
            raise FileNotFoundError(
                f"{folder} has no frames at {wavelength * 1e9:g} nm yet: the command that began "
                "it goes on"
            )
        channels.append(open_channel(folder / name))
    first = channels[0]
    for channel, wavelength in zip(channels, plan.wavelengths, strict=True):
        if channel.wavelength != wavelength:
            raise ValueError(
                f"{channel.folder} is for {channel.wavelength * 1e9:g} nm: {folder} was put "
                "together from videos that do not belong to each other; remake it"
            )
        if (channel.slm, channel.encoding) != (first.slm, first.encoding) or (
            channel.scene["name"] != first.scene["name"]
        ):
            raise ValueError(
                f"{channel.folder} and {first.folder} are of different scenes, panels or "
                "encodings: remake them"
            )
    return ColourVideo(folder, tuple(channels))


def channel_name(wavelength: float) -> str:
    """Folder of a laser's video, such as 532nm."""
    return f"{wavelength * 1e9:.9g}nm"


def read_plan(folder: Path) -> Plan | None:
    """What `colour.json` holds, checked; None where there is none."""
    path = folder / COLOUR
    if not path.exists():
        return None
    content = read_json(path, "video in colours")
    try:
        if not isinstance(content, dict) or content.get("format") != FORMAT:
            raise ValueError("this version reads format 1")
        plan = Plan(
            tuple(WAVELENGTH_RANGE.of(w) for w in _list(content, "wavelengths")),
            tuple(SCALE.of(s) for s in _list(content, "scales")),
        )
        if len(plan.scales) != len(plan.wavelengths) or len(set(plan.folders)) != len(plan.scales):
            raise ValueError("lasers must be different, and have a scale each")
        primaries(plan.wavelengths)
    except ValueError as error:
        raise ValueError(f"{path} is not a colour video's ({error}): remake it") from None
    return plan


def _list(content: dict[str, Any], name: str) -> list[Any]:
    values = content.get(name)
    if not isinstance(values, list) or not 2 <= len(values) <= MOST:
        raise ValueError(f"{name} must be a list of 2 to {MOST}, not {short(values)}")
    return values


def write_plan(folder: Path, plan: Plan) -> None:
    """Write `colour.json`, whole or not at all."""
    content = {"format": FORMAT, "wavelengths": plan.wavelengths, "scales": plan.scales}
    write_json(folder / COLOUR, content)


def lasers_of(wavelength: Any) -> tuple[float, ...]:
    """Several wavelengths, or none where it is one or the scene's own."""
    if np.ndim(wavelength) == 0:
        return ()
    found = tuple(WAVELENGTH_RANGE.of(w) for w in wavelength)
    if not 2 <= len(found) <= MOST:
        raise ValueError(f"a video in colours has 2 to {MOST} wavelengths, not {len(found)}")
    return found
