"""Speckle averaged away: the same frame with its points' phases drawn anew, several times.

Light from a diffuse surface is speckle, and one hologram shows one draw of it. A panel that is fast
enough shows several draws while the eye takes one picture; here their intensities are averaged.
What many draws tend to is the incoherent picture, which `rendered_view` gives directly.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh import DEFAULT_METHOD, compute_field
from chrmc.encoding import coding_for
from chrmc.grey_levels import encode
from chrmc.metrics import psnr, ssim
from chrmc.optics.propagation import Patch
from chrmc.optics.resolution import apertures, depth_of_focus
from chrmc.response import GreyResponse
from chrmc.scene.drawn import LOOKS, SEED
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Scene, SceneFrame
from chrmc.store.video import Video
from reconstruct.four_f_system import FourF
from reconstruct.metrics import scale_to

ROOM = 8
"""Pixels around an object that belong to its picture."""


def looks(video: Video, scene: Scene, number: int, count: int) -> Iterator[NDArray[np.uint8]]:
    """Grey levels of a frame: the stored ones, then with its points' phases drawn anew.

    scene : that the video was made of
    count : frames in all, 1 or more; a video that was made with several looks has the first of them
    """
    if count < 1:
        raise ValueError(f"looks must be 1 or more, not {count}")
    stored = looks_of(video)
    first = (number - 1) // stored * stored + 1
    others = [n for n in range(first, first + stored) if n != number and n in video.numbers]
    shown = [number, *others][:count]
    yield from map(video.read, shown)
    if count == len(shown):
        return
    cloud = scene.frame(number).cloud
    response = GreyResponse.from_dict(video.response) if video.response else None
    band = coding_for(video.encoding, video.slm).passband
    for look in range(len(shown), count):
        phase = np.random.default_rng([SEED, number, look]).uniform(0, 2 * np.pi, len(cloud))
        field = compute_field(
            replace(cloud, phase=phase),
            video.slm,
            video.wavelength,
            DEFAULT_METHOD,
            passband=band,
            tolerance=1e-3,
        )
        yield encode(
            field, video.slm, video.encoding, video.scale, response=response, band_limited=True
        )


def looks_of(video: Video) -> int:
    """Draws of its phases that a video shows of each of the scene's frames, one after the other."""
    return LOOKS.of(video.scene.get("looks", 1))


def rendered_view(
    cloud: PointCloud, system: FourF, depth: float, patch: Patch
) -> NDArray[np.float32]:
    """(h, w) intensity of points that do not interfere, seen through the same aperture and focused
    at a depth: what the mean of many looks tends to, up to a factor.

    Every point's picture is that of a rectangular aperture, defocused by its distance from the
    depth; points within a quarter of the depth of focus share one.
    """
    slm, wavelength = system.slm, system.wavelength
    y, x = patch.coordinates()
    out = np.zeros(patch.shape)
    if not len(cloud):
        return out.astype(np.float32)
    step = min(depth_of_focus(slm, wavelength, depth, system.band)) / 4
    slices = np.rint((cloud.positions[:, 2] - depth) / step).astype(np.int64)
    at = (cloud.positions[:, 1::-1] - (y[0], x[0])) / patch.pitch
    first = np.floor(at).astype(np.int64)
    way = at - first
    seen = ((first >= -1) & (first < patch.shape)).all(axis=1)
    for number in np.unique(slices[seen]):
        part = seen & (slices == number)
        z = depth + float(number) * step
        sides = apertures(slm, wavelength, z, system.band)
        rows, columns = (
            _line(side, wavelength, z, depth, n, patch.pitch)
            for side, n in zip(sides, patch.shape, strict=True)
        )
        # Between samples, each beside takes its share; one row and column of room on each side.
        places = np.zeros((patch.shape[0] + 2, patch.shape[1] + 2))
        for dy in (0, 1):
            for dx in (0, 1):
                share = np.abs(1 - dy - way[part, 0]) * np.abs(1 - dx - way[part, 1])
                spot = tuple((first[part] + (1 + dy, 1 + dx)).T)
                np.add.at(places, spot, cloud.intensity[part] * share)
        out += rows @ places[1:-1, 1:-1] @ columns.T
    return out.astype(np.float32)


@dataclass(frozen=True)
class Likened:
    """How like its rendered view an object's picture is, in its own box and a little around.

    psnr (dB), ssim : of intensities, the picture scaled to the view
    """

    name: str
    psnr: float
    ssim: float


def compare_with_view(
    image: NDArray[np.floating], frame: SceneFrame, system: FourF, depth: float
) -> list[Likened]:
    """The objects that are in focus at a depth, each against its rendered view.

    image : (H, W) intensity at the depth, on the SLM's pixels
    """
    found = []
    for name, part, patch in in_focus(frame, system, depth):
        view = rendered_view(frame.cloud, system, depth, patch)
        level = image[part] * scale_to(image[part], view)
        found.append(Likened(name, psnr(level, view), ssim(level, view)))
    return found


def in_focus(
    frame: SceneFrame, system: FourF, depth: float
) -> Iterator[tuple[str, tuple[slice, slice], Patch]]:
    """Of the objects in focus at a depth: name, rows and columns of the box around it, and where
    they are."""
    slm = system.slm
    sharp = max(depth_of_focus(slm, system.wavelength, depth, system.band))
    for obj in (o for o in frame.objects if len(o.cloud)):
        low, high = (f(obj.cloud.positions, axis=0) for f in (np.min, np.max))
        if not low[2] - sharp / 2 <= depth <= high[2] + sharp / 2:
            continue
        part, centre = [], []
        for axis, count in ((1, slm.height), (0, slm.width)):
            ends = np.array([low[axis], high[axis]]) / slm.pixel_pitch + (count - 1) / 2
            first = int(np.clip(np.rint(ends[0]) - ROOM, 0, count - 1))
            last = int(np.clip(np.rint(ends[1]) + ROOM + 1, first + 1, count))
            part.append(slice(first, last))
            centre.append(((first + last - 1) / 2 - (count - 1) / 2) * slm.pixel_pitch)
        shape = (part[0].stop - part[0].start, part[1].stop - part[1].start)
        yield (
            obj.name,
            (part[0], part[1]),
            Patch((centre[0], centre[1]), shape, slm.pixel_pitch),
        )


def rendered_like(
    image: NDArray[np.floating],
    clouds: Sequence[PointCloud],
    systems: Sequence[FourF],
    depth: float,
) -> NDArray[np.float32]:
    """(H, W, lasers) rendered view of the whole panel, by one factor as bright as a picture.

    image : (H, W, lasers) balanced intensities; clouds, systems : of each laser
    """
    slm = systems[0].slm
    patch = Patch((0.0, 0.0), slm.shape, slm.pixel_pitch)
    views = [rendered_view(c, s, depth, patch) for c, s in zip(clouds, systems, strict=True)]
    view = np.stack(views, axis=-1)
    return np.asarray(view * scale_to(view, np.asarray(image)), dtype=np.float32)


def _line(
    side: float, wavelength: float, z: float, depth: float, count: int, pitch: float
) -> NDArray[np.float64]:
    """(count, count) share of a point's light along one axis that each sample gets from each: the
    squared Fourier transform of an aperture with the defocus's quadratic phase."""
    bend = np.pi / wavelength * (1 / depth - 1 / z)
    # Samples of the aperture: fine enough for its phase and for the widest offset.
    need = abs(bend) * side**2 / np.pi + 2 * side * count * pitch / (wavelength * depth)
    q = (np.arange(int(need) + 64) + 0.5) / (int(need) + 64) * side - side / 2
    offsets = np.arange(-count + 1, count) * pitch
    turn = np.exp(
        1j * (bend * q**2)[None, :] - 2j * np.pi / (wavelength * depth) * np.outer(offsets, q)
    )
    line = np.abs(turn.mean(axis=1)) ** 2
    line *= side * pitch / (wavelength * depth)
    index = np.arange(count)
    return line[index[:, None] - index[None, :] + count - 1]
