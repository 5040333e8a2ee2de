"""Videos in colours on one panel: a laser after the other, or one in each colour channel.

In sequence every frame of the video takes as many flips as it has lasers, and something must switch
the lasers in step: the file in each `Flip` (`colour_of`), a byte per laser on a serial line, or
light itself, a square per laser that is bright while its frame is on (`with_squares`).
"""

import hashlib
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from chrmc.store.colour import ColourVideo
from display.log import Flip
from display.playlist import Entry, Picture, Playlist

if TYPE_CHECKING:
    from display.gl import Trigger

WAYS = ("sequence", "channels")
Reader = Callable[[int], Picture]


def colour_playlist(
    video: ColourVideo,
    order: Sequence[float] | None = None,
    frames: tuple[int, int] | None = None,
) -> Playlist:
    """Frame 1 of each laser, then frame 2, …

    order : wavelengths (metres), each of the video's once; default the video's own order
    """
    lasers = list(video.wavelengths)
    wanted = lasers if order is None else list(order)
    places = [min(range(len(lasers)), key=lambda k, w=w: abs(lasers[k] - w)) for w in wanted]  # type: ignore[misc]
    near = all(abs(lasers[k] - w) < 1e-10 for k, w in zip(places, wanted, strict=True))
    if not near or sorted(places) != list(range(len(lasers))):
        raise ValueError(
            f"an order names each laser once: {_said(lasers)} nm, not {_said(wanted)} nm"
        )
    first, last = frames or (0, max(video.numbers, default=0))
    entries = []
    for number in (n for n in video.numbers if first <= n <= last):
        for k in places:
            channel = video.channels[k]
            path = channel.path(number)
            name = f"{channel.folder.name}/{path.name}"
            entries.append(Entry(number, path, str(channel.entry(number)["sha256"]), name))
    if not entries:
        raise ValueError(f"{video.folder} has no such frames in all its colours: nothing to play")
    names = [video.channels[k].folder.name for k in places]
    return Playlist(video.slm, entries, video.folder.name, lasers=names)


def _said(wavelengths: Sequence[float]) -> str:
    return ", ".join(f"{w * 1e9:g}" for w in wavelengths)


def with_squares(read: Reader, lasers: int, trigger: "Trigger") -> Reader:
    """Frames in sequence with a square for each laser, in a row beside the trigger's own: that of
    the laser whose frame it is is bright, the others are dark."""

    def read_marked(index: int) -> Picture:
        picture = read(index)
        levels = picture.levels.copy()
        x0, y0, x1, y1 = trigger.box((levels.shape[0], levels.shape[1]))
        step = (x1 - x0) * (1 if trigger.corner.endswith("left") else -1)
        if abs(step) * (lasers + 1) > levels.shape[1]:
            raise ValueError(
                f"{lasers} squares of {abs(step)} pixels are wider than the panel: make them "
                "smaller"
            )
        for k in range(lasers):
            lit = 255 if k == index % lasers else 0
            levels[y0:y1, x0 + (k + 1) * step : x1 + (k + 1) * step] = lit
        return Picture(picture.number, picture.file, picture.sha256, levels)

    return read_marked


def in_channels(read: Reader, lasers: int) -> Reader:
    """The frames of up to three lasers as one picture: red, green and blue in the list's order."""
    if lasers > 3:
        raise ValueError(f"a picture has three channels, too few for {lasers} lasers")

    def read_together(index: int) -> Picture:
        parts = [read(index * lasers + k) for k in range(lasers)]
        levels: NDArray[np.uint8] = np.zeros((*parts[0].levels.shape, 3), dtype=np.uint8)
        for k, part in enumerate(parts):
            levels[..., k] = part.levels
        name = " + ".join(part.file for part in parts)
        return Picture(parts[0].number, name, hashlib.sha256(levels.data).hexdigest(), levels)

    return read_together


def colour_of(flip: Flip) -> str:
    """Which laser's frame a flip shows, such as "532nm"; "" of a video in one colour."""
    laser, slash, _ = flip.file.partition("/")
    return laser if slash and laser.endswith("nm") and "+" not in flip.file else ""


def laser_bytes(lasers: Sequence[str]) -> Callable[[Flip], bytes]:
    """For a mark: byte 1 at a frame of the first laser, 2 of the second, …, 0 where there is none.

    lasers : as `colour_of` calls them
    """
    places = {name: bytes([k + 1]) for k, name in enumerate(lasers)}
    return lambda flip: places.get(colour_of(flip), b"\0")


def sequence_rate(fps: float | None, lasers: int, refresh: float) -> float | None:
    """Flips with a new picture per second for `fps` frames in colours; ValueError where the panel
    is too slow for them.

    refresh : of the panel, Hz
    """
    if fps is None or lasers < 2:
        return fps
    if fps * lasers > 1.01 * refresh:
        raise ValueError(
            f"{fps:g} frames a second of {lasers} colours need {fps * lasers:g} pictures a second, "
            f"and this panel refreshes at {refresh:.4g} Hz: at most {refresh / lasers:.4g} frames"
        )
    return fps * lasers
