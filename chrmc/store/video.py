"""A hologram video on disk: a folder of 8-bit frames and `manifest.json`, resumable.

The manifest holds what the frames are (SLM, wavelength, scene, methods, encoding, scale) and, per
frame, its record. Frames are named `frame_0001.tif` after the scene's frame numbers. While a run
goes on, each group of frames has a record of its own, `group_….json`, which the manifest takes in;
a run that was cut off leaves them, and they count.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from chrmc.files import inside, read_json
from chrmc.pictures import read_grey
from chrmc.slm import SLM
from chrmc.store.group import Entry, group_record, group_records
from chrmc.store.manifest import checked

if TYPE_CHECKING:
    import pandas

MANIFEST = "manifest.json"
COLOUR = "colour.json"
"""In a folder of videos that belong together, one for each laser: `chrmc.store.colour`."""


@dataclass(frozen=True, repr=False)
class Video:
    """A stored video, read from its manifest.

    folder, slm, wavelength (m), scene (dict), methods (dict), encoding (name), scale (field
    amplitude that fills the grey range), frames (list of the manifest's entries, ascending)
    """

    folder: Path
    slm: SLM
    wavelength: float
    scene: dict[str, Any]
    methods: dict[str, Any]
    encoding: str
    scale: float
    response: dict[str, Any]
    frames: list[Entry]

    def __repr__(self) -> str:
        return (
            f"Video({str(self.folder)!r}, frames {ranges(self.numbers) or 'none yet'} of "
            f"{self.scene.get('name', 'a scene')}, {self.slm.width} × {self.slm.height})"
        )

    def __len__(self) -> int:
        return len(self.frames)

    def _repr_html_(self) -> str:
        from chrmc.store.notebook import video_html

        return video_html(self)

    def to_dataframe(self) -> "pandas.DataFrame":
        """One row per frame: its record, stages as "seconds …", indexed by the frame number.

        Needs pandas; ImportError says so.
        """
        from chrmc.store.notebook import dataframe

        return dataframe(self)

    @property
    def pixel_pitch(self) -> float:
        """The scene's pixel pitch, metres."""
        return float(self.scene["pixel_pitch"])

    @property
    def channels(self) -> "tuple[Video, ...]":
        """The video of each laser, as a video in colours has them: itself."""
        return (self,)

    @property
    def wavelengths(self) -> tuple[float, ...]:
        """Of the lasers, metres: of its one."""
        return (self.wavelength,)

    @property
    def numbers(self) -> list[int]:
        """Frame numbers that are there."""
        return [int(f["number"]) for f in self.frames]

    def entry(self, number: int) -> Entry:
        """The manifest's entry of a frame."""
        for frame in self.frames:
            if frame["number"] == number:
                return frame
        raise ValueError(
            f"{self.folder} has no frame {number}; it has {ranges(self.numbers) or 'none'}"
        )

    def path(self, number: int) -> Path:
        """File of a frame; ValueError where it is a link that leads out of the folder."""
        return inside(self.folder, self.folder / str(self.entry(number)["file"]))

    def read(self, number: int) -> NDArray[np.uint8]:
        """(H, W) grey levels of a frame; ValueError when it does not fit the SLM."""
        path = self.path(number)
        return read_grey(path, self.slm.shape)


def ranges(numbers: list[int]) -> str:
    """[1, 2, 3, 7] as "1:3, 7"."""
    runs: list[list[int]] = []
    for n in sorted(numbers):
        if runs and n == runs[-1][1] + 1:
            runs[-1][1] = n
        else:
            runs.append([n, n])
    return ", ".join(f"{a}:{b}" if b > a else f"{a}" for a, b in runs)


def open_video(folder: str | Path) -> Video:
    """Read a video's manifest; one-line ValueError or OSError when it is none."""
    folder = Path(folder)
    manifest = read_manifest(folder)
    return Video(
        folder,
        **{f.name: manifest[f.name] for f in fields(Video) if f.name != "folder"},
    )


def read_manifest(folder: Path) -> dict[str, Any]:
    """A folder's manifest, checked, with the frames of groups that it has not taken in yet."""
    if (folder / COLOUR).exists():
        names = ", ".join(str(path) for path in sorted(folder.glob("*nm")))
        raise ValueError(f"{folder} holds a video in colours: name one of them, {names}")
    return written_and_checked(folder)[1]


def written_and_checked(folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """A folder's manifest as it is written, and checked."""
    content = read_json(folder / MANIFEST, "hologram video; make one with `chrmc generate`")
    try:
        if isinstance(content, dict) and isinstance(content.get("frames"), list):
            content["frames"] = list(_with_groups(folder, content["frames"]))
        return content, checked(content)
    except ValueError as error:
        raise ValueError(
            f"{folder / MANIFEST} is not a hologram video's manifest ({error}): remake it"
        ) from None


def _with_groups(folder: Path, entries: list[Any]) -> Iterator[Any]:
    """The manifest's entries, then those of group records that it does not name yet."""
    known = [entry.get("number") for entry in entries if isinstance(entry, dict)]
    numbers = {number for number in known if isinstance(number, int)}
    yield from entries
    for path in group_records(folder):
        for entry in group_record(path)[0]:
            if entry["number"] not in numbers:
                numbers.add(entry["number"])
                yield entry
