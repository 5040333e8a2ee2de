"""What object-centred CH-RMC books: key frames by all pixels, strips by theirs."""

import numpy as np
import pytest

import chrmc
from chrmc import SLM, WAVELENGTH, PointCloud
from chrmc.optics.footprint import reach
from chrmc.scene.point_scene import PointScene
from chrmc.scene.scene import Pose

PANEL = SLM("panel", 320, 200, 16e-6)


def test_strips_are_a_part_of_the_panel_and_a_key_frame_all_of_it() -> None:
    random = np.random.default_rng(5)
    body = PointCloud(
        (random.random((120, 3)) - 0.5) * (6e-4, 4e-4, 3e-4), np.ones(120), random.random(120) * 6
    )
    # At 60 mm footprints end 1 mm from their points: soft edges cross the panel.
    poses = [Pose.from_rotvec([0, 0.004 * k, 0], [2e-5 * k, 0, 0.06]) for k in range(4)]
    scene = PointScene("turning", {"body": body}, {"body": poses}, {})
    frames = list(
        chrmc.video(scene, PANEL, cgh="curved", compensation="ch-rmc-object", reuse="always")
    )
    assert [frame.record.key for frame in frames] == [True, False, False, False]
    pixels = PANEL.width * PANEL.height
    for frame in frames:
        # Soft is a lit pixel on which some point's edge may fall: all but the flat rectangle.
        z = frame.cloud.positions[:, 2]
        lit, flat = 1, 1
        for axis, places in enumerate((PANEL.x(), PANEL.y())):
            half, at = z * reach(WAVELENGTH, PANEL.nyquist), frame.cloud.positions[:, axis]
            lit *= int(np.sum((places > np.min(at - half)) & (places < np.max(at + half))))
            low, high = np.max(at - 0.9 * half), np.min(at + 0.9 * half)
            flat *= int(np.sum((places >= low) & (places <= high)))
        assert 0 < flat < lit < pixels
        record = frame.record
        if record.key:
            assert record.blank_share == 0 and record.point_pixels == len(frame.cloud) * pixels
        else:
            assert record.blank_share == pytest.approx((lit - flat) / pixels, rel=0.02)
            assert record.point_pixels == pytest.approx(len(frame.cloud) * (lit - flat), rel=0.02)
