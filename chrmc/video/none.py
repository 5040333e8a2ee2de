"""No compensation: every frame computed afresh by the CGH method."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh import Method, compute_field
from chrmc.coding import Coding
from chrmc.scene.scene import Scene
from chrmc.slm import SLM
from chrmc.video.frame import VideoFrame
from chrmc.video.ledger import FrameRecord


def frames(
    scene: Scene,
    slm: SLM,
    wavelength: float,
    cgh: str | Method,
    numbers: range,
    coding: Coding,
    **options: Any,
) -> Iterator[VideoFrame]:
    """Every frame a key frame; `options` go to the CGH method."""
    for number in numbers:
        scene_frame = scene.frame(number)
        cloud = scene_frame.cloud
        record = FrameRecord(
            number,
            points_computed=len(cloud),
            points_added=len(cloud),
            point_pixels=len(cloud) * slm.width * slm.height,
        )

        def make(cloud: Any = cloud, record: FrameRecord = record) -> NDArray[np.complex64]:
            with record.stage("HC"):
                return compute_field(
                    cloud, slm, wavelength, cgh, passband=coding.passband, **options
                )

        yield VideoFrame(scene_frame, record, make)
