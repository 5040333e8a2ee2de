"""The motion between two poses carries every point from the one to the other."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from chrmc import load_scene
from chrmc.scene.path import rotation_y
from chrmc.scene.rigid import relative_motion
from chrmc.scene.scene import Pose

BODY = np.random.default_rng(0).normal(0, 1e-3, (20, 3))


@settings(max_examples=60, deadline=None)
@given(
    st.floats(-3, 3),
    st.floats(-3.1, 3.1).filter(lambda a: abs(a) > 1e-6),
    st.tuples(st.floats(-0.05, 0.05), st.floats(0.1, 0.4)),
)
def test_turn_about_a_vertical_axis(start, angle, centre):
    before = Pose(rotation_y(start), np.array([0.01, 2e-3, 0.25]))
    axis = np.array([centre[0], 0, centre[1]])
    turn = rotation_y(angle)
    after = Pose(turn @ before.rotation, turn @ (before.translation - axis) + axis)
    motion = relative_motion(before, after)
    assert motion.kind == "rotation"
    assert motion.angle == pytest.approx(angle, abs=1e-12)
    assert motion.centre == pytest.approx(centre, abs=1e-14 / abs(angle) + 1e-12)
    assert motion.rise == pytest.approx(0, abs=1e-15)
    assert motion.apply(before.apply(BODY)) == pytest.approx(after.apply(BODY), abs=1e-13)


def test_the_car_turns_about_the_centres_of_its_arcs():
    scene = load_scene("car-house")
    poses = [scene.frame(n).objects[0].pose for n in (20, 21, 22)]
    first, second = (relative_motion(a, b) for a, b in pairwise(poses))
    for motion, radius in ((first, 15.68e-3), (second, 36.74e-3)):
        assert np.degrees(motion.angle) == pytest.approx(0.303)
        arm = np.array(motion.centre) - poses[1].translation[[0, 2]]
        assert np.linalg.norm(arm) == pytest.approx(radius)
        assert arm[1] > 0


def test_translation_and_rest():
    before = Pose(rotation_y(0.4), np.array([0.01, 2e-3, 0.25]))
    after = Pose(before.rotation, before.translation + np.array([1e-3, 0, -2e-3]))
    motion = relative_motion(before, after)
    assert motion.kind == "translation" and motion.angle == 0 and motion.centre is None
    assert motion.shift == pytest.approx([1e-3, 0, -2e-3])
    still = relative_motion(before, Pose(before.rotation.copy(), before.translation.copy()))
    assert still.kind == "none" and not still.shift.any()


def test_turning_on_the_spot():
    before = Pose(np.eye(3), np.array([0.01, 2e-3, 0.25]))
    motion = relative_motion(before, Pose(rotation_y(-0.2), before.translation))
    assert motion.kind == "rotation" and motion.angle == pytest.approx(-0.2)
    assert motion.centre == pytest.approx((0.01, 0.25))


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6))
def test_any_rigid_motion(seed):
    rng = np.random.default_rng(seed)
    before, after = (
        Pose(Rotation.random(random_state=rng).as_matrix(), rng.normal(0, 0.1, 3)) for _ in range(2)
    )
    motion = relative_motion(before, after)
    assert motion.kind == "rigid"
    assert motion.apply(before.apply(BODY)) == pytest.approx(after.apply(BODY), abs=1e-12)
    again = Rotation.from_rotvec(motion.angle * motion.axis).as_matrix()
    assert again == pytest.approx(motion.rotation, abs=1e-12)
