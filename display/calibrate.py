"""A panel's grey response measured in a closed loop: show a level, take its light, go on."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.progress import progress
from chrmc.ranges import WAVELENGTH_RANGE, Count, Range, short
from chrmc.response import LEVELS
from chrmc.response_fit import SEED, ResponseFit, fit_response
from display.screen import Screen

STEPS, REPEATS = Count("steps", 5, LEVELS), Count("repeats", 1, 10_000)
SETTLE = Range("settle", 0.0, 60.0, unit="s")
Measure = Callable[[int], Any]
"""grey → what is measured while it is on: an intensity, or an (h, w) picture of the panel."""


def calibrate_response(
    screen: Screen,
    measure: Measure,
    *,
    steps: int = 33,
    repeats: int = 4,
    settle: float = 0.1,
    degree: int = 0,
    wavelength: float | None = None,
) -> ResponseFit:
    """Show uniform grey levels, measure each, and fit the response.

    screen : of the panel
    measure : called with each level once it is on; an intensity in any unit, or for a map a picture
        of the panel alone, whole and upright, (h, w)
    steps : levels from 0 to 255; repeats : times that each is shown. Every repeat goes through them
        in another order, so that a laser that drifts does not bend the curve
    settle : seconds between the flip and the measurement, for the liquid crystal and the camera
    degree : of the map over the panel, 1 or 2; 0 for none
    wavelength : metres, of the laser, kept with the response so that it is not taken for another's
    """
    steps, repeats, settle = STEPS.of(steps), REPEATS.of(repeats), SETTLE.of(settle)
    if wavelength is not None:
        wavelength = WAVELENGTH_RANGE.of(wavelength)
    if degree not in (0, 1, 2):
        raise ValueError(f"the degree of a map is 1 or 2, or 0 for none, not {short(degree)}")
    if screen.slm.kind == "binary":
        raise ValueError(f"{screen.slm.name} is either dark or bright: it has no grey response")
    levels = np.rint(np.linspace(0, LEVELS - 1, steps)).astype(int)
    rng = np.random.default_rng(SEED)
    order = np.concatenate([rng.permutation(levels) for _ in range(repeats)])
    readings = []
    for grey in progress(order.tolist(), "levels", unit="level"):
        screen.show(np.full(screen.slm.shape, grey, dtype=np.uint8), f"grey {grey}")
        time.sleep(settle)
        try:
            readings.append(np.asarray(measure(grey), dtype=np.float64))
        except (TypeError, ValueError) as error:
            raise ValueError(f"measuring grey {grey} gave no number or picture: {error}") from None
    return replace(fit_response(order.tolist(), readings, degree), wavelength=wavelength)


@contextmanager
def camera(
    source: int | str, region: tuple[int, int, int, int] | None = None, pictures: int = 4
) -> Iterator[Measure]:
    """A camera that OpenCV knows, as a `Measure`; needs OpenCV (chrmc[camera]).

    source : number of the camera, or what OpenCV opens by name: a device, a stream, a recording
    region : x, y, width, height of the panel in its pictures
    pictures : that are averaged; as many before them are thrown away, being older than the flip

    Switch automatic exposure and gamma off, in the camera's own program if it must be: grey must be
    proportional to light, and 255 not reached.
    """
    try:
        cv2: Any = import_module("cv2")
    except ImportError:
        raise OSError("a camera needs OpenCV: pip install 'chrmc[camera]'") from None
    with suppress(AttributeError):  # what is wrong is said below
        cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    device = cv2.VideoCapture(source)
    try:
        if not device.isOpened():
            raise OSError(f"there is no camera {source}")
        yield lambda grey: _taken(device, region, pictures)
    finally:
        device.release()


def _taken(
    device: Any, region: tuple[int, int, int, int] | None, pictures: int
) -> NDArray[np.float64]:
    frames = []
    for count in range(2 * pictures):
        there, frame = device.read()
        if not there:
            raise OSError("the camera gave no picture")
        if count >= pictures:
            frames.append(np.asarray(frame, dtype=np.float64))
    mean = np.mean(frames, axis=0)
    mean = mean.mean(axis=2) if mean.ndim == 3 else mean
    if region is not None:
        x, y, width, height = region
        mean = mean[y : y + height, x : x + width]
        if mean.shape != (height, width):
            raise ValueError(f"the region reaches beyond the camera's {frame.shape[:2]} pixels")
    if mean.max() >= 254:
        raise ValueError("the camera is overexposed: it reaches 255; shorten its exposure")
    return np.asarray(mean)
