"""Whole videos: every frame at one depth or following an object, composites, the panorama."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import ceil, hypot

import numpy as np
from numpy.typing import NDArray

from chrmc.optics.propagation import Patch, Propagator
from chrmc.response import GreyResponse
from chrmc.store.video import Video
from reconstruct.bench import Bench
from reconstruct.four_f_system import FourF, check_distance, intensity
from reconstruct.images import exposure
from reconstruct.verdict import Target

DepthOf = Callable[[int], float]


def system_of(video: Video, bench: Bench | None = None) -> FourF:
    """The 4-f system that a stored video was made for."""
    return FourF(
        video.slm,
        video.wavelength,
        video.encoding,
        bench,
        GreyResponse.from_dict(video.response),
        video.scale,
    )


def targets_of(video: Video, number: int) -> list[Target]:
    """A frame's visible objects."""
    found = [Target.of_record(o) for o in video.entry(number).get("objects", [])]
    return [t for t in found if t is not None]


def at_depth(depth: float) -> DepthOf:
    """Every frame at one depth."""
    check_distance(depth)
    return lambda number: depth


def following(video: Video, name: str) -> DepthOf:
    """Every frame at the depth of an object; where it is out of sight, the last it was seen at.

    Raises ValueError when no frame has such an object.
    """
    depths: dict[int, float] = {}
    names: set[str] = set()
    for number in video.numbers:
        for target in targets_of(video, number):
            names.add(target.name)
            if target.name == name:
                depths[number] = float(target.position[2])
    if not depths:
        raise ValueError(f"no object {name!r}; the video has {', '.join(sorted(names)) or 'none'}")
    seen = sorted(depths)

    def depth_of(number: int) -> float:
        before = [n for n in seen if n <= number]
        return depths[before[-1] if before else seen[0]]

    return depth_of


@dataclass(frozen=True, eq=False)
class Shown:
    """One reconstructed frame: its number, depth (metres; NaN for a composite) and (h, w)
    intensities."""

    number: int
    depth: float
    image: NDArray[np.float32]


def reconstruct_all(
    video: Video,
    depth_of: DepthOf,
    numbers: Sequence[int] | None = None,
    system: FourF | None = None,
) -> Iterator[Shown]:
    """The frames, one after the other, each at its depth."""
    system = system_of(video) if system is None else system
    for number in video.numbers if numbers is None else numbers:
        depth = depth_of(number)
        yield Shown(number, depth, system.image(video.read(number), depth))


def composite(
    video: Video,
    number: int,
    system: FourF,
    margin: float = 0.2e-3,
    levels: NDArray[np.uint8] | None = None,
) -> Shown:
    """A frame with every object in focus at once: each object's surroundings at its own depth.

    margin : of the surroundings, metres. Where those of two objects meet, the brighter shows.
    levels : (H, W) grey levels to show in place of the stored ones
    """
    slm = video.slm
    field = system.field(video.read(number) if levels is None else levels)
    image = np.zeros(slm.shape, dtype=np.float32)
    for target in targets_of(video, number):
        slices = _pixels(target, slm.shape, slm.pixel_pitch, margin)
        if slices is None:
            continue
        rows, columns = slices
        shape = (rows.stop - rows.start, columns.stop - columns.start)
        centre = tuple(
            ((s.start + s.stop - 1) / 2 - (n - 1) / 2) * slm.pixel_pitch
            for s, n in zip(slices, slm.shape, strict=True)
        )
        depth = float(target.position[2])
        patch = Patch((centre[0], centre[1]), shape, slm.pixel_pitch)
        there = Propagator(
            slm.shape, slm.pixel_pitch, video.wavelength, depth, patch, system.band, keep=0
        )
        np.maximum(image[slices], intensity(there(field, -depth)), out=image[slices])
    return Shown(number, float("nan"), image)


def _pixels(
    target: Target, shape: tuple[int, int], pitch: float, margin: float
) -> tuple[slice, slice] | None:
    """Rows and columns of a target's surroundings, or None beside the SLM."""
    found = []
    for axis, count in ((1, shape[0]), (0, shape[1])):
        ends = (target.low[axis] - margin, target.high[axis] + margin)
        low, high = (e / pitch + (count - 1) / 2 for e in ends)
        first, last = max(int(np.floor(low)), 0), min(int(np.ceil(high)) + 1, count)
        if last - first < 2:
            return None
        found.append(slice(first, last))
    return found[0], found[1]


def spread_frames(video: Video, numbers: Sequence[int] | None = None) -> list[int]:
    """Frames far enough apart that no moving object overlaps itself: for the panorama."""
    chosen: list[int] = []
    last: dict[str, Target] = {}
    for number in video.numbers if numbers is None else numbers:
        targets = {t.name: t for t in targets_of(video, number)}
        moved = [
            hypot(*(t.position - last[n].position)[:2]) >= 1.08 * (t.high - t.low)[:2].max()
            for n, t in targets.items()
            if n in last and np.any(t.position != last[n].position)
        ]
        if not chosen or (moved and all(moved)):
            chosen.append(number)
            last = targets
    return chosen


def panorama(video: Video, numbers: Sequence[int] | None = None) -> Shown:
    """Composites of several frames in one exposure: where everything was, all in focus.

    numbers : default frames in which moving objects do not overlap themselves
    """
    system = system_of(video)
    image = np.zeros(video.slm.shape, dtype=np.float32)
    chosen = spread_frames(video) if numbers is None else list(numbers)
    if not chosen:
        raise ValueError(f"{video.folder} has no frames to show")
    for number in chosen:
        np.maximum(image, composite(video, number, system).image, out=image)
    return Shown(chosen[0], float("nan"), image)


def region_of(video: Video, margin: float = 0.6e-3) -> tuple[slice, slice]:
    """Rows and columns that hold all objects of all frames; the whole SLM without any."""
    boxes = [t for n in video.numbers for t in targets_of(video, n)]
    slm = video.slm
    everything = (slice(0, slm.height), slice(0, slm.width))
    if not boxes:
        return everything
    whole = Target(
        "all",
        boxes[0].position,
        np.stack([t.low for t in boxes]).min(axis=0),
        np.stack([t.high for t in boxes]).max(axis=0),
    )
    return _pixels(whole, slm.shape, slm.pixel_pitch, margin) or everything


def shrink(image: NDArray[np.floating], width: int) -> NDArray[np.float32]:
    """Means over squares of pixels, at most `width` columns."""
    factor = max(1, ceil(image.shape[1] / width))
    rows, columns = (n // factor * factor for n in image.shape)
    if factor == 1 or not rows or not columns:
        return np.asarray(image, dtype=np.float32)
    blocks = np.asarray(image[:rows, :columns], dtype=np.float32)
    blocks = blocks.reshape(rows // factor, factor, columns // factor, factor)
    return np.asarray(blocks.mean(axis=(1, 3)), dtype=np.float32)


def common_scale(images: Sequence[NDArray[np.floating]]) -> float:
    """One intensity to show as white in all images: the median of their exposures."""
    lit = [e for e in (exposure(i) for i in images) if e > 0]
    return float(np.median(lit)) if lit else 0.0
