"""What a frame cost and how wrong it is; it travels with the frame into the manifest."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any


@dataclass
class FrameRecord:
    """One frame's account. None means: not measured.

    number : frame, from 1
    key : the whole frame was computed afresh
    points_computed : points whose fringes were computed (added and removed ones both count)
    points_added, points_removed : of them, by motion compensation's corrections
    point_pixels : Σ over computed points of the pixels that they were computed on
    blank_share : share of the hologram that the previous frames could not give
    reuse : object name to where its light came from, and why
    stage_seconds : stage name to seconds; the paper's stages are PE, PA, CON, RMC, HC, EC
    error_reference : relative L2 field error against the float64 truth, on sampled pixels
    error_pixels : how many pixels that was measured on
    error_reuse : the same against full recomputation with the same CGH method
    error_predicted : what the method itself expected `error_reference` to be
    objects : per object {name, position (x, y, z), depth, …}
    image : image measures per object, on request
    """

    number: int
    key: bool = True
    points_computed: int = 0
    points_added: int = 0
    points_removed: int = 0
    point_pixels: int = 0
    blank_share: float = 0.0
    reuse: dict[str, str] = field(default_factory=dict)
    stage_seconds: dict[str, float] = field(default_factory=dict)
    error_reference: float | None = None
    error_pixels: int = 0
    error_reuse: float | None = None
    error_predicted: float | None = None
    objects: list[dict[str, Any]] = field(default_factory=list)
    image: dict[str, Any] = field(default_factory=dict)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Add the time of the enclosed work to `stage_seconds[name]`."""
        start = time.perf_counter()
        try:
            yield
        finally:
            spent = time.perf_counter() - start
            self.stage_seconds[name] = self.stage_seconds.get(name, 0.0) + spent
