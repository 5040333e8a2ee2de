"""What the eye would say of a compensated hologram: its images against the recomputed one's.

Both fields are shown at each object's depth, as light and not as grey levels, and compared on the
object's own area: PSNR and SSIM of the intensity, the centroid's shift, and best focus.
"""

from collections.abc import Callable
from functools import partial
from math import ceil, floor
from sys import maxsize
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.kept import Kept
from chrmc.metrics import psnr, ssim
from chrmc.optics.propagation import padded_shape, propagate, transfer_function
from chrmc.scene.scene import ObjectFrame, SceneFrame
from chrmc.slm import SLM
from chrmc.window import Window

BEST_PSNR = 120.0
"""dB given to equal images."""
MARGIN = 12
"""Pixels around an object's points that belong to its image."""
FOCUS_RANGE = 1.5e-3
"""Best focus is looked for within so many metres of an object's depth."""
_PLANE = 4e-3  # spacing of the depths whose transfer functions are kept, metres
_FOCUS_STEPS = 13
_ROOM = 28  # pixels around an image into which it may defocus


def image_measures(
    slm: SLM, wavelength: float
) -> Callable[[NDArray[np.complex64], NDArray[np.complex64], SceneFrame], dict[str, Any]]:
    """The function (field, recomputed field, scene frame) → object name → measures.

    Measures per object: psnr (dB), ssim, shift_x, shift_y (m, centroid against the recomputed
    image's), focus (m, depth of best focus), focus_shift (m, against the recomputed field's).
    Objects without light are left out.
    """
    kept = Kept(limit=maxsize, most=4)

    def image(field: NDArray[np.complex64], part: Window, depth: float) -> NDArray[np.complex64]:
        """Field near the object: on a kept plane first, then the crop to the depth itself."""
        plane = round(depth / _PLANE) * _PLANE
        grid = padded_shape(field.shape, slm.pixel_pitch, wavelength, plane)
        optics = grid, slm.pixel_pitch, wavelength, -plane
        transfer = kept.get(optics, partial(transfer_function, *optics))
        whole = propagate(field, slm.pixel_pitch, wavelength, -plane, transfer=transfer)
        crop = whole[part.slices]
        return propagate(crop, slm.pixel_pitch, wavelength, plane - depth)

    def measure(
        field: NDArray[np.complex64], again: NDArray[np.complex64], scene_frame: SceneFrame
    ) -> dict[str, Any]:
        out = {}
        for obj in scene_frame.objects:
            if not obj.cloud.amplitude.any():
                continue
            part, inner = _area(obj, slm)
            if part.size == 0:
                continue
            a, b = (image(f, part, obj.depth) for f in (field, again))
            out[obj.name] = _compare(a, b, inner, slm, wavelength, obj.depth)
        return out

    return measure


def _area(obj: ObjectFrame, slm: SLM) -> tuple[Window, tuple[slice, slice]]:
    """The window that holds an object and its defocus, and the object's part of that window."""
    spans, inner = [], []
    for axis, count in ((1, slm.height), (0, slm.width)):
        at = obj.cloud.positions[:, axis] / slm.pixel_pitch + (count - 1) / 2
        low = max(0, floor(at.min()) - MARGIN)
        high = min(count, ceil(at.max()) + MARGIN + 1)
        if high <= low:
            return Window(0, 0, 0, 0), (slice(0), slice(0))
        first, last = max(0, low - _ROOM), min(count, high + _ROOM)
        spans.append((first, last))
        inner.append(slice(low - first, high - first))
    return Window(*spans[0], *spans[1]), (inner[0], inner[1])


def _compare(
    a: NDArray[np.complex64],
    b: NDArray[np.complex64],
    inner: tuple[slice, slice],
    slm: SLM,
    wavelength: float,
    depth: float,
) -> dict[str, float]:
    images = [np.abs(f[inner]).astype(np.float64) ** 2 for f in (a, b)]
    shift = _centroid(images[0]) - _centroid(images[1])
    focus = [_best_focus(f, inner, slm, wavelength, depth) for f in (a, b)]
    return {
        "psnr": min(BEST_PSNR, psnr(images[0], images[1])),
        "ssim": ssim(images[0], images[1]),
        "shift_x": float(shift[1] * slm.pixel_pitch),
        "shift_y": float(shift[0] * slm.pixel_pitch),
        "focus": focus[0],
        "focus_shift": focus[0] - focus[1],
    }


def _centroid(image: NDArray[np.float64]) -> NDArray[np.float64]:
    """(row, column) of the intensity's mean."""
    total = max(float(image.sum()), 1e-300)
    rows, columns = np.arange(image.shape[0]), np.arange(image.shape[1])
    return np.array([image.sum(axis=1) @ rows, image.sum(axis=0) @ columns]) / total


def _best_focus(
    field: NDArray[np.complex64],
    inner: tuple[slice, slice],
    slm: SLM,
    wavelength: float,
    depth: float,
) -> float:
    """Depth where the light is most concentrated, ΣI²/(ΣI)², refined by a parabola, metres."""
    offsets = np.linspace(-FOCUS_RANGE, FOCUS_RANGE, _FOCUS_STEPS)
    sharpness = np.empty(len(offsets))
    for k, offset in enumerate(offsets):
        light = np.abs(propagate(field, slm.pixel_pitch, wavelength, -offset)[inner]) ** 2
        sharpness[k] = np.sum(light**2, dtype=np.float64) / max(float(np.sum(light)) ** 2, 1e-300)
    best = int(np.clip(np.argmax(sharpness), 1, len(offsets) - 2))
    left, top, right = sharpness[best - 1 : best + 2]
    bend = left - 2 * top + right
    move = 0.5 * (left - right) / bend if bend < 0 else 0.0
    return float(depth + offsets[best] + np.clip(move, -1, 1) * (offsets[1] - offsets[0]))
