"""The viewer's model: a video, a frame, a depth, a filter, and the pictures that follow.

No GUI here. Pictures are made when asked for and kept until what they depend on changes:
grey levels → Fourier plane → field (filter) → spectrum → coarse or full picture (depth).
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from chrmc.optics.propagation import Patch, transfer_function
from chrmc.response import GreyResponse
from chrmc.store import Video
from chrmc.threads import workers
from reconstruct import metrics
from reconstruct.bench import Bench, Filter
from reconstruct.focus import Focus, find_focus
from reconstruct.focus_metrics import normalised_variance
from reconstruct.four_f_system import FourF, intensity
from reconstruct.images import exposure, write_colour, write_image
from reconstruct.stack import focal_stack
from reconstruct.verdict import Target
from reconstruct.viewer.shade import Look, shade

MARGIN = 8e-3
"""Metres that the depth slider reaches before the nearest and behind the farthest object."""
REGION = 0.45e-3
"""Half the side of the region that a click focuses on, metres."""


class Picture(NamedTuple):
    """field : (H, W) complex64 at `depth`; white : intensity to show as white; coarse : made
    without padding, so that what leaves the panel on one side comes in on the other."""

    field: NDArray[np.complex64]
    depth: float
    white: float
    coarse: bool


@dataclass(frozen=True)
class Thing:
    """An object of the frame: its name, and where the scene says it is."""

    name: str
    target: Target

    @property
    def depth(self) -> float:
        """metres"""
        return float(self.target.position[2])


class ViewerModel:
    """State of one viewer.

    video : the stored video
    filter : what stands in the Fourier plane; assign another to change it
    look : how pictures become colours
    follow : name of the object whose depth every frame is shown at, or None
    """

    def __init__(self, video: Video) -> None:
        if not video.frames:
            raise ValueError(f"{video.folder} has no frames yet: run `chrmc generate` first")
        self.video = video
        self.numbers = video.numbers
        self.look = Look()
        self.follow: str | None = None
        self.last_focus: Focus | None = None
        self._filter = Filter()
        self._system = self._make_system()
        self._index = 0
        self._cache: dict[str, tuple[Any, Any]] = {}
        self.depth_range = self._find_range()
        things = self.things()
        first = things[0].depth if things else sum(self.depth_range) / 2
        self._depth = float(first)

    # --- what can be changed ---

    @property
    def number(self) -> int:
        """The frame shown."""
        return self.numbers[self._index]

    @number.setter
    def number(self, number: int) -> None:
        if number not in self.numbers:
            self.video.entry(number)  # says which there are
        self._index = self.numbers.index(number)
        self._follow()

    @property
    def index(self) -> int:
        """Place of the frame in `numbers`."""
        return self._index

    @index.setter
    def index(self, index: int) -> None:
        self._index = int(np.clip(index, 0, len(self.numbers) - 1))
        self._follow()

    def step(self, count: int = 1) -> None:
        """So many frames on, round and round."""
        self._index = (self._index + count) % len(self.numbers)
        self._follow()

    @property
    def depth(self) -> float:
        """The depth shown, metres; kept within `depth_range`."""
        return self._depth

    @depth.setter
    def depth(self, depth: float) -> None:
        self._depth = float(np.clip(depth, *self.depth_range))

    @property
    def filter(self) -> Filter:
        """What stands in the Fourier plane."""
        return self._filter

    @filter.setter
    def filter(self, chosen: Filter) -> None:
        self._filter = chosen
        self._system = self._make_system()

    def change_filter(self, **changes: Any) -> None:
        """Change single parts of the filter."""
        self.filter = replace(self._filter, **changes)

    def _make_system(self) -> FourF:
        v = self.video
        return FourF(
            v.slm,
            v.wavelength,
            v.encoding,
            Bench(filter=self._filter),
            GreyResponse.from_dict(v.response),
            v.scale,
        )

    def _follow(self) -> None:
        for thing in self.things():
            if thing.name == self.follow:
                self.depth = thing.depth

    def _find_range(self) -> tuple[float, float]:
        depths = [
            corner[2]
            for frame in self.video.frames
            for o in frame.get("objects", [])
            if o.get("position") is not None
            for corner in (o.get("box") or [o["position"]])
        ]
        if not depths:
            return 0.05, 0.5
        low, high = min(depths) - MARGIN, max(depths) + MARGIN
        return max(low, 0.2 * min(depths)), high

    # --- what is there to see ---

    @property
    def system(self) -> FourF:
        """The 4-f system as it stands."""
        return self._system

    def things(self) -> list[Thing]:
        """The frame's visible objects."""
        found = [Target.of_record(o) for o in self.video.entry(self.number)["objects"]]
        return [Thing(t.name, t) for t in found if t is not None]

    def _kept(self, name: str, key: Any, make: Any) -> Any:
        """The value of a name, made anew when its key differs from the last."""
        held = self._cache.get(name)
        if held is None or held[0] != key:
            held = (key, make())
            self._cache[name] = held
        return held[1]

    @property
    def frame_key(self) -> Any:
        """Changes when the hologram does."""
        return self.number

    @property
    def field_key(self) -> Any:
        """Changes when the decoded field does."""
        return self.number, id(self._system)

    def hologram(self) -> NDArray[np.uint8]:
        """(H, W) grey levels."""
        made: NDArray[np.uint8] = self._kept(
            "hologram", self.frame_key, lambda: self.video.read(self.number)
        )
        return made

    def fourier_plane(self) -> NDArray[np.complex64]:
        """(H, W) amplitude before the filter, FFT order."""
        made: NDArray[np.complex64] = self._kept(
            "fourier", self.frame_key, lambda: self._system.fourier_plane(self.hologram())
        )
        return made

    def field(self) -> NDArray[np.complex64]:
        """(H, W) decoded field at depth 0."""
        made: NDArray[np.complex64] = self._kept(
            "field", self.field_key, lambda: self._system.field(self.hologram())
        )
        return made

    def picture(self, coarse: bool = False) -> Picture:
        """The reconstruction at the depth; a coarse one in a third of the time."""
        key = (self.field_key, self._depth)
        full = self._cache.get("full")
        if not coarse or (full is not None and full[0] == key):
            made: Picture = self._kept("full", key, self._full)
            return made
        quick: Picture = self._kept("coarse", key, self._coarse)
        return quick

    def _full(self) -> Picture:
        field = self._system.at(self.field(), self._depth)
        return Picture(field, self._depth, exposure(intensity(field)), False)

    def _coarse(self) -> Picture:
        slm = self.video.slm
        spectrum = self._kept(
            "spectrum",
            self.field_key,
            lambda: scipy.fft.fft2(self.field(), workers=workers()),
        )
        there = transfer_function(slm.shape, slm.pixel_pitch, self.video.wavelength, -self._depth)
        there *= spectrum
        field: NDArray[np.complex64] = scipy.fft.ifft2(there, workers=workers(), overwrite_x=True)
        light = field[::2, ::2]
        return Picture(field, self._depth, exposure(intensity(light)), True)

    # --- what can be asked ---

    def position_of(self, row: float, column: float) -> tuple[float, float]:
        """(x, y) metres of a pixel."""
        slm = self.video.slm
        return (
            (column - (slm.width - 1) / 2) * slm.pixel_pitch,
            (row - (slm.height - 1) / 2) * slm.pixel_pitch,
        )

    def autofocus(self, row: int, column: int) -> Focus:
        """Focus on what is seen around a pixel: the whole depth range, then finely where it is
        sharpest. Sets the depth when something comes into focus there."""
        slm = self.video.slm
        x, y = self.position_of(row, column)
        p = slm.pixel_pitch
        side = max(4, round(2 * self.video.pixel_pitch / p))
        tiles = max(2, int(np.ceil(2 * REGION / (side * p))))
        patch = Patch((y, x), (tiles * side, tiles * side), p)
        low, high = self.depth_range
        coarse = np.linspace(low, high, int(np.clip((high - low) / 0.25e-3, 21, 160)))
        field, band = self.field(), self._system.band
        wide = find_focus(focal_stack(field, slm, self.video.wavelength, coarse, patch, band), side)
        best = float(coarse[int(np.argmax(wide.curve))])
        near = np.linspace(max(best - 3e-3, low), min(best + 3e-3, high), 41)
        found = find_focus(focal_stack(field, slm, self.video.wavelength, near, patch, band), side)
        # The curve over the whole range is the one worth looking at.
        found = replace(found, depths=wide.depths, curve=wide.curve)
        self.last_focus = found
        if found.focused:
            self.depth = found.depth
        return found

    def figures(self) -> dict[str, float]:
        """What the picture at the depth measures, per name.

        sharpness : normalised variance of the whole picture
        contrast, speckle : of the object nearest in depth, against the rest of its surroundings
        efficiency, blocked : shares of the laser's light in the image and on the filter
        """
        picture = self.picture()
        light = intensity(picture.field)
        values = {"sharpness": normalised_variance(light)}
        things = self.things()
        if things:
            thing = min(things, key=lambda t: abs(t.depth - picture.depth))
            p, shape = self.video.slm.pixel_pitch, light.shape
            low, high = (
                np.rint(c[1::-1] / p + (np.array(shape) - 1) / 2).astype(int)
                for c in (thing.target.low, thing.target.high)
            )
            edge = max(4, round(4 * self.video.pixel_pitch / p))
            first = np.clip(low - edge, 0, np.array(shape) - 1)
            last = np.clip(high + edge + 1, 1, np.array(shape))
            part = light[first[0] : last[0], first[1] : last[1]]
            lit = np.zeros(part.shape, dtype=bool)
            inner = np.maximum(low - first, 0)
            outer = np.maximum(high + 1 - first, 0)
            lit[inner[0] : outer[0], inner[1] : outer[1]] = True
            if lit.any() and not lit.all():
                values["contrast"] = metrics.contrast(part, lit, ~lit)
                values["speckle"] = metrics.speckle_contrast(part, lit)
        energy = self._kept("energy", self.field_key, lambda: self._system.energy(self.hologram()))
        values["efficiency"] = energy.efficiency
        values["blocked"] = energy.blocked_filter / energy.incident
        return values

    def colours(self) -> NDArray[np.uint8]:
        """(H, W, 3) the full picture as the look shows it."""
        picture = self.picture()
        return shade(picture.field, picture.white, self.look)

    def save(self, path: str | Path) -> Path:
        """Write the full picture: .exr intensities, .png as it looks."""
        path = Path(path)
        if path.suffix.lower() == ".exr":
            picture = self.picture()
            note = {"frame": self.number, "depth": picture.depth}
            write_image(path, intensity(picture.field), note)
        else:
            write_colour(path, self.colours())
        return path

    def suggested_name(self) -> str:
        """File name of a saved picture, without suffix."""
        return f"frame_{self.number:04d}_at_{self.depth * 1e3:.2f}mm"
