"""The verdict sees shape: pictures of wrong objects at the right place and depth."""

import json

import numpy as np
import pytest

from chrmc import SLM, PointCloud, compute_field
from chrmc.encoding import coding_for
from chrmc.light_map import LightMap
from chrmc.optics.propagation import Patch
from display import encode
from reconstruct import FourF
from reconstruct.focus import cells_of
from reconstruct.likeness import correlation, dimmed, lateral_shift
from reconstruct.region import target_stack
from reconstruct.stack import FocalStack, focal_stack
from reconstruct.verdict import Target, judge_frame

P, LAMBDA = 8.1e-6, 532e-9
SLM_ = SLM("small", 480, 400, P)
BAND = coding_for("ssb", SLM_).passband
SYSTEM = FourF(SLM_, LAMBDA)


def cloud_of(positions, seed=0, constant=False):
    n = len(positions)
    phase = np.random.default_rng(seed).uniform(0, 6.283, n)
    return PointCloud(positions, np.ones(n), 0 * phase if constant else phase)


def step(z=0.07, depth=2.5e-3, count=1200, seed=1):
    """A lopsided surface: an L whose arms slope away."""
    u = np.random.default_rng(seed).uniform(-1, 1, (4 * count, 2))
    u = u[(u[:, 0] < -0.3) | (u[:, 1] > 0.4)][:count]
    relief = u[:, 0] + 0.5 * u[:, 1]
    return np.column_stack([0.7e-3 * u[:, 0], 0.5e-3 * u[:, 1], z + depth / 2 * relief])


PLACES = step()
SCENE = cloud_of(PLACES)
CENTRE = SCENE.centroid
TARGET = Target.of_cloud("step", SCENE, SYSTEM)
TARGET_PATCH = Patch((0.1e-3, -0.2e-3), (90, 110), 2 * P)


def verdict(cloud, target=TARGET, noise=0.0):
    field = compute_field(cloud, SLM_, LAMBDA, "curved", passband=BAND)
    if noise:
        rng = np.random.default_rng(5)
        size = noise * np.sqrt(np.mean(np.abs(field) ** 2) / 2)
        more = rng.standard_normal((2, *field.shape)) * size
        field = (field + more[0] + 1j * more[1]).astype(np.complex64)
    return judge_frame(encode(field, SLM_), SYSTEM, [target], 40e-6)


def away(factors):
    """The scene's points, their places about the centroid multiplied."""
    return cloud_of(CENTRE + (PLACES - CENTRE) * factors)


@pytest.mark.parametrize("noise", [0.0, 1.0])
@pytest.mark.parametrize("constant", [False, True])
def test_the_right_object_passes(noise, constant):
    found = verdict(cloud_of(PLACES, 3, constant), noise=noise)
    shape = found.objects[0].shape
    assert found.passed and shape.picture > 0.9
    assert shape.relief == pytest.approx(1, abs=0.1) and shape.relief_known
    assert abs(found.objects[0].depth_error) < 5e-5
    assert np.hypot(*found.objects[0].lateral_error) < 6e-6
    assert len(shape.slices) > 1 and min(r for _, r in shape.slices) > 0.6
    assert found.light == pytest.approx(0.95 if noise == 0 else 0.65, abs=0.1)


@pytest.mark.parametrize(
    ("factors", "says"),
    [
        ((-1, 1, 1), "not the scene's"),
        ((1, -1, 1), "not the scene's"),
        ((0.5, 0.5, 0.5), "not the scene's"),
        ((0.0, 0.0, 0.0), "not the scene's"),
        ((1, 1, 0), "relief is flat"),
        ((1, 1, -1), "relief is inverted"),
    ],
)
def test_wrong_shapes_at_the_right_place_fail(factors, says):
    found = verdict(away(factors))
    assert not found.passed and says in "; ".join(found.objects[0].faults)


def test_a_hundred_random_points_and_drowning_noise_fail():
    rng = np.random.default_rng(7)
    places = rng.uniform(TARGET.low, TARGET.high, (100, 3))
    assert not verdict(cloud_of(places + CENTRE - places.mean(axis=0))).passed
    noisy = verdict(SCENE, noise=3.0)
    assert not noisy.passed and "noise" in noisy.faults[0]


@pytest.mark.parametrize("by", [(16e-6, 0, 0), (0, -20e-6, 0), (0, 0, 0.3e-3), (0, 0, -0.2e-3)])
def test_errors_have_the_sign_of_found_less_expected(by):
    found = verdict(cloud_of(PLACES + np.array(by), 4)).objects[0]
    assert found.lateral_error == pytest.approx(by[:2], abs=8e-6)
    assert found.depth_error == pytest.approx(by[2], abs=5e-5)


def test_cells_lie_on_whole_samples_from_the_edge_of_the_map():
    """A point in the middle of each corner cell lights that cell of the map, and of the picture."""
    low, high = np.array([-0.5e-3, -0.3e-3]), np.array([0.5e-3, 0.3e-3])
    light = LightMap.of_cloud(
        cloud_of(np.array([[*low, 0.07], [*high, 0.07]])), SLM_, LAMBDA, SYSTEM.band
    )
    stack, _, parts = target_stack(
        np.zeros(SLM_.shape, dtype=np.complex64),
        SYSTEM,
        Target("two", np.array([0, 0, 0.07]), np.append(low, 0.07), np.append(high, 0.07), light),
        40e-6,
    )
    rows, columns = light.light.shape
    assert stack.patch.shape == (rows * parts, columns * parts)
    y, x = stack.patch.coordinates()
    edge_y, edge_x = (
        c - n * light.cell / 2 for c, n in zip(light.centre, (rows, columns), strict=True)
    )
    assert y[0] - edge_y == pytest.approx(stack.patch.pitch / 2)
    assert x[0] - edge_x == pytest.approx(stack.patch.pitch / 2)
    assert light.light[2, 2] > 0.1 and light.light[-3, -3] > 0.1
    assert int((low[0] - edge_x) / light.cell) == 2 and int((low[1] - edge_y) / light.cell) == 2


def test_brightness_leaves_sharpness_alone_and_evens_light():
    rng = np.random.default_rng(0)
    plain = rng.random((7, 12, 12)).astype(np.float32) + 0.1
    dim = np.stack([np.full((12, 12), 0.9), np.full((12, 12), 0.3)])
    way = np.linspace(0, 1, 7)[:, None, None]
    shown = plain * (0.9 + way * (0.3 - 0.9)).astype(np.float32)
    depths, patch = np.linspace(0.1, 0.2, 7), Patch((0, 0), (12, 12), P)
    a = cells_of(FocalStack(depths, plain, patch), 4)
    b = cells_of(FocalStack(depths, shown, patch), 4, dim)
    assert np.allclose(a.light, b.light, rtol=1e-5)
    assert np.allclose(a.square, b.square, rtol=1e-5)
    assert np.allclose(a.sharpness, b.sharpness, rtol=1e-5)


def test_light_that_the_panel_does_not_show_is_not_expected():
    dim = np.ones((TARGET.light.light.shape[0] * 3, TARGET.light.light.shape[1] * 3))
    dim[: len(dim) // 2] = 0.1
    seen = dimmed(TARGET.light, dim).light
    assert seen.sum() == pytest.approx(1)
    top, bottom = (
        seen[part].sum() / TARGET.light.light[part].sum()
        for part in (slice(0, len(seen) // 2), slice(len(seen) // 2 + 1, None))
    )
    assert top == pytest.approx(0.1 * bottom)


def test_a_deep_object_and_an_object_far_away_pass():
    deep = cloud_of(step(0.08, 12e-3, 900))
    found = verdict(deep, Target.of_cloud("deep", deep, SYSTEM)).objects[0]
    assert found.passed and found.shape.relief == pytest.approx(1, abs=0.05)
    far = cloud_of(step(3.0, 1e-3, 900) * [12, 12, 1])
    found = verdict(far, Target.of_cloud("far", far, SYSTEM)).objects[0]
    assert found.passed and found.depth_tolerance > 0.1
    moved = cloud_of(far.positions + np.array([0, 0, 1.2]))
    assert not verdict(moved, Target.of_cloud("far", far, SYSTEM)).passed


def test_what_is_too_small_to_have_a_shape_is_not_judged():
    point = cloud_of(np.array([[1e-4, 2e-4, 0.07]]))
    found = verdict(point, Target.of_cloud("point", point, SYSTEM)).objects[0]
    assert found.passed and not found.shape.told and not found.shape.relief_known


def test_far_planes_are_the_near_ones():
    """The same planes by both ways, where both can go."""
    from reconstruct import stack

    cloud = cloud_of(step(0.25, 1e-3, 60))
    field = compute_field(cloud, SLM_, LAMBDA, "curved", passband=BAND)
    depths = np.array([0.246, 0.25, 0.254])
    near = focal_stack(field, SLM_, LAMBDA, depths, TARGET_PATCH, BAND)
    far = np.array(list(stack._far_planes(field, SLM_, LAMBDA, depths, TARGET_PATCH)))
    assert np.linalg.norm(near.intensity - far) < 0.03 * np.linalg.norm(near.intensity)


def test_a_map_survives_its_record():
    light = TARGET.light
    again = LightMap.from_record(json.loads(json.dumps(light.as_record())))
    assert len(json.dumps(light.as_record())) < 3000
    assert again.cell == light.cell and again.centre == light.centre
    assert np.abs(again.light - light.light).max() < 0.01 * light.light.max()
    assert light.light.sum() == pytest.approx(1) and again.light.sum() == pytest.approx(1)
    lit = light.light > 0
    assert np.abs(again.depth - light.depth)[lit].max() < 1e-5
    assert (again.depth * again.light).sum() == pytest.approx(CENTRE[2], abs=1e-5)


@pytest.mark.parametrize(
    "change", [{"data": "AAAA"}, {"shape": [9999, 9999]}, {"cell": -1.0}, {"depths": [1]}]
)
def test_damaged_maps_are_told(change):
    with pytest.raises(ValueError, match="map of light"):
        LightMap.from_record(TARGET.light.as_record() | change)


def test_a_map_moves_with_its_object():
    whole = cloud_of(PLACES + np.array([10 * P, -7 * P, 0]))
    a, b = TARGET.light, LightMap.of_cloud(whole, SLM_, LAMBDA, SYSTEM.band)
    assert np.allclose(a.light, b.light, atol=1e-12)
    assert np.subtract(b.centre, a.centre) == pytest.approx((-7 * P, 10 * P))
    assert LightMap.of_cloud(PointCloud.empty(), SLM_, LAMBDA, SYSTEM.band) is None


def test_shifts_of_a_part_of_a_cell():
    x = np.arange(12.0)

    def blob(cx, cy):
        return np.exp(-((x - cx) ** 2)[None, :] / 4 - ((x - cy) ** 2)[:, None] / 4)

    dx, dy = lateral_shift(blob(5.7, 4.9), blob(5.5, 5.2), 10.0)
    assert dx == pytest.approx(2, abs=0.3) and dy == pytest.approx(-3, abs=0.3)
    assert correlation(blob(5, 5), 3 * blob(5, 5) + 2) == pytest.approx(1)
    assert correlation(np.ones((3, 3)), blob(5, 5)[:3, :3]) == 0
