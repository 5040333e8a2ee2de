"""What a panel resolves: figures by hand, and the focus's own definition by propagation."""

import numpy as np
import pytest

from chrmc.optics.passband import Passband, full_band
from chrmc.optics.resolution import apertures, depth_of_focus, resolution
from chrmc.slm import LC_R_1080, SLM

WAVELENGTH = 532e-9


def test_the_paper_s_panel_at_250_mm() -> None:
    band = full_band(LC_R_1080)
    y, x = resolution(LC_R_1080, WAVELENGTH, 0.25, band)
    assert (y, x) == (pytest.approx(13.68e-6, rel=1e-3), pytest.approx(8.55e-6, rel=1e-3))
    y, x = depth_of_focus(LC_R_1080, WAVELENGTH, 0.25, band)
    assert (y, x) == (pytest.approx(0.7038e-3, rel=1e-3), pytest.approx(0.275e-3, rel=1e-3))


def test_near_the_panel_the_footprint_is_the_aperture_and_resolution_is_the_pixel_s() -> None:
    slm = SLM("square", 1000, 1000, 10e-6)
    half = Passband(slm.nyquist, slm.nyquist / 2)
    y, x = apertures(slm, WAVELENGTH, 0.02, half)
    assert x == pytest.approx(2 * 0.02 * np.tan(np.arcsin(WAVELENGTH * slm.nyquist)), rel=1e-9)
    assert y == pytest.approx(2 * 0.02 * np.tan(np.arcsin(WAVELENGTH * slm.nyquist / 2)), rel=1e-9)
    # λz/A with A = 2zλf is 1/(2f): the pixel, and twice it where half the band is left.
    y, x = resolution(slm, WAVELENGTH, 0.02, half)
    assert x == pytest.approx(slm.pixel_pitch, rel=1e-3)
    assert y == pytest.approx(2 * slm.pixel_pitch, rel=1e-3)


def test_a_defocus_of_that_depth_delays_the_edge_by_a_quarter_wave() -> None:
    """Rayleigh's limit: out of focus by δ, an aperture's edge is late by (A/2)²·δ/(2z²)."""
    slm = SLM("wide", 800, 400, 10e-6)
    z = 0.3
    for size, focus in zip(
        apertures(slm, WAVELENGTH, z, full_band(slm)),
        depth_of_focus(slm, WAVELENGTH, z, full_band(slm)),
        strict=True,
    ):
        late = (size / 2) ** 2 * focus / (2 * z**2)
        assert late == pytest.approx(WAVELENGTH / 4, rel=1e-9)
