"""`wrp` against the float64 truth: its floor, what planes and guard buy, windows, odd points."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import chrmc
from chrmc.cgh import wrp
from chrmc.cgh.wrp_patches import MOST_PLANES
from chrmc.encoding import coding_for
from chrmc.kept import Kept
from chrmc.optics.passband import full_band
from chrmc.reference import reference_field, relative_error
from chrmc.slm import LC_R_1080, SLM
from chrmc.window import Window

WAVELENGTH = chrmc.WAVELENGTH
ROWS = np.arange(7, 1200, 41)
COLUMNS = np.arange(5, 1920, 37)


def scene_like(
    count: int, depths: tuple[float, float], seed: int = 0, spread: float = 4e-3
) -> chrmc.PointCloud:
    rng = np.random.default_rng(seed)
    positions = np.c_[
        rng.uniform(-spread, spread, count),
        rng.uniform(-spread / 2, spread / 2, count),
        rng.uniform(*depths, count),
    ]
    return chrmc.PointCloud(positions, rng.uniform(0.1, 1, count), rng.uniform(-9, 9, count))


def error(cloud: chrmc.PointCloud, coding: str = "real", **options: object) -> float:
    band = coding_for(coding, LC_R_1080).passband
    field = wrp.field(cloud, LC_R_1080, WAVELENGTH, Window.full(LC_R_1080), band, **options)
    truth = reference_field(cloud, LC_R_1080, WAVELENGTH, ROWS, COLUMNS, passband=band)
    return relative_error(field[np.ix_(ROWS, COLUMNS)], truth)


@pytest.mark.parametrize("coding", ["real", "ssb"])
def test_stated_error_on_the_scenes_geometry(coding: str) -> None:
    assert error(scene_like(30, (0.244, 0.2695)), coding) < 5e-3


def test_error_falls_as_planes_are_added_down_to_a_floor() -> None:
    half = SLM("half", 960, 600, 8.1e-6)
    cloud = scene_like(30, (0.2, 0.3), spread=2e-3)
    rows, columns = np.arange(7, 600, 21), np.arange(5, 960, 19)
    truth = reference_field(cloud, half, WAVELENGTH, rows, columns)

    def of(planes: int) -> float:
        made = wrp.field(cloud, half, WAVELENGTH, Window.full(half), full_band(half), planes=planes)
        return relative_error(made[np.ix_(rows, columns)], truth)

    one, two, eight, sixteen = (of(planes) for planes in (1, 2, 8, 16))
    assert one > 3 * two > 6 * eight
    assert eight < 3e-4 and abs(sixteen - eight) < 0.1 * eight


def test_error_falls_with_the_guard() -> None:
    cloud = scene_like(20, (0.25, 0.26))
    none, some, much = (error(cloud, guard=g) for g in (0, 12, 32))
    assert none > 3 * some > 9 * much


def test_a_point_on_its_own_plane_is_no_special_case() -> None:
    cloud = scene_like(5, (0.252, 0.252))
    assert error(cloud, planes=[0.252]) < 5e-3
    assert error(cloud, planes=[0.2525]) < 5e-3  # in front of the plane
    assert error(cloud, planes=[0.2515]) < 5e-3  # and behind it


def test_points_beyond_the_panel_and_a_window_that_only_they_reach() -> None:
    cloud = chrmc.PointCloud(
        np.array([[12e-3, 1e-3, 0.25], [-13.5e-3, -8e-3, 0.25], [0, 0, 0.252]]),
        np.array([1.0, 2.0, 0.5]),
        np.array([0.0, 1.0, 2.0]),
    )
    for window in (Window(100, 300, 1800, 1920), Window(0, 400, 0, 90), Window(5, 6, 900, 901)):
        band = full_band(LC_R_1080)
        field = wrp.field(cloud, LC_R_1080, WAVELENGTH, window, band)
        truth = reference_field(cloud, LC_R_1080, WAVELENGTH, window.rows, window.columns)
        assert field.shape == window.shape and field.dtype == np.complex64
        assert relative_error(field, truth) < 1e-2


def test_a_window_that_no_point_reaches_is_dark() -> None:
    cloud = chrmc.PointCloud(np.array([[13e-3, 0, 0.25]]), np.ones(1), np.zeros(1))
    field = wrp.field(cloud, LC_R_1080, WAVELENGTH, Window(0, 50, 0, 50), full_band(LC_R_1080))
    assert not field.any()


@settings(max_examples=12, deadline=None)
@given(st.integers(1, 90), st.integers(1, 70), st.floats(0.3, 3.0), st.integers(0, 99))
def test_any_small_panel(width: int, height: int, depth: float, seed: int) -> None:
    slm = SLM("any", width, height, 8.1e-6)
    cloud = scene_like(4, (depth, depth * 1.02), seed)
    cloud = chrmc.PointCloud(cloud.positions * [0.1, 0.1, 1], cloud.amplitude, cloud.phase)
    field = wrp.field(cloud, slm, WAVELENGTH, Window.full(slm), full_band(slm))
    # Where all points happen to cancel, a relative error means nothing: compare with their power.
    truth = reference_field(cloud, slm, WAVELENGTH)
    scale = np.sqrt(np.sum(cloud.amplitude**2)) / depth
    assert np.sqrt(np.mean(np.abs(field - truth) ** 2)) < 3e-3 * scale


def test_planes_stand_where_the_farthest_point_is_nearest() -> None:
    z = np.array([1.0, 1.1, 1.2, 5.0, 5.4, 9.0])
    assert np.allclose(wrp.place_planes(z, 3), [1.1, 5.2, 9.0])
    assert np.allclose(wrp.place_planes(z, 1), [5.0])
    assert np.allclose(wrp.place_planes(np.array([0.244, 0.2535])), [0.24875])
    assert len(wrp.place_planes(np.linspace(0.2, 2.0, 500))) <= MOST_PLANES
    assert np.array_equal(wrp.place_planes(z, [3.0, 2.0]), [2.0, 3.0])


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(0.01, 10), min_size=1, max_size=30), st.integers(1, 8))
def test_more_planes_never_stand_farther(depths: list[float], count: int) -> None:
    z = np.array(depths)

    def farthest(n: int) -> float:
        return float(np.max(np.min(np.abs(z[:, None] - wrp.place_planes(z, n)), axis=1)))

    assert len(wrp.place_planes(z, count)) <= count
    assert farthest(count + 1) <= farthest(count) + 1e-9
    assert farthest(count) <= (z.max() - z.min()) / 2 + 1e-9


def test_kept_transfer_functions_change_nothing_and_stay_within_their_limit() -> None:
    slm = SLM("small", 120, 90, 8.1e-6)
    cloud = scene_like(6, (0.25, 0.28))
    cloud = chrmc.PointCloud(cloud.positions * [0.1, 0.1, 1], cloud.amplitude, cloud.phase)
    cache = Kept(limit=40 << 20)
    whole = Window.full(slm)
    fresh = wrp.field(cloud, slm, WAVELENGTH, whole, full_band(slm))
    for planes in (3, 3, 2, 1):
        wrp.field(cloud, slm, WAVELENGTH, whole, full_band(slm), planes=planes, cache=cache)
        assert 0 < cache.nbytes <= cache.limit
    again = wrp.field(cloud, slm, WAVELENGTH, whole, full_band(slm), cache=cache)
    assert relative_error(again, fresh) < 1e-6


def test_refusals() -> None:
    cloud = scene_like(3, (0.25, 0.26))
    with pytest.raises(ValueError, match="footprint"):
        chrmc.compute_field(cloud, LC_R_1080, WAVELENGTH, "wrp", footprint=None)
    with pytest.raises(ValueError, match="at least one"):
        chrmc.compute_field(cloud, LC_R_1080, WAVELENGTH, "wrp", planes=0)
    with pytest.raises(ValueError, match="z > 0"):
        chrmc.compute_field(cloud, LC_R_1080, WAVELENGTH, "wrp", planes=[-0.1])
    with pytest.raises(ValueError, match="guard"):
        chrmc.compute_field(cloud, LC_R_1080, WAVELENGTH, "wrp", guard=-1)
    far = chrmc.PointCloud(np.array([[0, 0, 190.0]]), np.ones(1), np.zeros(1))
    for wavelength in (WAVELENGTH, 10.6e-6):  # the planes, and already one point's patch
        with pytest.raises(ValueError, match="use rt"):
            chrmc.compute_field(far, LC_R_1080, wavelength, "wrp")
