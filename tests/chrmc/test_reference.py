"""The truth against a scalar sum written out by hand, and what it refuses."""

import cmath
from math import asin, cos, pi, sqrt, tan

import numpy as np
import pytest

import chrmc
from chrmc.encoding import coding_for
from chrmc.reference import reference_samples, relative_error
from chrmc.slm import LC_R_1080, SLM

WAVELENGTH = chrmc.WAVELENGTH
SMALL = SLM("small", 40, 30, 8.1e-6)


def soft(offset: float, half: float) -> float:
    u = abs(offset) / half
    if u <= 0.9:
        return 1.0
    return cos(pi / 2 * (u - 0.9) / 0.1) ** 2 if u < 1 else 0.0


def by_hand(
    cloud: chrmc.PointCloud, slm: SLM, row: int, column: int, f: tuple[float, float] | None
) -> complex:
    x = (column - (slm.width - 1) / 2) * slm.pixel_pitch
    y = (row - (slm.height - 1) / 2) * slm.pixel_pitch
    total = 0j
    for (xj, yj, zj), a, phase in zip(
        cloud.positions.tolist(), cloud.amplitude.tolist(), cloud.phase.tolist(), strict=True
    ):
        r = sqrt((x - xj) ** 2 + (y - yj) ** 2 + zj**2)
        w = 1.0
        if f is not None:
            w = soft(x - xj, zj * tan(asin(WAVELENGTH * f[0]))) * soft(
                y - yj, zj * tan(asin(WAVELENGTH * f[1]))
            )
        total += w * a / r * cmath.exp(1j * (2 * pi / WAVELENGTH * r + phase))
    return total


def some_cloud(count: int = 70) -> chrmc.PointCloud:
    rng = np.random.default_rng(8)
    positions = np.c_[
        rng.uniform(-2e-4, 2e-4, count),
        rng.uniform(-2e-4, 2e-4, count),
        rng.uniform(8e-3, 2e-2, count),
    ]
    return chrmc.PointCloud(positions, rng.uniform(0, 1, count), rng.uniform(-9, 9, count))


@pytest.mark.parametrize("band", ["none", "real", "ssb"])
def test_against_a_sum_by_hand(band: str) -> None:
    cloud = some_cloud()
    rows, columns = [0, 13, 29], [0, 7, 39]
    passband = None if band == "none" else coding_for(band, SMALL).passband
    field = chrmc.reference_field(
        cloud,
        SMALL,
        WAVELENGTH,
        rows,
        columns,
        footprint=None if band == "none" else "soft",
        passband=passband,
    )
    assert field.shape == (3, 3) and field.dtype == np.complex128
    limits = None if passband is None else (passband.fx_max, passband.fy_max)
    expected = [[by_hand(cloud, SMALL, r, c, limits) for c in columns] for r in rows]
    np.testing.assert_allclose(field, expected, rtol=1e-7, atol=1e-7)


def test_samples_are_the_grid_s() -> None:
    cloud = some_cloud(5)
    grid = chrmc.reference_field(cloud, SMALL, WAVELENGTH)
    rows, columns = np.array([[1, 2], [3, 29]]), np.array([[0, 39], [7, 7]])
    np.testing.assert_allclose(
        reference_samples(cloud, SMALL, WAVELENGTH, rows, columns), grid[rows, columns]
    )


def test_empty_cloud_and_refusals() -> None:
    assert not chrmc.reference_field(chrmc.PointCloud.empty(), SMALL, WAVELENGTH).any()
    far_out = chrmc.PointCloud(np.array([[1.0, 0, 0.25]]), np.ones(1), np.zeros(1))
    with pytest.raises(ValueError, match="can be shown by no pixel"):
        chrmc.reference_field(far_out, LC_R_1080, WAVELENGTH, [0], [0])
    with pytest.raises(ValueError, match="footprint"):
        chrmc.reference_field(some_cloud(1), SMALL, WAVELENGTH, footprint="hard")


def test_relative_error_sees_phase_and_scale() -> None:
    truth = np.array([1, 1j, -2])
    assert relative_error(truth, truth) == 0
    assert relative_error(1.1 * truth, truth) == pytest.approx(0.1)
    assert relative_error(-truth, truth) == pytest.approx(2)
    assert relative_error(np.zeros(3, complex), np.zeros(3, complex)) == 0


def test_far_away_waves_that_all_but_cancel_keep_their_digits() -> None:
    """Paths of 20 m have half the digits that are needed; 80-bit floats have them."""
    slm = SLM("far", 60, 40, 15e-6)
    steps = np.arange(400)
    positions = np.stack([steps % 20 * 6e-7, steps // 20 * 6e-7, np.full(400, 20.006)], axis=1)
    cloud = chrmc.PointCloud(positions, np.ones(400), pi * (steps % 2))
    rows, columns = np.array([0, 7, 39]), np.array([3, 59, 30])
    found = reference_samples(cloud, slm, WAVELENGTH, rows, columns, footprint=None)
    wide = positions.astype(np.longdouble)
    truth = []
    for row, column in zip(rows, columns, strict=True):
        aside = (wide[:, 0] - slm.x(column)) ** 2 + (wide[:, 1] - slm.y(row)) ** 2
        r = np.sqrt(aside + wide[:, 2] ** 2)
        cycles = r / np.longdouble(WAVELENGTH)
        turn = 8 * np.arctan(np.longdouble(1)) * (cycles - np.rint(cycles)) + cloud.phase
        truth.append(complex(np.sum(np.cos(turn) / r)) + 1j * complex(np.sum(np.sin(turn) / r)))
    assert np.abs(truth).max() < 1e-3 * len(cloud) / 20
    assert relative_error(found, np.array(truth)) < 1e-6
