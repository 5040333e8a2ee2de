"""Is every object in focus where the scene says? Figures per object, and pass or fail."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import hypot
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.metrics import psnr, ssim
from chrmc.optics.propagation import Patch
from chrmc.optics.resolution import resolution
from reconstruct import metrics
from reconstruct.focus import Focus, brightness_at, cells_of, find_focus, focus_curve, refine_peak
from reconstruct.focus_metrics import METRICS
from reconstruct.four_f_system import FourF, power
from reconstruct.likeness import ALIKE, SHARP, Likeness, compare, dimmed, light_of
from reconstruct.outshone import NOTHING, Shares, shares_of
from reconstruct.own_light import least_light
from reconstruct.region import search_scale, target_stack
from reconstruct.spill import spill_error
from reconstruct.stack import FocalStack, brightness, focal_stack
from reconstruct.target import Target

DEPTH_TOLERANCE = 0.5e-3
"""Metres between found and expected depth that pass."""


@dataclass(frozen=True, eq=False)
class ObjectVerdict:
    """What was found of one object. Lengths in metres, errors found − expected.

    focus : depth, front and rear, curve, tiles
    depth_error : of the cells of the scene's map together, else of the intensity-weighted mean
    lateral_error : (x, y) of the centroid
    depth_tolerance, lateral_tolerance : what it is held against, metres
    shape : against the scene's map of light; None where the video has none
    light : share of the frame's light that is this object's; None where the video has no map
    shares : what the scene says of that; an object that is outshone cannot be judged
    contrast, snr (dB), speckle_contrast : at the found depth (`reconstruct.metrics`)
    psnr (dB), ssim : against the reconstruction of the truth; None when that was not asked for
    metric_depths : where published metrics of the whole region peak, when asked for; they lean
        towards where points crowd, and do not count for `passed`
    """

    name: str
    target: Target
    focus: Focus
    depth_error: float
    lateral_error: tuple[float, float]
    depth_tolerance: float
    lateral_tolerance: float
    shape: Likeness | None = None
    light: float | None = None
    shares: Shares = NOTHING
    contrast: float = float("nan")
    snr: float = float("nan")
    speckle_contrast: float = float("nan")
    psnr: float | None = None
    ssim: float | None = None
    metric_depths: dict[str, float] = field(default_factory=dict)

    @property
    def judged(self) -> bool:
        """Whether it has light enough to be judged by."""
        return not self.shares.too_little

    @property
    def passed(self) -> bool:
        """In focus where the scene says, and shaped as the scene says as far as can be told."""
        return not self.faults

    @property
    def faults(self) -> list[str]:
        """What is wrong, each in a few words; nothing of an object that cannot be judged."""
        if not self.judged:
            return []
        if not self.focus.focused:
            return ["nothing comes into focus there"]
        found = []
        if not abs(self.depth_error) <= self.depth_tolerance:
            found.append(f"depth is {self.depth_error * 1e3:+.2f} mm off")
        if not hypot(*self.lateral_error) <= self.lateral_tolerance:
            found.append(f"{hypot(*self.lateral_error) * 1e6:.0f} µm off sideways")
        return found + (self.shape.faults if self.shape is not None else [])

    def as_dict(self) -> dict[str, Any]:
        """Plain figures for JSON; what was not found is null."""
        figures: dict[str, Any] = {
            "name": self.name,
            "passed": self.passed,
            "judged": self.judged,
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
            "light": self.light,
            "contrast": self.contrast,
            "snr": self.snr,
            "speckle_contrast": self.speckle_contrast,
            "shape": None if self.shape is None else self.shape.as_dict(),
            "faults": self.faults,
            "psnr": self.psnr,
            "ssim": self.ssim,
            "metric_depths": self.metric_depths,
            "curve": {
                "depths": self.focus.depths.tolist(),
                "sharpness": self.focus.curve.tolist(),
            },
        }
        return {key: _finite(value) for key, value in figures.items()}


@dataclass(frozen=True)
class FrameVerdict:
    """All objects of one frame; an empty frame passes.

    least_light : share of the light that must be the objects', where that is known
    wavelength : metres, of a video in colours
    """

    number: int
    objects: list[ObjectVerdict] = field(default_factory=list)
    least_light: float = 0.0
    wavelength: float | None = None

    @property
    def passed(self) -> bool:
        """Every object is in focus where the scene says, and most of the light is theirs."""
        return all(o.passed for o in self.objects) and not self.faults

    @property
    def light(self) -> float | None:
        """Share of the light that belongs to the objects; None where it cannot be told."""
        shares = [o.light for o in self.objects if o.light is not None]
        return sum(shares) if shares and len(shares) == len(self.objects) else None

    @property
    def faults(self) -> list[str]:
        """What is wrong with the frame as a whole."""
        if self.objects and not any(o.judged for o in self.objects):
            return ["no object has light enough of its own to be judged"]
        if self.light is None or self.light >= self.least_light:
            return []
        return [f"only {self.light:.0%} of the light belongs to the objects: noise"]


def _finite(value: Any) -> Any:
    """JSON has no NaN and no infinity."""
    if isinstance(value, dict):
        return {k: _finite(v) for k, v in value.items()}
    if isinstance(value, list):
        return [_finite(v) for v in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def judge_object(
    field_: NDArray[np.complex64],
    system: FourF,
    target: Target,
    pixel_pitch: float,
    depth_tolerance: float | None = None,
    lateral_tolerance: float | None = None,
    truth: NDArray[np.complexfloating] | None = None,
    with_metrics: bool = False,
    shares: Shares = NOTHING,
) -> ObjectVerdict:
    """Verdict on one object from a decoded field.

    field_ : (H, W) from `system.field(frame)`
    pixel_pitch : of the scene, metres
    depth_tolerance : metres, default 0.5 mm, or half the depth of focus where that is more, and
        two standard errors where the depth is told by a few tiles or by the rim
    lateral_tolerance : metres, default a scene pixel, or a resolution or an eighth of a
        cell of the map where that is more; a quarter of its size more where it has no shape
    truth : (H, W) field of the scene itself, for PSNR and SSIM
    with_metrics : also find where published focus metrics peak
    shares : what part of the light is the target's, as the scene has it
    """
    total = power(field_)
    stack, tile, parts = target_stack(field_, system, target, pixel_pitch)
    x, y, z = (float(v) for v in target.position)
    ends = (float(stack.depths[0]), float(stack.depths[-1]))
    lit_by = brightness(stack.patch, system.slm, system.wavelength, ends, system.band)
    fine = float(np.mean(resolution(system.slm, system.wavelength, z, system.band)))
    coarse, finer = search_scale(target, system)
    focus = find_focus(stack, tile, lit_by, max(1.0, fine / stack.patch.pitch))
    limit = max(DEPTH_TOLERANCE, coarse / 2) if depth_tolerance is None else depth_tolerance
    shape, share, cell, error = None, None, 0.0, focus.error
    if target.light is not None:
        cell = target.light.cell
        # What the panel does not show of a cell is no fault of the picture: less is expected there.
        seen = dimmed(target.light, brightness_at(stack, lit_by, stack.index(z)))
        cells = cells_of(stack, parts)
        shape = compare(cells, seen, coarse, finer)
        off, scatter = float("nan"), float("inf")
        # Speckle has peaks of its own, up to twice what counts as a focus; and cells with light at
        # two depths have two peaks.
        unclear = focus.method == "region" or 0 < shape.sharpness < 2 * SHARP
        unclear |= 2 * shape.depth_scatter > limit
        if unclear and shape.picture >= ALIKE:
            off, scatter = spill_error(stack, seen, system)
        # Whichever of the two tells the depth more surely, by its own standard error.
        if np.isfinite(off) and (scatter <= shape.depth_scatter or shape.sharpness < SHARP):
            focus = replace(focus, depth=z + off, focused=True, method="rim")
            error = min(scatter, limit / 2)
        elif shape.sharpness >= SHARP:
            focus = replace(focus, depth=z + shape.depth_error, focused=True, method="cells")
            error = 0.0
    depth_error = focus.depth - z
    if shape is not None and total > 0:
        light = light_of(cells, seen, np.nan_to_num(depth_error))
        share = light * (stack.patch.pitch / system.slm.pixel_pitch) ** 2 / total
    lateral = (focus.position[0] - x, focus.position[1] - y)
    sideways = max(pixel_pitch, fine, cell / 8)
    if shape is not None and shape.told:
        lateral = shape.lateral_error
    elif shape is not None:  # a speck is a few speckles, some brighter by chance
        sideways += float((target.high - target.low)[:2].max()) / 4
    found = ObjectVerdict(
        target.name,
        target,
        focus,
        depth_error,
        lateral,
        depth_tolerance=limit + (2 * error if depth_tolerance is None else 0.0),
        lateral_tolerance=sideways if lateral_tolerance is None else lateral_tolerance,
        shape=shape,
        light=share,
        shares=shares,
    )
    return replace(found, **_figures(found, stack, system, truth, with_metrics))


def _figures(
    found: "ObjectVerdict",
    stack: FocalStack,
    system: FourF,
    truth: NDArray[np.complexfloating] | None,
    with_metrics: bool,
) -> dict[str, Any]:
    """What the picture at the found depth measures."""
    target, depth = found.target, found.focus.depth
    shown = depth if np.isfinite(depth) else float(target.position[2])
    index = int(np.argmin(np.abs(stack.depths - shown)))
    plane, lit = stack.intensity[index], inside(stack.patch, target)
    figures: dict[str, Any] = {
        "contrast": metrics.contrast(plane, lit, ~lit),
        "snr": metrics.snr(plane, lit, ~lit),
        "speckle_contrast": metrics.speckle_contrast(plane, lit),
    }
    if truth is not None:
        field_ = np.asarray(truth, dtype=np.complex64)
        at = stack.depths[[index]]
        true_plane = focal_stack(
            field_, system.slm, system.wavelength, at, stack.patch, system.band
        ).intensity[0]
        level = plane * metrics.scale_to(plane, true_plane)
        figures |= {"psnr": psnr(level, true_plane), "ssim": ssim(level, true_plane)}
    if with_metrics:
        peaks = {n: refine_peak(stack.depths, focus_curve(stack, n)) for n in METRICS}
        figures["metric_depths"] = peaks
    return figures


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
    depth_tolerance: float | None = None,
    lateral_tolerance: float | None = None,
    with_metrics: bool = False,
) -> FrameVerdict:
    """Verdict on every target of one frame of grey levels; one filter pass for all of them."""
    field_ = system.field(frame)
    judged = [
        judge_object(
            field_, system, target, pixel_pitch, depth_tolerance, lateral_tolerance, truth,
            with_metrics, shares,
        )
        for target, shares in zip(targets, shares_of(targets, system), strict=True)
    ]  # fmt: skip
    return FrameVerdict(number, judged, least_light(targets, system))
