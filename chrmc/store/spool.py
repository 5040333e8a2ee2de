"""Frames' entries of a manifest in the making, kept on disk: memory does not grow with a video."""

import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from chrmc.files import json_text, replacing


class Spool:
    """Entries by frame number, in a file without a name that ends with the process.

    folder : where that file lies

    In memory are only the numbers, and where each entry's text begins and ends. Close it.
    """

    def __init__(self, folder: Path) -> None:
        self._file = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115 - it lives as long as this
        self._places: dict[int, tuple[int, int]] = {}

    def close(self) -> None:
        """Forget all entries."""
        self._file.close()

    def __contains__(self, number: int) -> bool:
        return number in self._places

    def __len__(self) -> int:
        return len(self._places)

    def __iter__(self) -> Iterator[int]:
        return iter(sorted(self._places))

    def add(self, entry: Mapping[str, Any]) -> None:
        """Keep a frame's entry, unless its number is there already."""
        number = int(entry["number"])
        if number not in self._places:
            content = json_text(entry).encode()
            start = self._file.seek(0, 2)
            self._file.write(content)
            self._file.flush()
            self._places[number] = start, len(content)

    def write_manifest(self, path: Path, description: Mapping[str, Any]) -> None:
        """Write the description and below it "frames", in order, whole or not at all."""
        with (
            replacing(path, new_folder=False) as partial,
            partial.open("w", encoding="utf-8") as out,
        ):
            out.write(json_text(description).removesuffix("\n}") + ',\n "frames": [')
            for index, number in enumerate(self):
                start, length = self._places[number]
                self._file.seek(start)
                text = self._file.read(length).decode()
                out.write((",\n  " if index else "\n  ") + text.replace("\n", "\n  "))
            out.write("\n ]\n}\n")
