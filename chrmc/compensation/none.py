"""No compensation: every frame computed afresh by the CGH method."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh import Method, field_and_error, method_named, signal_and_error
from chrmc.compensation.frame import VideoFrame
from chrmc.encoding import Coding
from chrmc.options import option_names
from chrmc.record import FrameRecord
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Scene
from chrmc.slm import SLM


def frames(
    scene: Scene,
    slm: SLM,
    wavelength: float,
    cgh: str | Method,
    numbers: range,
    coding: Coding,
    **options: Any,
) -> Iterator[VideoFrame]:
    """Every frame a key frame; `options` go to the CGH method.

    From a method that has one, the coded signal comes straight from the points, without a complex
    field. An error that the method expects is in the record once the frame is made.
    """
    direct = _gives_signal(cgh, coding, options)
    for number in numbers:
        scene_frame = scene.frame(number)
        cloud = scene_frame.cloud
        record = FrameRecord(
            number,
            points_computed=len(cloud),
            points_added=len(cloud),
            point_pixels=len(cloud) * slm.width * slm.height,
        )

        def field(cloud: PointCloud = cloud, record: FrameRecord = record) -> NDArray[np.complex64]:
            with record.stage("HC"):
                out, record.error_predicted = field_and_error(
                    cloud, slm, wavelength, cgh, passband=coding.passband, **options
                )
            return out

        def signal(cloud: PointCloud = cloud, record: FrameRecord = record) -> NDArray[np.float32]:
            with record.stage("HC"):
                out, record.error_predicted = signal_and_error(
                    cloud, slm, wavelength, cgh, coding, **options
                )
            return out

        make_signal: Callable[[], NDArray[np.float32]] | None = signal if direct else None
        yield VideoFrame(scene_frame, record, field, make_signal)


def _gives_signal(cgh: str | Method, coding: Coding, options: Mapping[str, Any]) -> bool:
    """Whether the coded signal is all that is wanted, and the method makes it without a field.

    Options that only `compute_field` knows, or nobody, are left to it.
    """
    signal = method_named(cgh).signal
    if coding.needs_field or signal is None:
        return False
    return set(options) <= set(option_names(signal)[0])
