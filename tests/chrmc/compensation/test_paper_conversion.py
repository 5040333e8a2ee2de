"""Eqs 5–13: the cylinder's geometry, and a conversion that loses nothing."""

import warnings
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chrmc.compensation.ch_rmc_paper.conversion import (
    RADIUS,
    check_radius,
    conversion_table,
    gap,
    one_pixel_distance,
    sagitta,
    to_curved,
    to_planar,
)
from chrmc.compensation.ch_rmc_paper.cylinder import cylinder_at, rotate, to_local, to_original
from chrmc.reference import reference_field
from chrmc.scene.points import PointCloud
from chrmc.slm import LC_R_1080, SLM, WAVELENGTH

WIDTH = LC_R_1080.width * LC_R_1080.pixel_pitch


def test_the_paper_s_figures() -> None:
    assert sagitta(RADIUS, WIDTH) == pytest.approx(208.65e-6, abs=1e-8)
    assert one_pixel_distance(8.1e-6, WAVELENGTH) == pytest.approx(246.5e-6, abs=1e-7)


def test_the_least_radius_that_is_told_is_the_least_that_passes() -> None:
    with pytest.warns(UserWarning, match=r"take at least ([\d.]+) mm") as told:
        check_radius(0.1, LC_R_1080, WAVELENGTH)
    least = float(str(told[0].message).split("at least ")[1].split(" mm")[0]) * 1e-3
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_radius(1.001 * least, LC_R_1080, WAVELENGTH)
        with pytest.raises(UserWarning, match="bulges"):
            check_radius(0.998 * least, LC_R_1080, WAVELENGTH)


def test_the_gap_reaches_to_the_circles_ends() -> None:
    z0 = sagitta(0.1, WIDTH)
    np.testing.assert_allclose(gap(np.array([-0.1, 0.1]), 0.1, z0), z0 - 0.1)
    with pytest.raises(ValueError, match="ends before"):
        gap(np.array([0.1001]), 0.1, z0)


@given(st.floats(0.008, 10), st.floats(-1, 1))
def test_the_gap_ends_on_the_circle(radius: float, share: float) -> None:
    # The plane's chord stands z0 in front of the circle's nearest point: a point that goes z(x)
    # towards the hologram lies at `radius` from the axis.
    x = share * WIDTH / 2
    z0 = sagitta(radius, WIDTH)
    z = gap(np.array([x]), radius, z0)[0]
    from_axis = radius - z0 + z
    assert np.hypot(x, from_axis) == pytest.approx(radius, rel=1e-9)
    assert -1e-12 <= z <= z0 + 1e-12


def test_table_is_the_phase_of_the_gap() -> None:
    x = LC_R_1080.x()[::100]
    z0 = sagitta(RADIUS, WIDTH)
    expected = np.exp(1j * np.fmod(2 * pi / WAVELENGTH * gap(x, RADIUS, z0), 2 * pi))
    np.testing.assert_allclose(conversion_table(x, RADIUS, z0, WAVELENGTH), expected, atol=1e-5)


@given(st.floats(0.02, 1), st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_there_and_back_is_the_identity_and_keeps_energy(radius: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    x = LC_R_1080.x()
    planar = (rng.normal(size=(4, 1920)) + 1j * rng.normal(size=(4, 1920))).astype(np.complex64)
    table = conversion_table(x, radius, sagitta(radius, WIDTH), WAVELENGTH)
    curved = to_curved(planar, table)
    np.testing.assert_allclose(np.abs(curved), np.abs(planar), rtol=1e-5)
    np.testing.assert_allclose(to_planar(curved, table), planar, atol=1e-5)
    assert not np.allclose(curved, planar, atol=0.1)


def test_radius_refused_and_warned_of() -> None:
    with pytest.raises(ValueError, match=r"radius 7\.7 mm cannot span a hologram 15\.55 mm"):
        check_radius(7.7e-3, LC_R_1080, WAVELENGTH)
    for bad in (0.0, -0.1, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="cannot span"):
            check_radius(bad, LC_R_1080, WAVELENGTH)
    with pytest.warns(UserWarning, match="past the 247 µm"):
        check_radius(0.12, LC_R_1080, WAVELENGTH)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert check_radius(RADIUS, LC_R_1080, WAVELENGTH) == RADIUS
        check_radius(0.1231, LC_R_1080, WAVELENGTH)  # just past where W(z0) = p


def smooth_field(slm: SLM, seed: int = 0) -> np.ndarray:
    """Noise that stays away from the panel's edges and from the band's edge."""
    rng = np.random.default_rng(seed)
    noise = rng.normal(size=slm.shape) + 1j * rng.normal(size=slm.shape)
    fy, fx = np.fft.fftfreq(slm.height)[:, None], np.fft.fftfreq(slm.width)[None, :]
    calm = np.fft.ifft2(np.fft.fft2(noise) * np.exp(-((fx / 0.05) ** 2) - (fy / 0.05) ** 2))
    window = np.exp(-((slm.x() / slm.x()[-1] / 0.5) ** 4)) * np.exp(
        -((slm.y()[:, None] / slm.y()[-1] / 0.5) ** 4)
    )
    return (calm * window).astype(np.complex64)


@pytest.mark.parametrize("centre", [(0.0, 0.06), (4e-4, 0.05), (-7e-4, 0.02)])
def test_position_adjustment_there_and_back(centre: tuple[float, float]) -> None:
    slm = SLM("small", 240, 90, 8.1e-6)
    field = smooth_field(slm)
    cylinder = cylinder_at(slm, WAVELENGTH, centre, 0.03)
    assert cylinder.distance == pytest.approx(centre[1] - 0.03 + cylinder.z0)
    local = to_local(field, cylinder)
    # (f_y, x): rows are transformed without a factor, so the energy is `rows` times as large.
    energy = np.sum(np.abs(local) ** 2) / local.shape[0]
    assert energy == pytest.approx(np.sum(np.abs(field) ** 2), rel=1e-4)
    back = to_original(local, cylinder)
    assert np.linalg.norm(back - field) < 1e-4 * np.linalg.norm(field)


@pytest.mark.parametrize("bearing", [0.0, 2e-3])
def test_turned_there_and_back(bearing: float) -> None:
    slm = SLM("small", 240, 90, 8.1e-6)
    field = smooth_field(slm, 1)
    cylinder = cylinder_at(slm, WAVELENGTH, (1e-4, 0.05), 0.04)
    curved = to_curved(to_local(field, cylinder), cylinder.table)
    there = rotate(curved, cylinder, 0.0031, bearing)
    back = rotate(there, cylinder, -0.0031, bearing)
    assert np.linalg.norm(there - curved) > 0.5 * np.linalg.norm(curved)
    assert np.linalg.norm(back - curved) < 1e-4 * np.linalg.norm(curved)
    assert np.linalg.norm(there) == pytest.approx(np.linalg.norm(curved), rel=1e-4)


def test_a_whole_pixel_rotation_is_a_roll() -> None:
    slm = SLM("small", 240, 30, 8.1e-6)
    cylinder = cylinder_at(slm, WAVELENGTH, (0.0, 0.05), 0.04)
    rng = np.random.default_rng(3)
    curved = rng.normal(size=cylinder.out.shape).astype(np.complex64)
    turned = rotate(curved, cylinder, 7 * slm.pixel_pitch / 0.04)
    assert np.linalg.norm(turned - np.roll(curved, -7, axis=1)) < 1e-4 * np.linalg.norm(curved)


def test_receding_makes_a_points_fringe_that_of_one_farther_away() -> None:
    slm = SLM("small", 240, 160, 8.1e-6)

    def fringe(z: float) -> np.ndarray:
        return reference_field(PointCloud(np.array([[0, 0, z]]), np.ones(1), np.zeros(1)), slm,
                               WAVELENGTH)  # fmt: skip

    def alike(one: np.ndarray, other: np.ndarray) -> float:
        return float(abs(np.vdot(one, other)) / np.linalg.norm(one) / np.linalg.norm(other))

    at, step = 20e-3, 1e-3
    cylinder = cylinder_at(slm, WAVELENGTH, (0.0, 0.05), 0.04)
    moved = to_original(to_local(fringe(at).astype(np.complex64), cylinder), cylinder, step)
    assert alike(moved, fringe(at + step)) > 0.98
    assert alike(moved, fringe(at)) < 0.95 and alike(moved, fringe(at - step)) < 0.8


@pytest.mark.parametrize("angle", [0.01, -0.01])
def test_light_that_a_rotation_would_carry_past_nyquist_is_taken_out_first(angle: float) -> None:
    """Waves along x: those that end below 0.9 of Nyquist stay as they are, those beyond it go."""
    slm = SLM("wide", 960, 16, 8.1e-6)
    cylinder = cylinder_at(slm, WAVELENGTH, (0.0, 0.03), 0.025)
    soft = np.exp(-((slm.x() / slm.x()[-1] / 0.6) ** 8))
    for share in (-0.8, -0.5, 0.0, 0.5, 0.8):
        wave = soft * np.exp(2j * np.pi * share * slm.nyquist * slm.x())
        field = np.tile(wave.astype(np.complex64), (16, 1))
        kept = np.linalg.norm(to_local(field, cylinder, angle))
        kept /= np.linalg.norm(to_local(field, cylinder))
        after = share - np.sin(angle) / WAVELENGTH / slm.nyquist
        assert kept == pytest.approx(1.0 if abs(after) < 0.9 else 0.0, abs=0.02), share
