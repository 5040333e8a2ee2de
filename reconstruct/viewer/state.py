"""What a viewer looks at: frame, depth, filter, look, zoom, and how to get back to it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from chrmc.encoding import coding_for
from chrmc.store.colour import ColourVideo
from chrmc.store.video import Video
from reconstruct.bench import Filter
from reconstruct.sequence import targets_of
from reconstruct.verdict import Target
from reconstruct.viewer.compare import MODES
from reconstruct.viewer.history import History
from reconstruct.viewer.lasers import Source, leading
from reconstruct.viewer.measure import Line, Region
from reconstruct.viewer.shade import Look
from reconstruct.viewer.sight import Sight
from reconstruct.viewer.sources import check_pair
from reconstruct.viewer.view import View

MARGIN = 8e-3
"""Metres that the depth slider reaches before the nearest and behind the farthest object."""
RATES = (0.5, 60.0)
"""Frames a second that playing can be set to."""
NEAREST = 1e-6
"""Smallest depth that can be looked at, metres."""


@dataclass(frozen=True)
class Snapshot:
    """A view that can be returned to."""

    number: int
    depth: float
    filter: Filter
    look: Look
    sight: tuple[float | None, float, float]


class ViewerState:
    """What one video, or two that are compared, are looked at with.

    videos : one or two, of the same panel; of one in colours, that of its leading laser
    sources : what they were opened as

    follow : name of the object whose depth every frame is shown at, or None
    look : how pictures become colours
    active : which video's hologram and Fourier plane are shown
    mode : how two videos are shown, one of compare.MODES; wipe : where the wipe is, 0 … 1
    view : zoom and pan of the reconstructions
    screen : (rows, columns) screen pixels that the panel's picture covers
    sight : what of the hologram is shown, and how large; None shows it pixel by pixel
    line, region : marks on the reconstructions; videos are compared within the region
    playing, rate : frames follow each other, so many a second
    """

    def __init__(self, videos: Source | Sequence[Source]) -> None:
        self.sources: list[Source] = (
            [videos] if isinstance(videos, Video | ColourVideo) else list(videos)
        )
        self.videos = [leading(source) for source in self.sources]
        for source in self.sources:
            if not source.numbers:
                raise ValueError(f"{source.folder} has no frames yet: run `chrmc generate` first")
        self.numbers = check_pair(*self.sources) if self.comparing else self.sources[0].numbers
        self.look = Look()
        self.follow: str | None = None
        self.active = 0
        self.mode = MODES[0]
        self.wipe = 0.5
        self.view = View(self.video.slm.width, self.video.slm.height)
        self.screen = self.video.slm.shape
        self.sight: Sight | None = None
        self.line: Line | None = None
        self.region: Region | None = None
        self.playing = False
        self.rate = 8.0
        self._filter = Filter()
        self._index = 0
        self.depth_range = self._find_range()
        self._depth = self._first_depth()
        self._history = History(self.snapshot())

    # --- what can be changed ---

    @property
    def video(self) -> Video:
        """The first video."""
        return self.videos[0]

    @property
    def comparing(self) -> bool:
        """Whether there are two."""
        return len(self.videos) == 2

    @property
    def number(self) -> int:
        """The frame wanted."""
        return self.numbers[self._index]

    @number.setter
    def number(self, number: int) -> None:
        if number not in self.numbers:
            for source in self.sources:
                source.entry(number)  # says which there are
        self._turn_to(self.numbers.index(number))

    @property
    def index(self) -> int:
        """Place of the frame in `numbers`."""
        return self._index

    @index.setter
    def index(self, index: int) -> None:
        self._turn_to(int(np.clip(index, 0, len(self.numbers) - 1)))

    def step(self, count: int = 1) -> None:
        """So many frames on, round and round."""
        self._turn_to((self._index + count) % len(self.numbers))

    def _turn_to(self, index: int) -> None:
        self._index = index
        for target in self.objects():
            if target.name == self.follow:
                self.depth = float(target.position[2])

    @property
    def depth(self) -> float:
        """The depth wanted, metres; one beyond `depth_range` widens it."""
        return self._depth

    @depth.setter
    def depth(self, depth: float) -> None:
        if not np.isfinite(depth):
            raise ValueError(f"depth must be metres from the hologram, not {depth}")
        self._depth = max(float(depth), NEAREST)
        low, high = self.depth_range
        if not low <= self._depth <= high:
            self.depth_range = min(low, self._depth), max(high, self._depth)

    @property
    def filter(self) -> Filter:
        """What stands in the Fourier plane; assign another to change it."""
        return self._filter

    @filter.setter
    def filter(self, chosen: Filter) -> None:
        self._filter = chosen

    def change_filter(self, **changes: Any) -> None:
        """Change single parts of the filter."""
        self.filter = replace(self._filter, **changes)

    def start(self, number: int | None, depth: float | None, follow: str | None) -> None:
        """How the window opens: at this frame or the first, at this depth or its first object's."""
        names = {o["name"] for f in self.video.frames for o in f.get("objects", [])}
        if follow is not None and follow not in names:
            there = ", ".join(sorted(names)) or "none"
            raise ValueError(f"no object {follow!r}; the video has {there}")
        if number is not None:
            self.number = number
        self.depth = self._first_depth()
        self.follow = follow
        self._turn_to(self._index)
        if depth is not None:
            self.follow = None
            if not names:  # nothing says where to look but this
                self.depth_range = depth / 2, 2 * depth
            self.depth = depth
        self._history = History(self.snapshot())

    def _first_depth(self) -> float:
        objects = self.objects()
        return float(objects[0].position[2]) if objects else sum(self.depth_range) / 2

    def _find_range(self) -> tuple[float, float]:
        depths = [
            corner[2]
            for video in self.videos
            for frame in video.frames
            for o in frame.get("objects", [])
            if o.get("position") is not None
            for corner in (o.get("box") or [o["position"]])
        ]
        if not depths:
            return 0.05, 0.5
        low, high = min(depths) - MARGIN, max(depths) + MARGIN
        return max(low, 0.2 * min(depths)), high

    # --- undo of the view ---

    def snapshot(self) -> Snapshot:
        """What is looked at, to return to."""
        sight = (self.view.zoom, self.view.x, self.view.y)
        return Snapshot(self.number, self._depth, self._filter, replace(self.look), sight)

    def undo(self) -> bool:
        """Back to the view before; False when there is none."""
        self._history.note(self.snapshot())
        return self._restore(self._history.undo())

    def redo(self) -> bool:
        """Forward again."""
        return self._restore(self._history.redo())

    def _restore(self, held: Snapshot | None) -> bool:
        if held is None:
            return False
        follow, self.follow = self.follow, None
        self.number = held.number
        self.depth = held.depth
        self.filter = held.filter
        self.look = replace(held.look)
        self.view.zoom, self.view.x, self.view.y = held.sight
        self.follow = follow
        return True

    # --- what is there ---

    @property
    def front(self) -> int:
        """Which video is looked at, when it is about one."""
        return MODES.index(self.mode) - MODES.index("A") if self.mode in ("A", "B") else self.active

    @property
    def carries(self) -> bool:
        """Whether the active video's encoding needs one sideband."""
        video = self.videos[self.active]
        return coding_for(video.encoding, video.slm).carrier > 0

    def objects(self) -> list[Target]:
        """The frame's visible objects, as the scene says."""
        return targets_of(self.video, self.number)

    def position_of(self, row: float, column: float) -> tuple[float, float]:
        """(x, y) metres of a pixel."""
        slm = self.video.slm
        return (
            (column - (slm.width - 1) / 2) * slm.pixel_pitch,
            (row - (slm.height - 1) / 2) * slm.pixel_pitch,
        )

    def suggested_name(self) -> str:
        """File name of a saved picture, without suffix."""
        return f"frame_{self.number:04d}_at_{self.depth * 1e3:.2f}mm"
