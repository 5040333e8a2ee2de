"""A Screen under slmsuite: its own simulated camera looks at what is on the screen."""

import warnings

import numpy as np
import pytest

import chrmc
import display
from reconstruct import decode_field

pytest.importorskip("slmsuite")
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from slmsuite.hardware.cameras.simulated import SimulatedCamera
    from slmsuite.hardware.slms.simulated import SimulatedSLM
    from slmsuite.holography import toolbox

    from display.slmsuite_slm import ScreenSLM

PANEL = chrmc.SLM("phase", 128, 96, 8e-6)


def test_its_simulated_camera_sees_the_spot_where_it_was_sent() -> None:
    twin = SimulatedSLM((PANEL.width, PANEL.height), pitch_um=(8, 8), wav_um=0.532)
    camera = SimulatedCamera(twin)
    with display.Screen(headless=True, slm=PANEL) as screen:
        slm = ScreenSLM(screen, 532e-9, settle_time_s=0)
        assert slm.shape == PANEL.shape and slm.wav_um == pytest.approx(0.532)
        for across, down in ((0, 0), (20, -10), (-31, 7)):
            k = across * 0.532 / (PANEL.width * 8), down * 0.532 / (PANEL.height * 8)
            slm.set_phase(toolbox.phase.blaze(slm, k))
            assert slm.flip.shown == "new" and not slm.flip.late
            twin.set_phase(screen.read()[..., 0])  # integers: what light meets, not what was asked
            picture = camera.get_image()
            place = np.unravel_index(picture.argmax(), picture.shape)
            assert place == (PANEL.height // 2 + down, PANEL.width // 2 + across)
        slm.close()
        screen.show(np.zeros(PANEL.shape, np.uint8))  # its owner's still


def test_on_an_amplitude_panel_the_phases_are_encoded() -> None:
    y, x = PANEL.y()[:, None], PANEL.x()[None, :]
    wanted = 2 * np.pi * (x * 4e3 - y * 5e3) + 1e6 * x * x
    with display.Screen(headless=True, slm=PANEL) as screen:
        slm = ScreenSLM(screen, 532e-9, encoding="ssb", settle_time_s=0)
        slm.set_phase(wanted.astype(np.float32))
        found = decode_field(screen.read()[..., 0], PANEL, "ssb")
        field = np.exp(1j * wanted)
        alike = abs(np.vdot(field, found)) / np.linalg.norm(field) / np.linalg.norm(found)
        assert alike > 0.97  # the ends of the band are cut
        with pytest.raises(ValueError, match="unknown encoding"):
            ScreenSLM(screen, encoding="sbs")
