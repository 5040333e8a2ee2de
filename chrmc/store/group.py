"""A group of frames on disk: its pictures, and the record that its one writer keeps of them."""

import time
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.files import read_json, sha256, still_there, write_json
from chrmc.machine import arithmetic
from chrmc.pictures import write_grey
from chrmc.record import FrameRecord
from chrmc.store.manifest import checked_frame

SAVE_INTERVAL = 1.0
"""Seconds between records while a run goes on; frames since the last one are made again."""

Entry = dict[str, Any]


def group_record(path: Path) -> tuple[list[Entry], list[Any]]:
    """The frames of a group's record, and what it was made on; ValueError for what is none."""
    content = read_json(path, "hologram video")
    if not isinstance(content, dict) or not isinstance(content.get("frames"), list):
        raise ValueError(f"{path} is no record of a group: remove it")
    made_on = [content["made_on"]] if "made_on" in content else []
    return [checked_frame(entry) for entry in content["frames"]], made_on


def group_records(folder: Path) -> list[Path]:
    """Records of groups that the manifest has not taken in for good."""
    return sorted(folder.glob("group_[0-9]*.json"))


@dataclass
class GroupWriter:
    """Writes a group's frames and its record; nobody else writes that file.

    first : the group's first frame
    """

    folder: Path
    first: int
    suffix: str = ".tif"
    entries: dict[int, Entry] = field(default_factory=dict)
    _recorded: set[int] = field(default_factory=set)
    _saved: float = 0.0

    @property
    def path(self) -> Path:
        """The group's record."""
        return self.folder / f"group_{self.first:06d}.json"

    def add(self, record: FrameRecord, levels: NDArray[np.uint8]) -> None:
        """Store one frame with its entry; interrupted, neither. The record follows within
        `SAVE_INTERVAL` or with `save`."""
        still_there(self.folder)
        number, path = record.number, self.folder / f"frame_{record.number:04d}{self.suffix}"
        there = path.exists()  # an attempt before this one stored it, with the same bytes
        try:
            write_grey(path, levels, new_folder=False)
            named = {"number": number, "file": path.name, "sha256": sha256(path)}
            self.entries[number] = named | asdict(record)
        except BaseException:
            if number not in self.entries and not there:
                path.unlink(missing_ok=True)
            raise
        if time.monotonic() - self._saved > SAVE_INTERVAL:
            self.save()

    def save(self) -> None:
        """Write the record of the group's frames so far; where it cannot be written, the frames
        that no record names go."""
        if not self.entries:
            return
        still_there(self.folder)
        frames = [self.entries[n] for n in sorted(self.entries)]
        try:
            record = {"made_on": arithmetic(), "frames": frames}
            write_json(self.path, record, new_folder=False)
        except OSError:
            for number in self.entries.keys() - self._recorded:
                with suppress(OSError):
                    (self.folder / self.entries.pop(number)["file"]).unlink(missing_ok=True)
            raise
        self._recorded = set(self.entries)
        self._saved = time.monotonic()
