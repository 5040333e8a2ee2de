"""The float64 truth that every error is measured against: a sum of spherical waves.

U(q) = Σ_j w_j(q)·a_j/r_j·exp(+i(k·r_j + φ_j)), r_j = |q − P_j|, w_j the soft footprint.
Slow and plain on purpose.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from chrmc.optics.footprint import check_showable, reach, taper
from chrmc.optics.passband import UNLIMITED, Passband, full_band
from chrmc.ranges import WAVELENGTH_RANGE
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM

_BLOCK = 1 << 21  # complex values held at once
_FEWEST = 1 << 15  # below which calls cost more than the values


def resolve_passband(slm: SLM, footprint: str | None, passband: Passband | None) -> Passband:
    """The passband meant by a footprint argument: "soft" (default full band) or None (bare)."""
    if footprint is None:
        return UNLIMITED
    if footprint != "soft":
        raise ValueError(f'footprint must be "soft" or None, not {footprint!r}')
    return full_band(slm) if passband is None else passband


def reference_field(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    rows: ArrayLike | None = None,
    columns: ArrayLike | None = None,
    footprint: str | None = "soft",
    passband: Passband | None = None,
) -> NDArray[np.complex128]:
    """Exact field on the grid of the given rows and columns.

    cloud : points, z > 0
    wavelength : metres
    rows, columns : index arrays, default all
    footprint : "soft" as in `chrmc.optics.footprint`, or None for bare spherical waves
    passband : what the footprint ends at, default the SLM's full band

    Returns (len(rows), len(columns)) complex128. Raises ValueError for points behind the
    hologram or that no pixel can show.
    """
    row_index = np.arange(slm.height) if rows is None else np.atleast_1d(np.asarray(rows))
    column_index = np.arange(slm.width) if columns is None else np.atleast_1d(np.asarray(columns))
    grid = np.broadcast_arrays(row_index[:, None], column_index[None, :])
    return reference_samples(cloud, slm, wavelength, grid[0], grid[1], footprint, passband)


def reference_samples(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    rows: NDArray[np.integer],
    columns: NDArray[np.integer],
    footprint: str | None = "soft",
    passband: Passband | None = None,
) -> NDArray[np.complex128]:
    """Exact field at single pixels: rows and columns of one shape, which the result has too."""
    wavelength = WAVELENGTH_RANGE.of(wavelength)
    band = resolve_passband(slm, footprint, passband)
    check_showable(cloud, slm, wavelength, band)
    x, y = slm.x(columns).ravel(), slm.y(rows).ravel()
    field = np.zeros(x.size, dtype=np.complex128)
    half_x, half_y = reach(wavelength, band.fx_max), reach(wavelength, band.fy_max)
    points = max(1, min(len(cloud), max(64, _FEWEST // max(1, x.size))))
    pixels = max(1, _BLOCK // points)
    for p0 in range(0, x.size, pixels):
        part = slice(p0, p0 + pixels)
        for j0 in range(0, len(cloud), points):
            xj, yj, zj = (c[:, None] for c in cloud.positions[j0 : j0 + points].T)
            dx, dy = x[part] - xj, y[part] - yj
            weight = taper(dx, zj * half_x) * taper(dy, zj * half_y)
            aside = dx**2 + dy**2
            distance = np.sqrt(aside + zj**2)
            # r = z + ρ²/(r + z), and whole turns out of each: far away, waves that all but cancel
            # differ in digits that r itself has not.
            cycles = aside / (distance + zj) / wavelength
            cycles -= np.rint(cycles)
            along = zj / wavelength
            cycles += along - np.rint(along)
            phase = 2 * np.pi * cycles + cloud.phase[j0 : j0 + points, None]
            amplitude = cloud.amplitude[j0 : j0 + points, None] * weight / distance
            field[part] += np.sum(amplitude * np.exp(1j * phase), axis=0)
    return field.reshape(np.shape(rows))


def true_waves(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    rows: NDArray[np.integer],
    columns: NDArray[np.integer],
    passband: Passband,
) -> NDArray[np.complex128]:
    """(N, K) each point's own wave at K pixels of its own, rows and columns (N, K)."""
    x, y, z = (c[:, None] for c in cloud.positions.T)
    dx, dy = slm.x(columns) - x, slm.y(rows) - y
    weight = taper(dx, z * reach(wavelength, passband.fx_max))
    weight *= taper(dy, z * reach(wavelength, passband.fy_max))
    distance = np.sqrt(dx**2 + dy**2 + z**2)
    cycles = distance / wavelength
    cycles += cloud.phase[:, None] / (2 * np.pi) - np.rint(cycles)
    amplitude = cloud.amplitude[:, None] * weight / distance
    waves: NDArray[np.complex128] = amplitude * np.exp(2j * np.pi * cycles)
    return waves


def relative_error(field: NDArray[np.complexfloating], truth: NDArray[np.complexfloating]) -> float:
    """‖field − truth‖/‖truth‖, absolute phase and scale included; 0 where both vanish."""
    # In double precision: squares of what single precision holds may be past its range.
    norm = float(np.linalg.norm(truth.astype(np.complex128)))
    difference = float(np.linalg.norm((field - truth).astype(np.complex128)))
    if norm == 0:
        return 0.0 if difference == 0 else float("inf")
    return difference / norm
