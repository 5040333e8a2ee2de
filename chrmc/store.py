"""A hologram video on disk: a folder of 8-bit frames and `manifest.json`, resumable.

The manifest holds what the frames are (SLM, wavelength, scene, methods, encoding, scale) and, per
frame, its record. Frames are named `frame_0001.tif` after the scene's frame numbers. A run that
stops in between is continued by opening the same folder with the same description.
"""

import time
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.compensation.ledger import FrameRecord
from chrmc.files import read_json, sha256, write_json
from chrmc.pictures import read_grey, write_grey
from chrmc.slm import SLM

MANIFEST = "manifest.json"
FORMAT = 1
SAVE_INTERVAL = 1.0
"""Seconds between manifests while a run goes on; frames since the last one are made again."""


@dataclass(frozen=True)
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
    frames: list[dict[str, Any]]

    @property
    def pixel_pitch(self) -> float:
        """The scene's pixel pitch, metres."""
        return float(self.scene["pixel_pitch"])

    @property
    def numbers(self) -> list[int]:
        """Frame numbers that are there."""
        return [int(f["number"]) for f in self.frames]

    def entry(self, number: int) -> dict[str, Any]:
        """The manifest's entry of a frame."""
        for frame in self.frames:
            if frame["number"] == number:
                return frame
        raise ValueError(
            f"{self.folder} has no frame {number}; it has {ranges(self.numbers) or 'none'}"
        )

    def path(self, number: int) -> Path:
        """File of a frame."""
        return self.folder / str(self.entry(number)["file"])

    def read(self, number: int) -> NDArray[np.uint8]:
        """(H, W) grey levels of a frame; ValueError when it does not fit the SLM."""
        path = self.path(number)
        levels = read_grey(path)
        if levels.shape != self.slm.shape:
            raise ValueError(
                f"{path} is {levels.shape[1]} × {levels.shape[0]} pixels; {self.slm.name} needs "
                f"{self.slm.width} × {self.slm.height}"
            )
        return levels


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
    manifest = read_json(folder / MANIFEST, "hologram video; make one with `chrmc generate`")
    try:
        if manifest["format"] != FORMAT:
            raise ValueError(
                f"{folder / MANIFEST} has format {manifest['format']}; this version reads {FORMAT}"
            )
        frames = sorted(manifest["frames"], key=lambda f: int(f["number"]))
        for frame in frames:
            if Path(frame["file"]).name != frame["file"]:
                raise ValueError(f"{folder / MANIFEST}: {frame['file']!r} is not a plain file name")
        return Video(
            folder,
            SLM(**manifest["slm"]),
            float(manifest["wavelength"]),
            dict(manifest["scene"]),
            dict(manifest["methods"]),
            str(manifest["encoding"]),
            float(manifest["scale"]),
            dict(manifest.get("response", {})),
            frames,
        )
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(
            f"{folder / MANIFEST} is not a hologram video's manifest ({error}): remake it"
        ) from None


@dataclass
class VideoWriter:
    """Writes a video frame by frame; state is the manifest in the making.

    folder : made when absent
    description : everything of the manifest but `frames`; a folder that holds a video of another
        description is refused
    suffix : ".tif" or ".png"
    """

    folder: Path
    description: dict[str, Any]
    suffix: str = ".tif"
    entries: dict[int, dict[str, Any]] = field(default_factory=dict)
    _saved: float = 0.0

    def __post_init__(self) -> None:
        self.folder = Path(self.folder)
        if self.folder.exists() and not self.folder.is_dir():
            raise ValueError(f"{self.folder} is a file; --out needs a folder")
        path = self.folder / MANIFEST
        if path.exists():
            self._continue(read_json(path, "hologram video"))
        elif self.folder.is_dir() and any(self.folder.glob("frame_*")):
            raise ValueError(
                f"{self.folder} holds frames without a {MANIFEST}: they are not this video's; "
                "choose another --out"
            )

    def _continue(self, manifest: dict[str, Any]) -> None:
        for key, wanted in self.description.items():
            if manifest.get(key) != wanted:
                raise ValueError(
                    f"{self.folder} holds another video (its {key} is "
                    f"{_short(manifest.get(key))}, not {_short(wanted)}): choose another --out, "
                    "or replace it with --force"
                )
        for entry in manifest.get("frames", []):
            path = self.folder / Path(str(entry["file"])).name
            if path.is_file() and sha256(path) == entry["sha256"]:
                self.entries[int(entry["number"])] = entry

    def add(self, record: FrameRecord, levels: NDArray[np.uint8]) -> None:
        """Store one frame and its record."""
        path = self.folder / f"frame_{record.number:04d}{self.suffix}"
        write_grey(path, levels)
        entry = {"number": record.number, "file": path.name, "sha256": sha256(path)}
        self.entries[record.number] = entry | asdict(record)
        if time.monotonic() - self._saved > SAVE_INTERVAL:
            self.save()

    def save(self) -> None:
        """Write the manifest of all frames so far."""
        frames = [self.entries[n] for n in sorted(self.entries)]
        write_json(self.folder / MANIFEST, self.description | {"frames": frames})
        self._saved = time.monotonic()


def remove_video(folder: str | Path) -> None:
    """Delete the frames and the manifest of a video, and nothing else."""
    folder = Path(folder)
    if (folder / MANIFEST).exists():
        for path in folder.glob("frame_[0-9]*.*"):
            path.unlink()
        (folder / MANIFEST).unlink()


def _short(value: Any) -> str:
    text = str(value)
    return text if len(text) <= 60 else text[:57] + "…"
