"""The curved hologram against the float64 sum of spherical waves."""

import re
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chrmc import LC_R_1080, SLM, WAVELENGTH, PointCloud, compute_field
from chrmc.cgh import curved
from chrmc.encoding import coding_for
from chrmc.optics.footprint import reach
from chrmc.optics.passband import full_band
from chrmc.reference import reference_field, reference_samples, relative_error
from chrmc.window import Window

PANEL = SLM("a quarter of the paper's", 480, 300, 8.1e-6)
DECADES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)


def box(count: int, size: tuple[float, ...], centre: tuple[float, ...], seed: int) -> PointCloud:
    random = np.random.default_rng(seed)
    positions = (random.random((count, 3)) - 0.5) * size + centre
    return PointCloud(positions, random.uniform(0.2, 1, count), random.uniform(-9, 9, count))


def samples(slm: SLM, count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    return random.integers(0, slm.height, count), random.integers(0, slm.width, count)


@cache
def two_boxes(name: str) -> tuple[PointCloud, np.ndarray]:
    """Points in two places, and their true field in the band of an encoding."""
    # At 60 mm the footprint ends 1 to 2 mm from a point: soft edges cross the block.
    cloud = PointCloud.concatenate(
        [
            box(60, (8e-4, 4e-4, 3e-4), (-6e-4, 3e-4, 0.06), 1),
            box(40, (3e-4,) * 3, (5e-4, -4e-4, 0.066), 2),
        ]
    )
    band = coding_for(name, PANEL).passband
    return cloud, reference_field(cloud, PANEL, WAVELENGTH, passband=band)


@pytest.mark.parametrize("tolerance", DECADES)
@pytest.mark.parametrize("name", ["ssb", "real"])
def test_every_tolerance_is_met(tolerance: float, name: str) -> None:
    cloud, truth = two_boxes(name)
    band = coding_for(name, PANEL).passband
    field = compute_field(cloud, PANEL, WAVELENGTH, "curved", passband=band, tolerance=tolerance)
    assert field.dtype == np.complex64
    error = relative_error(field, truth)
    assert error <= tolerance
    assert error >= 1e-3 * tolerance or tolerance < 1e-4, "far more work than was asked for"


def test_the_coded_signal_is_the_real_part_of_field_times_carrier() -> None:
    coding = coding_for("ssb", PANEL)
    cloud = box(70, (6e-4, 5e-4, 3e-4), (2e-4, 1e-4, 0.08), 3)
    window = Window(21, 280, 3, 470)
    truth = reference_field(
        cloud, PANEL, WAVELENGTH, window.rows, window.columns, passband=coding.passband
    )
    expected = (truth * np.exp(2j * np.pi * coding.carrier * PANEL.y(window.rows)[:, None])).real
    for tolerance in (1e-3, 1e-6):
        signal = curved.signal(cloud, PANEL, WAVELENGTH, window, coding, tolerance=tolerance)
        assert signal.dtype == np.float32 and signal.shape == window.shape
        assert np.linalg.norm(signal - expected) <= 1.1 * tolerance * np.linalg.norm(expected)


def test_full_panel_at_the_default_tolerance() -> None:
    band = coding_for("ssb", LC_R_1080).passband
    cloud = box(450, (1.6e-3, 0.62e-3, 0.7e-3), (-4e-3, 1.2e-3, 0.252), 4)
    rows, columns = samples(LC_R_1080, 1500)
    truth = reference_samples(cloud, LC_R_1080, WAVELENGTH, rows, columns, passband=band)
    field = compute_field(cloud, LC_R_1080, WAVELENGTH, "curved", passband=band)
    assert relative_error(field[rows, columns], truth) <= 1e-3


@pytest.mark.parametrize(
    "window", [Window(0, 300, 100, 131), Window(150, 151, 0, 480), Window(299, 300, 479, 480)]
)
def test_any_window(window: Window) -> None:
    cloud = box(900, (8e-4, 4e-4, 3e-4), (1e-4, 3e-4, 0.2), 5)
    truth = reference_field(cloud, PANEL, WAVELENGTH, window.rows, window.columns)
    field = compute_field(cloud, PANEL, WAVELENGTH, "curved", window=window, tolerance=1e-4)
    assert field.shape == window.shape
    assert relative_error(field, truth) <= 1e-4


def test_many_points_go_through_sub_clusters() -> None:
    slm = SLM("half", 960, 600, 8.1e-6)
    cloud = box(40_000, (1.6e-3, 0.62e-3, 0.7e-3), (-1e-3, 0.5e-3, 0.252), 6)
    band = full_band(slm)
    rows, columns = samples(slm, 200)
    truth = reference_samples(cloud, slm, WAVELENGTH, rows, columns, passband=band)
    made = curved.low_rank(cloud, slm, WAVELENGTH, Window.full(slm), band)
    field = curved.field_of(made.factors, slm, WAVELENGTH, Window.full(slm))
    assert relative_error(field[rows, columns], truth) <= 1e-3
    plane = curved.plane_of(slm, WAVELENGTH, Window.full(slm), band)
    box_ = curved.clusters.bounding_box(cloud.positions)
    assert curved.clusters.leaf_grid(box_, len(cloud), (200, 90), plane, 1e-3) != (1, 1, 1)


def test_objects_far_apart_get_a_reference_wave_each() -> None:
    cloud = PointCloud.concatenate(
        [
            box(300, (5e-4,) * 3, (-5e-3, 1e-3, 0.25), 7),
            box(300, (5e-4,) * 3, (5e-3, -1e-3, 0.26), 8),
        ]
    )
    plane = curved.plane_of(LC_R_1080, WAVELENGTH, Window.full(LC_R_1080), full_band(LC_R_1080))
    parts = curved.clusters.split(cloud, plane)
    assert [len(part) for part in parts] == [300, 300]
    assert all(np.ptp(part.positions[:, 0]) < 6e-4 for part in parts)
    # Their blocks of rows begin and end elsewhere.
    coding = coding_for("ssb", LC_R_1080)
    signal = curved.signal(cloud, LC_R_1080, WAVELENGTH, Window.full(LC_R_1080), coding)
    rows, columns = samples(LC_R_1080, 1500)
    truth = reference_samples(cloud, LC_R_1080, WAVELENGTH, rows, columns, passband=coding.passband)
    expected = (truth * np.exp(2j * np.pi * coding.carrier * LC_R_1080.y(rows))).real
    missed = np.linalg.norm(signal[rows, columns] - expected)
    assert missed <= 1.2e-3 * np.linalg.norm(expected)


@pytest.mark.parametrize("tolerance", [2e-7, 0.5, 0.0, -1e-3, float("nan")])
def test_a_tolerance_out_of_range_is_refused_with_the_range(tolerance: float) -> None:
    cloud = box(3, (1e-4,) * 3, (0, 0, 0.1), 9)
    with pytest.raises(ValueError, match=r"between 1e-06 and 0\.1, not|finite number, not"):
        compute_field(cloud, PANEL, WAVELENGTH, "curved", tolerance=tolerance)


def test_every_decade_of_tolerance_is_a_setting_to_try() -> None:
    tried = [setting["tolerance"] for setting in curved.METHOD.settings]
    assert tried == pytest.approx(list(DECADES))


def test_a_tolerance_that_cancelling_waves_put_out_of_reach_is_refused() -> None:
    # Pairs of opposite points a tenth of a micrometre apart leave a ten-thousandth of their light.
    places = np.random.default_rng(5).uniform(-1e-4, 1e-4, (100, 3)) + np.array([0, 0, 0.25])
    pairs = np.concatenate([places, places + np.array([1e-7, 0, 0])])
    cloud = PointCloud(pairs, np.ones(200), np.repeat([0.0, np.pi], 100))
    with pytest.raises(ValueError, match="cannot promise a tolerance of 1e-06 here: it expects"):
        compute_field(cloud, LC_R_1080, WAVELENGTH, "curved", tolerance=1e-6)


def test_the_tolerance_that_a_refusal_names_is_kept() -> None:
    """It names none where waves cancel so far that nobody knows."""
    random, named = np.random.default_rng(7), 0
    for _ in range(60):
        places = random.uniform(-1e-4, 1e-4, (20, 3)) + np.array([0, 0, 0.25])
        pairs = np.concatenate([places, places + np.array([10 ** random.uniform(-7, -4), 0, 0])])
        cloud = PointCloud(pairs, np.ones(40), np.repeat([0.0, np.pi], 20))
        given = cloud, PANEL, WAVELENGTH, Window.full(PANEL), full_band(PANEL)
        try:
            curved.low_rank(*given, tolerance=10 ** random.uniform(-6, -5))
        except ValueError as refused:
            said = re.search(r"allow (\S+), or use rt", str(refused))
            if said is not None:
                named += 1
                assert curved.low_rank(*given, tolerance=float(said[1])).factors
    assert named


def test_amplitudes_a_million_million_apart() -> None:
    near, far = box(60, (4e-4,) * 3, (0, 0, 0.1), 10), box(60, (4e-4,) * 3, (0, 0, 0.1), 11)
    dim = PointCloud(far.positions, far.amplitude * 1e-12, far.phase)
    bright = PointCloud(near.positions, near.amplitude * 1e12, near.phase)
    of_near, of_far = (reference_field(cloud, PANEL, WAVELENGTH) for cloud in (near, far))
    for cloud, truth in (
        (PointCloud.concatenate([near, dim]), of_near + 1e-12 * of_far),
        (bright, 1e12 * of_near),
        (dim, 1e-12 * of_far),
    ):
        field = compute_field(cloud, PANEL, WAVELENGTH, "curved", tolerance=1e-5)
        assert relative_error(field, truth) <= 1e-5


@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    st.integers(0, 2**32 - 1),
    st.floats(-6, np.log10(40e-6)),
    st.floats(380e-9, 1.5e-6),
    st.floats(-3, 2),
    st.sampled_from(DECADES),
    st.sampled_from(["ssb", "real"]),
)
def test_within_tolerance_or_refused_from_a_millimetre_to_a_hundred_metres(
    seed: int, log_pitch: float, wavelength: float, log_z: float, tolerance: float, name: str
) -> None:
    random = np.random.default_rng(seed)
    slm = SLM("any", *(int(v) for v in 10 ** random.uniform(0, 2.8, 2)), 10**log_pitch)
    band = coding_for(name, slm).passband
    z = 10**log_z
    size = 10 ** random.uniform(-5, -2, 3)
    size[2] = min(size[2], 1.9 * z) if seed % 3 else z * random.uniform(0.2, 1.9)
    half = np.array([slm.width, slm.height]) * slm.pixel_pitch / 2
    limits = np.array([reach(wavelength, f) for f in (band.fx_max, band.fy_max)])
    edge = half + np.minimum(z * limits, 1e3)
    centre = (*(edge * random.uniform(-0.95, 0.95, 2)), z)
    cloud = box(int(10 ** random.uniform(0, 2.2)), tuple(size), centre, seed)
    rows, columns = samples(slm, 400, seed)
    try:
        truth = reference_samples(cloud, slm, wavelength, rows, columns, passband=band)
        field = compute_field(cloud, slm, wavelength, "curved", passband=band, tolerance=tolerance)
    except ValueError as refusal:
        assert "\n" not in str(refusal) and any(c.isdigit() for c in str(refusal))
        return
    # Single precision, not the method, limits pixels where next to nothing is left.
    strongest = (cloud.amplitude / cloud.positions[:, 2]).max()
    difference = np.linalg.norm(field[rows, columns] - truth)
    floor = 1e-7 * strongest * np.sqrt(len(cloud) * rows.size)
    assert difference <= 1.1 * tolerance * np.linalg.norm(truth) + floor
