"""`car-house-dense`: the motion and places of car-house, a hundred thousand visible points."""

import numpy as np
import pytest

from chrmc import load_scene


@pytest.fixture(scope="module")
def scene():
    return load_scene("car-house-dense")


def test_size_motion_and_identity(scene) -> None:
    sparse = load_scene("car-house")
    assert scene.frame_count == 80
    assert scene.object_names == ("car", "house")
    before = None
    for number in (1, 2):
        dense, thin = scene.frame(number), sparse.frame(number)
        assert len(dense.cloud) == pytest.approx(100_000, rel=0.05)
        for mine, theirs in zip(dense.objects, thin.objects, strict=True):
            assert mine.pose.same_as(theirs.pose)
            assert mine.position == pytest.approx(theirs.position, abs=1.2e-4)
            at = mine.pose.apply(mine.body.positions[mine.ids])
            assert np.abs(mine.cloud.positions - at).max() <= 1e-15
        if number == 2:
            changed = len(np.setxor1d(before, dense.objects[0].ids)) / len(before)
            assert 0 < changed < 0.022
        before = dense.objects[0].ids


def test_the_same_frame_whenever_it_is_asked(scene) -> None:
    first = scene.frame(21).cloud
    for number in (1, 2, 60, 80):  # more than are kept
        scene.frame(number)
    again = scene.frame(21).cloud
    assert np.array_equal(first.positions, again.positions)
    assert np.array_equal(first.phase, again.phase)


def test_pictures_of_it() -> None:
    frame = load_scene("car-house-dense", form="rgbd").rgbd(21)
    assert frame.ids.tolist() == [1, 2]
    rows, columns = np.nonzero(frame.object_id == 1)
    # The car of frame 21 stands at x = 2.2 mm, y = 1.2 mm, the house above it on the axis.
    assert rows.min() > np.nonzero(frame.object_id == 2)[0].max()
    assert (columns.mean() - 159.5) * 40.5e-6 == pytest.approx(
        load_scene("car-house").frame(21).objects[0].position[0], abs=1e-4
    )
