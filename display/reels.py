"""Where a screen's frames come from: a stored video read ahead, or an iterable asked one by one."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from display.playlist import Picture, Playlist
from display.prefetch import Fault, Ring


def ring_of(
    playlist: Playlist,
    loop: bool,
    ahead: int,
    planes: int = 0,
    colours: str = "sequence",
    trigger: Any = None,
) -> Ring:
    """A ring over a stored video, `planes` binary frames to a picture.

    colours : of a video in colours, "sequence" or "channels"; trigger : squares in sequence
    """
    numbers = [entry.number for entry in playlist.entries]
    read: Callable[[int], Picture] = playlist.read
    count, lasers = len(playlist), list(playlist.lasers)
    if lasers:
        from display.colours import WAYS, in_channels, with_squares

        if colours not in WAYS:
            raise ValueError(f"colours are shown in {' or '.join(WAYS)}, not {colours!r}")
        if colours == "channels":
            read, numbers = in_channels(read, len(lasers)), numbers[:: len(lasers)]
            count, lasers = len(numbers), []
        elif trigger is not None:
            read = with_squares(read, len(lasers), trigger)
    if planes:
        from display.planes import PLANES, packed_reader

        if lasers:
            raise ValueError("bit planes and lasers in sequence exclude each other")
        if not 1 <= planes <= PLANES:
            raise ValueError(f"a colour frame holds 1 to {PLANES} bit planes, not {planes}")
        read, numbers = packed_reader(read, count, planes), numbers[::planes]
        count = len(numbers)
    ring = Ring(read, count, loop, ahead)
    ring.numbers = numbers
    ring.lasers = lasers
    return ring


class Pulled:
    """A reel over any iterable; a frame is asked for when its time has come."""

    def __init__(
        self, frames: Iterable[Any], picture: Callable[[int, Any], Picture], loop: bool
    ) -> None:
        self.loop = loop
        self._frames, self._picture = frames, picture
        self._list = frames if isinstance(frames, Sequence | np.ndarray) else None
        self.count = 1 if self._list is None else len(self._list)
        self._next = 0
        self._left = iter(frames)

    def seek(self, index: int) -> None:
        """Go on from a place in a list; an iterator cannot."""
        self._next = min(max(index, 0), self.count - 1)

    def take(self, timeout: float | None = 0.0) -> tuple[int, Picture | Fault] | None:
        """The next (place, frame), None at the end."""
        if self._list is not None:
            if self._next >= self.count:
                if not self.loop or not self.count:
                    return None
                self._next = 0
            index = self._next
            self._next += 1
            return index, self._picture(index + 1, self._list[index])
        for again in (False, True):
            if again:
                if not self.loop or not self._next:
                    return None
                self._left, self._next = iter(self._frames), 0
            for frame in self._left:
                self._next += 1
                return self._next - 1, self._picture(self._next, frame)
        return None
