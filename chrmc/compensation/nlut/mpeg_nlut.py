"""MPEG-NLUT: groups of one reference and three general frames, block vectors in x and y.

MPEG-based NLUT (reference 29 of the CH-RMC paper): see `chrmc.compensation.nlut.groups` for how a
general frame is made from its group's reference.
"""

from collections.abc import Iterator
from typing import Any

from chrmc.cgh import Method
from chrmc.compensation.frame import VideoFrame
from chrmc.compensation.nlut.groups import Search, group_frames
from chrmc.encoding import Coding
from chrmc.scene.scene import Scene
from chrmc.slm import SLM


def frames(
    scene: Scene,
    slm: SLM,
    wavelength: float,
    cgh: str | Method,
    numbers: range,
    coding: Coding,
    *,
    group: int = 4,
    block: int = 16,
    search: int = 16,
    measure: str = "sad",
    matching: str | None = None,
    **options: Any,
) -> Iterator[VideoFrame]:
    """Frames by block motion compensation from each group's reference, with any CGH method.

    group : frames in a group, the reference included
    block : side of a block of the reference, scene pixels
    search : longest vector per axis, scene pixels (from the reference, not from frame to frame)
    measure : "sad" or "mse" of intensities over the block, whose least value decides
    matching : as in `chrmc.compensation.nlut.tr_nlut`
    options : for the CGH method

    The publications give group sizes, but no block size, search range or criterion: 16 pixels is
    MPEG's macroblock, the search covers three frames of the built-in car, full search by the sum
    of absolute differences. Points of known identity: the median displacement of a block's.
    With "exact" the field is that of `none` within 1e-5 with rt or nlut, 1e-2 with wrp, of the
    light that the points have one by one: what cancels, or is gone, leaves its rounding. A field
    is kept for each block that moves. `frame.shown` are the points that the field is the sum of.
    """
    how = Search(group, block, search, 0, measure)
    return group_frames(scene, slm, wavelength, cgh, numbers, coding, how, matching, options)
