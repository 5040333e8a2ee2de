"""Whether a sphere pays is counted, from shapes alone: the same on every machine.

The figures are those that the measured weights give; who changes one measures it anew.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from chrmc import LC_R_1080, WAVELENGTH, PointCloud
from chrmc.cgh.curved.interface import cost_of, plane_of
from chrmc.compensation.ch_rmc_object.choice import (
    MOST_VALUES,
    Choice,
    Patience,
    choose,
    poses_ahead,
)
from chrmc.compensation.ch_rmc_object.cost import cost, looked_at
from chrmc.compensation.ch_rmc_object.plan import outline_of, planned
from chrmc.encoding import coding_for
from chrmc.scene.point_scene import PointScene
from chrmc.scene.scene import ObjectFrame, Pose
from chrmc.slm import SLM
from chrmc.window import Window


def body(count: int, size: tuple[float, float, float]) -> PointCloud:
    random = np.random.default_rng(1)
    return PointCloud((random.random((count, 3)) - 0.5) * size, np.ones(count), np.zeros(count))


def chosen(
    count: int, size: tuple[float, float, float], turn: tuple[float, float, float],
    frames: int, tolerance: float, most: int = MOST_VALUES, always: bool = False,
) -> Choice:  # fmt: skip
    """For a body that turns by so much a frame, near the left edge."""
    points = body(count, size)
    # Whose coordinates begin anywhere.
    aside = np.array([5e-3, -2e-3, 1e-2])
    points = PointCloud(points.positions + aside, points.amplitude, points.phase)
    turns = [Rotation.from_rotvec(np.array(turn) * k).as_matrix() for k in range(frames)]
    poses = [Pose(one, np.array([-3e-3, 5e-4, 0.25]) - one @ aside) for one in turns]
    cloud = PointCloud(poses[0].apply(points.positions), points.amplitude, points.phase)
    obj = ObjectFrame("body", cloud, points, np.arange(count), poses[0])
    window, passband = Window.full(LC_R_1080), coding_for("ssb", LC_R_1080).passband
    plane = plane_of(LC_R_1080, WAVELENGTH, window, passband)
    outline = outline_of(points)
    plan = planned(obj, outline, plane, tolerance)
    return choose(plan, outline, poses, plane, tolerance, most, always)


CAR, SMALL = (4e-3, 2e-3, 3e-3), (1.6e-3, 7e-4, 8e-4)


@pytest.mark.parametrize(
    ("count", "size", "turn", "frames", "tolerance", "pays", "length", "fresh", "reused"),
    [
        (500, (1e-3, 1e-3, 1e-3), (0, 0.01, 0), 20, 1e-3, False, 64, 5.360e8, 1.447e9),
        (3000, CAR, (0, 2e-3, 0), 40, 1e-3, False, 64, 3.534e9, 4.962e9),
        (3000, CAR, (1e-3, 5e-3, 2e-3), 80, 1e-3, False, 64, 3.534e9, 7.958e9),
        (3000, CAR, (0, 0.5, 0), 10, 1e-3, False, 64, 3.534e9, np.inf),
        (20_000, (4e-3, 3e-3, 2e-3), (0, 3e-3, 0), 80, 1e-3, False, 64, 1.268e10, 1.274e10),
        (40_000, CAR, (0, 1e-3, 0), 80, 1e-3, True, 80, 9.161e9, 6.533e9),
        (100_000, SMALL, (0, 5e-3, 0), 80, 1e-3, True, 80, 1.406e10, 4.071e9),
        (40_000, CAR, (0, 1e-3, 0), 80, 1e-2, False, 64, 4.072e9, 4.898e9),
        # Its strips are summed from the points in every frame.
        (100_000, SMALL, (0, 5e-3, 0), 80, 1e-4, False, 64, 2.181e10, 2.599e10),
    ],
)
def test_what_a_sphere_and_a_sum_afresh_count(
    count: int, size: tuple[float, float, float], turn: tuple[float, float, float], frames: int,
    tolerance: float, pays: bool, length: int, fresh: float, reused: float,
) -> None:  # fmt: skip
    found = chosen(count, size, turn, frames, tolerance)
    assert (found.pays, found.frames) == (pays, length)
    assert (found.fresh, found.reused) == (
        pytest.approx(fresh, rel=0.01), pytest.approx(reused, rel=0.01),
    )  # fmt: skip
    assert found.cost == (found.reused if pays else found.fresh)
    words = (
        f"for up to {length} frames" if pays else "no chart" if reused == np.inf else "would cost"
    )
    assert words in found.why


@pytest.mark.parametrize(
    ("count", "size", "frames", "tolerance", "most", "length", "reused"),
    [
        (3000, CAR, 40, 1e-5, MOST_VALUES, 40, 1.553e10),
        (20_000, (4e-3, 3e-3, 2e-3), 80, 1e-3, MOST_VALUES, 80, 1.274e10),
        (3000, CAR, 40, 1e-3, 1_100_000, 8, 7.036e9),
    ],
)
def test_reuse_that_is_wanted_has_as_many_frames_as_fit(
    count: int, size: tuple[float, float, float], frames: int, tolerance: float, most: int,
    length: int, reused: float,
) -> None:  # fmt: skip
    found = chosen(count, size, (0, 3e-3, 0), frames, tolerance, most, always=True)
    assert found.pays and found.frames == length
    assert found.reused == pytest.approx(reused, rel=0.01)


def test_reuse_may_be_wanted_whatever_it_costs_and_memory_may_forbid_it() -> None:
    wanted = chosen(3000, CAR, (0, 2e-3, 0), 40, 1e-3, always=True)
    assert wanted.pays and wanted.frames == 40
    assert wanted.reused > wanted.fresh
    narrow = chosen(40_000, CAR, (0, 1e-3, 0), 80, 1e-3, most=1000)
    assert not narrow.pays and narrow.reused == np.inf


def test_an_outline_holds_all_points_and_little_more() -> None:
    few = body(1900, CAR)
    assert np.allclose(outline_of(few).rim, few.positions, atol=1e-18)
    points = body(9000, CAR)
    points = PointCloud(
        Rotation.from_rotvec([0.4, -0.7, 0.2]).apply(points.positions) + np.array([0.1, -0.2, 0.3]),
        points.amplitude, points.phase,
    )  # fmt: skip
    outline = outline_of(points)
    assert len(outline.rim) <= 200
    own, rim = points.positions - outline.middle, outline.rim - outline.middle
    assert outline.size == pytest.approx(float(np.linalg.norm(own, axis=1).max()), rel=1e-12)
    random = np.random.default_rng(4).normal(size=(500, 3))
    ways = random / np.linalg.norm(random, axis=1)[:, None]
    farthest, found = (own @ ways.T).max(axis=0), (rim @ ways.T).max(axis=0)
    assert np.all(found >= 0.998 * farthest) and np.all(found <= 1.021 * farthest)


def test_what_is_done_with_each_object_and_what_it_takes() -> None:
    """The largest first: how it is made, its first frame, and one on the average."""
    slm = SLM("small", 480, 300, 8.1e-6)
    wide = PointCloud.concatenate([
        PointCloud(part.positions + np.array([x, 0, z]), part.amplitude, part.phase)
        for part, x, z in ((body(900, (5e-4,) * 3), -1e-3, 0), (body(800, (5e-4,) * 3), 1e-3, 0.1))
    ])  # fmt: skip
    bodies = {"turns": body(4000, (1e-3,) * 3), "wide": wide, "few": body(600, (1e-3,) * 3),
              "rests": body(300, (1e-3,) * 3), "loose": body(200, (1e-3,) * 3)}  # fmt: skip

    def pose(name: str, k: int) -> Pose:
        turn = 0 if name == "rests" else 0.01 * k
        return Pose(Rotation.from_rotvec([0, turn, 0]).as_matrix(), np.array([0, 0, 0.15]))

    poses = {name: [pose(name, k) for k in range(4)] for name in bodies}
    scene = PointScene("five", bodies, poses)
    things = [
        replace(obj, body=None, ids=None, pose=None) if obj.name == "loose" else obj
        for obj in scene.frame(1).objects
    ]
    coding = coding_for("ssb", slm)
    found = cost(scene, things, range(2, 5), slm, WAVELENGTH, coding, tolerance=1e-3)
    assert [one.name for one in found] == ["turns", "wide", "few", "rests", "loose"]
    turns, several, few, rests, loose = found
    assert loose.how == "afresh: its points are not known again" and loose.key == loose.later
    assert rests.how == "it rests"
    assert rests.mean(4).calls == pytest.approx(rests.key.calls / 4)
    assert few.how.startswith("afresh, or from its sphere") and few.key.calls > few.mean(4).calls
    assert several.how.startswith("afresh, most likely: its light takes")
    assert turns.how.startswith("afresh: looking up would") or turns.how.startswith("for up to")
    plane = plane_of(slm, WAVELENGTH, Window.full(slm), coding.passband)
    for one, obj in zip(found[1:], [things[i] for i in (1, 2, 3, 4)], strict=True):
        own = replace(plane, points=len(obj.cloud))
        afresh = cost_of(obj.cloud, own, 1e-3)
        assert one.key.phasors == pytest.approx(afresh.phasors)
        assert one.key.products == pytest.approx(afresh.products)
    for one in (turns, several, few):
        # Finding out how is paid once.
        assert one.key.calls > 2 * one.later.calls


def test_what_objects_that_are_looked_up_take() -> None:
    """The choice is worked out for the two largest; the third is taken as the second."""
    turns = {"many": 5e-3, "some": 2e-3, "wider": 5e-3}
    bodies = {"many": body(30_000, SMALL), "some": body(12_000, SMALL),
              "wider": body(12_000, (4e-3, 2e-3, SMALL[2]))}  # fmt: skip
    poses = {
        name: [Pose.from_rotvec([0, turn * k, 0], [aside, 5e-4, 0.25]) for k in range(80)]
        for (name, turn), aside in zip(turns.items(), (-3e-3, 0, 3e-3), strict=True)
    }
    scene = PointScene("three", bodies, poses)
    coding = coding_for("ssb", LC_R_1080)
    objects = scene.frame(1).objects
    found = cost(scene, objects, range(2, 81), LC_R_1080, WAVELENGTH, coding, tolerance=1e-3)
    assert [one.how.split(": ")[0] for one in found] == [
        "for up to 80 frames, each at 0.33 of what it would cost afresh",
        "for up to 80 frames, each at 0.45 of what it would cost afresh",
        "as for a body of 12000 points",
    ]
    for one, key, later in zip(
        found,
        [(1.666e8, 3.145e8, 1.537e8, 7.01e5), (1.141e10, 8.010e7, 1.773e9, 843_984),
         (5.288e10, 1.306e8, 7.171e9, 865_000)],
        [(1.666e8, 9.227e6, 9.214e6, 23_837), (6.561e8, 3.439e6, 7.926e7, 36_507),
         (2.443e9, 5.540e6, 3.077e8, 39_376)],
        strict=True,
    ):  # fmt: skip
        assert one.serves == 80
        for counts, wanted in ((one.key, key), (one.later, later)):
            in_all = counts.products, counts.phasors, counts.bytes, counts.calls
            assert in_all == pytest.approx(wanted, rel=1e-2)
        # Of 200 frames three are key frames.
        assert one.mean(200).calls == pytest.approx((3 * key[3] + 197 * later[3]) / 200, rel=1e-2)
    # Of many points every eighth frame is looked at.
    assert [looked_at(points, 1e-3) for points in (5000, 5001)] == [5000 * 10, 5001 * 9 / 8]


def test_poses_are_asked_for_600_frames_ahead_or_until_there_are_none() -> None:
    here = [Pose.from_rotvec([0, 0.01 * k, 0], [0, 0, 0.2]) for k in range(700)]
    scene = PointScene("long", {"body": body(5, SMALL)}, {"body": here})
    (obj,) = scene.frame(1).objects
    found = poses_ahead(scene, obj, range(2, 701))
    assert len(found) == 600 and found[-1].same_as(here[600])
    assert len(poses_ahead(scene, obj, range(650, 701))) == 51

    class Lost(PointScene):
        def pose(self, name: str, number: int) -> Pose | None:  # type: ignore[override]
            return here[0] if number < 5 else None

    assert len(poses_ahead(Lost("lost", scene.bodies, scene.poses), obj, range(2, 9))) == 3


def test_what_does_not_pay_is_thought_of_again_twice_as_late_each_time() -> None:
    patience = Patience()
    assert patience.over("car", 1)
    patience.put_off("car", 1, 64)
    assert [patience.over("car", n) for n in (64, 65)] == [False, True]
    patience.put_off("car", 65, 64)
    assert [patience.over("car", n) for n in (192, 193)] == [False, True]
    assert patience.over("house", 2)
    patience.put_off("car", 193, 8)
    assert [patience.over("car", n) for n in (448, 449)] == [False, True]
    patience.end("car")
    assert patience.over("car", 200)
    patience.put_off("car", 200, 8)
    assert [patience.over("car", n) for n in (207, 208)] == [False, True]
