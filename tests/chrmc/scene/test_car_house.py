"""The built-in scenes have the numbers that their specification states."""

import itertools

import numpy as np
import pytest

from chrmc import load_scene
from chrmc.scene.car_house import STEP
from chrmc.scene.scene import Pose

SCENES = ("car-house", "car-house-deep")
PAIRS = [(n, n + 1) for n in range(1, 80, 8)]
LOOKED_AT = [*itertools.chain(*PAIRS), 80]
"""Frames whose points are looked at; poses are looked at in all."""


@pytest.fixture(scope="module", params=SCENES)
def scene(request):
    return load_scene(request.param)


@pytest.fixture(scope="module")
def frames(scene):
    return {n: scene.frame(n) for n in LOOKED_AT}


@pytest.fixture(scope="module")
def poses(scene):
    """Of the car."""
    return [scene.pose("car", n) for n in range(1, scene.frame_count + 1)]


def car_places(poses):
    """(80, 2) x and z of the car's origin, metres."""
    return np.array([p.translation[[0, 2]] for p in poses])


def headings(poses):
    """(80,) ψ of the car's nose: body −x goes to (−cos ψ, sin ψ) in (x, z)."""
    nose = np.array([p.rotation @ [-1, 0, 0] for p in poses])
    assert np.all(nose[:, 1] == 0)
    return np.arctan2(nose[:, 2], -nose[:, 0])


def test_eighty_frames_of_a_car_and_a_house(scene, frames):
    assert scene.frame_count == 80
    assert tuple(scene.object_names) == ("car", "house")
    assert scene.form == "points"
    assert scene.pixel_pitch == 40.5e-6
    for number, frame in frames.items():
        assert frame.number == number
        assert frame.objects[0].pose.same_as(scene.pose("car", number))
    with pytest.raises(ValueError, match="frames 1 to 80"):
        scene.frame(81)


def test_start_heading_and_turn(scene, poses):
    psi = headings(poses)
    assert np.degrees(psi[0]) == pytest.approx(-12 if scene.name == "car-house" else -30)
    assert np.degrees(np.diff(psi)) == pytest.approx(0.303)


def test_moves_along_its_nose_and_turns_away(poses):
    places, psi = car_places(poses), headings(poses)
    step = np.diff(places, axis=0)
    # A chord of an arc points half way between the tangents at its ends.
    middle = (psi[:-1] + psi[1:]) / 2
    direction = np.stack([-np.cos(middle), np.sin(middle)], axis=1)
    assert step / np.linalg.norm(step, axis=1, keepdims=True) == pytest.approx(direction)
    assert np.all(step[:, 0] < 0)


@pytest.mark.parametrize(
    ("first", "last", "radius"), [(1, 21, 15.68e-3), (21, 51, 36.74e-3), (51, 80, 17.53e-3)]
)
def test_three_arcs_with_centres_behind_the_car(poses, first, last, radius):
    places, psi = car_places(poses)[first - 1 : last], headings(poses)[first - 1 : last]
    centre = places + radius * np.stack([np.sin(psi), np.cos(psi)], axis=1)
    assert centre == pytest.approx(np.broadcast_to(centre[0], centre.shape), abs=1e-12)
    assert np.all(centre[:, 1] > places[:, 1])
    chord = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert chord == pytest.approx(2 * radius * np.sin(STEP / 2))


def test_place_of_the_path(scene, poses):
    places = car_places(poses)
    reach, low, high = {
        "car-house": (5.06e-3, 251.80e-3, 252.26e-3),
        "car-house-deep": (4.81e-3, 249.58e-3, 252.75e-3),
    }[scene.name]
    assert places[20, 1] == pytest.approx(252e-3)
    assert places[:, 0].max() == pytest.approx(reach, abs=6e-6)
    assert places[:, 0].min() == pytest.approx(-reach, abs=6e-6)
    assert places[:, 1].min() == pytest.approx(low, abs=6e-6)
    assert places[:, 1].max() == pytest.approx(high, abs=6e-6)
    assert {p.translation[1] for p in poses} == {1.2e-3}


def test_number_of_points(frames):
    car = np.array([len(f.objects[0].cloud) for f in frames.values()])
    house = len(frames[1].objects[1].cloud)
    assert (car + house).mean() == pytest.approx(1208, rel=0.05)
    assert car.mean() == pytest.approx(450, rel=0.1)
    assert house == pytest.approx(758, rel=0.05)


def test_visibility_changes_a_little_from_frame_to_frame(frames):
    ids = {n: f.objects[0].ids for n, f in frames.items()}
    share = np.array([len(np.setxor1d(ids[a], ids[b])) / len(ids[a]) for a, b in PAIRS])
    assert 0.002 < share.mean() < 0.022
    assert share.max() < 0.03


def test_sizes_and_places_of_the_bodies(frames):
    car, house = (o.body for o in frames[1].objects)
    assert np.ptp(car.positions, axis=0) == pytest.approx([1.6e-3, 0.62e-3, 0.7e-3], rel=0.08)
    assert np.ptp(house.positions, axis=0) == pytest.approx([1.05e-3, 1.1e-3, 0.85e-3], rel=0.08)
    assert frames[1].objects[1].pose.translation == pytest.approx([0, -0.9e-3, 264e-3])


def test_house_is_identical_in_all_frames(frames):
    first = frames[1].objects[1]
    for frame in frames.values():
        other = frame.objects[1]
        assert np.array_equal(first.cloud.positions, other.cloud.positions)
        assert np.array_equal(first.cloud.amplitude, other.cloud.amplitude)
        assert np.array_equal(first.cloud.phase, other.cloud.phase)
        assert first.pose.same_as(other.pose)


def test_points_are_fixed_to_the_body(frames):
    for frame in (frames[1], frames[41], frames[80]):
        for part in frame.objects:
            assert np.all(np.diff(part.ids) > 0)
            at = part.body.positions[part.ids] @ part.pose.rotation.T + part.pose.translation
            assert part.cloud.positions == pytest.approx(at, abs=1e-15)
            assert np.array_equal(part.cloud.phase, part.body.phase[part.ids])
            assert np.array_equal(part.cloud.amplitude, part.body.amplitude[part.ids])


def test_phases_are_random_and_the_same_in_every_run(scene, frames):
    phase = frames[1].cloud.phase
    assert abs(np.exp(1j * phase).mean()) < 4 / np.sqrt(len(phase))
    again = load_scene(scene.name).frame(41).cloud
    assert np.array_equal(again.positions, frames[41].cloud.positions)
    assert np.array_equal(again.phase, frames[41].cloud.phase)


def test_objects_keep_clear_of_each_other(frames):
    for frame in frames.values():
        car, house = (o.cloud.positions for o in frame.objects)
        assert car[:, 1].min() > house[:, 1].max()


def test_body_is_rigid(poses):
    for pose in poses:
        assert isinstance(pose, Pose)
        assert pose.rotation @ pose.rotation.T == pytest.approx(np.eye(3))
        assert np.linalg.det(pose.rotation) == pytest.approx(1)
