"""Parameter extraction: the motions that objects take, from exact and from quantised positions."""

from dataclasses import replace

import numpy as np
import pytest

import chrmc
from chrmc.compensation.ch_rmc_paper.carry import Rotation, Translation, moved
from chrmc.compensation.ch_rmc_paper.plan import motions, place, plan
from chrmc.scene.car_house import ARCS, STEP
from chrmc.scene.path import arc_path
from chrmc.scene.scene import ObjectFrame, Pose, SceneFrame


def track(*moves: Rotation | Translation | None) -> np.ndarray:
    cloud = chrmc.PointCloud(np.array([[1e-3, 2e-4, 0.25]]), np.ones(1), np.zeros(1))
    places = [cloud.positions[0]]
    for move in moves:
        cloud = moved(cloud, move)
        places.append(cloud.positions[0])
    return np.array(places)


def test_every_kind_of_step_is_found_again() -> None:
    arc = Rotation((-2e-3, 0.266), 4e-3)
    back = Rotation(arc.centre, -arc.angle)
    line = Translation((5e-5, 0.0, -3e-5))
    rise = Translation((0.0, 4e-5, 0.0))
    moves = [arc] * 8 + [None] * 3 + [back] * 8 + [line] * 6 + [None] * 2 + [rise] * 4
    found = motions(track(*moves))
    assert sorted(found) == list(range(2, len(moves) + 2))
    for number, move in enumerate(moves, 2):
        motion = found[number]
        if move is None:
            assert motion is None
        elif isinstance(move, Rotation):
            assert isinstance(motion, Rotation)
            np.testing.assert_allclose(motion.centre, move.centre, atol=1e-8)
            assert motion.angle == pytest.approx(move.angle, rel=1e-5)
        else:
            assert isinstance(motion, Translation)
            np.testing.assert_allclose(motion.by, move.by, atol=1e-12)


def test_gaps_have_no_step() -> None:
    path = track(*[Rotation((-2e-3, 0.266), 4e-3)] * 9)
    path[4] = np.nan
    found = motions(path)
    assert 5 not in found and 6 not in found
    assert isinstance(found[3], Rotation) and isinstance(found[9], Rotation)


def test_the_built_in_car() -> None:
    found = plan(chrmc.load_scene("car-house"))
    assert not any(found["house"].values())
    car = [found["car"][n] for n in range(2, 81)]
    assert all(isinstance(s, Rotation) and s.angle == pytest.approx(STEP, rel=1e-6) for s in car)
    assert len({s.centre for s in car if isinstance(s, Rotation)}) == 3


class Centroids:
    """A scene of which only centroids are known, quantised like those of depth images."""

    name, form, object_names = "centroids", "rgbd", ("car",)
    wavelength, pixel_pitch = None, 40.5e-6

    def __init__(self, noise: float) -> None:
        places, _, _ = arc_path(np.radians(-12), STEP, ARCS)
        self.places = places + np.array([5e-3, 0.252])
        self.places += np.random.default_rng(0).normal(0, noise, self.places.shape)
        self.frame_count = len(places)

    def frame(self, number: int) -> SceneFrame:
        x, z = self.places[number - 1]
        cloud = chrmc.PointCloud(np.array([[x, 1e-3, z]]), np.ones(1), np.zeros(1))
        return SceneFrame(number, (ObjectFrame("car", cloud),))


def test_noisy_centroids_still_give_arcs() -> None:
    found = plan(Centroids(1e-6))["car"]
    turned = [s.angle for s in found.values() if isinstance(s, Rotation)]
    assert len(turned) > 55
    assert np.median(turned) == pytest.approx(STEP, rel=0.3)


def test_a_known_pose_is_preferred_to_the_centroid() -> None:
    scene = chrmc.load_scene("car-house")
    obj = scene.frame(3).objects[0]
    assert obj.pose is not None
    moved_pose = Pose(obj.pose.rotation, obj.pose.translation + 1.0)
    np.testing.assert_array_equal(place(replace(obj, pose=moved_pose)), obj.pose.translation + 1.0)
    np.testing.assert_array_equal(place(replace(obj, pose=None)), obj.position)
