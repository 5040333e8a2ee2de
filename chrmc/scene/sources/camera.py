"""A recording's camera, in the words of RealSense, Open3D, the TUM RGB-D set and Blender."""

from dataclasses import dataclass
from math import radians, tan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.scene.sources.world import number, triple

SENSOR = 36.0
"""Millimetres across the sensor of a camera that only names its lens, as Blender has it."""


@dataclass(frozen=True)
class Camera:
    """Pinhole: pixel (u, v) at depth d sees ((u − cx)·d/fx, (v − cy)·d/fy, d).

    pitch : metres between pixels of a camera whose lines of sight are parallel; None for a pinhole
    unit : metres of one unit of the depth pictures
    scale : metres here per metre of the recording, None to fit; offset : metres added then
    """

    fx: float
    fy: float
    cx: float
    cy: float
    unit: float
    scale: float | None = None
    offset: tuple[float, float, float] | None = None
    pitch: float | None = None

    def place(self, u: Any, v: Any, depth: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) metres of pixels at (N,) depths in the file's unit."""
        d = depth * self.unit
        across = d / self.fx if self.pitch is None else self.pitch
        down = d / self.fy if self.pitch is None else self.pitch
        return np.stack([(u - self.cx) * across, (v - self.cy) * down, d], axis=1)

    def pixel(self, depth: float) -> float:
        """Metres between neighbouring pixels at a depth in metres."""
        return depth / self.fx if self.pitch is None else self.pitch


def camera_of(
    content: Any, where: str, shape: tuple[int, ...], unit: float | None = None
) -> Camera:
    """A camera from the words of RealSense, Open3D, the TUM set and Blender (lens in millimetres,
    sensor_width, or fov in degrees, across the picture); ValueError in one line.

    shape : (H, W) of the pictures; unit : metres per unit of depth where nothing is said
    """
    if not isinstance(content, dict):
        raise ValueError(f"{where} must be an object with fx, fy, cx, cy")
    inner: dict[str, Any] = next((content[k] for k in ("camera", "intrinsics", "depth_intrinsics")
                  if isinstance(content.get(k), dict)), {})  # fmt: skip
    words = {**content, **inner}
    matrix = words.get("intrinsic_matrix")
    if isinstance(matrix, list) and len(matrix) == 9:
        words |= {"fx": matrix[0], "fy": matrix[4], "cx": matrix[6], "cy": matrix[7]}

    def value(*names: str, default: float | None = None) -> float:
        for name in names:
            found = words.get(name)
            if isinstance(found, int | float) and not isinstance(found, bool):
                return number(found, f"{where}: {name}")
        if default is None:
            raise ValueError(f"{where} has no {names[0]} (pixels); write fx, fy, cx, cy")
        return default

    height, width = shape
    pitch, focal = None, None
    if "lens" in words:
        focal = width * value("lens") / value("sensor_width", default=SENSOR)
    elif "fov" in words:
        focal = width / 2 / tan(radians(value("fov")) / 2)
    elif not inner and "fx" not in words and "pixel_pitch" in words:
        pitch, focal = value("pixel_pitch"), 1.0
    fx, fy = value("fx", default=focal), value("fy", default=focal)
    for name, found in (("fx", fx), ("fy", fy), ("pixel_pitch", pitch)):
        if found is not None:
            number(found, f"{where}: {name}", positive=True)
    offset = words.get("offset")
    return Camera(
        fx,
        fy,
        value("cx", "ppx", default=(width - 1) / 2 if focal else None),
        value("cy", "ppy", default=(height - 1) / 2 if focal else None),
        _unit(words, where, unit),
        None if words.get("scale") is None else value("scale"),
        None if offset is None else triple(offset, f"{where}: offset"),
        pitch,
    )


def _unit(words: dict[str, Any], where: str, default: float | None) -> float:
    """Metres of one unit of depth: `depth_unit`, or `depth_scale` as units per metre (Open3D,
    TUM: 1000, 5000) or metres per unit (RealSense: 0.001)."""
    unit = words.get("depth_unit", words.get("depth_scale", default or 0.001))
    found = number(unit, f"{where}: depth_unit, metres per unit,", positive=True)
    return 1 / found if "depth_unit" not in words and found > 1 else found
