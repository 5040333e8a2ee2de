"""A video's folder in the making: the one writer of its manifest, and its removal."""

import time
from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from chrmc.files import sha256, still_there, sweep
from chrmc.store.differences import refuse_another
from chrmc.store.group import SAVE_INTERVAL, GroupWriter, group_record, group_records
from chrmc.store.manifest import plain_file
from chrmc.store.spool import Spool
from chrmc.store.video import COLOUR, MANIFEST, read_manifest, written_and_checked


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
        return written_and_checked(folder)[0]
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
