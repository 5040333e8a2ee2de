"""Right pictures that are speckle, or one speck, and the same ones elsewhere in depth."""

import numpy as np
import pytest

from chrmc import SLM, PointCloud, compute_field
from chrmc.encoding import coding_for
from chrmc.optics.resolution import depth_of_focus, resolution
from display import encode
from reconstruct import FourF, report
from reconstruct.verdict import FrameVerdict, Target, judge_frame

SMALL = SLM("small", 256, 256, 8.1e-6)
GREEN = 532e-9


def judged(cloud, shown, slm, wavelength):
    """The verdict on `shown` where the scene has `cloud`."""
    band = coding_for("ssb", slm).passband
    field = compute_field(shown, slm, wavelength, "curved", passband=band, tolerance=1e-3)
    system = FourF(slm, wavelength)
    target = Target.of_cloud("it", cloud, system)
    frame = encode(field, slm)
    return judge_frame(frame, system, [target], 5 * slm.pixel_pitch).objects[0]


def moved(cloud, by):
    return PointCloud(cloud.positions + np.array([0, 0, by]), cloud.amplitude, cloud.phase)


def dense(share, depth, seed):
    """Two points to a resolution cell: a letter L over a share of the small panel, and its depth of
    focus."""
    random = np.random.default_rng(seed)
    band = coding_for("ssb", SMALL).passband
    width = share * SMALL.width * SMALL.pixel_pitch / 2
    fine = resolution(SMALL, GREEN, depth, band)
    count = int(8 * width**2 / (fine[0] * fine[1]))
    u = random.uniform(-1, 1, (count, 2))
    u = u[(u[:, 0] < -0.2) | (u[:, 1] > 0.3)]
    focus = max(depth_of_focus(SMALL, GREEN, depth, band))
    places = np.column_stack([u * width, depth + u @ [0.07, 0.05] * focus])
    cloud = PointCloud(places, np.ones(len(u)), random.uniform(0, 6.28, len(u)))
    return cloud, focus


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize(("share", "depth"), [(0.3, 0.12), (0.8, 0.12), (0.8, 0.3)])
def test_speckle_passes_where_it_is_and_nowhere_else(share, depth, seed):
    cloud, focus = dense(share, depth, seed)
    found = judged(cloud, cloud, SMALL, GREEN)
    assert found.passed, found.faults
    assert found.focus.method == "rim" and abs(found.depth_error) < 0.5 * focus
    for by in (-2.5 * focus, 2.5 * focus):
        assert not judged(cloud, moved(cloud, by), SMALL, GREEN).passed


@pytest.mark.parametrize("count", [1, 6, 200])
@pytest.mark.parametrize("at", [0.2, 0.4, 0.8])
def test_a_speck_far_from_the_axis_is_in_focus_where_it_stands(at, count):
    """Its light walks sideways by its own size within the depth of focus."""
    slm, wavelength, depth = SLM("fine", 1000, 800, 3.74e-6), 633e-9, 0.106
    random = np.random.default_rng(count)
    band = coding_for("ssb", slm).passband
    fine = resolution(slm, wavelength, depth, band)[::-1]
    focus = max(depth_of_focus(slm, wavelength, depth, band))
    middle = np.array([at * 500, at * 400]) * slm.pixel_pitch
    spread = random.uniform(-1.5, 1.5, (count, 2)) * fine if count > 1 else np.zeros((1, 2))
    places = np.column_stack([middle + spread, np.full(count, depth)])
    cloud = PointCloud(places, np.ones(count), random.uniform(0, 6.28, count))
    found = judged(cloud, cloud, slm, wavelength)
    assert found.passed, found.faults
    assert abs(found.depth_error) < 0.4 * focus
    assert not judged(cloud, moved(cloud, 2 * focus), slm, wavelength).passed


@pytest.mark.parametrize(("times", "doubted"), [(1, False), (5, True)])
def test_a_relief_that_speckle_hides_is_said_not_to_be_judged(times, doubted):
    cloud, _ = dense(0.8, 0.12, 0)
    places = (cloud.positions - [0, 0, 0.12]) * [1, 1, times] + [0, 0, 0.12]
    cloud = PointCloud(places, cloud.amplitude, cloud.phase)
    found = judged(cloud, cloud, SMALL, GREEN)
    assert found.passed and not found.shape.relief_known
    assert ("relief cannot be judged" in found.shape.doubt) == doubted
    lines = list(report.table([FrameVerdict(1, [found])]))
    assert all(("cannot be judged" in line) == doubted for line in lines[-2:])
