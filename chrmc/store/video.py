"""A hologram video on disk: a folder of 8-bit frames and `manifest.json`, resumable.

The manifest holds what the frames are (SLM, wavelength, scene, methods, encoding, scale) and, per
frame, its record. Frames are named `frame_0001.tif` after the scene's frame numbers. While a run
goes on, each group of frames has a record of its own, `group_….json`, which the manifest takes in;
a run that was cut off leaves them, and they count.
"""

import time
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from chrmc.files import inside, read_json, sha256, still_there, sweep
from chrmc.pictures import read_grey
from chrmc.slm import SLM
from chrmc.store.differences import refuse_another
from chrmc.store.group import (
    SAVE_INTERVAL,
    Entry,
    GroupWriter,
    group_record,
    group_records,
)
from chrmc.store.manifest import FORMAT, checked, plain_file
from chrmc.store.spool import Spool

if TYPE_CHECKING:
    import pandas

__all__ = [
    "COLOUR",
    "FORMAT",
    "MANIFEST",
    "GroupWriter",
    "Video",
    "VideoWriter",
    "open_video",
    "ranges",
]

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
    return _read(folder)[1]


def _read(folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:
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


@dataclass
class VideoWriter:
    """Writes a video's manifest; state is the manifest in the making. See `lock.writer_lock`.

    entries : of the frames that are there, kept on disk

    folder : made when absent
    description : everything of the manifest but `frames`; a folder that holds a video of another
        description is refused with what differs
    suffix : ".tif" or ".png"
    """

    folder: Path
    description: dict[str, Any]
    suffix: str = ".tif"
    entries: Spool = field(init=False)
    made_on: list[Any] = field(default_factory=list)
    _saved: float = 0.0
    _pause: float = SAVE_INTERVAL

    def __post_init__(self) -> None:
        self.folder = Path(self.folder)
        before = existing_manifest(self.folder)
        if before is not None:
            refuse_another(self.folder, before, self.description)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.entries = Spool(self.folder)
        if before is not None:
            for entry in before["frames"]:
                path = self.folder / plain_file(entry["file"])
                if path.is_file() and sha256(path) == entry["sha256"]:
                    self.entries.add(entry)
            self.made_on += before.get("made_on", [])
            sweep(self.folder)

    def take_in(self) -> list[Path]:
        """Take in the records of groups; their paths."""
        paths = group_records(self.folder)
        for path in paths:
            entries, made_on = group_record(path)
            for entry in entries:
                self.entries.add(entry)
            self.made_on += [machine for machine in made_on if machine not in self.made_on]
        return paths

    def collect(self, busy: Collection[int] = ()) -> None:
        """Take in the records of groups, save the manifest, and remove those records.

        busy : first frames of groups that are still being written; their records stay
        """
        paths = self.take_in()
        self.save()
        kept = {GroupWriter(self.folder, first).path for first in busy}
        for path in paths:
            if path not in kept:
                path.unlink(missing_ok=True)

    @property
    def due(self) -> bool:
        """Whether the manifest was saved so long ago that it may be again."""
        return time.monotonic() - self._saved > self._pause

    def save(self) -> None:
        """Write the manifest of all frames so far."""
        still_there(self.folder)
        start = time.monotonic()
        content = self.description | {"made_on": self.made_on}
        self.entries.write_manifest(self.folder / MANIFEST, content)
        self._saved = time.monotonic()
        # A long manifest is saved more rarely: a twentieth of the time at most.
        self._pause = max(SAVE_INTERVAL, 20 * (self._saved - start))

    def discard_if_empty(self) -> None:
        """Remove the manifest of a video of which no frame came about."""
        if not self.entries:
            (self.folder / MANIFEST).unlink(missing_ok=True)


def existing_manifest(folder: Path) -> dict[str, Any] | None:
    """The manifest as it stands on disk, groups' records included; None where there is none.

    ValueError for a file in place of the folder, and for frames that no manifest names.
    """
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"{folder} is a file; --out needs a folder")
    if (folder / COLOUR).exists():
        raise ValueError(f"{folder} holds a video in colours: choose another --out, or remove it")
    if (folder / MANIFEST).exists():
        return _read(folder)[0]
    if folder.is_dir() and any(folder.glob("frame_*")):
        raise ValueError(
            f"{folder} holds frames without a {MANIFEST}: they are not this video's; "
            "choose another --out"
        )
    return None


def remove_video(folder: str | Path) -> None:
    """Delete the frames, the records and the manifest of a video, and nothing else."""
    folder = Path(folder)
    if (folder / MANIFEST).exists():
        for path in [*folder.glob("frame_[0-9]*.*"), *group_records(folder)]:
            path.unlink()
        (folder / MANIFEST).unlink()


def replace_video(folder: Path, new: Path) -> None:
    """Put the video in `new` in place of the one in `folder`, which goes only then."""
    names = {entry["file"] for entry in read_manifest(new)["frames"]}
    old = [p for p in folder.glob("frame_[0-9]*.*") if p.name not in names]
    old += group_records(folder)
    for name in names:
        (new / name).replace(folder / name)
    (new / MANIFEST).replace(folder / MANIFEST)
    for path in old:
        path.unlink()
    new.rmdir()
