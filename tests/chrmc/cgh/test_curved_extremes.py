"""The curved hologram at the ends of its domain: within tolerance, or refused with the number."""

import numpy as np
import pytest

from chrmc import LC_R_1080, SLM, PointCloud, compute_field
from chrmc.cgh import curved
from chrmc.encoding import coding_for
from chrmc.optics.footprint import reach
from chrmc.reference import reference_samples, relative_error
from chrmc.window import Window

GREEN = 532e-9


def box(count: int, size: tuple[float, ...], centre: tuple[float, ...]) -> PointCloud:
    random = np.random.default_rng(count)
    return PointCloud(
        (random.random((count, 3)) - 0.5) * size + centre,
        random.uniform(0.2, 1, count),
        random.uniform(0, 6.3, count),
    )


def check(
    slm: SLM, wavelength: float, cloud: PointCloud, tolerance: float, encoding: str = "real"
) -> None:
    band = coding_for(encoding, slm).passband
    field = compute_field(cloud, slm, wavelength, "curved", passband=band, tolerance=tolerance)
    random = np.random.default_rng(0)
    pixels = int(min(800, 300_000 / len(cloud) + 50))
    rows, columns = random.integers(0, slm.height, pixels), random.integers(0, slm.width, pixels)
    truth = reference_samples(cloud, slm, wavelength, rows, columns, passband=band)
    assert relative_error(field[rows, columns], truth) <= tolerance


@pytest.mark.parametrize("tolerance", [1e-2, 1e-5])
@pytest.mark.parametrize(
    ("depth", "size"),
    [
        (1e-3, (1e-3, 1e-3, 2e-4)),
        (1e-2, (1e-3, 5e-4, 2e-3)),
        (1.0, (5e-3, 5e-3, 1e-2)),
        (100.0, (0.4, 0.3, 5.0)),
    ],
)
def test_depths_from_a_millimetre_to_a_hundred_metres(
    depth: float, size: tuple[float, ...], tolerance: float
) -> None:
    check(SLM("s", 300, 201, 8.1e-6), GREEN, box(60, size, (0, 0, depth)), tolerance)


@pytest.mark.parametrize("wavelength", [380e-9, 1.5e-6])
@pytest.mark.parametrize(("pitch", "depth"), [(1e-6, 2e-3), (40e-6, 0.5)])
def test_wavelengths_and_pitches(wavelength: float, pitch: float, depth: float) -> None:
    cloud = box(50, (2e-4,) * 3, (1e-5, 0, depth))
    check(SLM("s", 260, 171, pitch), wavelength, cloud, 1e-4)


@pytest.mark.parametrize(("width", "height"), [(1, 1), (1, 900), (901, 1), (640, 427), (427, 640)])
def test_any_shape(width: int, height: int) -> None:
    check(SLM("s", width, height, 8.1e-6), GREEN, box(700, (5e-4,) * 3, (0, 0, 0.2)), 1e-4)


def test_an_object_thicker_than_its_distance() -> None:
    check(SLM("s", 320, 200, 8.1e-6), GREEN, box(120, (1e-3, 1e-3, 0.19), (0, 0, 0.1)), 1e-3)


@pytest.mark.parametrize("encoding", ["ssb", "real"])
def test_the_last_pixel_that_can_show_a_point(encoding: str) -> None:
    band = coding_for(encoding, LC_R_1080).passband
    x = LC_R_1080.x()[-1] + 0.25 * reach(GREEN, band.fx_max) - 2.5e-4
    y = LC_R_1080.y()[0] - 0.25 * reach(GREEN, band.fy_max) + 2.5e-4
    cloud = box(80, (1e-4, 1e-4, 1e-4), (x, y, 0.25))
    # Only a corner sees it: errors are taken there.
    field = compute_field(cloud, LC_R_1080, GREEN, "curved", passband=band, tolerance=1e-3)
    rows, columns = (v.ravel() for v in np.mgrid[0:40, 1880:1920])
    truth = reference_samples(cloud, LC_R_1080, GREEN, rows, columns, passband=band)
    assert np.linalg.norm(truth) > 0
    assert relative_error(field[rows, columns], truth) <= 1e-3
    assert not field[60:, :].any() and not field[:, :1850].any()
    beyond = PointCloud(cloud.positions + np.array([4e-4, 0, 0]), cloud.amplitude, cloud.phase)
    with pytest.raises(ValueError, match="can be shown by no pixel"):
        compute_field(beyond, LC_R_1080, GREEN, "curved", passband=band)


def test_hopeless_work_is_refused_before_it_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(curved.baseband, "MOST_WAVES", 1e3)
    monkeypatch.setattr(curved.baseband, "_MOST_TERMS", 2)
    cloud = box(40, (1e-3, 1e-3, 5e-4), (0, 0, 1e-3))
    slm = SLM("s", 300, 201, 8.1e-6)
    full, band = Window.full(slm), coding_for("real", slm).passband
    for quick in (1e9, 0):  # whole, and cut into sub-clusters
        monkeypatch.setattr(curved.baseband, "_QUICK", quick)
        with pytest.raises(ValueError, match=r"points at [01]\.\d+ mm would take .* waves each"):
            curved.low_rank(cloud, slm, GREEN, full, band)


@pytest.mark.long
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
@pytest.mark.parametrize(
    ("slm", "wavelength", "cloud"),
    [
        (SLM("s", 4096, 4096, 4e-6), GREEN, box(100, (1e-3,) * 3, (0, 0, 0.25))),
        (SLM("s", 4095, 4093, 40e-6), 1.5e-6, box(1000, (0.2, 0.2, 1), (0, 0, 100.0))),
        (SLM("s", 1000, 1000, 1e-6), 380e-9, box(200, (2e-4, 2e-4, 1e-4), (0, 0, 1e-3))),
        (LC_R_1080, GREEN, box(500, (2e-3, 2e-3, 2e-4), (0, 0, 1e-3))),
        (LC_R_1080, GREEN, box(1000, (1e-3, 1e-3, 0.25), (0, 0, 0.225))),
        (LC_R_1080, GREEN, box(2000, (12e-3, 8e-3, 5e-3), (0, 0, 0.25))),
        (LC_R_1080, GREEN, box(1000, (0.5, 0.5, 2), (1.0, 0.5, 100.0))),
        (LC_R_1080, GREEN, box(1_000_000, (1.6e-3, 6e-4, 7e-4), (0, 0, 0.252))),
    ],
    ids=["4096", "100 m", "1 µm", "1 mm", "thick", "wide", "far", "million"],
)
def test_extremes_at_full_size(
    slm: SLM, wavelength: float, cloud: PointCloud, tolerance: float
) -> None:
    check(slm, wavelength, cloud, tolerance)
