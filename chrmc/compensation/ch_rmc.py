"""CH-RMC, curved-hologram rotational-motion compensation, on one of two surfaces.

surface "paper": the published method, a cylinder around the centre of the object's arc, over any
CGH method. surface "object": a sphere around the object itself, where the idea is exact.
"""

from collections.abc import Iterator
from importlib import import_module
from typing import Any

from chrmc.cgh import Method
from chrmc.compensation.frame import VideoFrame
from chrmc.encoding import Coding
from chrmc.options import check_options
from chrmc.scene.scene import Scene
from chrmc.slm import SLM

SURFACES = {
    "object": "chrmc.compensation.ch_rmc_object.video",
    "paper": "chrmc.compensation.ch_rmc_paper.paper",
}


def frames(
    scene: Scene,
    slm: SLM,
    wavelength: float,
    cgh: str | Method,
    numbers: range,
    coding: Coding,
    *,
    surface: str = "object",
    **options: Any,
) -> Iterator[VideoFrame]:
    """Frames by CH-RMC on the named surface; options are that surface's own."""
    if surface not in SURFACES:
        raise ValueError(f"unknown surface {surface!r}: choose one of {', '.join(SURFACES)}")
    module = import_module(SURFACES[surface])
    check_options(f"ch-rmc on the {surface} surface", module.frames, options)
    made: Iterator[VideoFrame] = module.frames(
        scene, slm, wavelength, cgh, numbers, coding, **options
    )
    return made
