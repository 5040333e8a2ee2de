"""Bodies and panels on which the object surface once broke its promise, divided by zero or hung."""

import numpy as np
import pytest

import chrmc
from chrmc.bench.extremes import case_of, run
from chrmc.encoding import coding_for
from chrmc.reference import reference_field, relative_error
from chrmc.scene.point_scene import PointScene
from chrmc.slm import SLM


@pytest.mark.parametrize(
    "seed",
    [
        15,  # one pixel
        3010,  # one column, a long wavelength, near
        3025,  # one row
        1031,  # two points: their error stands in one corner
        6001,  # three points 17 m away: a strip of thousands of places
        8200321,  # seven points, most of whose error is in one row of pixels
        72001843,  # objects that graze the panel and cancel in part
        72003255,  # half of the error in a thousandth of the pixels, at corners
        72003872,  # light on a corner, a hundredth of the nodes
    ],
)
def test_the_promise_is_kept_or_refused(seed: int) -> None:
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        out = run(case_of(seed))
    assert not out.fault, out.fault
    assert out.seconds < 60


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
def test_a_body_of_one_place_is_shown(tolerance: float) -> None:
    """One point on the axis: the few nodes that it takes were refused."""
    slm, wavelength = SLM("small", 320, 200, 8e-6), 532e-9
    point = chrmc.PointCloud(np.zeros((1, 3)), np.ones(1), np.zeros(1))
    poses = [
        chrmc.Pose.from_rotvec([0, 0.3 * k, 0], [1e-4 * k, 0, 0.12 + 1e-3 * k]) for k in range(2)
    ]
    scene = PointScene("one", {"point": point}, {"point": poses})
    band = coding_for("real", slm).passband
    for frame in chrmc.video(
        scene, slm, wavelength, compensation="ch-rmc-object", tolerance=tolerance
    ):
        truth = reference_field(frame.cloud, slm, wavelength, passband=band)
        assert relative_error(frame.field, truth) <= tolerance


def test_a_body_that_comes_near_fast_is_shown() -> None:
    """Its points' phases change by more radians with the range than layers can be added up for."""
    slm, wavelength = SLM("small", 60, 40, 8e-6), 532e-9
    random = np.random.default_rng(3)
    body = chrmc.PointCloud(random.uniform(-2e-3, 2e-3, (30, 3)), np.ones(30), random.random(30))
    poses = [chrmc.Pose.from_rotvec([0, 1e-3 * k, 0], [0, 0, 0.3 - 0.02 * k]) for k in range(6)]
    scene = PointScene("near", {"body": body}, {"body": poses})
    band = coding_for("real", slm).passband
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        for frame in chrmc.video(
            scene, slm, wavelength, compensation="ch-rmc-object", tolerance=1e-3, reuse="always"
        ):
            truth = reference_field(frame.cloud, slm, wavelength, passband=band)
            assert relative_error(frame.field, truth) <= 1e-3
