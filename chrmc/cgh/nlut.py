"""Novel look-up table: each point's fringe is the shifted fringe of its depth plane.

Kim and Kim, Appl. Opt. 47, D55 (2008): one principal fringe pattern (PFP) per depth plane, the
others by shift and add. Here the PFPs are complex and exact, made for the depth planes that the
points use and no others, and only the part of a fringe that meets the window is touched.

RGB-D points whose scene pixels are a whole number of SLM pixels lie on the grid: shift and add is
exact. For others the method's own error is large, and `subpixel` says what to do about it.
"""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.counts import OperationCounts
from chrmc.cgh.method import CGHMethod
from chrmc.cgh.pfp import (
    DEPTH_SETTINGS,
    DEPTH_STEP,
    FORMS,
    PFPTable,
    Placed,
    axis_factors,
    placed_waves,
    quadrant,
)
from chrmc.optics.footprint import coverage, reach
from chrmc.optics.passband import Passband
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM
from chrmc.threads import workers
from chrmc.window import Window

_BLOCK = 1 << 16  # pixels a thread works on at once, so that sums stay in its cache
_CHUNK = 128  # points whose correction factors are held at once


def field(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    window: Window,
    passband: Passband,
    *,
    depth_step: float | None = DEPTH_STEP,
    subpixel: str = "exact",
    pfp: str = "spherical",
    cache: PFPTable | None = None,
) -> NDArray[np.complex64]:
    """Field on the window by shifted principal fringe patterns.

    depth_step : metres between depth planes; None gives each depth its own
    subpixel : for points between pixels or planes, "exact": shifted PFP times a tilt and a thin
        lens per axis; "round": the nearest pixel and plane (the constant exp(ikz) stays the
        point's), as NLUT was published
    pfp : "spherical", or "fresnel" for the paraxial PFP
    cache : PFPs kept from call to call, with a memory cap

    Relative error at 250 mm, 8.1 µm, planes of 0.1 mm: points on pixels and planes 1e-6; others
    "exact" 6e-5 (what is not separable in the correction; it grows as (λ/pitch)²), "round" 0.45.
    "fresnel" adds the paraxial error, about 0.16.
    """
    if pfp not in FORMS:
        raise ValueError(f"pfp must be one of {', '.join(FORMS)}, not {pfp!r}")
    table = PFPTable() if cache is None else cache
    out = np.zeros(window.shape, dtype=np.complex64)
    everything = Placed.of(cloud, slm, wavelength, depth_step, subpixel)
    order = np.lexsort((everything.shift_only, everything.plane))
    rows = max(1, _BLOCK // max(1, window.shape[1]))
    blocks = [
        (first, min(first + rows, window.row1)) for first in range(window.row0, window.row1, rows)
    ]
    changes = np.flatnonzero(
        (np.diff(everything.plane[order]) != 0) | (np.diff(everything.shift_only[order]) != 0)
    )
    extent = everything.extent(slm, wavelength, passband)
    with ThreadPoolExecutor(workers()) as pool:
        for group in np.split(order, changes + 1):
            first = everything.select(group[:1])
            pattern = quadrant(
                table,
                slm,
                wavelength,
                float(first.plane[0]),
                passband,
                extent,
                pfp,
                bool(first.shift_only[0]),
            )
            for start in range(0, len(group), _CHUNK):
                part = everything.select(group[start : start + _CHUNK])
                fringes = _Fringes(part, slm, wavelength, window, passband, pfp)
                for done in [pool.submit(fringes.add, block, pattern, out) for block in blocks]:
                    done.result()
    return out


class _Fringes:
    """Points of one plane, with what the shifted PFP is multiplied by and where it lies."""

    def __init__(
        self,
        placed: Placed,
        slm: SLM,
        wavelength: float,
        window: Window,
        passband: Passband,
        form: str,
    ) -> None:
        self.placed = placed
        self.window = window
        spans = []
        for axis, pixels, f_max in (
            (0, window.rows, passband.fy_max),
            (1, window.columns, passband.fx_max),
        ):
            slope = reach(wavelength, f_max)
            spans.append([placed.span(j, axis, pixels, slope, slm) for j in range(len(placed))])
        self.row_spans, self.column_spans = spans
        self.factors: tuple[NDArray[np.complex64], NDArray[np.complex64]] | None = None
        if not placed.shift_only[0]:
            in_y = axis_factors(placed, 0, window.rows, slm, wavelength, passband.fy_max, form)
            in_y *= placed.factor[:, None]
            in_x = axis_factors(placed, 1, window.columns, slm, wavelength, passband.fx_max, form)
            self.factors = in_y, in_x

    def add(
        self, block: tuple[int, int], pattern: NDArray[np.complex64], out: NDArray[np.complex64]
    ) -> None:
        """Add all fringes to the rows block[0] … block[1] − 1 of the window's field `out`."""
        row0, column0 = self.window.row0, self.window.column0
        scratch = np.empty((block[1] - block[0]) * self.window.shape[1], dtype=np.complex64)
        for j in range(len(self.placed)):
            row, column = self.placed.index[j]
            low, high = self.row_spans[j]
            for r0, r1, from_rows in _halves(max(low, block[0]), min(high, block[1]), row):
                for c0, c1, from_columns in _halves(*self.column_spans[j], column):
                    shape = (r1 - r0, c1 - c0)
                    fringe = scratch[: shape[0] * shape[1]].reshape(shape)
                    source = pattern[from_rows, from_columns]
                    if self.factors is None:
                        np.multiply(source, self.placed.factor[j], out=fringe)
                    else:
                        in_y, in_x = self.factors
                        np.multiply(source, in_x[j, c0 - column0 : c1 - column0], out=fringe)
                        fringe *= in_y[j, r0 - row0 : r1 - row0, None]
                    out[r0 - row0 : r1 - row0, c0 - column0 : c1 - column0] += fringe


def _halves(low: int, high: int, centre: int) -> Iterator[tuple[int, int, slice]]:
    """The pixels low … high − 1 before the centre and from it on, with slices of a quadrant."""
    before, after = min(high, centre), max(low, centre)
    if low < before:
        yield low, before, slice(centre - low, centre - before, -1)
    if after < high:
        yield after, high, slice(after - centre, high - centre)


def cost(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    window: Window,
    passband: Passband,
    *,
    depth_step: float | None = DEPTH_STEP,
    subpixel: str = "exact",
    **_: object,
) -> OperationCounts:
    """A look-up for each point and pixel of its footprint; PFPs too where the table forgets."""
    placed = Placed.of(cloud, slm, wavelength, depth_step, subpixel)
    share = coverage(cloud, slm, wavelength, passband)
    each = np.where(placed.shift_only, 1.3, 2.1)
    extent = placed.extent(slm, wavelength, passband)
    planes = len(np.unique(placed.plane))
    held = 8.0 * planes * extent[0] * extent[1]
    built = float(planes * extent[0] * extent[1]) if held > PFPTable().limit else 0.0
    return OperationCounts(
        lookups=float(share @ each) * window.size,
        phasors=4 * built + 5.0 * len(cloud) * sum(window.shape),
        bytes=40.0 * window.size,
        calls=float(np.sum(6 + 34 * share)) * window.size / _BLOCK + 100.0 * planes,
        memory=8.0 * window.size + min(held, float(PFPTable().limit)),
    )


def waves(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    rows: NDArray[np.intp],
    columns: NDArray[np.intp],
    passband: Passband,
    *,
    depth_step: float | None = DEPTH_STEP,
    subpixel: str = "exact",
    pfp: str = "spherical",
    **_: object,
) -> NDArray[np.complex128]:
    """Each point's shifted PFP at pixels of its own, (N, K)."""
    placed = Placed.of(cloud, slm, wavelength, depth_step, subpixel)
    return placed_waves(placed, slm, wavelength, rows, columns, passband, pfp)


METHOD = CGHMethod(
    field, cost=cost, waves=waves, rounding=3e-7, new_cache=PFPTable, settings=DEPTH_SETTINGS
)
