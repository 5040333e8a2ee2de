"""Whole sequences by the published method: arcs, stops, reversals, several objects, the ledger."""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import chrmc
from chrmc.cgh import rt
from chrmc.compensation.frame import VideoFrame
from chrmc.reference import relative_error
from chrmc.scene.path import rotation_y
from chrmc.scene.point_scene import PointScene
from chrmc.scene.rgbd import DepthPlanes
from chrmc.scene.rgbd_scene import rasterised
from chrmc.scene.scene import Pose
from chrmc.slm import SLM, WAVELENGTH

PANEL = SLM("panel", 400, 64, 8.1e-6)
START = np.array([2e-4, 0.0, 0.25])
ANGLE = 1e-3
# In front of a centre 15 mm behind the object, a positive angle carries it towards −x.
ARC_1 = (START[0] - 1e-3, START[2] + 0.015)


def body(count: int, seed: int, y: float = 0.0) -> chrmc.PointCloud:
    rng = np.random.default_rng(seed)
    positions = rng.uniform(-1, 1, (count, 3)) * [2.5e-4, 1e-4, 1.5e-4] + [0, y, 0]
    return chrmc.PointCloud(positions, rng.uniform(0.4, 1, count), rng.uniform(0, 6.28, count))


def turn(pose: Pose, centre: tuple[float, float], angle: float) -> Pose:
    rotation = rotation_y(angle)
    pivot = np.array([centre[0], 0.0, centre[1]])
    return Pose(rotation @ pose.rotation, rotation @ (pose.translation - pivot) + pivot)


def slide(pose: Pose, by: tuple[float, float, float]) -> Pose:
    return Pose(pose.rotation, pose.translation + np.array(by))


def journey(*moves: Callable[[Pose], Pose], start: np.ndarray = START) -> list[Pose]:
    poses = [Pose(np.eye(3), start)]
    for move in moves:
        poses.append(move(poses[-1]))
    return poses


def on(centre: tuple[float, float], angle: float, count: int) -> list[Callable[[Pose], Pose]]:
    return [lambda pose: turn(pose, centre, angle)] * count


def scene_of(**objects: tuple[chrmc.PointCloud, list[Pose]]) -> PointScene:
    return PointScene(
        "test",
        {name: cloud for name, (cloud, _) in objects.items()},
        {name: poses for name, (_, poses) in objects.items()},
        pixel_pitch=40e-6,
    )


def frames(scene: Any, **options: Any) -> list[VideoFrame]:
    return list(
        chrmc.video(
            scene,
            PANEL,
            compensation="ch-rmc",
            surface="paper",
            radius=0.24,
            measure_reuse=True,
            **{"cgh": "rt", **options},
        )
    )


def truth_of(frame: VideoFrame) -> np.ndarray:
    return chrmc.compute_field(frame.shown, PANEL, WAVELENGTH, method="rt")


HOUSE = (body(8, 5), [Pose(np.eye(3), np.array([0.0, 1e-4, 0.26]))])


def test_arc_change_straight_line_stop_and_reversal() -> None:
    moves = on(ARC_1, ANGLE, 6)
    corner = journey(*moves)[-1].translation
    arc_2 = (float(corner[0]) + 2e-3, float(corner[2]) + 0.025)
    moves += on(arc_2, ANGLE, 6)
    moves += [lambda pose: pose] * 3
    moves += on(arc_2, -ANGLE, 6)
    moves += [lambda pose: slide(pose, (3e-5, 0, 1e-5))] * 5
    made = frames(scene_of(car=(body(25, 0), journey(*moves))), frames=(1, 27))
    records = [frame.record for frame in made]
    assert [r.number for r in records] == list(range(1, 28))
    assert [r.key for r in records] == [True] + [False] * 26
    for frame in made:
        error = relative_error(frame.field, truth_of(frame))
        assert error == pytest.approx(frame.record.error_reuse, abs=1e-3)
        assert error < 0.05
    still = records[13:16]
    assert all(r.point_pixels == 0 and r.blank_share == 0 for r in still)
    assert all("PA" not in r.stage_seconds for r in still)
    np.testing.assert_array_equal(made[12].field, made[15].field)
    turning = records[1:13] + records[16:22]
    assert all(0.05 < r.blank_share < 0.2 for r in turning)
    assert all({"PE", "PA", "CON", "RMC", "HC", "EC"} <= set(r.stage_seconds) for r in turning)
    # The object did go somewhere: the first frame is no substitute for the last.
    assert relative_error(made[0].field, truth_of(made[12])) > 1


def test_a_reversal_on_the_spot_comes_back() -> None:
    poses = journey(*on(ARC_1, ANGLE, 4), *on(ARC_1, -ANGLE, 4))
    made = frames(scene_of(car=(body(25, 1), poses)))
    assert max(f.record.error_reuse for f in made) < 0.05
    start, end = made[0].field, made[-1].field
    assert relative_error(end, start) < 0.05


def test_the_still_object_is_computed_once() -> None:
    calls: list[int] = []

    def counted(cloud: chrmc.PointCloud, *arguments: Any, **options: Any) -> np.ndarray:
        calls.append(len(cloud))
        return rt.field(cloud, *arguments, **options)

    scene = scene_of(car=(body(20, 0), journey(*on(ARC_1, ANGLE, 4))), house=HOUSE)
    made = list(
        chrmc.video(scene, PANEL, cgh=counted, compensation="ch-rmc", surface="paper", radius=0.24)
    )
    assert calls.count(8) == 1 and calls.count(20) >= 5
    assert made[0].record.points_computed == 28
    assert all(f.record.points_computed == 0 for f in made[1:])
    key, later = made[0].record, made[3].record
    assert key.point_pixels == 28 * PANEL.width * PANEL.height
    blank = later.blank_share * PANEL.width * PANEL.height
    assert later.point_pixels == pytest.approx(20 * blank)


def test_several_moving_objects_each_on_its_arc() -> None:
    other = np.array([-3e-4, 0.0, 0.24])
    centre = (float(other[0]) + 1e-3, float(other[2]) + 0.03)
    scene = scene_of(
        car=(body(20, 0, -1e-4), journey(*on(ARC_1, ANGLE, 5))),
        van=(body(15, 2, 1e-4), journey(*on(centre, -0.7e-3, 5), start=other)),
        house=HOUSE,
    )
    made = frames(scene)
    assert max(relative_error(f.field, truth_of(f)) for f in made) < 0.08
    assert not any(f.record.key for f in made[1:])


def test_motion_together_with_changed_visibility_is_corrected() -> None:
    cloud = body(30, 3)
    poses = journey(*on(ARC_1, ANGLE, 3))
    visible = np.ones((4, 30), dtype=bool)
    visible[0, :3] = visible[2, 3:6] = visible[3, 3:6] = False
    scene = PointScene(
        "test", {"car": cloud}, {"car": poses}, {"car": list(visible)}, pixel_pitch=40e-6
    )
    made = frames(scene, snr_threshold=np.inf)
    counts = [(f.record.points_added, f.record.points_removed) for f in made]
    assert counts == [(27, 0), (3, 0), (0, 3), (0, 0)]
    assert [f.record.points_computed for f in made] == [27, 3, 3, 0]
    assert max(relative_error(f.field, truth_of(f)) for f in made) < 0.08
    uncorrected = frames(scene, snr_threshold=-np.inf)
    assert relative_error(uncorrected[3].field, truth_of(made[3])) > 0.2


def test_corrections_of_a_still_object_are_exact() -> None:
    cloud = body(30, 3)
    visible = np.ones((3, 30), dtype=bool)
    visible[1, :4] = visible[2, 2:9] = False
    scene = PointScene(
        "test",
        {"car": cloud},
        {"car": [Pose(np.eye(3), START)] * 3},
        {"car": list(visible)},
        pixel_pitch=40e-6,
    )
    for frame in frames(scene):
        assert relative_error(frame.field, truth_of(frame)) < 1e-5


@pytest.fixture(scope="module")
def long_arc() -> PointScene:
    return scene_of(car=(body(15, 0), journey(*on(ARC_1, 2 * ANGLE, 7))), house=HOUSE)


def test_rekey_every(long_arc: PointScene) -> None:
    made = frames(long_arc, rekey_every=3)
    assert [f.number for f in made if f.record.key] == [1, 4, 7]
    assert [f.record.points_computed for f in made if f.record.key] == [23, 15, 15]
    assert made[3].record.error_reuse < 1e-5 < made[4].record.error_reuse


def test_rekey_on_field_error(long_arc: PointScene) -> None:
    free = [f.record.error_reuse for f in frames(long_arc)]
    limit = float(np.median(free[1:]))
    made = frames(long_arc, rekey_error=limit)
    assert all(f.record.error_reuse <= limit for f in made)
    keys = [f.record.key for f in made]
    assert 1 < sum(keys) < len(keys)
    assert keys.index(True, 1) == next(i for i, e in enumerate(free) if e > limit)


def test_reuse_is_measured_where_it_is_asked_for_or_decides(long_arc: PointScene) -> None:
    def errors(**options: Any) -> list[float | None]:
        made = chrmc.video(
            long_arc, PANEL, cgh="rt", compensation="ch-rmc-paper", radius=0.24, frames=(1, 3),
            **options,
        )  # fmt: skip
        return [frame.record.error_reuse for frame in made]

    assert errors() == [None] * 3
    decided = errors(rekey_error=1e-6)
    assert all(error is not None and error <= 1e-6 for error in decided)


def test_rekey_on_images(long_arc: PointScene) -> None:
    def measure(field: np.ndarray, again: np.ndarray, scene_frame: Any) -> dict[str, Any]:
        psnr = -20 * np.log10(relative_error(field, again) + 1e-9)
        return {"car": {"psnr": psnr}, "house": {"psnr": 200.0}}  # the worst object decides

    free = [f.record.image["car"]["psnr"] for f in frames(long_arc, measure=measure)]
    limit = float(np.median(free[1:]))
    made = frames(long_arc, rekey_image=limit, measure=measure)
    assert all(f.record.image["car"]["psnr"] >= limit for f in made[1:])
    assert 1 < sum(f.record.key for f in made) < len(made)


def test_images_of_depth_have_their_own_truth() -> None:
    scene = rasterised(
        scene_of(car=(body(40, 4), journey(*on(ARC_1, 5 * ANGLE, 4)))),
        (12, 24),
        DepthPlanes(0.24, 1e-4, 400),
    )
    made = frames(scene)
    again = frames(scene, matching="tolerant")
    for frame in made:
        assert relative_error(frame.field, truth_of(frame)) < 0.15
    fresh = chrmc.compute_field(made[3].cloud, PANEL, WAVELENGTH, method="rt")
    assert relative_error(made[3].field, fresh) > 0.5
    assert sum(f.record.points_added for f in made) > sum(f.record.points_added for f in again)


def test_an_object_that_leaves_and_returns() -> None:
    visible = np.ones((6, 10), dtype=bool)
    visible[2:4] = False
    scene = PointScene(
        "test",
        {"car": body(10, 0)},
        {"car": journey(*on(ARC_1, ANGLE, 5))},
        {"car": list(visible)},
        pixel_pitch=40e-6,
    )
    made = frames(scene)
    assert not made[2].field.any() and not made[3].field.any()
    assert relative_error(made[4].field, truth_of(made[4])) < 1e-5
    assert made[4].record.points_computed == 10


def test_a_clip_continues_the_same_arcs(long_arc: PointScene) -> None:
    clip = frames(long_arc, frames=(4, 5))
    assert [f.record.key for f in clip] == [True, False]
    assert clip[1].record.error_reuse < 0.05


def test_refusals(long_arc: PointScene) -> None:
    for options, message in (
        ({"rekey_every": 0}, "rekey_every"),
        ({"rekey_error": 0.0}, "rekey_error"),
        ({"matching": "loose"}, "unknown matching rule"),
        ({"radius": 1e-3}, "cannot span"),
    ):
        with pytest.raises(ValueError, match=message):
            chrmc.video(
                long_arc,
                PANEL,
                compensation="ch-rmc",
                surface="paper",
                **{"radius": 0.24, "cgh": "rt", **options},
            )


def test_frames_follow_each_other_without_repeats(long_arc: PointScene) -> None:
    made = frames(long_arc)
    assert all(relative_error(a.field, b.field) > 0.1 for a, b in pairwise(made))


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "worst_error", "least_psnr"),
    [("car-house", 0.23, 37.0), ("car-house-deep", 0.95, 22.0)],
)
def test_the_built_in_scenes_at_full_size(name: str, worst_error: float, least_psnr: float) -> None:
    made = chrmc.video(
        chrmc.load_scene(name),
        chrmc.LC_R_1080,
        cgh="curved",
        compensation="ch-rmc",
        surface="paper",
        coding="ssb",
        measure=True,
    )
    records = [frame.record for frame in made]
    errors = [r.error_reuse for r in records]
    assert 0.5 * worst_error < max(errors) < worst_error
    assert min(r.image["car"]["psnr"] for r in records) > least_psnr
    assert [r.number for r in records if r.key] == [1]
    assert np.mean([r.points_computed for r in records[1:]]) < 20
    assert all(0.15 < r.blank_share < 0.25 for r in records[1:])
