"""What the scene says of an object: where it stands, and where its light is."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.light_map import LightMap
from chrmc.optics.footprint import expected_power
from chrmc.scene.points import PointCloud
from reconstruct.four_f_system import FourF

FALLBACK_SIZE = 1e-3
"""Half-width of the region around an object whose extent the video does not tell, metres."""


@dataclass(frozen=True, eq=False)
class Target:
    """An object as the scene says it stands.

    position : (3,) intensity-weighted mean of the visible points, metres
    low, high : (3,) and (3,) corners of the visible points' box, metres
    light : map of the visible points' light, where the video tells it
    power : of its light on the panel, in a unit that all objects of a frame share, or None
    """

    name: str
    position: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    light: LightMap | None = None
    power: float | None = None

    @classmethod
    def of_cloud(cls, name: str, cloud: PointCloud, system: FourF | None = None) -> "Target | None":
        """From an object's visible points; with a system, with their map of light. None for an
        object without light."""
        if not cloud.amplitude.any():
            return None
        p, light, power = cloud.positions, None, None
        if system is not None:
            optics = system.slm, system.wavelength, system.band
            light = LightMap.of_cloud(cloud, *optics)
            power = float(expected_power(cloud, *optics).sum())
        return cls(name, cloud.centroid, p.min(axis=0), p.max(axis=0), light, power)

    @classmethod
    def of_record(cls, record: dict[str, Any]) -> "Target | None":
        """From a manifest's entry {name, position, box}; None for an object without points."""
        if record.get("position") is None:
            return None
        position = np.asarray(record["position"], dtype=np.float64)
        box = record.get("box")
        if box is None:
            low, high = position - FALLBACK_SIZE, position + FALLBACK_SIZE
        else:
            low, high = (np.asarray(corner, dtype=np.float64) for corner in box)
        told = record.get("light")
        light = None if told is None else LightMap.from_record(told)
        return cls(str(record["name"]), position, low, high, light, record.get("power"))
