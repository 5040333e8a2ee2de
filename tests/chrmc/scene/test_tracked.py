"""Points followed through RGB-D frames by ids and poses: the same bodies as were drawn."""

import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from chrmc.scene.folder import write_scene
from chrmc.scene.load import load_scene
from chrmc.scene.point_scene import PointScene
from chrmc.scene.points import PointCloud
from chrmc.scene.rgbd import DepthPlanes
from chrmc.scene.rgbd_scene import RGBDScene, rasterised
from chrmc.scene.scene import Pose
from chrmc.scene.tracked import tracked

PITCH = 40.5e-6


def turned(angle: float, x: float, z: float) -> Pose:
    c, s = np.cos(angle), np.sin(angle)
    return Pose(np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]), np.array([x, 0, z]))


def drawn(poses: list[Pose], planes: DepthPlanes | None = None, side: int = 9) -> RGBDScene:
    """A plate of points two pixels apart, and pictures of it with the poses told."""
    steps = (np.arange(side) - side // 2) * 2 * PITCH
    x, y = (grid.ravel() for grid in np.meshgrid(steps, steps))
    rng = np.random.default_rng(3)
    cloud = PointCloud(
        np.stack([x, y, np.zeros_like(x)], axis=1), rng.uniform(0.5, 1, len(x)), np.zeros(len(x))
    )
    points = PointScene("plate", {"plate": cloud}, {"plate": poses})
    pictures = rasterised(points, (6 * side + 6, 8 * side + 8), planes)
    return replace(pictures, poses={"plate": poses})


@pytest.mark.parametrize("planes", [None, DepthPlanes(0.244, 1e-4, 256)])
def test_a_moving_plate_s_points_are_known_again(planes: DepthPlanes | None) -> None:
    poses = [turned(0.01 * k, 13e-6 * k, 0.25) for k in range(12)]
    told = drawn(poses, planes)
    scene = tracked(told)
    assert scene is not None and scene.form == "points"
    assert len(scene.bodies["plate"]) == 81
    for number in (1, 6, 12):
        shown, pictured = scene.frame(number).objects[0], told.frame(number).objects[0]
        assert len(shown.cloud) == len(pictured.cloud)
        step = PITCH if planes is None else planes.step
        for mine in shown.cloud.positions:
            apart = np.abs(pictured.cloud.positions - mine) / (PITCH, PITCH, step)
            assert apart.max(axis=1).min() <= 1.01
        assert shown.pose is not None and shown.pose.same_as(poses[number - 1])


def test_a_point_s_phase_and_light_stay_its_own() -> None:
    told = drawn([turned(0.0, 9e-6 * k, 0.25) for k in range(6)])
    scene = tracked(told)
    assert scene is not None
    first, last = scene.frame(1).objects[0], scene.frame(6).objects[0]
    assert first.ids is not None and last.ids is not None
    both = np.intersect1d(first.ids, last.ids)
    assert len(both) == 81
    for values in ("phase", "amplitude"):
        a, b = (getattr(o.cloud, values)[np.searchsorted(o.ids, both)] for o in (first, last))
        assert np.array_equal(a, b)
    again = tracked(told)
    assert again is not None
    assert np.array_equal(again.frame(6).cloud.phase, scene.frame(6).cloud.phase)


def test_a_long_folder_takes_less_than_a_bit_for_each_point_and_frame() -> None:
    told = drawn([turned(0.0, 1e-6 * k, 0.25) for k in range(40)], side=31)
    held = []
    for count in (8, 40):
        poses = {"plate": told.poses["plate"][:count]}
        tracemalloc.start()
        scene = tracked(replace(told, frame_count=count, poses=poses))
        held.append(tracemalloc.get_traced_memory()[0])
        tracemalloc.stop()
        assert scene is not None and len(scene.frame(count).cloud) == 31 * 31
    assert (held[1] - held[0]) / 32 < 31 * 31 / 8


def test_what_changes_its_light_or_depth_is_a_new_point() -> None:
    told = drawn([turned(0.0, 0.0, 0.25)] * 2)
    first = told.read(1)
    changed = type(first)(first.intensity.copy(), first.depth.copy(), first.object_id)
    rows, columns = np.nonzero(first.lit)
    changed.intensity[rows[0], columns[0]] *= 1.5
    changed.depth[rows[1], columns[1]] += 3 * PITCH
    pictures = RGBDScene(
        "plate", lambda n: first if n == 1 else changed, 2, told.shape, PITCH, told.objects,
        poses=told.poses,
    )  # fmt: skip
    scene = tracked(pictures)
    assert scene is not None
    assert len(scene.bodies["plate"]) == 83
    assert len(scene.frame(2).cloud) == 81
    assert scene.frame(2).cloud.intensity.sum() == pytest.approx(changed.intensity.sum(), rel=0.1)


def test_a_folder_with_ids_and_poses_is_points_and_without_stays_pictures(tmp_path: Path) -> None:
    write_scene(load_scene("car-house", form="rgbd"), tmp_path / "s", frames=(1, 4))
    scene = load_scene(tmp_path / "s")
    assert scene.form == "points" and scene.frame_count == 4
    pictures = load_scene(tmp_path / "s", form="rgbd")
    assert pictures.form == "rgbd"
    for number in (1, 4):
        a, b = scene.frame(number), pictures.frame(number)
        for mine, theirs in zip(a.objects, b.objects, strict=True):
            assert len(mine.cloud) == len(theirs.cloud)
            assert mine.position == pytest.approx(theirs.position, abs=2e-5)
    described = tmp_path / "s" / "scene.json"
    described.write_text(described.read_text().replace('"poses"', '"were_poses"'))
    assert load_scene(tmp_path / "s").form == "rgbd"
