"""Arcs, lines and stops found again in paths that were made of them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chrmc import LC_R_1080, load_scene
from chrmc.scene.motion import (
    find_motion,
    local_offsets,
    position_noise,
)
from chrmc.scene.path import arc_path, rotation_y

STEP = np.radians(0.303)
ARCS = ((15.68e-3, 20), (36.74e-3, 30), (17.53e-3, 29))


@pytest.fixture
def path():
    """The car's path of 80 frames: (positions, centres)."""
    positions, _, centres = arc_path(np.radians(-12), STEP, ARCS)
    return positions + np.array([0, 0.25]), centres + np.array([0, 0.25])


def spans(motion):
    return [(s.kind, s.first, s.last) for s in motion.segments]


def rebuild(motion, start):
    """Positions that the segments say, from the first one on."""
    place = np.array(start, dtype=float)
    out = [place]
    for s in motion.segments:
        for k in range(s.last - s.first):
            if s.kind == "arc":
                turn = rotation_y(s.angles[k])[np.ix_([0, 2], [0, 2])]
                place = turn @ (place - s.centre) + s.centre
            else:
                place = place + s.steps[k]
            out.append(place)
    return np.array(out)


def positions_of(scene, name):
    """(N, 2) x and z: of the body's origin where poses are known, else of what is visible."""
    index = list(scene.object_names).index(name)
    seen = [scene.frame(n).objects[index] for n in range(1, scene.frame_count + 1)]
    return np.array([o.position if o.pose is None else o.pose.translation for o in seen])[:, [0, 2]]


@pytest.mark.parametrize("name", ["car-house", "car-house-deep"])
def test_the_car_is_found_on_its_three_arcs(name):
    scene = load_scene(name)
    motion = find_motion(positions_of(scene, "car"))
    assert spans(motion) == [("arc", 1, 21), ("arc", 21, 51), ("arc", 51, 80)]
    assert [s.radius for s in motion.segments] == pytest.approx([15.68e-3, 36.74e-3, 17.53e-3])
    for s in motion.segments:
        assert s.angles == pytest.approx(STEP, rel=1e-9)
        assert s.centre[1] > 0.26
    assert spans(find_motion(positions_of(scene, "house"))) == [("still", 1, 80)]


@pytest.mark.parametrize("name", ["car-house", "car-house-deep"])
def test_the_car_of_images_is_tracked_to_its_noise(name):
    """Identity unknown: what the images show explains the path, whatever arcs they say."""
    scene = load_scene(name, form="rgbd")
    path = positions_of(scene, "car")
    # Other sides of the car come into view: the path wanders by a part of a pixel.
    noise = max(position_noise(path), scene.pixel_pitch / 16)
    motion = find_motion(path, noise=noise)
    assert 2 <= len(motion.segments) <= 6
    assert all(s.kind != "still" and s.rms < 6e-6 for s in motion.segments)
    # Radial errors only: the angles put every position on its arc.
    assert np.abs(rebuild(motion, path[0]) - path).max() < 25e-6
    first, last = motion.segments[0], motion.segments[-1]
    assert first.radius == pytest.approx(15.68e-3, rel=0.25)
    assert last.radius == pytest.approx(17.53e-3, rel=0.25)


def test_a_clip_keeps_the_scene_s_numbers():
    path = positions_of(load_scene("car-house"), "car")[14:30]
    motion = find_motion(path, first_frame=15)
    assert spans(motion) == [("arc", 15, 21), ("arc", 21, 30)]
    assert motion.at(15) is None and motion.at(16) is motion.segments[0]
    assert motion.at(22) is motion.segments[1] and motion.at(31) is None
    assert motion.angle(21) == pytest.approx(STEP)


def test_rotations_about_the_found_centres_give_the_path_back(path):
    motion = find_motion(path[0])
    assert rebuild(motion, path[0][0]) == pytest.approx(path[0], abs=1e-12)


def test_reversal_turns_the_angles_round(path):
    there_and_back = np.concatenate([path[0][:40], path[0][38::-1]])
    motion = find_motion(there_and_back)
    # Frames 21 to 59 stay on one circle, forth and back.
    assert spans(motion) == [("arc", 1, 21), ("arc", 21, 59), ("arc", 59, 79)]
    assert motion.segments[1].angles == pytest.approx([STEP] * 19 + [-STEP] * 19)
    assert motion.segments[2].angles == pytest.approx(-STEP)


def test_turning_the_other_way_is_negative(path):
    mirrored = path[0] * [-1, 1]
    assert find_motion(mirrored).angle(5) == pytest.approx(-STEP)


def test_a_stop_is_still(path):
    positions = np.concatenate([path[0][:30], np.repeat(path[0][29:30], 6, axis=0), path[0][30:]])
    motion = find_motion(positions)
    assert spans(motion) == [
        ("arc", 1, 21),
        ("arc", 21, 30),
        ("still", 30, 36),
        ("arc", 36, 57),
        ("arc", 57, 86),
    ]
    assert not motion.segments[2].angles.any() and not motion.segments[2].steps.any()
    noisy = positions + np.random.default_rng(0).normal(0, 0.5e-6, positions.shape)
    kinds = [s.kind for s in find_motion(noisy).segments]
    assert kinds.count("still") == 1


def test_one_repeated_position_is_a_step_without_motion(path):
    positions = np.insert(path[0], 10, path[0][10], axis=0)
    motion = find_motion(positions)
    assert ("still", 11, 12) in spans(motion)
    assert motion.angle(12) == 0


def test_straight_lines_are_translations():
    along = np.linspace(0, 5e-3, 20)
    line = np.stack([along, 0.25 + 0.3 * along], axis=1)
    motion = find_motion(line)
    assert spans(motion) == [("translation", 1, 20)]
    assert motion.segments[0].centre is None and motion.segments[0].radius is None
    assert motion.segments[0].steps == pytest.approx(np.diff(line, axis=0))
    assert not motion.segments[0].angles.any()
    back = np.concatenate([line, line[-2::-1]])
    assert {s.kind for s in find_motion(back).segments} == {"translation"}


def test_line_into_arc():
    turned = arc_path(0.0, 0.01, ((20e-3, 30),))[0] + [0, 0.25]
    line = turned[0] + np.arange(20, 0, -1)[:, None] * [2e-4, 0]
    motion = find_motion(np.concatenate([line, turned]))
    assert spans(motion) == [("translation", 1, 21), ("arc", 21, 51)]
    assert motion.segments[1].radius == pytest.approx(20e-3)


def test_a_stray_position_is_left_out(path):
    positions = path[0].copy()
    positions[9] += 60e-6
    motion = find_motion(positions)
    assert spans(motion)[0] == ("arc", 1, 21)
    assert motion.segments[0].outliers == (10,)
    assert motion.segments[0].radius == pytest.approx(15.68e-3)


def test_frames_without_the_object_part_the_motion(path):
    positions = path[0].copy()
    positions[30:33] = np.nan
    motion = find_motion(positions)
    assert spans(motion) == [("arc", 1, 21), ("arc", 21, 30), ("arc", 34, 51), ("arc", 51, 80)]
    assert motion.at(31) is None and motion.at(33) is None and motion.at(34) is None


def test_a_jump_is_a_translation_and_no_arc(path):
    positions = path[0].copy()
    positions[35:] += 1e-3
    assert ("translation", 35, 36) in spans(find_motion(positions))


@pytest.mark.parametrize("count", [0, 1, 2, 3, 4])
def test_few_frames_are_legal(path, count):
    motion = find_motion(path[0][:count])
    expected = {0: [], 1: [], 2: [("translation", 1, 2)]}.get(count, [("arc", 1, count)])
    assert spans(motion) == expected
    if count >= 3:
        assert motion.segments[0].radius == pytest.approx(15.68e-3, rel=1e-6)


def test_an_object_that_never_moves():
    assert spans(find_motion(np.full((9, 2), 0.25))) == [("still", 1, 9)]
    assert spans(find_motion(np.full((2, 2), 0.25))) == [("still", 1, 2)]
    shaking = 0.25 + np.random.default_rng(1).normal(0, 1e-6, (60, 2))
    assert spans(find_motion(shaking)) == [("still", 1, 60)]


def test_bad_positions_are_refused():
    with pytest.raises(ValueError, match=r"\(N, 2\)"):
        find_motion(np.zeros((4, 3)))
    with pytest.raises(ValueError, match="noise"):
        find_motion(np.zeros((4, 2)), noise=-1)


@pytest.mark.parametrize("noise", [0.3e-6, 1e-6])
def test_noise_is_estimated_and_arcs_survive_it(path, noise):
    rng = np.random.default_rng(7)
    for _ in range(5):
        noisy = path[0] + rng.normal(0, noise, path[0].shape)
        assert position_noise(noisy) == pytest.approx(noise, rel=0.5)
        motion = find_motion(noisy)
        assert [s.kind for s in motion.segments] == ["arc"] * 3
        borders = np.array([motion.segments[1].first, motion.segments[1].last])
        assert np.abs(borders - [21, 51]).max() <= 3
        assert [s.radius for s in motion.segments] == pytest.approx(
            [15.68e-3, 36.74e-3, 17.53e-3], rel=0.1
        )


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.tuples(st.floats(5e-3, 50e-3), st.integers(5, 20)), min_size=1, max_size=4),
    st.floats(2e-3, 2e-2),
    st.floats(-3, 3),
    st.sampled_from([1, -1]),
)
def test_any_chain_of_arcs_is_walked_again(arcs, step, heading, way):
    positions = arc_path(heading, step, arcs)[0][::way] + np.array([0.01, 0.25])
    motion = find_motion(positions)
    assert rebuild(motion, positions[0]) == pytest.approx(positions, abs=1e-7)
    # No more arcs than there were, though equal neighbours may be one.
    assert len(motion.segments) <= len(arcs)


def test_long_paths_cost_little():
    arcs = [(r, 60) for r in (10e-3, 40e-3) * 4]
    positions = arc_path(0.0, 5e-3, arcs)[0]
    motion = find_motion(positions)
    assert [s.first for s in motion.segments] == list(range(1, 481, 60))


def test_offsets_of_the_paper_s_blue_arc():
    """Section 3.3: d1 = 31.90 cm and l1 = 20.52 cm for O1 (20.52 cm, 46.38 cm), R = 14.5 cm."""
    width = LC_R_1080.width * LC_R_1080.pixel_pitch
    d, lateral = local_offsets((0.2052, 0.4638), 0.145, width)
    assert d == pytest.approx(0.3190, abs=5e-5)
    assert lateral == 0.2052
    assert d - (0.4638 - 0.145) == pytest.approx(208.65e-6, abs=0.05e-6)
    with pytest.raises(ValueError, match="no circle of radius 5 mm"):
        local_offsets((0, 0.25), 5e-3, width)
