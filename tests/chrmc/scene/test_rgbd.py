"""Images to points and back; bad images are refused with numbers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from chrmc import PointCloud, load_scene
from chrmc.scene.rgbd import (
    DepthPlanes,
    RGBDFrame,
    clouds_to_frame,
    frame_to_cloud,
    pixel_phases,
)

PITCH = 40.5e-6
PLANES = DepthPlanes(244e-3, 0.1e-3, 256)


@st.composite
def frames(draw, planes=PLANES, most_ids=3):
    """Random RGB-D frames with depths on planes."""
    shape = draw(st.tuples(st.integers(1, 7), st.integers(1, 7)))
    light = draw(
        arrays(
            np.float32,
            shape,
            elements=st.one_of(st.just(0.0), st.floats(2**-20, 2**10, width=32)),
        )
    )
    plane = draw(arrays(np.int64, shape, elements=st.integers(0, planes.count - 1)))
    ids = draw(arrays(np.int32, shape, elements=st.integers(1, most_ids)))
    depth = np.where(light > 0, planes.first + plane * planes.step, 0)
    return RGBDFrame(light, depth, ids)


def same(a, b):
    return (
        np.array_equal(a.intensity, b.intensity)
        and np.array_equal(a.depth, b.depth)
        and np.array_equal(a.object_id, b.object_id)
    )


@settings(max_examples=60, deadline=None)
@given(frames())
def test_points_and_back_loses_nothing(frame):
    clouds = {int(i): frame_to_cloud(frame, PITCH, object_id=i) for i in (1, 2, 3)}
    assert same(clouds_to_frame(clouds, frame.shape, PITCH, PLANES), frame)


@settings(max_examples=60, deadline=None)
@given(frames())
def test_single_precision_depths_come_back_to_their_planes(frame):
    lit = frame.lit
    assert np.array_equal(PLANES.snap(frame.depth[lit].astype(np.float32)), frame.depth[lit])


def test_pixels_are_centred_on_the_axis():
    light = np.zeros((240, 320), np.float32)
    light[0, 0] = light[119, 160] = 4.0
    frame = RGBDFrame(light, np.full((240, 320), 0.25), np.ones((240, 320), int))
    corner, middle = frame_to_cloud(frame, PITCH).positions
    assert corner == pytest.approx([-159.5 * 40.5e-6, -119.5 * 40.5e-6, 0.25])
    assert middle == pytest.approx([0.5 * 40.5e-6, -0.5 * 40.5e-6, 0.25])
    assert frame_to_cloud(frame, PITCH).amplitude == pytest.approx(2.0)


def test_the_nearest_point_wins_its_pixel():
    points = PointCloud([[0, 0, 0.26], [1e-6, 0, 0.25], [0, 0, 0.255]], [1, 2, 3], np.zeros(3))
    frame = clouds_to_frame({7: points}, (3, 3), PITCH)
    assert np.argwhere(frame.lit).tolist() == [[1, 1]]
    assert (frame.intensity[1, 1], frame.depth[1, 1], frame.object_id[1, 1]) == (4, 0.25, 7)


def test_phases_belong_to_pixels():
    scene = load_scene("car-house", form="rgbd")
    phases = pixel_phases(scene.shape, scene.phase_seed)
    for number in (1, 50):
        cloud = scene.frame(number).objects[0].cloud
        column = np.rint(cloud.positions[:, 0] / scene.pixel_pitch + 159.5).astype(int)
        row = np.rint(cloud.positions[:, 1] / scene.pixel_pitch + 119.5).astype(int)
        assert np.array_equal(cloud.phase, phases[row, column])
    house = [scene.frame(n).objects[1].cloud for n in (1, 80)]
    assert np.array_equal(house[0].phase, house[1].phase)
    assert np.array_equal(house[0].positions, house[1].positions)


def good(shape=(4, 5)):
    return [np.ones(shape, np.float32), np.full(shape, 0.25), np.ones(shape, np.int32)]


@pytest.mark.parametrize(
    ("which", "value", "message"),
    [
        (0, np.nan, "intensity is NaN: 1 pixels, the first at row 2, column 3"),
        (0, np.inf, "intensity is infinite"),
        (0, -0.5, "intensity is negative .down to -0.5."),
        (1, np.nan, "depth is NaN: 1 pixels, the first at row 2, column 3"),
        (1, np.inf, "depth is not a positive"),
        (1, 0.0, "depth is not a positive"),
        (1, -0.25, "depth is not a positive"),
        (2, -3, "object id"),
    ],
)
def test_bad_pixels_are_refused_with_their_place(which, value, message):
    images = good()
    images[which][2, 3] = value
    with pytest.raises(ValueError, match=message):
        RGBDFrame(*images)


def test_nan_is_refused_even_in_the_background():
    intensity, depth, ids = good()
    intensity[2, 3], depth[2, 3] = 0, np.nan
    with pytest.raises(ValueError, match="depth is NaN"):
        RGBDFrame(intensity, depth, ids)


def test_background_may_be_anywhere_but_nan():
    intensity, depth, ids = good()
    intensity[2, 3], depth[2, 3], ids[2, 3] = 0, np.inf, -1
    intensity[0, 0], depth[0, 0] = 0, -5
    assert len(frame_to_cloud(RGBDFrame(intensity, depth, ids), PITCH)) == 18


def test_ids_must_be_whole():
    intensity, depth, _ = good()
    with pytest.raises(ValueError, match="whole number"):
        RGBDFrame(intensity, depth, np.full((4, 5), 1.5))


def test_sizes_must_agree():
    with pytest.raises(ValueError, match=r"depth is \(5, 4\), but intensity \(4, 5\)"):
        RGBDFrame(np.ones((4, 5)), np.ones((5, 4)), np.ones((4, 5), int))


def test_an_empty_frame_is_legal():
    assert len(frame_to_cloud(RGBDFrame.empty((3, 4)), PITCH)) == 0
    assert not clouds_to_frame({1: PointCloud.empty()}, (3, 4), PITCH, PLANES).lit.any()


def test_depths_outside_the_planes_are_counted():
    with pytest.raises(ValueError, match=r"2 depths from 243\.9 to 270 mm lie outside"):
        PLANES.snap(np.array([243.9e-3, 0.25, 0.27]))


def test_points_outside_the_raster_are_counted():
    points = PointCloud([[1e-3, 0, 0.25], [0, 0, 0.25]], [1, 1], [0, 0])
    with pytest.raises(ValueError, match="1 of 2 points lie outside the 3 × 3 raster"):
        clouds_to_frame({1: points}, (3, 3), PITCH)


@pytest.mark.parametrize("name", ["car-house", "car-house-deep"])
def test_built_in_images_agree_with_the_built_in_points(name):
    images, points = load_scene(name, form="rgbd"), load_scene(name)
    assert images.form == "rgbd" and images.shape == (240, 320)
    counts = []
    for number in range(1, 81, 13):
        seen, exact = images.frame(number), points.frame(number)
        counts.append(len(seen.cloud))
        index = (seen.cloud.positions[:, 2] - 244e-3) / 0.1e-3
        assert index == pytest.approx(np.rint(index), abs=1e-9)
        for a, b in zip(seen.objects, exact.objects, strict=True):
            assert a.name == b.name and a.body is None and a.ids is None
            low, high = b.cloud.positions.min(axis=0), b.cloud.positions.max(axis=0)
            slack = np.array([1.5 * PITCH, 1.5 * PITCH, 0.15e-3])
            assert np.all(a.cloud.positions.min(axis=0) >= low - slack)
            assert np.all(a.cloud.positions.max(axis=0) <= high + slack)
            assert a.depth == pytest.approx(b.depth, abs=0.1e-3)
    assert np.mean(counts) == pytest.approx(1208, rel=0.05)
