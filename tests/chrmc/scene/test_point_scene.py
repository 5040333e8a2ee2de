"""Scenes of one's own bodies and poses."""

import numpy as np
import pytest

from chrmc import PointCloud
from chrmc.scene.path import rotation_y
from chrmc.scene.point_scene import PointScene
from chrmc.scene.scene import Pose, frame_range

POINTS = PointCloud([[1e-3, 0, 0], [0, 1e-3, 0], [0, 0, 1e-3]], [1, 2, 3], [0.1, 0.2, 0.3])
POSES = [Pose(rotation_y(k * np.pi / 2), np.array([0, 0, 0.25])) for k in range(3)]


def test_rotation_about_y_carries_z_to_x_and_x_away_from_the_viewer():
    turn = rotation_y(np.pi / 2)
    assert turn @ [0, 0, 1] == pytest.approx([1, 0, 0])
    assert turn @ [1, 0, 0] == pytest.approx([0, 0, -1])
    assert turn @ [0, 1, 0] == pytest.approx([0, 1, 0])


def test_bodies_follow_their_poses():
    scene = PointScene("mine", {"a": POINTS, "b": POINTS}, {"a": POSES, "b": POSES[:1]})
    assert scene.frame_count == 3 and scene.object_names == ("a", "b")
    second = scene.frame(2)
    assert second.objects[0].cloud.positions == pytest.approx(
        np.array([[0, 0, 0.249], [0, 1e-3, 0.25], [1e-3, 0, 0.25]])
    )
    assert np.array_equal(second.objects[0].cloud.phase, POINTS.phase)
    assert second.objects[1].pose is POSES[0]
    assert len(second.cloud) == 6
    assert frame_range(scene, None) == range(1, 4)


@pytest.mark.parametrize("as_function", [False, True])
def test_visibility_chooses_points(as_function):
    masks = [np.array([1, 1, 0], bool), np.zeros(3, bool), np.ones(3, bool)]
    visible = (lambda number: masks[number - 1]) if as_function else masks
    scene = PointScene("mine", {"a": POINTS}, {"a": POSES}, {"a": visible})
    assert [scene.frame(n).objects[0].ids.tolist() for n in (1, 2, 3)] == [[0, 1], [], [0, 1, 2]]
    assert scene.frame(1).cloud.amplitude.tolist() == [1, 2]
    assert np.isnan(scene.frame(2).objects[0].depth)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (({}, {}), "no objects"),
        (({"a": POINTS}, {"b": POSES}), "both"),
        (({"a": POINTS, "b": POINTS}, {"a": POSES, "b": POSES[:2]}), "2 poses, but there are 3"),
        (({"a": POINTS}, {"a": POSES}, {"c": [np.ones(3, bool)]}), "unknown object 'c'"),
        (({"a": POINTS}, {"a": POSES}, {"a": [np.ones(3, bool)] * 2}), "2 visibility masks"),
        (({"a": POINTS}, {"a": POSES}, None, -1.0), "pixel_pitch"),
    ],
)
def test_what_does_not_fit_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        PointScene("mine", *arguments)


def test_a_mask_of_the_wrong_length_is_refused():
    scene = PointScene("mine", {"a": POINTS}, {"a": POSES}, {"a": [np.ones(2, bool)]})
    with pytest.raises(ValueError, match="mask over its 3 points"):
        scene.frame(1)
