"""A coarse map of an object's light, small enough for a manifest and enough to judge a picture by.

Square cells of a few resolutions around the visible points of one frame: how much light each holds,
and its mean depth. Written by whoever makes a video, read by whoever checks it.
"""

import base64
import zlib
from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.optics.passband import Passband
from chrmc.optics.resolution import resolution
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM

RESOLUTIONS = 4.0
"""Least side of a cell in resolutions, so that speckle averages out and no point spills over."""
MOST_CELLS = 32
"""Cells across the longer side of an object; larger objects get larger cells."""
DARK_CELLS = 2
"""Cells without light around the object, where a right picture is dark."""


@dataclass(frozen=True, eq=False)
class LightMap:
    """Cells of one object in one frame, centred on the box of its visible points.

    cell : side of a cell, metres; the SLM's pixel pitch times a whole number
    centre : (y, x) of the grid, metres
    light : (rows, columns) share of the object's intensity, sum 1
    depth : (rows, columns) intensity-weighted mean depth, metres; the object's where there is none
    spread : (rows, columns) its standard deviation within the cell, metres
    """

    cell: float
    centre: tuple[float, float]
    light: NDArray[np.float64]
    depth: NDArray[np.float64]
    spread: NDArray[np.float64]

    @classmethod
    def of_cloud(
        cls, cloud: PointCloud, slm: SLM, wavelength: float, passband: Passband
    ) -> "LightMap | None":
        """The map of an object's visible points; None where there is no light."""
        total = float(cloud.intensity.sum())
        if not total > 0:
            return None
        p = cloud.positions
        low, high = p.min(axis=0), p.max(axis=0)
        depth = float(cloud.centroid[2])
        fine = np.array(resolution(slm, wavelength, depth, passband)[::-1])
        wanted = max(RESOLUTIONS * float(fine.mean()), float((high - low)[:2].max()) / MOST_CELLS)
        cell = slm.pixel_pitch * ceil(wanted / slm.pixel_pitch)
        centre = (low + high)[:2] / 2
        counts = [2 * DARK_CELLS + max(1, ceil((high - low)[k] / cell)) for k in (1, 0)]
        light, deep, square = np.zeros((3, *counts))
        share = cloud.intensity / total / 9
        # A point's picture is as wide as the resolution: nine parts of it, each into its cell.
        for dx in (-1, 0, 1):
            for dy in (-1, 0, 1):
                at = p[:, :2] + fine * (dx / 3, dy / 3) - centre
                column, row = (
                    np.clip(np.floor(at[:, k] / cell + n / 2).astype(np.intp), 0, n - 1)
                    for k, n in ((0, counts[1]), (1, counts[0]))
                )
                np.add.at(light, (row, column), share)
                np.add.at(deep, (row, column), share * (p[:, 2] - depth))
                np.add.at(square, (row, column), share * (p[:, 2] - depth) ** 2)
        lit = light > 0
        deep[lit] /= light[lit]
        square[lit] /= light[lit]
        spread = np.sqrt(np.maximum(square - deep**2, 0))
        return cls(cell, (float(centre[1]), float(centre[0])), light, deep + depth, spread)

    def as_record(self) -> dict[str, Any]:
        """For a manifest: light in 255 steps of its square root, depths in 255 of their range."""
        ends = float(self.depth.min()), float(self.depth.max())
        size = (ends[1] - ends[0]) or 1.0
        root = np.sqrt(self.light / self.light.max())
        widest = float(self.spread.max()) or 1.0
        levels = np.stack([root, (self.depth - ends[0]) / size, self.spread / widest])
        packed = zlib.compress(np.rint(255 * levels).astype(np.uint8).tobytes(), 9)
        return {
            "cell": self.cell,
            "centre": list(self.centre),
            "shape": list(self.light.shape),
            "depths": list(ends),
            "widest": widest,
            "data": base64.b64encode(packed).decode("ascii"),
        }

    @staticmethod
    def _widest(size: float) -> float:
        """What 255 stands for in `spread`: no cell of a range of means is wider than twice that,
        but one whose cells are all alike may be."""
        return 2 * size

    @classmethod
    def from_record(cls, record: dict[str, Any]) -> "LightMap":
        """What `as_record` wrote; ValueError for anything else."""
        try:
            rows, columns = (int(n) for n in record["shape"])
            near, far = (float(z) for z in record["depths"])
            y, x = (float(v) for v in record["centre"])
            cell = float(record["cell"])
            packed = base64.b64decode(record["data"], validate=True)
            widest = float(record["widest"])
            count = 3 * rows * columns
            if not (0 < count <= 3 * (MOST_CELLS + 3 + 2 * DARK_CELLS) ** 2 and cell > 0):
                raise ValueError("its size")
            raw = zlib.decompressobj().decompress(packed, count + 1)
            levels = np.frombuffer(raw, dtype=np.uint8).reshape(3, rows, columns) / 255.0
        except (KeyError, TypeError, ValueError, zlib.error) as error:
            raise ValueError(f"an object's map of light cannot be read ({error})") from None
        light = levels[0] ** 2
        if not (
            light.sum() > 0 and 0 < near <= far and np.isfinite([far, y, x, cell, widest]).all()
        ):
            raise ValueError("an object's map of light cannot be read (its values)")
        depth = near + levels[1] * (far - near)
        return cls(cell, (y, x), light / light.sum(), depth, levels[2] * widest)
