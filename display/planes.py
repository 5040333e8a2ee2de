"""Binary frames as bit planes of colour frames, as controllers of micromirror panels take them.

A video frame of 24 bits carries up to 24 binary patterns, which the controller shows one after the
other while the frame lasts: the eight bits of one colour from the lowest up, then those of the
next. Many begin with green; see your controller's guide.
"""

import hashlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from display.playlist import Picture

PLANES = 24
ORDER = "grb"


def pack_planes(frames: Sequence[NDArray[np.uint8]], order: str = ORDER) -> NDArray[np.uint8]:
    """(rows, columns, 3) uint8 that holds up to 24 binary frames; planes left over are dark.

    frames : (rows, columns) uint8, each dark (0) or bright (255) everywhere
    order : the colours in the order that the controller shows them, such as "grb"

    Raises ValueError for too many frames, grey ones, or an order that is none.
    """
    if sorted(order) != ["b", "g", "r"]:
        raise ValueError(f"an order of colours is rgb, grb, …, not {order!r}")
    if not 1 <= len(frames) <= PLANES:
        raise ValueError(f"a colour frame holds 1 to {PLANES} binary frames, not {len(frames)}")
    packed = np.zeros((*frames[0].shape, 3), dtype=np.uint8)
    for plane, frame in enumerate(frames):
        if frame.dtype != np.uint8 or not np.isin(np.unique(frame), (0, 255)).all():
            raise ValueError(
                "bit planes need frames that are 0 or 255 everywhere: encode them for a binary "
                "panel (error-diffusion, lee)"
            )
        colour = "rgb".index(order[plane // 8])
        packed[..., colour] |= (frame >> 7) << np.uint8(plane % 8)
    return packed


def packed_reader(
    read: Callable[[int], Picture], count: int, planes: int, order: str = ORDER
) -> Callable[[int], Picture]:
    """Reads every `planes` frames of a list of `count` as one picture, named after the first."""

    def read_group(index: int) -> Picture:
        parts = [read(n) for n in range(index * planes, min((index + 1) * planes, count))]
        levels = pack_planes([part.levels for part in parts], order)
        name = f"{parts[0].file} … {parts[-1].file}" if len(parts) > 1 else parts[0].file
        return Picture(parts[0].number, name, hashlib.sha256(levels.data).hexdigest(), levels)

    return read_group


def packed_frames(
    frames: Iterable[NDArray[np.uint8]], planes: int, order: str = ORDER
) -> Iterator[NDArray[np.uint8]]:
    """Every `planes` frames as one."""
    left = iter(frames)
    while group := list(islice(left, planes)):
        yield pack_planes(group, order)
