"""The soft footprint: where it ends, what is refused, and the power it lets through."""

from math import asin, tan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import chrmc
from chrmc.encoding import coding_for
from chrmc.optics.footprint import (
    check_showable,
    coverage,
    expected_power,
    pixels_within,
    reach,
    taper,
)
from chrmc.optics.passband import UNLIMITED, full_band
from chrmc.slm import LC_R_1080, SLM

WAVELENGTH = chrmc.WAVELENGTH


def one_point(x: float, y: float, z: float) -> chrmc.PointCloud:
    return chrmc.PointCloud(np.array([[x, y, z]]), np.ones(1), np.zeros(1))


def test_reach_is_the_half_angle_of_the_pixels() -> None:
    assert np.degrees(asin(WAVELENGTH / (2 * 8.1e-6))) == pytest.approx(1.882, abs=5e-4)
    half = 0.25 * reach(WAVELENGTH, LC_R_1080.nyquist)
    assert half == pytest.approx(8.21e-3, abs=1e-5)
    assert reach(WAVELENGTH, 1 / WAVELENGTH) == float("inf")


@given(st.floats(-3, 3), st.floats(1e-6, 1e3))
def test_taper_is_even_falls_and_ends(u: float, half: float) -> None:
    value, mirrored, further = taper(
        np.array([u, -u, np.copysign(abs(u) + 0.01, u)]) * half, np.array(half)
    )
    assert value == pytest.approx(mirrored)
    assert further <= value + 1e-12 and value <= 1
    if abs(u) <= 0.9:
        assert value == pytest.approx(1)
    if abs(u) >= 1.000001:
        assert value == 0


@pytest.mark.parametrize("left", [1e-6, 1e-3, 0.3, 1.0])
def test_taper_keeps_its_digits_where_a_footprint_only_grazes(left: float) -> None:
    # `left` of the soft share is inside the footprint: sin² of what is left, not cos² less one.
    value = taper(np.array([1 - 0.1 * left]), np.array(1.0))
    assert value == pytest.approx(np.sin(np.pi / 2 * left) ** 2, rel=1e-8)


def test_taper_of_an_unlimited_band_is_one() -> None:
    assert np.all(taper(np.array([0.0, 1.0, -1e9]), np.array(np.inf)) == 1)


def test_the_fringe_stays_below_nyquist_inside() -> None:
    # The local frequency of exp(ikr) along x is dx/(λr); on the axis's row it reaches f_max at L.
    z, f_max = 0.25, LC_R_1080.nyquist
    half = z * reach(WAVELENGTH, f_max)
    assert half / np.hypot(half, z) / WAVELENGTH == pytest.approx(f_max)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("coding", ["real", "ssb"])
@pytest.mark.parametrize("sign", [-1, 1])
def test_the_boundary_between_shown_and_refused(axis: int, coding: str, sign: int) -> None:
    slm, z = LC_R_1080, 0.25
    band = coding_for(coding, slm).passband
    f_max = (band.fx_max, band.fy_max)[axis]
    last_pixel = ((slm.width, slm.height)[axis] - 1) / 2 * slm.pixel_pitch
    edge = last_pixel + z * tan(asin(WAVELENGTH * f_max))
    position = [0.0, 0.0, z]
    position[axis] = sign * (edge - 1e-7)
    shown = one_point(*position)
    check_showable(shown, slm, WAVELENGTH, band)
    assert coverage(shown, slm, WAVELENGTH, band)[0] > 0
    position[axis] = sign * (edge + 2e-5)
    with pytest.raises(ValueError, match=r"1 of 1 points .* up to 0\.02 mm"):
        check_showable(one_point(*position), slm, WAVELENGTH, band)


@given(st.floats(-2e-3, 2e-3), st.floats(-2e-3, 2e-3), st.floats(1e-5, 0.05), st.integers(1, 40))
@settings(max_examples=150, deadline=None)
def test_refused_exactly_when_no_pixel_has_weight(x: float, y: float, z: float, n: int) -> None:
    slm = SLM("small", n, 20, 8.1e-6)
    band = full_band(slm)
    half = np.array(z * reach(WAVELENGTH, slm.nyquist))
    closest = min(half - np.abs(slm.x() - x).min(), half - np.abs(slm.y() - y).min())
    if abs(closest) < 1e-12:
        return
    if closest > 0:
        check_showable(one_point(x, y, z), slm, WAVELENGTH, band)
    else:
        with pytest.raises(ValueError, match="shown by no pixel"):
            check_showable(one_point(x, y, z), slm, WAVELENGTH, band)


def test_behind_is_refused_and_unlimited_is_not() -> None:
    with pytest.raises(ValueError, match="1 of 2 points stand at or behind"):
        check_showable(
            chrmc.PointCloud(np.array([[0, 0, 0.1], [0, 0, 0.0]]), np.ones(2), np.zeros(2)),
            LC_R_1080,
            WAVELENGTH,
            UNLIMITED,
        )
    check_showable(one_point(1.0, 0, 0.01), LC_R_1080, WAVELENGTH, UNLIMITED)
    with pytest.raises(ValueError, match="wavelength"):
        check_showable(one_point(0, 0, 1), LC_R_1080, float("nan"), UNLIMITED)


def test_partial_coverage_is_reported() -> None:
    share = coverage(one_point(5e-3, 0, 0.252), LC_R_1080, WAVELENGTH, full_band(LC_R_1080))
    columns = LC_R_1080.x()
    lit = np.abs(columns - 5e-3) < 0.252 * reach(WAVELENGTH, LC_R_1080.nyquist)
    assert share[0] == pytest.approx(lit.mean(), abs=2e-3)  # all rows are lit


@pytest.mark.parametrize("coding", ["real", "ssb"])
def test_expected_power_is_the_mean_intensity(coding: str) -> None:
    slm = SLM("medium", 240, 160, 8.1e-6)
    band = coding_for(coding, slm).passband
    rng = np.random.default_rng(5)
    positions = np.c_[
        rng.uniform(-1.2e-3, 1.2e-3, 60), rng.uniform(-8e-4, 8e-4, 60), rng.uniform(0.03, 0.06, 60)
    ]
    cloud = chrmc.PointCloud(positions, rng.uniform(0.2, 1, 60), rng.uniform(0, 6.28, 60))
    power = expected_power(cloud, slm, WAVELENGTH, band)
    for j in (0, 17, 42):  # one point alone: its own mean intensity
        alone = chrmc.reference_field(cloud.select(slice(j, j + 1)), slm, WAVELENGTH, passband=band)
        assert power[j] == pytest.approx(np.mean(np.abs(alone) ** 2), rel=0.05)
    means = []
    for seed in range(12):  # all of them, phases drawn anew
        phase = np.random.default_rng(seed).uniform(0, 2 * np.pi, 60)
        field = chrmc.compute_field(
            chrmc.PointCloud(positions, cloud.amplitude, phase),
            slm,
            WAVELENGTH,
            passband=band,
            method="rt",
        )
        means.append(np.mean(np.abs(field) ** 2))
    assert power.sum() == pytest.approx(np.mean(means), rel=0.1)


@pytest.mark.parametrize("at", [(0.0, 0.0), (2.9e-5, -2e-5), (-5e-5, 3.5e-5)])
def test_expected_power_and_coverage_end_at_the_outer_pixels_edges(at: tuple[float, float]) -> None:
    """On so few pixels that half of one counts, footprints inside the panel and beyond it."""
    slm = SLM("tiny", 8, 6, 8e-6)
    band = full_band(slm)
    for z in (3e-4, 1e-3, 4e-3):
        cloud = chrmc.PointCloud(np.array([[*at, z]]), np.full(1, 2.0), np.zeros(1))
        power, share = (2.0 / z) ** 2, 1.0
        for count, place, f_max in ((8, at[0], band.fx_max), (6, at[1], band.fy_max)):
            fine = (np.arange(4000) + 0.5) / 4000 * count * 8e-6 - count * 4e-6
            half = z * reach(WAVELENGTH, f_max)
            power *= np.mean(taper(fine - place, np.array(half)) ** 2)
            share *= np.mean(np.abs(fine - place) <= half)
        assert expected_power(cloud, slm, WAVELENGTH, band)[0] == pytest.approx(power, rel=2e-3)
        assert coverage(cloud, slm, WAVELENGTH, band)[0] == pytest.approx(share, rel=2e-3, abs=1e-9)


@pytest.mark.parametrize(("light", "shown"), [(1.02e-18, True), (0.98e-18, False),
                                              (0.98e18, True), (1.02e18, False)])  # fmt: skip
def test_light_that_single_precision_cannot_hold_is_refused(light: float, shown: bool) -> None:
    cloud = chrmc.PointCloud(np.array([[0.0, 0.0, 0.2]]), np.full(1, -0.2 * light), np.zeros(1))
    try:
        check_showable(cloud, LC_R_1080, WAVELENGTH, full_band(LC_R_1080))
        told = ""
    except ValueError as problem:
        told = str(problem)
    assert ("single precision holds 1e-18 to 1e+18" in told) != shown


def test_pixels_are_drawn_from_all_of_a_footprint_and_from_nothing_else() -> None:
    slm = SLM("few", 20, 12, 8e-6)
    band = coding_for("ssb", slm).passband
    places = [[0, 0, 1e-3], [-7.2e-5, 3e-5, 1.5e-3], [6e-5, -4.4e-5, 6e-4], [1e-5, 2e-5, 0.1]]
    cloud = chrmc.PointCloud(np.array(places), np.ones(4), np.zeros(4))
    rows, columns = pixels_within(cloud, slm, WAVELENGTH, band, 2000, np.random.default_rng(0))
    assert rows.shape == columns.shape == (4, 2000)
    for (x, y, z), row, column in zip(places, rows, columns, strict=True):
        for drawn, at, middle, f_max in (
            (column, slm.x(), x, band.fx_max), (row, slm.y(), y, band.fy_max),
        ):  # fmt: skip
            inside = np.flatnonzero(np.abs(at - middle) <= z * reach(WAVELENGTH, f_max))
            found, times = np.unique(drawn, return_counts=True)
            assert found.tolist() == inside.tolist()
            assert times == pytest.approx(2000 / len(inside), rel=0.5)


def test_an_axis_that_no_footprint_reaches_gives_its_nearest_pixel() -> None:
    slm = SLM("few", 20, 12, 8e-6)
    cloud = one_point(1e-3, -1e-3, 1e-4)
    draw = np.random.default_rng(0)
    rows, columns = pixels_within(cloud, slm, WAVELENGTH, full_band(slm), 5, draw)
    assert set(columns[0]) == {19} and set(rows[0]) == {0}
