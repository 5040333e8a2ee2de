"""3DMC-NLUT: groups of one reference and seven general frames, block vectors in x, y and z.

Three-directional motion compensation-based NLUT (reference 30 of the CH-RMC paper): after the x
and y vector of a block, its z vector is found from depth-sliced images, and the block's hologram
is moved in depth by the thin-lens property of fringe patterns,
PFP(z2) = PFP(z1)·exp[(ik/2)(x² + y²)(1/z2 − 1/z1)].
See `chrmc.compensation.nlut.groups` for the rest.
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
    group: int = 8,
    block: int = 16,
    search: int = 40,
    search_planes: int = 16,
    measure: str = "sad",
    matching: str | None = None,
    **options: Any,
) -> Iterator[VideoFrame]:
    """Frames by block motion compensation in three directions, with any CGH method.

    group, block, search, measure, matching, options : as in `mpeg_nlut`; the search
        covers seven frames of the built-in car
    search_planes : longest vector in depth, planes; of equally good ones the shortest

    A lens acts on a whole block about the axis through its centroid. `frame.shown` follows it
    point by point (image distance and magnification), so the field is the sum over `shown` within
    what the lens does not do: path beyond the paraxial one and the footprint's edge, which stays
    where it was: up to 1e-3 over a group on the built-in scene, full panel, and as far from `none`
    with "exact".
    """
    how = Search(group, block, search, search_planes, measure)
    return group_frames(scene, slm, wavelength, cgh, numbers, coding, how, matching, options)
