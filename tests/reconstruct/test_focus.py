import numpy as np
import pytest

from chrmc import LC_R_1080, SLM, PointCloud, compute_field, load_scene
from chrmc.encoding import coding_for
from chrmc.optics.propagation import Patch
from display import encode
from reconstruct import FourF
from reconstruct.focus import (
    centroid,
    find_focus,
    focus_curve,
    peak_middle,
    refine_peak,
    weighted_quantiles,
)
from reconstruct.focus_metrics import METRICS, metric_named
from reconstruct.stack import FocalStack, all_in_focus, brightness, focal_stack, patch_around
from reconstruct.verdict import Target, judge_frame

P, LAMBDA = 8.1e-6, 532e-9
SLM_ = SLM("small", 320, 320, P)


def show(cloud, slm=SLM_, seed=None):
    """Decoded field of a cloud and its system."""
    field = compute_field(cloud, slm, LAMBDA, passband=coding_for("ssb", slm).passband)
    system = FourF(slm, LAMBDA)
    return system.field(encode(field, slm)), system


def lattice(centre, size, pitch, tilt=0.0, seed=0):
    """Points on a plate of (width, height) metres, dz/dx = tilt, random phases."""
    x = np.arange(-size[0] / 2, size[0] / 2 + 1e-9, pitch)
    y = np.arange(-size[1] / 2, size[1] / 2 + 1e-9, pitch)
    xx, yy = np.meshgrid(x, y)
    points = np.column_stack([xx.ravel(), yy.ravel(), tilt * xx.ravel()]) + centre
    rng = np.random.default_rng(seed)
    return PointCloud(points, np.ones(len(points)), rng.uniform(0, 2 * np.pi, len(points)))


def test_stack_is_the_whole_planes_intensity():
    cloud = lattice((0.2e-3, -0.1e-3, 0.06), (0.3e-3, 0.3e-3), 60e-6)
    field, system = show(cloud)
    rows, columns = np.arange(120, 171), np.arange(150, 216)
    centre = ((145 - 159.5) * P, (182.5 - 159.5) * P)
    depths = np.linspace(0.057, 0.064, 5)
    stack = focal_stack(field, SLM_, LAMBDA, depths, Patch(centre, (51, 66), P), system.band)
    for i, d in enumerate(depths):
        want = np.abs(system.at(field, float(d)))[np.ix_(rows, columns)] ** 2
        assert np.linalg.norm(stack.intensity[i] - want) < 0.02 * np.linalg.norm(want)


def test_stack_of_the_whole_window_and_of_one_depth():
    cloud = lattice((0, 0, 0.06), (0.3e-3, 0.3e-3), 60e-6)
    field, system = show(cloud)
    stack = focal_stack(field, SLM_, LAMBDA, [0.06], band=system.band)
    want = np.abs(system.at(field, 0.06)) ** 2
    assert np.linalg.norm(stack.intensity[0] - want) < 0.02 * np.linalg.norm(want)
    assert stack.step == 0
    for wrong in ([], [-0.1], [0.2, 0.1], [np.nan]):
        with pytest.raises(ValueError, match="depths"):
            focal_stack(field, SLM_, LAMBDA, wrong)


@pytest.mark.parametrize("name", sorted(METRICS))
def test_each_metric_peaks_at_a_flat_objects_depth(name):
    field, system = show(lattice((0, 0, 0.06), (0.3e-3, 0.3e-3), 60e-6))
    depths = np.linspace(0.058, 0.062, 41)
    patch = patch_around((-0.2e-3, -0.2e-3), (0.2e-3, 0.2e-3), P, 0)
    stack = focal_stack(field, SLM_, LAMBDA, depths, patch, system.band)
    assert refine_peak(depths, focus_curve(stack, name)) == pytest.approx(0.06, abs=1e-4)


@pytest.mark.parametrize("name", sorted(METRICS))
def test_metrics_do_not_see_brightness_and_stand_darkness(name):
    image = np.random.default_rng(0).random((20, 30)) ** 4
    metric = metric_named(name)
    assert metric(7 * image) == pytest.approx(metric(image), rel=1e-6)
    assert metric(np.zeros((20, 30))) == 0
    assert np.isfinite(metric(np.ones((2, 2))))
    with pytest.raises(ValueError, match="focus metric"):
        metric_named("best")


def test_parabola_finds_its_own_top_and_ends_are_no_peaks():
    z = np.linspace(0, 1, 11)
    assert refine_peak(z, 3 - (z - 0.537) ** 2) == pytest.approx(0.537)
    assert np.isnan(refine_peak(z, z)) and np.isnan(refine_peak(z, -z))


@pytest.mark.parametrize("off", [-1.5e-3, 0.0, 1.2e-3])
def test_mean_depth_of_a_tilted_plate_wherever_the_search_is_centred(off):
    """Twice as deep as the depth of focus, and one end three times as bright: the mean leans."""
    cloud = lattice((0.1e-3, 0.1e-3, 0.08), (1.2e-3, 0.4e-3), 40e-6, tilt=1.5)
    bright = np.where(cloud.positions[:, 0] > 0.4e-3, np.sqrt(3.0), 1.0)
    cloud = PointCloud(cloud.positions, bright, cloud.phase)
    field, system = show(cloud)
    target = Target.of_cloud("plate", cloud)
    patch = patch_around(target.low, target.high, P, 80e-6, even=10)
    depths = target.position[2] + off + np.linspace(-4e-3, 4e-3, 41)
    stack = focal_stack(field, SLM_, LAMBDA, depths, patch, system.band)
    focus = find_focus(stack, 10)
    assert focus.focused
    assert focus.depth == pytest.approx(target.position[2], abs=1e-4)
    # Front and rear tenths of the light, apart.
    assert focus.front < target.position[2] - 0.4e-3
    assert focus.rear > target.position[2] + 0.3e-3
    assert focus.position[0] == pytest.approx(target.position[0], abs=40e-6)


def test_one_point():
    field, system = show(PointCloud([[0.2e-3, -0.3e-3, 0.07]], [1.0], [0.5]))
    depths = np.linspace(0.066, 0.073, 41)
    patch = patch_around((0.2e-3, -0.3e-3), (0.2e-3, -0.3e-3), P, 81e-6, even=10)
    focus = find_focus(focal_stack(field, SLM_, LAMBDA, depths, patch, system.band), 10)
    assert focus.focused
    assert focus.depth == pytest.approx(0.07, abs=1.5e-4)
    assert focus.position == pytest.approx((0.2e-3, -0.3e-3), abs=P)


@pytest.mark.parametrize("tilt", [0.0, 1.0])
def test_a_dense_surface_is_found_by_its_outline_and_texture(tilt):
    """Points closer than the resolution: speckle at every depth."""
    plate = lattice((0.1e-3, -0.1e-3, 0.05), (1.0e-3, 0.8e-3), 7e-6, tilt=tilt)
    stripes = np.floor(plate.positions[:, 0] / 0.16e-3) % 2 == 0
    plate = plate.select(stripes)
    field, system = show(plate)
    target = Target.of_cloud("plate", plate)
    patch = patch_around(target.low, target.high, P, 80e-6, even=10)
    depths = np.linspace(0.0465, 0.0545, 41)
    focus = find_focus(focal_stack(field, SLM_, LAMBDA, depths, patch, system.band), 10)
    assert focus.focused and focus.method == "region"
    assert focus.depth == pytest.approx(target.position[2], abs=3e-4)
    assert np.isnan(focus.front)


def test_the_middle_of_a_peak():
    z = np.linspace(0, 10, 101)
    assert peak_middle(z, 1 + np.maximum(0, 2 - np.abs(z - 4.33))) == pytest.approx(4.33, abs=0.02)
    assert np.isnan(peak_middle(z, z)) and np.isnan(peak_middle(z, np.ones(101)))


@pytest.mark.parametrize("seed", range(4))
def test_noise_and_darkness_have_no_focus(seed):
    noise = np.random.default_rng(seed).integers(0, 256, SLM_.shape, dtype=np.uint8)
    system = FourF(SLM_, LAMBDA)
    depths = np.linspace(0.058, 0.064, 41)
    patch = patch_around((-0.4e-3, -0.4e-3), (0.4e-3, 0.4e-3), P, 0)
    focus = find_focus(
        focal_stack(system.field(noise), SLM_, LAMBDA, depths, patch, system.band), 10
    )
    assert not focus.focused
    dark = FocalStack(depths, np.zeros((41, *patch.shape), dtype=np.float32), patch)
    focus = find_focus(dark, 10)
    assert not focus.focused and np.isnan(focus.depth) and np.isnan(focus.position[0])
    with pytest.raises(ValueError, match="5 depths"):
        find_focus(FocalStack(depths[:3], dark.intensity[:3], patch), 10)


def test_all_in_focus_takes_each_object_at_its_own_depth():
    near = lattice((-0.5e-3, 0, 0.060), (0.3e-3, 0.3e-3), 60e-6, seed=1)
    far = lattice((0.5e-3, 0, 0.064), (0.3e-3, 0.3e-3), 60e-6, seed=2)
    field, system = show(PointCloud.concatenate([near, far]))
    depths = np.linspace(0.058, 0.066, 33)
    stack = focal_stack(field, SLM_, LAMBDA, depths, band=system.band)
    image, depth = all_in_focus(stack)
    for cloud, z in ((near, 0.060), (far, 0.064)):
        rows = np.rint(cloud.positions[:, 1] / P + 159.5).astype(int)
        columns = np.rint(cloud.positions[:, 0] / P + 159.5).astype(int)
        assert np.median(depth[rows, columns]) == pytest.approx(z, abs=2.6e-4)
        plane = stack.intensity[np.argmin(np.abs(depths - z))]
        assert image[rows, columns].mean() > 0.9 * plane[rows, columns].mean()


def test_brightness_is_what_the_panel_receives():
    """Beside the panel's edge half of what it is on the axis; with depth as footprint over z²."""
    wide = Patch((0.0, 0.0), (1, 321), P)
    passband = coding_for("ssb", SLM_).passband
    near, _ = brightness(wide, SLM_, LAMBDA, (0.03, 0.3), passband)
    assert near[0, 160] == pytest.approx(1, abs=0.02)
    assert near[0, -1] == pytest.approx(0.5, abs=0.05)
    both = brightness(Patch((0.0, 0.0), (1, 1), P), SLM_, LAMBDA, (0.5, 1.0), passband)
    # So far away every footprint covers the panel: the inverse square alone is left.
    assert both[0, 0, 0] / both[1, 0, 0] == pytest.approx(4, rel=1e-6)
    # But a point near by lights a part of the panel that grows with its distance, per axis.
    pair = brightness(Patch((0.0, 0.0), (1, 1), P), SLM_, LAMBDA, (0.01, 0.02), passband)
    assert pair[0, 0, 0] / pair[1, 0, 0] == pytest.approx(1, abs=0.1)


def test_centroid_and_quantiles():
    patch = Patch((1e-3, -2e-3), (5, 7), 1e-5)
    image = np.zeros((5, 7))
    image[1, 2], image[1, 4] = 1, 3
    assert centroid(image, patch) == pytest.approx((-2e-3 + 0.5e-5, 1e-3 - 1e-5))
    values, weights = np.arange(101.0), np.ones(101)
    assert weighted_quantiles(values, weights, (0.1, 0.9)) == pytest.approx((10, 90), abs=1)


def test_two_bodies_taken_as_one():
    """A region with two depths: the mean lies where nothing is, and is found all the same."""
    near = lattice((-0.5e-3, 0.1e-3, 0.060), (0.4e-3, 0.3e-3), 50e-6, seed=1)
    far = lattice((0.5e-3, -0.2e-3, 0.066), (0.3e-3, 0.3e-3), 50e-6, seed=2)
    cloud = PointCloud.concatenate([near, far])
    field, system = show(cloud)
    target = Target.of_cloud("both", cloud)
    patch = patch_around(target.low, target.high, P, 80e-6, even=10)
    depths = np.linspace(0.0565, 0.0705, 71)
    focus = find_focus(focal_stack(field, SLM_, LAMBDA, depths, patch, system.band), 10)
    assert focus.focused
    assert focus.depth == pytest.approx(target.position[2], abs=3e-4)
    assert focus.front == pytest.approx(0.060, abs=4e-4)
    assert focus.rear == pytest.approx(0.066, abs=4e-4)
    assert focus.position == pytest.approx(tuple(target.position[:2]), abs=60e-6)


@pytest.mark.parametrize("number", [1, pytest.param(51, marks=pytest.mark.long)])
def test_the_car_and_the_house_at_full_size(number):
    scene = load_scene("car-house")
    frame = scene.frame(number)
    band = coding_for("ssb", LC_R_1080).passband
    field = compute_field(frame.cloud, LC_R_1080, LAMBDA, "curved", passband=band)
    system = FourF(LC_R_1080, LAMBDA)
    targets = [Target.of_cloud(o.name, o.cloud, system) for o in frame.objects]
    verdict = judge_frame(encode(field, LC_R_1080), system, targets, scene.pixel_pitch)
    assert verdict.passed
    for found in verdict.objects:
        assert abs(found.depth_error) < 1e-4
        assert np.hypot(*found.lateral_error) < 30e-6
