"""`rt` against the float64 truth, from near to far, on windows, with and without a footprint."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import chrmc
from chrmc.cgh import rt
from chrmc.encoding import coding_for
from chrmc.optics.passband import UNLIMITED
from chrmc.reference import reference_field, reference_samples, relative_error
from chrmc.slm import SLM
from chrmc.window import Window

SMALL = SLM("small", 96, 64, 8.1e-6)
WAVELENGTH = chrmc.WAVELENGTH


def cloud_at(depth: float, spread: float, count: int = 12, seed: int = 0) -> chrmc.PointCloud:
    rng = np.random.default_rng(seed)
    positions = rng.uniform(-spread, spread, (count, 3))
    positions[:, 2] = depth * rng.uniform(0.97, 1.03, count)
    return chrmc.PointCloud(positions, rng.uniform(0.2, 1, count), rng.uniform(-20, 20, count))


@pytest.mark.parametrize("depth", [1e-3, 5e-3, 0.05, 0.25, 1.0, 10.0])
def test_error_at_every_depth(depth: float) -> None:
    cloud = cloud_at(depth, 3e-4)
    field = chrmc.compute_field(cloud, SMALL, WAVELENGTH, method="rt")
    assert field.dtype == np.complex64
    assert relative_error(field, reference_field(cloud, SMALL, WAVELENGTH)) < 1e-5


@pytest.mark.parametrize("depth", [2e-4, 1e-3, 0.02, 0.25])
def test_bare_waves_at_steep_angles(depth: float) -> None:
    wide = SLM("wide", 1920, 1200, 8.1e-6)
    cloud = cloud_at(depth, 6e-3, count=3)
    rows, columns = np.arange(0, 1200, 97), np.arange(0, 1920, 83)
    truth = reference_field(cloud, wide, WAVELENGTH, rows, columns, footprint=None)
    for row in rows[::6]:  # single rows keep the float64 path affordable
        window = Window(int(row), int(row) + 1, 0, 1920)
        field = chrmc.compute_field(
            cloud, wide, WAVELENGTH, window=window, footprint=None, method="rt"
        )[:, columns]
        expected = truth[rows == row]
        assert relative_error(field, expected) < 2e-5


@pytest.mark.parametrize("aside", [1.4e-3, 3e-3])
@pytest.mark.parametrize("count", [3, 300])
def test_single_precision_is_left_before_its_error_shows(aside: float, count: int) -> None:
    """Oblique waves: `rest` of a few wavelengths, and of dozens."""
    panel, window = SLM("s", 40, 30, 1e-5), Window(0, 30, 0, 40)
    cloud = cloud_at(0.01, 1e-4, count)
    places = cloud.positions + np.array([aside, aside, 0])
    cloud = chrmc.PointCloud(places, cloud.amplitude, cloud.phase)
    truth = reference_field(cloud, panel, WAVELENGTH, footprint=None)
    made = chrmc.compute_field(cloud, panel, WAVELENGTH, footprint=None, method="rt")
    assert relative_error(made, truth) < 6e-6
    single, noise = rt._sum(cloud, panel, WAVELENGTH, window, UNLIMITED, np.complex64, allowed=1.0)
    expected = np.sqrt(noise) / np.linalg.norm(truth)
    assert 0.25 < relative_error(single, truth) / expected < 1.2


def test_full_size_scene_like_cloud() -> None:
    rng = np.random.default_rng(3)
    positions = np.c_[
        rng.uniform(-6e-3, 6e-3, 30), rng.uniform(-4e-3, 4e-3, 30), rng.uniform(0.244, 0.27, 30)
    ]
    cloud = chrmc.PointCloud(positions, rng.uniform(0, 1, 30), rng.uniform(0, 6, 30))
    rows, columns = rng.integers(0, 1200, 4000), rng.integers(0, 1920, 4000)
    for coding in ("real", "ssb"):
        band = coding_for(coding, chrmc.LC_R_1080).passband
        truth = reference_samples(cloud, chrmc.LC_R_1080, WAVELENGTH, rows, columns, passband=band)
        field = chrmc.compute_field(cloud, chrmc.LC_R_1080, WAVELENGTH, passband=band, method="rt")
        assert relative_error(field[rows, columns], truth) < 1e-5


@given(
    st.integers(0, SMALL.height),
    st.integers(0, SMALL.height),
    st.integers(0, SMALL.width),
    st.integers(0, SMALL.width),
)
@settings(max_examples=25, deadline=None)
def test_a_window_is_a_crop(r0: int, r1: int, c0: int, c1: int) -> None:
    window = Window(min(r0, r1), max(r0, r1), min(c0, c1), max(c0, c1))
    cloud = cloud_at(0.01, 3e-4, count=5)
    whole = chrmc.compute_field(cloud, SMALL, WAVELENGTH, method="rt")
    part = chrmc.compute_field(cloud, SMALL, WAVELENGTH, window=window, method="rt")
    np.testing.assert_allclose(part, whole[window.slices], rtol=0, atol=2e-5 * np.abs(whole).max())


def test_more_points_than_a_chunk_add_up() -> None:
    cloud = cloud_at(0.05, 3e-4, count=300)
    half = [
        chrmc.compute_field(cloud.select(s), SMALL, WAVELENGTH, method="rt")
        for s in (slice(0, 140), slice(140, None))
    ]
    whole = chrmc.compute_field(cloud, SMALL, WAVELENGTH, method="rt")
    assert relative_error(half[0] + half[1], whole) < 1e-5


def test_one_by_one_a_wave_is_the_same_whatever_others_there_are() -> None:
    """Steep and plain ones, and such as cancel: what was put in can be taken out."""
    panel = SLM("s", 40, 30, 1e-5)
    cloud = cloud_at(0.01, 1e-4, 6)
    aside = np.array([[a, a, 0] for a in (0, 1e-3, 1.4e-3, 1.6e-3, 2e-3, 3e-3)])
    cloud = chrmc.PointCloud(cloud.positions + aside, cloud.amplitude, cloud.phase)
    less = chrmc.PointCloud(cloud.positions, -cloud.amplitude, cloud.phase).select([1, 2, 4])

    def made(*clouds: chrmc.PointCloud) -> np.ndarray:
        given = chrmc.PointCloud.concatenate(clouds), panel, WAVELENGTH
        window = Window(0, 30, 0, 40)
        return rt.one_by_one(*given, window, UNLIMITED)

    left, whole = made(cloud.select([0, 3, 5])), made(cloud)
    assert np.abs(made(cloud, less) - left).max() < 3e-7 * np.abs(whole).max()
    assert np.abs(whole + made(less) - left).max() < 3e-7 * np.abs(whole).max()
    assert np.abs(made(cloud.select([1, 2, 4]), less)).max() < 3e-7 * np.abs(whole).max()


def test_extremes_of_amplitude() -> None:
    cloud = cloud_at(0.05, 3e-4, count=4)
    dark = chrmc.PointCloud(cloud.positions, np.zeros(4), cloud.phase)
    assert not chrmc.compute_field(dark, SMALL, WAVELENGTH, method="rt").any()
    empty = chrmc.compute_field(chrmc.PointCloud.empty(), SMALL, WAVELENGTH, method="rt")
    assert empty.shape == SMALL.shape and not empty.any()


def test_what_all_but_cancels_past_double_precision_is_refused() -> None:
    positions = [[0.0, 0.0, 0.12], [1e-13, 0.0, 0.12]]
    pair = chrmc.PointCloud(positions, np.ones(2), np.array([0, np.pi]))
    slm = SLM("panel", 20, 30, 2e-6)
    with pytest.raises(ValueError, match="rt promises 1e-05; leave out"):
        chrmc.compute_field(pair, slm, 532e-9, "rt")
