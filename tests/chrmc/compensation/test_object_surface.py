"""Object-centred CH-RMC against the float64 sum of spherical waves, frame by frame."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import chrmc
from chrmc import LC_R_1080, SLM, WAVELENGTH, PointCloud
from chrmc.encoding import coding_for
from chrmc.reference import reference_samples, relative_error
from chrmc.scene.point_scene import PointScene
from chrmc.scene.scene import ObjectFrame, Pose, SceneFrame

PANEL = SLM("a quarter of the paper's", 320, 200, 16e-6)
Motion = Callable[[int], tuple[np.ndarray, np.ndarray]]


def body(count: int, size: tuple[float, float, float], seed: int) -> PointCloud:
    random = np.random.default_rng(seed)
    return PointCloud(
        (random.random((count, 3)) - 0.5) * size,
        random.uniform(0.3, 1, count),
        random.uniform(0, 6.3, count),
    )


def moving(motion: Motion, count: int, shown: float = 1.0, points: int = 90) -> PointScene:
    """A still object and one that moves, a share of whose points is seen at a time."""
    random = np.random.default_rng(3)
    level = random.random(points)

    def visible(number: int) -> np.ndarray:
        return np.asarray((level + 0.04 * number) % 1 <= shown)

    poses = []
    for k in range(count):
        rotation, place = motion(k)
        poses.append(Pose(Rotation.from_rotvec(rotation).as_matrix(), np.asarray(place)))
    still = Pose(Rotation.from_rotvec([0.1, 0.5, 0]).as_matrix(), np.array([-4e-4, -5e-4, 0.21]))
    return PointScene(
        "two",
        {"mover": body(points, (8e-4, 4e-4, 5e-4), 1), "rest": body(60, (4e-4,) * 3, 2)},
        {"mover": poses, "rest": [still]},
        {"mover": visible},
    )


def check_frames(
    scene: PointScene, slm: SLM, tolerance: float, encoding: str, reuse: str = "always"
) -> list[bool]:
    coding = coding_for(encoding, slm)
    random = np.random.default_rng(0)
    rows, columns = random.integers(0, slm.height, 500), random.integers(0, slm.width, 500)
    carrier = np.exp(2j * np.pi * coding.carrier * slm.y(rows))
    keys = []
    for frame in chrmc.video(
        scene, slm, cgh="curved", compensation="ch-rmc", coding=coding, tolerance=tolerance,
        reuse=reuse,
    ):  # fmt: skip
        truth = reference_samples(
            frame.cloud, slm, WAVELENGTH, rows, columns, passband=coding.passband
        )
        error = relative_error(frame.field[rows, columns], truth)
        assert error <= tolerance, f"frame {frame.number}"
        assert frame.record.error_predicted is not None
        assert frame.record.error_predicted <= tolerance
        assert frame.record.error_predicted >= error / 3
        assert frame.signal is not None and frame.signal.dtype == np.float32
        signal = (truth * carrier).real
        assert np.linalg.norm(frame.signal[rows, columns] - signal) <= (
            1.2 * tolerance * np.linalg.norm(signal)
        )
        keys.append(frame.record.key)
    return keys


MOTIONS: dict[str, Motion] = {
    "about y, on an arc": lambda k: ([0, 0.05 * k, 0], [4e-4 - 1e-4 * k, 3e-4, 0.2 + 1e-4 * k]),
    "about x": lambda k: ([0.05 * k, 0, 0], [3e-4, 2e-4, 0.2]),
    "about z": lambda k: ([0, 0, 0.05 * k], [3e-4, 2e-4, 0.2]),
    "about all axes": lambda k: ([0.04 * k, 0.06 * k, -0.05 * k], [3e-4, 2e-4, 0.2]),
    "approach": lambda k: ([0, 0.02 * k, 0], [3e-4, 2e-4, 0.25 - 0.008 * k]),
    "a million-millionth of a radian": lambda k: ([0, 1e-12 * k, 1e-12 * k], [3e-4, 2e-4, 0.2]),
}


@pytest.mark.parametrize("name", MOTIONS)
def test_any_rigid_motion_from_one_key_frame(name: str) -> None:
    keys = check_frames(moving(MOTIONS[name], 6, shown=0.7), PANEL, 1e-3, "ssb")
    assert keys == [True] + [False] * 5


@pytest.mark.parametrize("encoding", ["ssb", "real"])
def test_one_key_frame_at_a_hundred_thousandth(encoding: str) -> None:
    keys = check_frames(moving(MOTIONS["about all axes"], 4, 0.7), PANEL, 1e-5, encoding)
    assert keys == [True] + [False] * 3


@pytest.mark.parametrize("axis", [[0, 1, 0], [1, 0, 0], [0, 0, 1], [0.6, 0.0, 0.8]])
def test_half_turns_are_keyed_anew_as_often_as_they_need(axis: list[float]) -> None:
    scene = moving(lambda k: (np.pi / 3 * k * np.array(axis), [3e-4, 2e-4, 0.2]), 4)
    keys = check_frames(scene, PANEL, 1e-3, "real")
    assert keys[0] and len(keys) == 4


def test_motion_against_the_eye_needs_the_new_reference_wave() -> None:
    # The same sphere, without following the centre, is plainly wrong: the test can fail.
    scene = moving(MOTIONS["about y, on an arc"], 3)
    frames = list(chrmc.video(scene, PANEL, cgh="curved", compensation="ch-rmc", coding="real"))
    assert relative_error(frames[0].field, frames[2].field) > 0.5


def test_points_that_appeared_or_vanished_since_the_frame_before_are_counted() -> None:
    scene = moving(MOTIONS["about y, on an arc"], 4, shown=0.7)
    made = list(chrmc.video(scene, PANEL, cgh="curved", compensation="ch-rmc", reuse="always"))
    first = set(np.asarray(scene.frame(1).objects[0].ids).tolist())
    for frame in made[1:]:
        now = set(np.asarray(frame.scene_frame.objects[0].ids).tolist())
        assert frame.record.points_added == len(now - first) > 0
        assert frame.record.points_removed == len(first - now) > 0
        assert frame.record.points_computed == len(now ^ first)
        first = now


def test_frames_may_be_skipped_or_asked_for_backwards() -> None:
    scene = moving(MOTIONS["about all axes"], 4, shown=0.7)
    one = list(chrmc.video(scene, PANEL, cgh="curved", compensation="ch-rmc", coding="ssb"))
    two = list(chrmc.video(scene, PANEL, cgh="curved", compensation="ch-rmc", coding="ssb"))
    signals = [frame.signal for frame in one]
    for number in (3, 1):
        np.testing.assert_allclose(two[number].signal, signals[number], rtol=0, atol=2e-2)


def test_a_scene_at_rest_is_made_once() -> None:
    scene = moving(lambda k: ([0, 0, 0], [3e-4, 2e-4, 0.2]), 3, shown=2.0)
    frames = list(chrmc.video(scene, PANEL, cgh="curved", compensation="ch-rmc", coding="ssb"))
    assert [frame.record.key for frame in frames] == [True, False, False]
    assert [frame.record.points_computed for frame in frames] == [150, 0, 0]
    np.testing.assert_allclose(frames[2].signal, frames[0].signal, atol=1e-2)
    np.testing.assert_array_equal(frames[2].signal, frames[1].signal)


class Quantised:
    """Frames whose points have no identity, as RGB-D images give them."""

    name, form, frame_count, object_names = "quantised", "rgbd", 2, ("mover",)
    wavelength, pixel_pitch = None, 4e-5

    def __init__(self, scene: PointScene) -> None:
        self._scene = scene

    def frame(self, number: int) -> SceneFrame:
        cloud = self._scene.frame(number).objects[0].cloud
        return SceneFrame(number, (ObjectFrame("mover", cloud),))


def test_unknown_identities_are_keyed_in_every_frame_that_differs() -> None:
    moves = Quantised(moving(MOTIONS["about x"], 2))
    rests = Quantised(moving(lambda k: ([0, 0, 0], [3e-4, 2e-4, 0.2]), 2, shown=2.0))
    for scene, expected in ((moves, [True, True]), (rests, [True, False])):
        frames = list(chrmc.video(scene, PANEL, cgh="curved", compensation="ch-rmc"))
        assert [frame.record.key for frame in frames] == expected
        for frame in frames:
            truth = chrmc.reference_field(frame.cloud, PANEL, WAVELENGTH, rows=[7, 150])
            assert relative_error(frame.field[[7, 150]], truth) <= 1e-3


def test_other_cgh_methods_and_bad_tolerances_are_refused() -> None:
    scene = moving(MOTIONS["about x"], 2)
    with pytest.raises(ValueError, match="choose cgh curved, or surface paper"):
        next(chrmc.video(scene, PANEL, cgh="rt", compensation="ch-rmc", surface="object"))
    with pytest.raises(ValueError, match="tolerance must lie between"):
        next(chrmc.video(scene, PANEL, cgh="curved", compensation="ch-rmc", tolerance=0.5))


def seen_now_and_then(points: PointCloud, shown: list[bool], poses: list[Pose]) -> PointScene:
    """A body beside one that rests, which is gone in some frames."""
    still = Pose(np.eye(3), np.array([-4e-4, -5e-4, 0.21]))
    return PointScene(
        "now and then",
        {"guest": points, "rest": body(60, (4e-4,) * 3, 2)},
        {"guest": poses, "rest": [still]},
        {"guest": [np.full(len(points), here) for here in shown]},
    )


@pytest.mark.parametrize("reuse", ["auto", "always"])
@pytest.mark.parametrize("encoding", ["ssb", "real"])
def test_a_body_that_goes_away_and_comes_back(encoding: str, reuse: str) -> None:
    points = body(50, (6e-4, 3e-4, 4e-4), 5)
    poses = [
        Pose(Rotation.from_rotvec([0, 0.05 * k, 0]).as_matrix(), np.array([3e-4, 2e-4, 0.2]))
        for k in (0, 1, 2, 0, 0, 5, 0, 0)  # it turns, comes back to where it was, and rests
    ]
    shown = [True, True, False, True, False, True, True, True]
    scene = seen_now_and_then(points, shown, poses)
    check_frames(scene, PANEL, 1e-3, encoding, reuse)


def test_points_that_flicker_are_added_once_and_stay_exact() -> None:
    panel = SLM("801 × 601 at 3.7 µm", 801, 601, 3.7e-6)
    points = body(150, (2e-3, 1.5e-3, 2e-3), 8)
    random = np.random.default_rng(4)
    poses = [
        Pose(Rotation.from_rotvec([0, 0.01 * k, 0]).as_matrix(), np.array([0, 0, 1.44]))
        for k in range(6)
    ]
    masks = [random.random(150) < 0.5 for _ in poses]
    scene = PointScene("flicker", {"body": points}, {"body": poses}, {"body": masks})
    keys = check_frames(scene, panel, 1e-3, "ssb")
    assert keys == [True] + [False] * 5


@pytest.mark.parametrize("count", [40, pytest.param(3000, marks=pytest.mark.long)])
def test_bodies_whose_light_cancels_are_made_together_or_refused(count: int) -> None:
    points = body(count, (6e-4, 3e-4, 4e-4), 5)
    twin = PointCloud(points.positions, 0.999 * points.amplitude, points.phase + np.pi)
    poses = [
        Pose(Rotation.from_rotvec([0, 0.01 * k, 0]).as_matrix(), np.array([3e-4, 2e-4, 0.2]))
        for k in range(3)
    ]
    scene = PointScene("pair", {"one": points, "other": twin}, {"one": poses, "other": poses})
    coding = coding_for("real", PANEL)
    made = list(
        chrmc.video(
            scene, PANEL, cgh="curved", compensation="ch-rmc", coding=coding, tolerance=1e-2,
            reuse="always",
        )
    )  # fmt: skip
    for frame in made:
        truth = chrmc.reference_field(
            frame.cloud, PANEL, WAVELENGTH, rows=[7, 90, 150], passband=coding.passband
        )
        assert relative_error(frame.field[[7, 90, 150]], truth) <= 1e-2


def test_a_body_that_rests_while_points_come_and_go_is_not_made_again() -> None:
    scene = moving(lambda k: ([0, 0, 0], [3e-4, 2e-4, 0.2]), 5, shown=0.7)
    keys = check_frames(scene, PANEL, 1e-3, "ssb")
    # Afresh while nobody knows that anything changes, then on its sphere.
    assert keys == [True, True, False, False, False]


def test_reuse_that_does_not_pay_is_left_and_the_record_says_why() -> None:
    scene = moving(lambda k: ([0, 1.0 * k, 0], [3e-4, 2e-4, 0.2]), 3)
    made = list(chrmc.video(scene, PANEL, cgh="curved", compensation="ch-rmc"))
    assert all(frame.record.key for frame in made)
    assert "no chart" in made[0].record.reuse["mover"] or "cost" in made[0].record.reuse["mover"]
    with pytest.raises(ValueError, match='"auto" or "always"'):
        next(chrmc.video(scene, PANEL, cgh="curved", compensation="ch-rmc", reuse="never"))


def test_spheres_of_many_bodies_stay_within_their_room(monkeypatch: pytest.MonkeyPatch) -> None:
    from chrmc.compensation.ch_rmc_object import video

    monkeypatch.setattr(video, "MOST_VALUES", 300_000)
    bodies = {f"b{k}": body(80, (6e-4, 3e-4, 4e-4), k) for k in range(5)}
    poses = {
        name: [
            Pose(
                Rotation.from_rotvec([0, 0.02 * n * (1 + k % 3), 0.01 * n]).as_matrix(),
                np.array([2e-4 * k - 4e-4, 1e-4 * k, 0.2 + 2e-3 * k]),
            )
            for n in range(4)
        ]
        for k, name in enumerate(bodies)
    }
    check_frames(PointScene("five", bodies, poses), PANEL, 1e-3, "ssb")


def test_three_frames_of_the_built_in_scene_at_full_size() -> None:
    random = np.random.default_rng(0)
    rows, columns = random.integers(0, 1200, 300), random.integers(0, 1920, 300)
    coding = coding_for("ssb", LC_R_1080)
    frames = list(
        chrmc.video(
            chrmc.load_scene("car-house-deep"), LC_R_1080, cgh="curved", compensation="ch-rmc",
            coding=coding, frames=(1, 3), reuse="always",
        )
    )  # fmt: skip
    assert [frame.record.key for frame in frames] == [True, False, False]
    truth = reference_samples(
        frames[2].cloud, LC_R_1080, WAVELENGTH, rows, columns, passband=coding.passband
    )
    assert relative_error(frames[2].field[rows, columns], truth) <= 1e-3


@pytest.mark.long
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
@pytest.mark.parametrize("name", ["car-house", "car-house-deep"])
@pytest.mark.parametrize("encoding", ["ssb", "real"])
def test_all_frames_of_the_built_in_scenes_from_one_key_frame(
    name: str, tolerance: float, encoding: str
) -> None:
    scene = chrmc.load_scene(name)
    keys = check_frames(scene, LC_R_1080, tolerance, encoding)  # type: ignore[arg-type]
    assert keys == [True] + [False] * 79


def test_many_points_are_summed_by_transforms() -> None:
    points = body(9000, (6e-4, 3e-4, 4e-4), 6)
    poses = [
        Pose(Rotation.from_rotvec([0, 0.01 * k, 0]).as_matrix(), np.array([3e-4, 2e-4, 0.2]))
        for k in range(3)
    ]
    hidden = np.random.default_rng(1).random((3, 9000)) < 0.99
    scene = PointScene("dense", {"body": points}, {"body": poses}, {"body": list(hidden)})
    coding = coding_for("ssb", PANEL)
    made = list(
        chrmc.video(
            scene, PANEL, cgh="curved", compensation="ch-rmc", coding=coding, tolerance=1e-3,
            reuse="always",
        )
    )  # fmt: skip
    assert made[0].record.reuse["body"].startswith("for up to 3 frames")
    random = np.random.default_rng(0)
    rows, columns = random.integers(0, PANEL.height, 60), random.integers(0, PANEL.width, 60)
    for frame in made:
        truth = reference_samples(
            frame.cloud, PANEL, WAVELENGTH, rows, columns, passband=coding.passband
        )
        assert relative_error(frame.field[rows, columns], truth) <= 1e-3
    assert [frame.record.key for frame in made] == [True, False, False]
