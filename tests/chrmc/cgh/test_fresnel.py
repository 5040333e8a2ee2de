"""`fresnel` against a float64 paraxial sum of its own, and its distance from the truth."""

import numpy as np

import chrmc
from chrmc.encoding import coding_for
from chrmc.optics.footprint import reach, taper
from chrmc.reference import reference_samples, relative_error
from chrmc.slm import LC_R_1080, SLM
from chrmc.window import Window

WAVELENGTH = chrmc.WAVELENGTH


def scene_like(count: int, seed: int = 0) -> chrmc.PointCloud:
    rng = np.random.default_rng(seed)
    positions = np.c_[
        rng.uniform(-5e-3, 5e-3, count),
        rng.uniform(-2e-3, 2e-3, count),
        rng.uniform(0.248, 0.265, count),
    ]
    return chrmc.PointCloud(positions, rng.uniform(0.1, 1, count), rng.uniform(0, 60, count))


def test_rounding_against_the_paraxial_sum_in_float64() -> None:
    cloud = scene_like(600)  # more than one chunk
    slm = SLM("wide", 1500, 40, 8.1e-6)
    band = coding_for("ssb", slm).passband
    x, y = slm.x()[None, :], slm.y()[:, None]
    truth = np.zeros(slm.shape, dtype=np.complex128)
    for (xj, yj, z), a, phase in zip(cloud.positions, cloud.amplitude, cloud.phase, strict=True):
        path = z + ((x - xj) ** 2 + (y - yj) ** 2) / (2 * z)
        weight = taper(x - xj, np.array(z * reach(WAVELENGTH, band.fx_max))) * taper(
            y - yj, np.array(z * reach(WAVELENGTH, band.fy_max))
        )
        truth += weight * a / z * np.exp(1j * (2 * np.pi / WAVELENGTH * path + phase))
    field = chrmc.compute_field(cloud, slm, WAVELENGTH, "fresnel", passband=band)
    assert field.dtype == np.complex64
    assert relative_error(field, truth) < 1e-5


def test_its_paraxial_error_is_what_the_docstring_says() -> None:
    cloud = scene_like(150)
    rng = np.random.default_rng(1)
    rows, columns = rng.integers(0, 1200, 2000), rng.integers(0, 1920, 2000)
    field = chrmc.compute_field(cloud, LC_R_1080, WAVELENGTH, "fresnel")
    truth = reference_samples(cloud, LC_R_1080, WAVELENGTH, rows, columns)
    assert 0.10 < relative_error(field[rows, columns], truth) < 0.20


def test_near_the_axis_it_is_the_truth() -> None:
    slm = SLM("small", 64, 48, 8.1e-6)
    cloud = chrmc.PointCloud(
        np.array([[1e-4, -5e-5, 0.25], [0, 0, 0.3]]), np.ones(2), np.array([0.0, 1.0])
    )
    field = chrmc.compute_field(cloud, slm, WAVELENGTH, "fresnel")
    assert relative_error(field, chrmc.reference_field(cloud, slm, WAVELENGTH)) < 1e-4


def test_a_window_is_a_crop() -> None:
    slm = SLM("small", 128, 96, 8.1e-6)
    cloud = scene_like(20).select(slice(0, 20))
    cloud = chrmc.PointCloud(cloud.positions * [0.05, 0.05, 0.1], cloud.amplitude, cloud.phase)
    whole = chrmc.compute_field(cloud, slm, WAVELENGTH, "fresnel")
    window = Window(10, 57, 31, 32)
    part = chrmc.compute_field(cloud, slm, WAVELENGTH, "fresnel", window=window)
    assert relative_error(part, whole[window.slices]) < 1e-5
