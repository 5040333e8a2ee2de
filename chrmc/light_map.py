"""A coarse map of an object's light, small enough for a manifest and enough to judge a picture by.

Square cells of a few resolutions around the visible points of one frame: how much light each holds,
and its mean depth; where cells hold several depths, as two turns of a helix, how much at each.
Written by whoever makes a video, read by whoever checks it.
"""

import base64
import zlib
from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.interference import alike, light_left, sharpness_shown
from chrmc.optics.passband import Passband
from chrmc.optics.resolution import depth_of_focus, resolution
from chrmc.scene.points import FARTHEST, PointCloud
from chrmc.slm import SLM

RESOLUTIONS = 4.0
"""Least side of a cell in resolutions, so that speckle averages out and no point spills over."""
MOST_CELLS = 32
"""Cells across the longer side of an object; larger objects get larger cells."""
DARK_CELLS = 2
"""Cells without light around the object, where a right picture is dark."""
FEW_CELLS = 6
"""Objects of fewer lit cells have no shape to judge."""
MIXED = 0.2
"""Share of the light, in cells deeper than the depth of focus, from which layers are kept."""
MOST_LAYERS = 32
"""Layers of depth that a map tells apart."""
_STEPS = 60


@dataclass(frozen=True, eq=False)
class LightMap:
    """Cells of one object in one frame, centred on the box of its visible points.

    cell : side of a cell, metres; the SLM's pixel pitch times a whole number
    centre : (y, x) of the grid, metres
    light : (rows, columns) share of the object's intensity, sum 1
    depth : (rows, columns) intensity-weighted mean depth, metres; the object's where there is none
    spread : (rows, columns) its standard deviation within the cell, metres
    layers : (layers, rows, columns) share of each cell's light at each of `layer_depths`, where
        cells hold more depths than lie between them; else None
    ends : depths of the object's nearest and farthest point, metres
    """

    cell: float
    centre: tuple[float, float]
    light: NDArray[np.float64]
    depth: NDArray[np.float64]
    spread: NDArray[np.float64]
    layers: NDArray[np.float64] | None = None
    ends: tuple[float, float] = (0.0, 0.0)

    @property
    def lit(self) -> NDArray[np.bool_]:
        """(rows, columns) cells that count as the object's."""
        bright: NDArray[np.bool_] = self.light > self.light.max() / 50
        return bright

    @property
    def shaped(self) -> bool:
        """Whether there are cells enough to judge a shape by."""
        return int(np.count_nonzero(self.lit)) >= FEW_CELLS

    @property
    def layer_depths(self) -> NDArray[np.float64]:
        """(layers,) metres, evenly spaced, each the middle of its layer."""
        count = 0 if self.layers is None else len(self.layers)
        return self.ends[0] + (np.arange(count) + 0.5) / max(count, 1) * (
            self.ends[1] - self.ends[0]
        )

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
        share, below = cloud.intensity / total / 9, p[:, 2] - depth
        # A point's picture is as wide as the resolution: nine parts of it, each into its cell.
        at = (
            [fine * (dx / 3, dy / 3) for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
            + p[:, None, :2]
            - centre
        )
        column, row = (
            np.clip(np.floor(at[:, :, k] / cell + n / 2).astype(np.intp), 0, n - 1)
            for k, n in ((0, counts[1]), (1, counts[0]))
        )
        into = row * counts[1] + column

        def summed(values: NDArray[np.float64], layer: Any = 0, layers: int = 1) -> Any:
            """(layers, rows, columns) of values (N,) of the points, each of its parts the same."""
            index = into + np.reshape(layer, (-1, 1)) * (counts[0] * counts[1])
            size = layers * counts[0] * counts[1]
            found = np.bincount(index.ravel(), np.repeat(values, 9), size)
            return found.reshape(layers, *counts)

        light, deep, square = (summed(share * below**k)[0] for k in range(3))
        lit = light > 0
        deep[lit] /= light[lit]
        square[lit] /= light[lit]
        spread = np.sqrt(np.maximum(square - deep**2, 0))
        finer, size = min(depth_of_focus(slm, wavelength, depth, passband)), float((high - low)[2])
        layers = None
        if light[spread > finer / 2].sum() > MIXED:
            parts = int(np.clip(ceil(2 * size / finer), 2, MOST_LAYERS))
            layer = np.minimum((p[:, 2] - low[2]) / size * parts, parts - 1).astype(np.intp)
            layers = summed(share, layer, parts)
            layers[:, lit] /= light[lit]
        middle, ends = (float(centre[1]), float(centre[0])), (float(low[2]), float(high[2]))
        if alike(cloud):
            shown = np.maximum(summed(light_left(cloud, slm, wavelength, passband))[0], 0)
            light = shown / shown.sum() if shown.any() else light
            if layers is not None:
                near = (np.arange(-2, len(layers) + 2) + 0.5) * size / len(layers)
                optics = slm, wavelength, passband, middle, (counts[0], counts[1]), cell
                sharp = sharpness_shown(cloud, *optics, low[2] + near)
                if sharp is not None:
                    foci = depth_of_focus(slm, wavelength, depth, passband)
                    layers = _as_layers(sharp, layers, focus_lost(near[:, None] - near[2:-2], foci))
        return cls(cell, middle, light, deep + depth, spread, layers, ends)

    def as_record(self) -> dict[str, Any]:
        """For a manifest: light in 255 steps of its square root, depths in 255 of their range."""
        ends = float(self.depth.min()), float(self.depth.max())
        size = (ends[1] - ends[0]) or 1.0
        root = np.sqrt(self.light / self.light.max())
        widest = float(self.spread.max()) or 1.0
        levels = np.stack([root, (self.depth - ends[0]) / size, self.spread / widest])
        record: dict[str, Any] = {
            "cell": self.cell,
            "centre": list(self.centre),
            "shape": list(self.light.shape),
            "depths": list(ends),
            "widest": widest,
            "data": _packed(levels),
        }
        if self.layers is not None:
            record["layers"] = {"ends": list(self.ends), "data": _packed(self.layers)}
        return record

    @classmethod
    def from_record(cls, record: dict[str, Any]) -> "LightMap":
        """What `as_record` wrote; ValueError for anything else."""
        try:
            rows, columns = (int(n) for n in record["shape"])
            near, far = (float(z) for z in record["depths"])
            y, x = (float(v) for v in record["centre"])
            cell = float(record["cell"])
            widest = float(record["widest"])
            if not (0 < rows * columns <= (MOST_CELLS + 3 + 2 * DARK_CELLS) ** 2 and cell > 0):
                raise ValueError("its size")
            levels = _unpacked(record["data"], 3, rows, columns)
            layers, ends = None, (0.0, 0.0)
            if len(levels) != 3:
                raise ValueError("its size")
            if record.get("layers") is not None:
                layers = _unpacked(record["layers"]["data"], MOST_LAYERS, rows, columns)
                first, last = (float(z) for z in record["layers"]["ends"])
                ends = first, last
        except (KeyError, TypeError, ValueError, zlib.error) as error:
            raise ValueError(f"an object's map of light cannot be read ({error})") from None
        light = levels[0] ** 2
        if not (
            light.sum() > 0 and 0 < near <= far and np.isfinite([far, y, x, cell, widest]).all()
        ):
            raise ValueError("an object's map of light cannot be read (its values)")
        depth = near + levels[1] * (far - near)
        if layers is not None:
            if not 0 < ends[0] < ends[1] < FARTHEST:
                raise ValueError("an object's map of light cannot be read (its layers)")
            layers = layers / np.maximum(layers.sum(axis=0), 1e-9)
        return cls(cell, (y, x), light / light.sum(), depth, levels[2] * widest, layers, ends)


def focus_lost(
    away: NDArray[np.float64], depths_of_focus: tuple[float, float]
) -> NDArray[np.float64]:
    """ΣI² of a point's picture at some distances from its focus, metres, over that in focus.

    Fitted to what slits show, hard or as soft as a footprint: within 0.07 at all distances.
    """
    widths = [np.cbrt(1 / (1 + np.abs(1.3 * away / d) ** 3)) for d in depths_of_focus]
    lost: NDArray[np.float64] = widths[0] * widths[1]
    return lost


def _as_layers(
    sharp: NDArray[np.float64], layers: NDArray[np.float64], focus: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Shares of light that would make cells as sharp as they are, if layers did not interfere.

    sharp : (D, rows, columns); layers : (L, rows, columns) shares by the points' places
    focus : (D, L) sharpness at the depths of light in the layers

    By multiplicative steps (Richardson and Lucy), which leave shares positive.
    """
    wanted = sharp - sharp.min(axis=0)
    lit = layers.sum(axis=0) > 0
    goal = wanted[:, lit] / np.maximum(wanted[:, lit].sum(axis=0), 1e-300)
    found = layers[:, lit] + 1 / len(layers)
    for _ in range(_STEPS):
        found *= focus.T @ (goal / np.maximum(focus @ found, 1e-300))
        found /= focus.sum(axis=0)[:, None]
    out = np.zeros_like(layers)
    out[:, lit] = found / np.maximum(found.sum(axis=0), 1e-300)
    return out


def _packed(levels: NDArray[np.float64]) -> str:
    """Values from 0 to 1 as text, in 255 steps."""
    packed = zlib.compress(np.rint(255 * levels).astype(np.uint8).tobytes(), 9)
    return base64.b64encode(packed).decode("ascii")


def _unpacked(text: str, most: int, rows: int, columns: int) -> NDArray[np.float64]:
    """(layers, rows, columns) of what `_packed` wrote, `most` layers at most; ValueError else."""
    packed, count = base64.b64decode(text, validate=True), most * rows * columns
    raw = zlib.decompressobj().decompress(packed, count + 1)
    if not 0 < len(raw) <= count:
        raise ValueError("its size")
    return np.frombuffer(raw, dtype=np.uint8).reshape(-1, rows, columns) / 255.0
