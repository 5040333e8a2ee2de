"""`nlut` and `nlut-1d`: exact on the grid, corrected off it, equal to each other, within a cap."""

from types import ModuleType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import chrmc
from chrmc.cgh import nlut, nlut_1d
from chrmc.cgh.pfp import PFPTable
from chrmc.encoding import coding_for
from chrmc.optics.passband import UNLIMITED, full_band
from chrmc.reference import reference_field, relative_error
from chrmc.slm import LC_R_1080, SLM
from chrmc.window import Window

WAVELENGTH = chrmc.WAVELENGTH
SMALL = SLM("small", 96, 64, 8.1e-6)
ROWS = np.arange(3, 1200, 53)
COLUMNS = np.arange(2, 1920, 41)


def loose(count: int, seed: int = 0, shrink: float = 1.0) -> chrmc.PointCloud:
    rng = np.random.default_rng(seed)
    positions = np.c_[
        rng.uniform(-5e-3, 5e-3, count) * shrink,
        rng.uniform(-2e-3, 2e-3, count) * shrink,
        rng.uniform(0.25, 0.252, count),
    ]
    return chrmc.PointCloud(positions, rng.uniform(0.1, 1, count), rng.uniform(-9, 9, count))


def on_grid(cloud: chrmc.PointCloud, slm: SLM) -> chrmc.PointCloud:
    positions = cloud.positions.copy()
    for axis, count in ((0, slm.width), (1, slm.height)):
        middle = (count - 1) / 2
        positions[:, axis] = (np.rint(positions[:, axis] / 8.1e-6 + middle) - middle) * 8.1e-6
    positions[:, 2] = np.rint(positions[:, 2] * 1e4) * 1e-4
    return chrmc.PointCloud(positions, cloud.amplitude, cloud.phase)


def error(cloud: chrmc.PointCloud, coding: str = "real", **options: object) -> float:
    band = coding_for(coding, LC_R_1080).passband
    field = nlut.field(cloud, LC_R_1080, WAVELENGTH, Window.full(LC_R_1080), band, **options)
    truth = reference_field(cloud, LC_R_1080, WAVELENGTH, ROWS, COLUMNS, passband=band)
    return relative_error(field[np.ix_(ROWS, COLUMNS)], truth)


@pytest.mark.parametrize("coding", ["real", "ssb"])
def test_stated_errors_at_full_size(coding: str) -> None:
    cloud = loose(12)
    assert error(on_grid(cloud, LC_R_1080), coding) < 2e-6
    assert error(cloud, coding) < 2e-4
    assert 0.2 < error(cloud, coding, subpixel="round") < 0.8
    assert 0.05 < error(cloud, coding, pfp="fresnel") < 0.25


@settings(max_examples=40, deadline=None)
@given(
    st.integers(1, 90),
    st.integers(1, 70),
    st.sampled_from([1e-6, 8.1e-6, 40e-6]),
    st.floats(0.02, 3),
    st.booleans(),
    st.booleans(),
    st.integers(0, 999),
)
def test_any_panel_depth_and_offset(
    width: int, height: int, pitch: float, depth: float, bare: bool, own_planes: bool, seed: int
) -> None:
    slm = SLM("any", width, height, pitch)
    rng = np.random.default_rng(seed)
    size = 0.3 * pitch * min(width, height) + pitch
    positions = np.c_[rng.uniform(-size, size, (5, 2)), rng.uniform(depth, depth * 1.01, 5)]
    cloud = chrmc.PointCloud(positions, rng.uniform(0.5, 1, 5), rng.uniform(-3, 3, 5))
    band = UNLIMITED if bare else full_band(slm)
    step = None if own_planes else 1e-4
    field = nlut.field(cloud, slm, WAVELENGTH, Window.full(slm), band, depth_step=step)
    truth = reference_field(cloud, slm, WAVELENGTH, footprint=None if bare else "soft")
    scale = np.sqrt(np.sum(cloud.amplitude**2)) / depth
    # What a correction per axis leaves: the mixed term x²y²/4z³ under half a pixel's shift. Bare
    # waves reach farther than any footprint, so it counts for them.
    slope = (pitch * (width + height) / 2 + 2 * size) / depth
    mixed = 2 * np.pi / WAVELENGTH * slope**3 * pitch / 4
    assert np.sqrt(np.mean(np.abs(field - truth) ** 2)) < (1e-4 + mixed) * scale


@settings(max_examples=25, deadline=None)
@given(
    st.integers(0, 99),
    st.sampled_from(["exact", "round"]),
    st.booleans(),
    st.sampled_from([1e-4, 3e-4, None]),
)
def test_one_dimensional_form_equals_the_two_dimensional_fresnel(
    seed: int, subpixel: str, half_band: bool, step: float | None
) -> None:
    slm = SLM("any", 90, 70, 8.1e-6)
    loose_points = loose(9, seed, 0.3)
    cloud = chrmc.PointCloud.concatenate([loose_points, on_grid(loose_points, slm)])
    band = coding_for("ssb" if half_band else "real", slm).passband
    window = Window(3, 66, 20, 88)
    options = {"subpixel": subpixel, "depth_step": step}
    flat = nlut.field(cloud, slm, WAVELENGTH, window, band, pfp="fresnel", **options)
    assert (
        relative_error(nlut_1d.field(cloud, slm, WAVELENGTH, window, band, **options), flat) < 1e-5
    )


def test_one_dimensional_exact_form_is_the_fresnel_method() -> None:
    cloud = loose(30)
    one = chrmc.compute_field(cloud, SMALL, WAVELENGTH, "nlut-1d")
    assert relative_error(one, chrmc.compute_field(cloud, SMALL, WAVELENGTH, "fresnel")) < 1e-5


def test_near_points_with_footprints_inside_the_panel() -> None:
    rng = np.random.default_rng(2)
    positions = np.c_[
        rng.uniform(-5e-4, 5e-4, 20), rng.uniform(-3e-4, 3e-4, 20), rng.uniform(2e-3, 9e-3, 20)
    ]
    cloud = chrmc.PointCloud(positions, np.ones(20), rng.uniform(0, 6, 20))
    truth = reference_field(cloud, SMALL, WAVELENGTH)
    field = chrmc.compute_field(cloud, SMALL, WAVELENGTH, "nlut", depth_step=1e-5)
    assert relative_error(field, truth) < 1e-3
    assert (np.abs(field[np.abs(truth) == 0]) == 0).all()


def test_points_beyond_the_panel_and_windows() -> None:
    cloud = chrmc.PointCloud(
        np.array([[12e-3, 1e-3, 0.25], [-13.5e-3, -8e-3, 0.25], [0, 0, 0.2521]]),
        np.array([1.0, 2.0, 0.5]),
        np.array([0.0, 1.0, 2.0]),
    )
    for window in (Window(100, 300, 1800, 1920), Window(0, 40, 0, 90), Window(5, 6, 900, 901)):
        field = nlut.field(cloud, LC_R_1080, WAVELENGTH, window, full_band(LC_R_1080))
        truth = reference_field(cloud, LC_R_1080, WAVELENGTH, window.rows, window.columns)
        assert field.shape == window.shape and field.dtype == np.complex64
        assert relative_error(field, truth) < 2e-4


@pytest.mark.parametrize("method", [nlut, nlut_1d])
def test_patterns_are_kept_within_the_cap_and_only_for_depths_in_use(
    method: ModuleType,
) -> None:
    cloud = on_grid(loose(40, shrink=0.05), SMALL)
    cloud = cloud.select(np.arange(80) // 2)  # twice: a lone point's line needs no table
    band, whole = full_band(SMALL), Window.full(SMALL)
    depths = len(np.unique(np.rint(cloud.positions[:, 2] * 1e4)))
    per_depth = depths if method is nlut else 2 * depths
    table = PFPTable()
    first = method.field(cloud, SMALL, WAVELENGTH, whole, band, cache=table)
    assert len(table) <= table.built == per_depth and f"{len(table)} PFPs" in str(table)
    method.field(cloud, SMALL, WAVELENGTH, whole, band, cache=table)
    assert table.built == per_depth and table.reused >= per_depth
    tight = PFPTable(limit=table.nbytes // len(table) * 3)
    again = method.field(cloud, SMALL, WAVELENGTH, whole, band, cache=tight)
    assert tight.nbytes <= tight.limit and len(tight) <= 3
    assert np.array_equal(again, first)


def test_least_recently_used_goes_first() -> None:
    table = PFPTable(limit=8 * 30)
    for name in "abacd":
        table.at_least((name,), (10,), lambda shape: np.zeros(shape, dtype=np.complex64))
    assert table.built == 4  # a came again before b, the oldest, had to go for d
    table.at_least(("a",), (10,), lambda shape: np.zeros(shape, dtype=np.complex64))
    assert table.built == 4
    table.at_least(("b",), (10,), lambda shape: np.zeros(shape, dtype=np.complex64))
    assert table.built == 5


def test_a_pattern_grows_when_a_point_needs_more_of_it() -> None:
    table = PFPTable()
    near = chrmc.PointCloud(np.array([[0, 0, 0.25]]), np.ones(1), np.zeros(1))
    far = chrmc.PointCloud(np.array([[6e-3, -5e-3, 0.25]]), np.ones(1), np.zeros(1))
    band, whole = full_band(SMALL), Window.full(SMALL)
    for cloud in (near, far, near):
        field = nlut.field(cloud, SMALL, WAVELENGTH, whole, band, cache=table)
        assert relative_error(field, reference_field(cloud, SMALL, WAVELENGTH)) < 2e-4
    assert len(table) == 1 and table.built == 2


def test_refusals() -> None:
    cloud = loose(2)
    for options, words in (
        ({"subpixel": "off"}, "subpixel"),
        ({"depth_step": 0.0}, "depth_step"),
        ({"pfp": "round"}, "pfp"),
        ({"cache": PFPTable(limit=1000)}, "MiB"),
    ):
        with pytest.raises(ValueError, match=words):
            chrmc.compute_field(cloud, SMALL, WAVELENGTH, "nlut", **options)
    with pytest.raises(ValueError, match="limit"):
        PFPTable(limit=0)
