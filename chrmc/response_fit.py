"""A panel's grey response from noisy readings: a monotone curve, its uncertainty, and a map.

The curve is a cubic spline whose coefficients rise (sums of B-splines with weights ≥ 0, Ramsay,
Statist. Sci. 3, 425, 1988), with as many pieces as generalised cross validation wants. Its
uncertainty is the spread of the curves that readings with turned residuals give (wild bootstrap).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.files import replacing
from chrmc.ranges import WAVELENGTH_RANGE
from chrmc.response import LEVELS, GreyResponse
from chrmc.response_map import TERMS, basis

PIECES = (3, 5, 8, 12, 18)
DARKEST, BRIGHTEST = 1e-30, 1e30
"""Of a reading, in whatever unit."""
DRAWS = 100
SEED = 20180103


@dataclass(frozen=True, eq=False)
class ResponseFit:
    """A fitted response.

    grey, readings : (n,) what was shown and the panel's mean intensity read, any unit
    intensity, uncertainty : (256,) the curve at grey 0 … 255 and its standard deviation
    tilt : (256, terms) how intensity varies over the panel (`chrmc.response_map`), or None
    wavelength : metres, of the laser; None where nobody said
    """

    grey: NDArray[np.float64]
    readings: NDArray[np.float64]
    intensity: NDArray[np.float64]
    uncertainty: NDArray[np.float64]
    tilt: NDArray[np.float64] | None = None
    wavelength: float | None = None

    def __post_init__(self) -> None:
        if self.wavelength is not None:
            object.__setattr__(self, "wavelength", WAVELENGTH_RANGE.of(self.wavelength))

    @cached_property
    def response(self) -> GreyResponse:
        """As encodings take it."""
        peak = float(self.intensity.max())
        tilt = None if self.tilt is None else self.tilt / peak
        levels = np.sqrt(self.intensity / peak) + 0j
        return GreyResponse(levels, "measured", tilt, self.wavelength)

    def write(self, path: str | Path) -> Path:
        """The CSV table that --response takes, whole or not at all."""
        target = Path(path)
        if target.suffix.lower() != ".csv":
            raise ValueError(f"{target}: a response is written as .csv")
        tilt = np.zeros((LEVELS, 0)) if self.tilt is None else self.tilt
        names = ["grey", "intensity", "uncertainty", *TERMS[: tilt.shape[1]]]
        rows = np.column_stack([np.arange(LEVELS), self.intensity, self.uncertainty, tilt])
        lines = [",".join(names)]
        if self.wavelength is not None:
            lines.insert(0, f"# wavelength {self.wavelength * 1e9:.9g} nm")
        lines += [f"{row[0]:.0f}," + ",".join(f"{v:.8g}" for v in row[1:]) for row in rows]
        with replacing(target) as partial:
            partial.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return target


def fit_response(grey: Sequence[float], readings: Sequence[Any], degree: int = 0) -> ResponseFit:
    """The response behind readings of a panel that showed one grey level at a time.

    grey : (n,) levels 0 … 255, each as often as it was read, in any order
    readings : an intensity each; or (h, w) pictures of the panel, whole and upright, of one shape
    degree : 0 for one curve; 1 or 2 for a map, a polynomial in x and y at each level (of pictures)

    Raises ValueError for too few levels, or readings that do not vary or are not finite.
    """
    if degree not in (0, 1, 2):
        raise ValueError(f"the degree of a map is 1 or 2, or 0 for none, not {degree}")
    at = np.asarray(grey, dtype=np.float64)
    pictures = [np.asarray(r, dtype=np.float64) for r in readings]
    if at.ndim != 1 or len(at) != len(pictures):
        raise ValueError(f"{len(at)} levels and {len(pictures)} readings: one is needed for each")
    if len(at) and not ((at >= 0) & (at < LEVELS)).all():
        raise ValueError(f"grey levels lie in 0 … {LEVELS - 1}, not {at.min():g} … {at.max():g}")
    if len(np.unique(at)) < 5 or at.min() > 16 or at.max() < LEVELS - 1 - 16:
        raise ValueError(
            f"readings at {len(np.unique(at))} levels are too few: 5 or more, spread over 0 … 255"
        )
    shapes = {p.shape for p in pictures}
    if len(shapes) > 1 or len(next(iter(shapes))) not in (0, 2):
        raise ValueError(f"readings must be numbers, or (h, w) pictures of one shape, not {shapes}")
    if degree and next(iter(shapes)) == ():
        raise ValueError("a map needs pictures of the panel, not single numbers")
    if not all(p.size and np.isfinite(p).all() for p in pictures):
        raise ValueError("readings must be finite numbers, or pictures of some pixels")
    # The brightest of all pixels: what it may be, sums and squares may be too.
    top = max(float(np.max(p)) for p in pictures)
    if not DARKEST <= top <= BRIGHTEST or min(float(np.min(p)) for p in pictures) < -top:
        raise ValueError(
            f"the brightest reading is {top:g}: it must lie between {DARKEST:g} and "
            f"{BRIGHTEST:g}, and outweigh negative ones; take another unit, or less dark current"
        )
    values = np.array([p.mean() for p in pictures])
    size = float(np.ptp(values))
    if not size > 1e-12 * float(np.abs(values).max()):
        raise ValueError("all readings are alike: does the panel modulate, does the camera see it?")
    rising = float(np.corrcoef(at, values)[0, 1]) >= 0
    x = at / (LEVELS - 1) if rising else 1 - at / (LEVELS - 1)
    every = np.linspace(0, 1, LEVELS) if rising else np.linspace(1, 0, LEVELS)
    pieces = min(PIECES, key=lambda p: _validation(x, values, p))
    curve, fitted = _monotone(x, values, pieces, every)
    rng = np.random.default_rng(SEED)
    # Residuals of a fit are smaller than the errors by the share of freedom that it took.
    residual = (values - fitted) * np.sqrt(len(values) / max(len(values) - pieces - 3, 1))
    drawn = [
        _monotone(x, fitted + residual * rng.choice((-1.0, 1.0), len(x)), pieces, every)[0]
        for _ in range(DRAWS)
    ]
    spread = np.std(drawn, axis=0)
    tilt = _tilt(at, pictures, degree) if degree else None
    return ResponseFit(at, values, curve, spread, tilt)


def _design(x: NDArray[np.float64], pieces: int) -> NDArray[np.float64]:
    """(n, pieces + 3) functions that rise from 0 to 1, the first one 1 everywhere."""
    from scipy.interpolate import BSpline

    knots = np.concatenate([np.zeros(3), np.linspace(0, 1, pieces + 1), np.ones(3)])
    bumps = BSpline.design_matrix(np.clip(x, 0, 1), knots, 3).toarray()
    return np.asarray(np.cumsum(bumps[:, ::-1], axis=1)[:, ::-1])


def _monotone(
    x: NDArray[np.float64], values: NDArray[np.float64], pieces: int, at: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The rising curve through values at x: at `at`, and at x."""
    from scipy.optimize import nnls

    design = _design(x, pieces)
    top = float(np.abs(values).max())
    weights = nnls(design, values / top)[0] * top
    return _design(at, pieces) @ weights, design @ weights


def _validation(x: NDArray[np.float64], values: NDArray[np.float64], pieces: int) -> float:
    free = len(x) - (pieces + 3)
    if free <= 0 or pieces + 3 > len(np.unique(x)):
        return float("inf") if pieces > PIECES[0] else 0.0
    _, fitted = _monotone(x, values, pieces, x)
    return float(np.sum((values - fitted) ** 2)) * len(x) / free**2


def _tilt(
    at: NDArray[np.float64], pictures: Sequence[NDArray[np.float64]], degree: int
) -> NDArray[np.float64]:
    """(256, terms) coefficients, smooth along the levels."""
    from scipy.interpolate import make_lsq_spline

    rows, columns = pictures[0].shape
    functions = basis(
        (np.arange(rows) + 0.5) / rows * 2 - 1, (np.arange(columns) + 0.5) / columns * 2 - 1, degree
    )
    flat = np.concatenate([np.ones((1, rows * columns)), functions.reshape(len(functions), -1)])
    solve = np.linalg.pinv(flat.T)
    found = np.array([(solve @ picture.ravel())[1:] for picture in pictures])
    levels = np.unique(at)
    means = np.array([found[at == level].mean(axis=0) for level in levels])
    pieces = max(1, min(6, len(levels) // 3))
    inner = np.linspace(levels[0], levels[-1], pieces + 1)[1:-1]
    knots = np.concatenate([[levels[0]] * 4, inner, [levels[-1]] * 4])
    spline = make_lsq_spline(levels, means, knots, k=3)
    return np.asarray(spline(np.clip(np.arange(LEVELS), levels[0], levels[-1])))
