"""TR-, MC-, MPEG- and 3DMC-NLUT: the field is the sum of the points they say they hold."""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

import chrmc
from chrmc.cgh import METHODS, method_named
from chrmc.compensation import video
from chrmc.compensation.frame import VideoFrame
from chrmc.encoding import coding_for
from chrmc.reference import reference_field, reference_samples, relative_error
from chrmc.scene.derived import DerivedScene
from chrmc.scene.load import load_scene
from chrmc.scene.point_scene import PointScene
from chrmc.scene.scene import Pose, Scene, SceneFrame
from chrmc.slm import SLM

SMALL = SLM("small", 100, 64, 8.1e-6)
PITCH = SMALL.pixel_pitch
METHOD_NAMES = ("tr-nlut", "mc-nlut", "mpeg-nlut", "3dmc-nlut")


def glide(steps: list[tuple[float, float, float]], hidden: dict[int, int] | None = None) -> Scene:
    """A still object and one that is shifted by `steps` (x, y, z metres), frame by frame."""
    rng = np.random.default_rng(4)
    body = chrmc.PointCloud(
        rng.uniform(-2e-4, 2e-4, (30, 3)), rng.uniform(0.5, 1, 30), rng.uniform(0, 6, 30)
    )
    places = np.cumsum([(1e-4, 0, 0.2), *steps], axis=0)
    visible = [np.ones(30, dtype=bool) for _ in places]
    for frame, point in (hidden or {}).items():
        visible[frame - 1][point] = False
    still = Pose(np.eye(3), np.array([-2e-4, 1e-4, 0.21]))
    return PointScene(
        "glide",
        bodies={"mover": body, "rock": body.select(slice(0, 12))},
        poses={"mover": [Pose(np.eye(3), p) for p in places], "rock": [still]},
        visible={"mover": visible},
    )


def frames_of(scene: Scene, method: str, count: int, **options: object) -> list[VideoFrame]:
    options.setdefault("cgh", "rt")
    made = video(scene, SMALL, compensation=method, frames=(1, count), **options)  # type: ignore[arg-type]
    return list(made)


@cache
def car_and_house(method: str, form: str) -> tuple[VideoFrame, ...]:
    """The first ten frames of `car-house`, made once for all tests."""
    return tuple(frames_of(load_scene("car-house", form=form), method, 10, coding="ssb"))


def error_of(field: NDArray[np.complex64], cloud: chrmc.PointCloud, coding: str = "real") -> float:
    """Against the truth, on some pixels and on the edges that shifts uncover."""
    rng = np.random.default_rng(0)
    rows, columns = rng.integers(0, SMALL.height, 200), rng.integers(0, SMALL.width, 200)
    columns[:40] = rng.choice([0, 1, SMALL.width - 1], 40)
    rows[40:80] = rng.choice([0, 1, SMALL.height - 1], 40)
    band = coding_for(coding, SMALL).passband
    truth = reference_samples(cloud, SMALL, chrmc.WAVELENGTH, rows, columns, passband=band)
    return relative_error(field[rows, columns], truth)


@pytest.mark.parametrize("form", ["points", "rgbd"])
@pytest.mark.parametrize("method", METHOD_NAMES)
def test_field_is_the_sum_of_the_points_it_shows(method: str, form: str) -> None:
    for frame in car_and_house(method, form):
        if frame.number in (1, 2, 4, 8, 9):
            assert error_of(frame.field, frame.shown, "ssb") < 3e-5


@pytest.mark.parametrize(("cgh", "stated"), [("rt", 1e-5), ("nlut", 1e-4), ("wrp", 1e-2)])
@pytest.mark.parametrize("method", METHOD_NAMES)
def test_stated_error_on_body_fixed_points(method: str, cgh: str, stated: float) -> None:
    scene = load_scene("car-house-deep")
    for frame in frames_of(scene, method, 2 if cgh == "wrp" else 3, cgh=cgh):
        assert error_of(frame.field, frame.cloud) < stated


@pytest.mark.parametrize("method", METHOD_NAMES)
def test_what_stands_still_is_computed_once(method: str) -> None:
    scene = glide([(0, 0, 0)] * 3)
    first, *rest = frames_of(scene, method, 4)
    assert first.record.key and first.record.points_computed == 42
    field = first.field
    for frame in rest:
        assert not frame.record.key
        assert frame.record.points_computed == frame.record.point_pixels == 0
        assert np.array_equal(frame.field, field)


@pytest.mark.parametrize("method", ["mc-nlut", "mpeg-nlut", "3dmc-nlut"])
def test_motion_by_whole_pixels_costs_only_the_strips(method: str) -> None:
    scene = glide([(3 * PITCH, -2 * PITCH, 0), (-7 * PITCH, 0, 0), (0, 30 * PITCH, 0)])
    for frame in frames_of(scene, method, 4)[1:]:
        record = frame.record
        assert record.points_computed == record.points_removed == record.points_added == 0
        assert 0 < record.point_pixels < 30 * SMALL.width * SMALL.height
        assert 0 < record.blank_share < 1
        assert error_of(frame.field, frame.cloud) < 1e-5


def test_the_ledger_of_a_move_counts_its_strips_and_a_key_frame_all_pixels() -> None:
    scene = glide([(3 * PITCH, -2 * PITCH, 0)])
    key, later = frames_of(scene, "mc-nlut", 2)
    objects = scene.frame(2).objects
    moving = [o for o in objects if not o.cloud.same_as(scene.frame(1).objects[0].cloud)]
    width, height = SMALL.width, SMALL.height
    assert key.record.point_pixels == len(key.cloud) * width * height
    strips = width * height - (width - 3) * (height - 2)
    assert later.record.blank_share == pytest.approx(strips / (width * height * len(objects)))
    assert later.record.point_pixels == len(moving[0].cloud) * strips


def test_only_three_directional_compensation_follows_depth() -> None:
    scene = glide([(0, 0, 2e-4), (2 * PITCH, 0, 3e-4)])
    count = {
        method: [f.record.points_computed for f in frames_of(scene, method, 3, matching="strict")]
        for method in METHOD_NAMES
    }
    assert count["3dmc-nlut"][1:] == [0, 0]
    assert count["tr-nlut"][1:] == count["mc-nlut"][1:] == [60, 60]
    assert count["mpeg-nlut"][1:] == [60, 60]
    moved = frames_of(scene, "3dmc-nlut", 3, matching="strict")
    for frame in moved[1:]:
        assert error_of(frame.field, frame.shown) < 1e-4
        # The lens puts the points where the scene has them, closer than can be resolved.
        apart = frame.shown.positions[:, None] - frame.cloud.positions
        nearest = np.abs(apart)[np.arange(42), np.argmin(np.linalg.norm(apart, axis=2), axis=1)]
        assert nearest[:, :2].max() < 1e-6 and nearest[:, 2].max() < 1e-5


@pytest.mark.parametrize("method", METHOD_NAMES)
def test_points_that_vanish_and_return_are_counted_and_right(method: str) -> None:
    scene = glide([(0, 0, 0)] * 3, hidden={2: 5, 3: 5})
    records = []
    for frame in frames_of(scene, method, 4):
        records.append((frame.record.points_removed, frame.record.points_added))
        assert error_of(frame.field, frame.cloud) < 1e-5
    if method in ("mpeg-nlut", "3dmc-nlut"):  # against the group's reference
        assert records[1:] == [(1, 0), (1, 0), (0, 0)]
    else:
        assert records[1:] == [(1, 0), (0, 0), (0, 1)]


def blinking(ratio: float, hidden: list[int], leaves: bool = False) -> Scene:
    """A dim rock, and a mover `ratio` times as bright that is hidden in some frames, or, if it
    leaves, is no object of them."""
    rng = np.random.default_rng(5)
    rock = chrmc.PointCloud(rng.uniform(-2e-4, 2e-4, (12, 3)), np.ones(12), rng.uniform(0, 6, 12))
    mover = chrmc.PointCloud(rock.positions[::-1] * 0.7, ratio * np.ones(12), rock.phase + 1)
    seen = [np.full(12, k not in hidden) for k in range(1, 8)]
    poses = [Pose(np.eye(3), np.array([1e-5 * k, 0, 0.2])) for k in range(7)]
    still = Pose(np.eye(3), np.array([0, 0, 0.21]))
    scene = PointScene(
        "blinking", {"mover": mover, "rock": rock}, {"mover": poses, "rock": [still]},
        {"mover": seen},
    )  # fmt: skip
    return _Leaving(scene, hidden) if leaves else scene


@dataclass(frozen=True, eq=False, repr=False)
class _Leaving(DerivedScene):
    hidden: list[int]

    def frame(self, number: int) -> SceneFrame:
        objects = self.scene.frame(number).objects
        return SceneFrame(number, objects[1:] if number in self.hidden else objects)


@pytest.mark.parametrize("ratio", [1.0, 1e4, 1e12])
@pytest.mark.parametrize("method", METHOD_NAMES)
def test_what_is_gone_leaves_no_light(method: str, ratio: float) -> None:
    """Rounding of what was put in and taken out is less than the least that is shown then."""
    for frame in frames_of(blinking(ratio, [2, 3, 5]), method, 7):
        assert error_of(frame.field, frame.cloud) < 1e-5


@pytest.mark.parametrize("method", METHOD_NAMES)
def test_where_bodies_cancel_what_they_leave_is_right(method: str) -> None:
    scene = cancelling(1e-4)
    for frame in frames_of(scene, method, 5):
        assert error_of(frame.field, frame.cloud) < 1e-5


@pytest.mark.parametrize("method", METHOD_NAMES)
def test_points_that_cancel_are_no_reason_to_refuse_a_bright_frame(method: str) -> None:
    scene = cancelling(1e-9)
    bodies = {
        "rock": scene.bodies["body"],
        "dark": chrmc.PointCloud.concatenate(scene.bodies.values()),
    }
    poses = {"rock": [Pose(np.eye(3), np.array([1e-4, 0, 0.21]))], "dark": scene.poses["body"]}
    seen = {"dark": [np.full(18, k != 1) for k in range(5)]}
    for frame in frames_of(PointScene("bright", bodies, poses, seen), method, 5):
        assert error_of(frame.field, frame.cloud) < 1e-5


def cancelling(left: float) -> PointScene:
    """A body, and its negative but for some of a half turn, that is hidden in the second frame."""
    rng = np.random.default_rng(6)
    body = chrmc.PointCloud(rng.uniform(-2e-4, 2e-4, (9, 3)), np.ones(9), rng.uniform(0, 6, 9))
    against = chrmc.PointCloud(body.positions, np.ones(9), body.phase + np.pi * (1 + left))
    bodies = {"body": body, "against": against}
    poses = [Pose(np.eye(3), np.array([3 * PITCH * k, 0, 0.2])) for k in range(5)]
    seen = {"against": [np.full(9, k != 1) for k in range(5)]}
    return PointScene("against", bodies, dict.fromkeys(bodies, poses), seen)


@pytest.mark.parametrize("method", ["tr-nlut", "mc-nlut"])
def test_what_blinks_for_long_leaves_no_more_than_before(method: str) -> None:
    """Steep waves, put in beside others than those they are taken out with: were one computed in
    single precision and the other in double, each time would add to what is left."""
    tiny = SLM("tiny", 12, 8, 1e-6)
    rng = np.random.default_rng(4)
    bodies, seen = {}, {}
    for k, name in enumerate("abc"):
        body = chrmc.PointCloud(rng.uniform(-2e-4, 2e-4, (2, 3)), np.ones(2), rng.uniform(0, 6, 2))
        bodies[name] = body
        seen[name] = [np.full(2, n % 7 not in (2 * k, 2 * k + 1)) for n in range(300)]
    pose = [Pose(np.eye(3), np.array([3e-3, 3e-3, 0.02]))] * 300
    scene = PointScene("blinks", bodies, dict.fromkeys(bodies, pose), seen)
    made = list(video(scene, tiny, cgh="rt", compensation=method))
    for frame in made[-7:]:
        truth = reference_field(frame.cloud, tiny, chrmc.WAVELENGTH)
        assert relative_error(frame.field, truth) < 1e-5


@pytest.mark.parametrize("method", METHOD_NAMES)
def test_a_frame_of_no_points_is_dark(method: str) -> None:
    scene = glide([(0, 0, 0)] * 3)
    seen = [np.full(30, k % 2 == 0) for k in range(4)]
    dark = PointScene(
        "dark", {"mover": scene.bodies["mover"]}, {"mover": scene.poses["mover"]}, {"mover": seen}
    )
    fields = [frame.field for frame in frames_of(dark, method, 4)]
    assert [field.any() for field in fields] == [True, False, True, False]


@pytest.mark.parametrize("method", METHOD_NAMES)
def test_objects_that_a_frame_leaves_out_are_taken_out(method: str) -> None:
    for frame in frames_of(blinking(1.0, [2, 3, 5], leaves=True), method, 7):
        assert error_of(frame.field, frame.cloud) < 1e-5
        assert len(frame.shown) == len(frame.cloud)


@pytest.mark.parametrize(("method", "size"), [("mpeg-nlut", 4), ("3dmc-nlut", 8)])
def test_groups_begin_with_a_whole_frame(method: str, size: int) -> None:
    keys = [f.number for f in car_and_house(method, "rgbd") if f.record.key]
    assert keys == list(range(1, 11, size))
    scene = load_scene("car-house", form="rgbd")
    keys = [f.number for f in frames_of(scene, method, 7, group=3) if f.record.key]
    assert keys == [1, 4, 7]


@pytest.mark.parametrize("method", METHOD_NAMES)
def test_fields_may_be_asked_for_in_any_order_or_not_at_all(method: str) -> None:
    scene = load_scene("car-house", form="rgbd")
    in_order = [f.field for f in car_and_house(method, "rgbd")[:5]]
    late = frames_of(scene, method, 5, coding="ssb")
    for index in (4, 1, 3):
        assert relative_error(late[index].field, in_order[index]) < 1e-5


@pytest.mark.parametrize("method", METHOD_NAMES)
def test_tolerant_matching_computes_fewer_points(method: str) -> None:
    scene = load_scene("car-house", form="rgbd")
    totals = {}
    tolerant = frames_of(scene, method, 4, matching="tolerant")
    for rule, frames in (("strict", car_and_house(method, "rgbd")[:4]), ("tolerant", tolerant)):
        records = [f.record for f in frames]
        totals[rule] = sum(r.points_computed for r in records[1:])
        for record in records:
            assert record.points_computed == record.points_added + record.points_removed
    assert totals["tolerant"] < totals["strict"]


def test_compensated_images_are_the_scenes_images() -> None:
    """Under "strict" what is shown falls into the frame's pixels, planes and intensities."""
    scene = load_scene("car-house", form="rgbd")
    step = np.array([scene.pixel_pitch, scene.pixel_pitch, 1e-4])
    for method in METHOD_NAMES:
        for frame in car_and_house(method, "rgbd")[:5]:
            places = []
            for cloud in (frame.shown, frame.cloud):
                place = np.rint((cloud.positions - frame.cloud.positions[0]) / step).astype(int)
                order = np.lexsort(place.T)
                places.append((place[order], cloud.intensity[order]))
            assert np.array_equal(places[0][0], places[1][0])
            assert np.abs(places[0][1] - places[1][1]).max() <= 2.1 / 255


def test_an_object_that_leaves_what_the_panel_shows() -> None:
    tiny = SLM("tiny", 24, 16, PITCH)
    edge = tiny.width / 2 * PITCH + 0.2 * np.tan(np.arcsin(chrmc.WAVELENGTH / 2 / PITCH))
    scene = glide([(edge / 2, 0, 0), (edge / 2 - 4.5e-4, 0, 0)])
    for method in METHOD_NAMES:
        frames = list(video(scene, tiny, cgh="rt", compensation=method))
        truth = reference_field(frames[-1].cloud, tiny, chrmc.WAVELENGTH)
        assert relative_error(frames[-1].field, truth) < 1e-5


def test_patterns_are_shared_by_a_whole_video() -> None:
    assert "cache" in method_named("wrp").with_cache({})
    assert method_named("rt").with_cache({"a": 1}) == {"a": 1}
    mine = method_named("nlut").with_cache({})["cache"]
    assert method_named("nlut").with_cache({"cache": mine})["cache"] is mine
    scene = load_scene("car-house", form="rgbd")
    for frame in frames_of(scene, "none", 3, cgh="nlut", cache=mine):
        assert frame.field.any()
    depths = {z for n in (1, 2, 3) for z in np.rint(scene.frame(n).cloud.positions[:, 2] * 1e4)}
    # Rebuilt at most once more each, when the moving car needs a larger part.
    assert len(depths) <= mine.built <= 2 * len(depths) and mine.reused > len(depths)


def test_refusals() -> None:
    scene = glide([(0, 0, 0)])
    for method, options, words in (
        ("tr-nlut", {"matching": "loose"}, "matching"),
        ("mpeg-nlut", {"block": 0}, "block"),
        ("3dmc-nlut", {"group": 0}, "group"),
        ("mpeg-nlut", {"search": -1}, "search"),
        ("mc-nlut", {"colour": 1}, "colour"),
    ):
        with pytest.raises(ValueError, match=words):
            for frame in frames_of(scene, method, 2, **options):
                assert frame.field is not None
    rgbd = load_scene("car-house", form="rgbd")
    with pytest.raises(ValueError, match="measure"):
        frames_of(rgbd, "mc-nlut", 2, measure="best")
    assert set(METHODS) >= {"wrp", "nlut", "nlut-1d"}
