"""Intensity-and-depth frames, and the points that they stand for.

A pixel of intensity above 0 is one point: x = (column − (W − 1)/2)·pixel_pitch, y likewise from
the row, z its depth, amplitude √intensity. Intensity 0 is background.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chrmc.scene.points import PointCloud


@dataclass(frozen=True)
class DepthPlanes:
    """Evenly spaced depths: plane k lies at first + k·step.

    first, step : metres; count : number of planes
    """

    first: float
    step: float
    count: int

    def __post_init__(self) -> None:
        if not (np.isfinite(self.first) and self.first > 0):
            raise ValueError(f"depth_min must be a positive depth, not {self.first} m")
        if not (np.isfinite(self.step) and self.step >= 1e-15):
            raise ValueError(f"depth_step must be a positive length, not {self.step} m")
        if self.count < 1:
            raise ValueError(f"depth_planes must be at least 1, not {self.count}")
        if not self.last <= 1e9:
            raise ValueError(f"depth_min, depth_step and depth_planes reach {self.last:g} m")

    @property
    def last(self) -> float:
        """Depth of the last plane, metres."""
        return self.first + (self.count - 1) * self.step

    def snap(self, depth: NDArray[np.floating]) -> NDArray[np.float64]:
        """Depth of the nearest plane, float64, so that float32 files give exact planes.

        Raises ValueError for depths farther than half a step outside the planes.
        """
        index = np.rint((np.asarray(depth, dtype=np.float64) - self.first) / self.step)
        outside = (index < 0) | (index >= self.count)
        if outside.any():
            wrong = np.asarray(depth)[outside]
            raise ValueError(
                f"{np.count_nonzero(outside)} depths from {wrong.min() * 1e3:.6g} to "
                f"{wrong.max() * 1e3:.6g} mm lie outside the depth range "
                f"{self.first * 1e3:.6g} to {self.last * 1e3:.6g} mm: move the object or widen "
                "the range"
            )
        return self.first + index * self.step


PLANES = DepthPlanes(244e-3, 0.1e-3, 256)
"""The depth range of the built-in scenes: 244.0 to 269.5 mm."""


@dataclass(frozen=True, eq=False)
class RGBDFrame:
    """One frame of intensity, depth and object.

    intensity : (H, W) float32, ≥ 0; 0 is background
    depth : (H, W) float64 metres, finite and > 0 where lit; what it says elsewhere is ignored
    object_id : (H, W) int32 ≥ 0, which object a lit pixel belongs to
    colour : (H, W, 3) float32 ≥ 0, linear sRGB of the light relative to white, or None for white

    Raises ValueError for anything else.
    """

    intensity: NDArray[np.float32]
    depth: NDArray[np.float64]
    object_id: NDArray[np.int32]
    colour: NDArray[np.floating] | None = None

    def __post_init__(self) -> None:
        intensity = np.asarray(self.intensity, dtype=np.float32)
        depth = np.asarray(self.depth, dtype=np.float64)
        object_id = np.asarray(self.object_id)
        if intensity.ndim != 2 or intensity.size == 0:
            raise ValueError(f"intensity must be (H, W), not {intensity.shape}")
        for name, values in (("depth", depth), ("object_id", object_id)):
            if values.shape != intensity.shape:
                raise ValueError(f"{name} is {values.shape}, but intensity {intensity.shape}")
        _refuse(np.isnan(intensity), "intensity is NaN", "write 0 for background")
        _refuse(np.isnan(depth), "depth is NaN", "write 0 where intensity is 0")
        _refuse(np.isinf(intensity), "intensity is infinite", "write finite values")
        _refuse(
            intensity < 0,
            f"intensity is negative (down to {intensity.min():.4g})",
            "write 0 for background and positive values for light",
        )
        lit = intensity > 0
        _refuse(
            lit & ~((depth > 0) & np.isfinite(depth)),
            "depth is not a positive, finite number of metres on lit pixels",
            "give them a depth in front of the hologram, or intensity 0",
        )
        if object_id.dtype.kind not in "iu":
            object_id = object_id.astype(np.float64)
            whole = np.where(np.isfinite(object_id), np.rint(object_id), -1)
            _refuse(lit & (whole != object_id), "object id is not a whole number ≥ 0", "write ids")
            object_id = np.where(lit, whole, 0)
        _refuse(
            lit & ((object_id < 0) | (object_id > 2**31 - 1)),
            "object id is not in 0 … 2³¹ − 1",
            "number the objects from 1",
        )
        if self.colour is not None:
            colour = np.asarray(self.colour, dtype=np.float32)
            if colour.shape != (*intensity.shape, 3):
                raise ValueError(f"colour is {colour.shape}, but intensity {intensity.shape}")
            _refuse(
                ((colour < 0) | ~np.isfinite(colour)).max(axis=2),
                "colour is negative or not finite",
                "write linear red, green and blue ≥ 0",
            )
            object.__setattr__(self, "colour", colour)
        object.__setattr__(self, "intensity", intensity)
        object.__setattr__(self, "depth", depth)
        object.__setattr__(self, "object_id", np.where(lit, object_id, 0).astype(np.int32))

    @property
    def shape(self) -> tuple[int, int]:
        """(H, W)."""
        height, width = self.intensity.shape
        return height, width

    @property
    def lit(self) -> NDArray[np.bool_]:
        """(H, W) where intensity is above 0."""
        return self.intensity > 0

    @property
    def ids(self) -> NDArray[np.int32]:
        """Ascending ids of the objects that have lit pixels."""
        return np.unique(self.object_id[self.lit])

    @classmethod
    def empty(cls, shape: tuple[int, int]) -> "RGBDFrame":
        """A frame of background only."""
        return cls(np.zeros(shape, np.float32), np.zeros(shape), np.zeros(shape, dtype=np.int32))


def _refuse(bad: NDArray[np.bool_], what: str, mend: str) -> None:
    """ValueError that counts the bad pixels and points at the first one."""
    if bad.any():
        row, column = np.argwhere(bad)[0]
        raise ValueError(
            f"{what}: {np.count_nonzero(bad)} pixels, the first at row {row}, column {column}; "
            f"{mend}"
        )


def pixel_centres(
    shape: tuple[int, int], pixel_pitch: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(W,) x of the columns and (H,) y of the rows, metres; the raster is centred on the axis."""
    height, width = shape
    x = (np.arange(width, dtype=np.float64) - (width - 1) / 2) * pixel_pitch
    y = (np.arange(height, dtype=np.float64) - (height - 1) / 2) * pixel_pitch
    return x, y


def pixel_phases(shape: tuple[int, int], seed: int) -> NDArray[np.float64]:
    """(H, W) random phases, one per pixel for all frames, so that clips and re-runs agree."""
    return np.random.default_rng(seed).uniform(0, 2 * np.pi, shape)


def frame_to_cloud(
    frame: RGBDFrame,
    pixel_pitch: float,
    phases: NDArray[np.float64] | None = None,
    object_id: int | None = None,
) -> PointCloud:
    """Points of the lit pixels, row by row.

    phases : (H, W) radians, default zero; object_id : only this object
    """
    chosen = frame.lit if object_id is None else frame.lit & (frame.object_id == object_id)
    rows, columns = np.nonzero(chosen)
    x, y = pixel_centres(frame.shape, pixel_pitch)
    return PointCloud(
        np.stack([x[columns], y[rows], frame.depth[chosen]], axis=1),
        np.sqrt(frame.intensity[chosen].astype(np.float64)),
        np.zeros(len(rows)) if phases is None else phases[chosen],
        None if frame.colour is None else frame.colour[chosen].astype(np.float64),
    )


def clouds_to_frame(
    clouds: Mapping[int, PointCloud],
    shape: tuple[int, int],
    pixel_pitch: float,
    planes: DepthPlanes | None = None,
) -> RGBDFrame:
    """Points put into the pixels nearest to them; of several in one pixel the nearest is kept.

    clouds : object id to its points; planes : snap depths to them
    The inverse of `frame_to_cloud` for points that came from pixels. Raises ValueError for points
    outside the raster or the planes.
    """
    cloud = PointCloud.concatenate(clouds.values())
    owner = np.repeat(list(clouds), [len(c) for c in clouds.values()]).astype(np.int32)
    height, width = shape
    place = cloud.positions[:, :2] / pixel_pitch + np.array([(width - 1) / 2, (height - 1) / 2])
    column, row = np.rint(place).astype(np.int64).T
    outside = (column < 0) | (column >= width) | (row < 0) | (row >= height)
    if outside.any():
        far = np.abs(cloud.positions[:, :2]).max(axis=0) * 1e3
        raise ValueError(
            f"{np.count_nonzero(outside)} of {len(cloud)} points lie outside the {width} × "
            f"{height} raster of {width * pixel_pitch * 1e3:.4g} × "
            f"{height * pixel_pitch * 1e3:.4g} mm (|x| up to {far[0]:.4g}, |y| up to {far[1]:.4g} "
            "mm): use more pixels or a wider pitch"
        )
    depth = cloud.positions[:, 2] if planes is None else planes.snap(cloud.positions[:, 2])
    # Farthest first, so that the nearest point is written last.
    order = np.argsort(-depth, kind="stable")
    at = (row[order], column[order])
    intensity, z = np.zeros(shape, np.float32), np.zeros(shape)
    object_id = np.zeros(shape, np.int32)
    intensity[at] = cloud.intensity[order]
    z[at] = depth[order]
    object_id[at] = owner[order]
    colour = None
    if cloud.colour is not None:
        colour = np.ones((*shape, 3), np.float32)
        colour[at] = cloud.colour[order]
    return RGBDFrame(intensity, z, object_id, colour)
