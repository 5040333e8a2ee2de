"""Is every object in focus where the scene says? Figures per object, and pass or fail."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import hypot
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from chrmc.metrics import psnr, ssim
from chrmc.optics.propagation import Patch
from reconstruct import metrics
from reconstruct.focus import Focus, find_focus, focus_curve, refine_peak
from reconstruct.focus_metrics import METRICS
from reconstruct.four_f_system import FourF
from reconstruct.stack import (
    FocalStack,
    brightness,
    depth_of_focus,
    focal_stack,
    patch_around,
)

DEPTH_TOLERANCE = 0.5e-3
"""Metres between found and expected depth that pass."""
FALLBACK_SIZE = 1e-3
"""Half-width of the region around an object whose extent the video does not tell, metres."""


@dataclass(frozen=True, eq=False)
class Target:
    """An object as the scene says it stands.

    position : (3,) intensity-weighted mean of the visible points, metres
    low, high : (3,) and (3,) corners of the visible points' box, metres
    """

    name: str
    position: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]

    @classmethod
    def of_points(cls, name: str, positions: ArrayLike, intensity: ArrayLike) -> "Target":
        """From (N, 3) points and their (N,) intensities."""
        p, w = np.asarray(positions, dtype=np.float64), np.asarray(intensity, dtype=np.float64)
        return cls(name, w @ p / w.sum(), p.min(axis=0), p.max(axis=0))

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
        return cls(str(record["name"]), position, low, high)


@dataclass(frozen=True, eq=False)
class ObjectVerdict:
    """What was found of one object. Lengths in metres, errors found − expected.

    passed : focused, depth and lateral errors within tolerance
    focus : depth, front and rear, curve, tiles
    depth_error : of the intensity-weighted mean depth
    lateral_error : (x, y) of the centroid
    contrast, snr (dB), speckle_contrast : at the found depth (`reconstruct.metrics`)
    depth_tolerance, lateral_tolerance : what it was held against, metres
    psnr (dB), ssim : against the reconstruction of the truth; None when that was not asked for
    metric_depths : where published metrics of the whole region peak, when asked for; they lean
        towards where points crowd, and do not count for `passed`
    """

    name: str
    target: Target
    focus: Focus
    depth_error: float
    lateral_error: tuple[float, float]
    passed: bool
    contrast: float
    snr: float
    speckle_contrast: float
    depth_tolerance: float
    lateral_tolerance: float
    psnr: float | None = None
    ssim: float | None = None
    metric_depths: dict[str, float] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """Plain figures for JSON; what was not found is null."""
        figures: dict[str, Any] = {
            "name": self.name,
            "passed": self.passed,
            "focused": self.focus.focused,
            "method": self.focus.method,
            "depth_expected": float(self.target.position[2]),
            "depth": self.focus.depth,
            "depth_error": self.depth_error,
            "front": self.focus.front,
            "rear": self.focus.rear,
            "position_expected": [float(v) for v in self.target.position[:2]],
            "position": list(self.focus.position),
            "lateral_error": list(self.lateral_error),
            "contrast": self.contrast,
            "snr": self.snr,
            "speckle_contrast": self.speckle_contrast,
            "psnr": self.psnr,
            "ssim": self.ssim,
            "metric_depths": {k: _finite(v) for k, v in self.metric_depths.items()},
            "curve": {
                "depths": self.focus.depths.tolist(),
                "sharpness": self.focus.curve.tolist(),
            },
        }
        return {key: _finite(value) for key, value in figures.items()}


@dataclass(frozen=True)
class FrameVerdict:
    """All objects of one frame; an empty frame passes."""

    number: int
    objects: list[ObjectVerdict] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        """Every object is in focus where the scene says."""
        return all(o.passed for o in self.objects)


def _finite(value: Any) -> Any:
    """JSON has no NaN and no infinity."""
    if isinstance(value, list):
        return [_finite(v) for v in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def search_range(target: Target, system: FourF) -> NDArray[np.float64]:
    """Depths to look at: the object's box and four depths of focus on each side, half a depth of
    focus apart.

    Uncentred on purpose by a few per cent: an estimate that leans on the middle shows.
    """
    low, high = float(target.low[2]), float(target.high[2])
    coarse, fine = search_scale(target, system)
    before, behind = max(3.6 * coarse, (high - low) / 2), max(4.4 * coarse, (high - low) / 2)
    first = max(low - before, low / 2)
    count = int(np.clip(np.ceil((high + behind - first) / (fine / 2)), 20, 400)) + 1
    return np.linspace(first, high + behind, count)


def search_scale(target: Target, system: FourF) -> tuple[float, float]:
    """The larger and the smaller depth of focus of both axes at a target, metres."""
    depth = float(target.position[2])
    pair = depth_of_focus(system.slm, system.wavelength, depth, system.band)
    return max(pair), min(pair)


def target_stack(
    field_: NDArray[np.complex64], system: FourF, target: Target, pixel_pitch: float
) -> tuple[FocalStack, int]:
    """Focal stack of a target's region, and the side of its tiles: two scene pixels, in samples."""
    p = system.slm.pixel_pitch
    tile = max(4, round(2 * pixel_pitch / p))
    patch = patch_around(target.low, target.high, p, margin=tile * p, even=tile)
    depths = search_range(target, system)
    stack = focal_stack(field_, system.slm, system.wavelength, depths, patch, system.band)
    return stack, tile


def judge_object(
    field_: NDArray[np.complex64],
    system: FourF,
    target: Target,
    pixel_pitch: float,
    depth_tolerance: float = DEPTH_TOLERANCE,
    lateral_tolerance: float | None = None,
    truth: NDArray[np.complexfloating] | None = None,
    with_metrics: bool = False,
) -> ObjectVerdict:
    """Verdict on one object from a decoded field.

    field_ : (H, W) from `system.field(frame)`
    pixel_pitch : of the scene, metres; the lateral tolerance unless one is given
    truth : (H, W) field of the scene itself, for PSNR and SSIM
    with_metrics : also find where published focus metrics peak
    """
    stack, tile = target_stack(field_, system, target, pixel_pitch)
    x, y, z = (float(v) for v in target.position)
    ends = (float(stack.depths[0]), float(stack.depths[-1]))
    lit_by = brightness(stack.patch, system.slm, system.wavelength, ends, system.band)
    # λz/A, from the depths of focus 2λ(z/A)² of both axes.
    sizes = np.sqrt(np.array(search_scale(target, system)) * system.wavelength / 2)
    grain = max(1.0, float(sizes.mean()) / system.slm.pixel_pitch)
    focus = find_focus(stack, tile, lit_by, grain)
    depth_error = focus.depth - z
    lateral = (focus.position[0] - x, focus.position[1] - y)
    allowed = pixel_pitch if lateral_tolerance is None else lateral_tolerance
    passed = focus.focused and abs(depth_error) <= depth_tolerance and hypot(*lateral) <= allowed
    shown = focus.depth if np.isfinite(focus.depth) else z
    plane = stack.intensity[int(np.argmin(np.abs(stack.depths - shown)))]
    lit = inside(stack.patch, target)
    likeness: dict[str, float] = {}
    if truth is not None:
        one = np.array([stack.depths[int(np.argmin(np.abs(stack.depths - shown)))]])
        true_plane = focal_stack(
            np.asarray(truth, dtype=np.complex64),
            system.slm,
            system.wavelength,
            one,
            stack.patch,
            system.band,
        ).intensity[0]
        level = plane * metrics.scale_to(plane, true_plane)
        likeness = {
            "psnr": psnr(level, true_plane),
            "ssim": ssim(level, true_plane),
        }
    peaks: dict[str, float] = {}
    if with_metrics:
        peaks = {n: refine_peak(stack.depths, focus_curve(stack, n)) for n in METRICS}
    return ObjectVerdict(
        target.name,
        target,
        focus,
        depth_error,
        lateral,
        bool(passed),
        contrast=metrics.contrast(plane, lit, ~lit),
        snr=metrics.snr(plane, lit, ~lit),
        speckle_contrast=metrics.speckle_contrast(plane, lit),
        depth_tolerance=depth_tolerance,
        lateral_tolerance=allowed,
        metric_depths=peaks,
        **likeness,
    )


def inside(patch: Patch, target: Target) -> NDArray[np.bool_]:
    """Samples of a patch that lie in a target's box, half a sample more on each side."""
    y, x = patch.coordinates()
    half = patch.pitch / 2
    rows = (y >= target.low[1] - half) & (y <= target.high[1] + half)
    columns = (x >= target.low[0] - half) & (x <= target.high[0] + half)
    return rows[:, None] & columns[None, :]


def judge_frame(
    frame: NDArray[np.uint8],
    system: FourF,
    targets: Sequence[Target],
    pixel_pitch: float,
    number: int = 1,
    truth: NDArray[np.complexfloating] | None = None,
    depth_tolerance: float = DEPTH_TOLERANCE,
    lateral_tolerance: float | None = None,
    with_metrics: bool = False,
) -> FrameVerdict:
    """Verdict on every target of one frame of grey levels; one filter pass for all of them."""
    field_ = system.field(frame)
    return FrameVerdict(
        number,
        [
            judge_object(
                field_,
                system,
                t,
                pixel_pitch,
                depth_tolerance,
                lateral_tolerance,
                truth,
                with_metrics,
            )
            for t in targets
        ],
    )
