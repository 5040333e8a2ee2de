"""Draws of the phases as successive frames: the scene, the video, and what comes back of it."""

from itertools import pairwise

import numpy as np
import pytest

from chrmc import SLM, PointCloud, PointScene, Pose, generate, open_video
from chrmc.scene.drawn import drawn, drawn_frames
from chrmc.scene.light import scenes_in_light
from reconstruct import check
from reconstruct.looks import looks

PANEL = SLM("small", 128, 96, 16e-6)
POSES = [Pose.from_rotvec([0, 0.004 * k, 0], [0, 0, 0.05]) for k in range(4)]


def scene() -> PointScene:
    random = np.random.default_rng(3)
    body = PointCloud(
        random.uniform(-1, 1, (300, 3)) * (3e-4, 2e-4, 1e-4), np.ones(300),
        random.uniform(0, 6, 300), random.uniform(0, 1, (300, 3)),
    )  # fmt: skip
    masks = [random.random(300) < 0.8 for _ in POSES]
    return PointScene("plate", {"plate": body}, {"plate": POSES}, {"plate": masks})


def test_each_look_is_a_scene_whose_phases_stay_on_the_body() -> None:
    plain, looked = scene(), drawn(scene(), 3)
    assert looked.frame_count == 12 and drawn_frames((2, 3), 3) == (4, 9)
    things = [looked.frame(n).objects[0] for n in range(1, 13)]
    for number, obj in enumerate(things, 1):
        own = plain.frame((number - 1) // 3 + 1).objects[0]
        assert np.array_equal(obj.cloud.positions, own.cloud.positions)
        assert np.array_equal(obj.ids, own.ids) and looked.frame(number).number == number
        assert obj.body is not None and obj.pose is looked.pose("plate", number)
        assert np.array_equal(obj.cloud.phase, obj.body.phase[obj.ids])
        assert obj.body is things[(number - 1) % 3].body
    assert np.array_equal(things[0].cloud.phase, plain.frame(1).cloud.phase)
    for a, b in pairwise(things[:3]):
        related = np.abs(np.mean(np.exp(1j * (a.cloud.phase - b.cloud.phase))))
        assert related < 0.2  # of random phases 1/√240
    with pytest.raises(ValueError, match="looks"):
        drawn(plain, 0)


def test_lasers_show_the_same_draws() -> None:
    one, other = (drawn(lit, 2) for lit in scenes_in_light(scene(), (638e-9, 450e-9)))
    assert np.array_equal(one.frame(2).cloud.phase, other.frame(2).cloud.phase)


@pytest.mark.parametrize("how", [{"compensation": "ch-rmc", "reuse": "always"}, {}])
def test_a_video_of_looks_is_made_resumed_and_checked(tmp_path, how) -> None:
    made = generate(scene(), tmp_path / "a", slm=PANEL, looks=2, check_pixels=40, **how)
    assert made.numbers == list(range(1, 9))
    assert all(frame["error_reference"] <= 1e-3 for frame in made.frames)
    if how:  # a key frame for each look
        assert [frame["key"] for frame in made.frames] == [True] * 2 + [False] * 6
    parts = tmp_path / "b"
    generate(scene(), parts, slm=PANEL, looks=2, check_pixels=40, frames=(3, 3), **how)
    assert open_video(parts).numbers == [5, 6]  # both looks of the scene's third frame
    whole = generate(scene(), parts, slm=PANEL, looks=2, check_pixels=40, **how)
    assert [f["sha256"] for f in whole.frames] == [f["sha256"] for f in made.frames]
    with pytest.raises(ValueError, match="looks 2, not 3"):
        generate(scene(), parts, slm=PANEL, looks=3, check_pixels=40, **how)
    (verdict,) = check(made, [4], scene=scene(), depth_tolerance=1.0, lateral_tolerance=1.0)
    assert verdict.objects[0].psnr > 30  # of the second look's own field
    shown = list(looks(made, scene(), 4, 2))
    assert np.array_equal(shown[0], made.read(4)) and np.array_equal(shown[1], made.read(3))


def test_a_video_of_looks_in_colours(tmp_path) -> None:
    lasers = (638e-9, 532e-9)
    made = generate(scene(), tmp_path, slm=PANEL, wavelength=lasers, looks=2, frames=(1, 2))
    assert [channel.numbers for channel in made.channels] == [[1, 2, 3, 4]] * 2
