"""Motion vectors, shifts, lenses and bookkeeping that the NLUT videos are made of."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import chrmc
from chrmc.compensation import video
from chrmc.compensation.held import Chain, Held, Matcher, correct, showable
from chrmc.compensation.nlut.blocks import (
    Image,
    depth_vector,
    grid_offset,
    image_of,
    lateral_vector,
)
from chrmc.compensation.shift import Move, lens, lens_axis, moved, shift_into, strips
from chrmc.optics.footprint import check_showable
from chrmc.optics.passband import full_band
from chrmc.reference import reference_field, relative_error
from chrmc.scene.rgbd import DepthPlanes, RGBDFrame
from chrmc.scene.rgbd_scene import RGBDScene
from chrmc.scene.scene import ObjectFrame
from chrmc.slm import SLM

SMALL = SLM("small", 90, 60, 8.1e-6)
PITCH = 40.5e-6
steps = st.integers(-130, 130)


@given(steps, steps)
def test_shift_and_strips_tile_the_panel(rows: int, columns: int) -> None:
    field = np.arange(60 * 90).reshape(60, 90).astype(np.complex64) + 1
    target = np.zeros_like(field)
    shift_into(target, field, Move(rows, columns))
    covered = target != 0
    for window in strips(Move(rows, columns), SMALL):
        assert not covered[window.slices].any()
        covered[window.slices] = True
    assert covered.all()
    if abs(rows) < 60 and abs(columns) < 90:
        rolled = np.roll(field, (rows, columns), (0, 1))
        assert np.array_equal(target[target != 0], rolled[target != 0])


@settings(max_examples=15, deadline=None)
@given(st.integers(-30, 30), st.integers(-20, 20), st.integers(0, 99))
def test_a_shifted_field_is_that_of_the_moved_points(rows: int, columns: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    positions = np.c_[rng.uniform(-3e-4, 3e-4, (5, 2)), rng.uniform(0.004, 0.3, 5)]
    cloud = chrmc.PointCloud(positions, np.ones(5), rng.uniform(0, 6, 5))
    before = reference_field(cloud, SMALL, 532e-9)
    move = Move(rows, columns)
    after = moved(cloud, move, SMALL, 532e-9)
    after = after.select(showable(after, SMALL, 532e-9, full_band(SMALL)))
    target = np.zeros(SMALL.shape, dtype=np.complex64)
    shift_into(target, before.astype(np.complex64), move)
    truth = reference_field(after, SMALL, 532e-9)
    for window in strips(move, SMALL):
        target[window.slices] = truth[window.slices]
    assert np.abs(target - truth).max() < 1e-5 * np.abs(before).max()


@settings(max_examples=15, deadline=None)
@given(st.floats(-2e-3, 2e-3), st.integers(-5, 5), st.integers(0, 99))
def test_a_lens_moves_points_in_depth(depth: float, columns: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    positions = np.c_[rng.uniform(-4e-4, 4e-4, (6, 2)), rng.uniform(0.25, 0.2505, 6)]
    cloud = chrmc.PointCloud(positions, np.ones(6), rng.uniform(0, 6, 6))
    move = Move(0, columns, depth)
    x, y, z = lens_axis(cloud, move, SMALL)
    in_y, in_x = lens(SMALL, 532e-9, (x, y), z, depth)
    sideways = moved(cloud, Move(0, columns), SMALL, 532e-9)
    field = reference_field(sideways, SMALL, 532e-9) * in_y[:, None] * in_x
    after = moved(cloud, move, SMALL, 532e-9)
    assert np.abs(after.positions[:, 2] - cloud.positions[:, 2] - depth).max() < 2e-5
    assert relative_error(field, reference_field(after, SMALL, 532e-9)) < 1e-4


@settings(deadline=None)
@given(st.integers(-6, 6), st.integers(-6, 6), st.integers(0, 999))
def test_full_search_finds_where_a_block_went(rows: int, columns: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    picture = rng.uniform(0.2, 1, (16, 16))
    image = Image((rows, columns), picture, np.zeros((16, 16), dtype=np.int64))
    for measure in ("sad", "mse"):
        assert lateral_vector(picture, (0, 0), image, 6, measure) == (rows, columns)


def test_the_shortest_of_equal_vectors_is_taken() -> None:
    flat = Image((-9, -9), np.ones((30, 30)), np.zeros((30, 30), dtype=np.int64))
    assert lateral_vector(np.ones((4, 4)), (0, 0), flat, 5) == (0, 0)
    with pytest.raises(ValueError, match="best"):
        lateral_vector(np.ones((4, 4)), (0, 0), flat, 5, "best")


def test_depth_vectors_come_from_slices_that_meet() -> None:
    lit = np.ones((3, 3))
    planes = np.arange(9).reshape(3, 3)
    assert depth_vector(lit, planes, lit, planes + 4, 10) == 4
    assert depth_vector(lit, planes, lit, planes + 4, 3) == 0
    noisy = planes - 2
    noisy[0] += 7
    assert depth_vector(lit, planes, lit, noisy, 10) == -2
    assert depth_vector(lit, planes, np.zeros((3, 3)), planes, 10) == 0


@given(st.booleans(), st.booleans(), st.integers(-50, 50), st.integers(-50, 50))
def test_grids_with_and_without_a_pixel_on_the_axis(
    odd_x: bool, odd_y: bool, i: int, j: int
) -> None:
    offset = np.array([0 if odd_x else 0.5, 0 if odd_y else 0.5])
    at = (np.array([[i, j], [i + 3, j - 2]]) + offset) * PITCH
    cloud = chrmc.PointCloud(np.c_[at, [0.25, 0.2501]], np.array([1, 2.0]), np.zeros(2))
    origin = grid_offset(cloud, PITCH)
    assert np.allclose(np.array(origin), offset * PITCH, atol=1e-9)
    image = image_of(cloud, PITCH, 1e-4, origin)
    assert image.origin == (j - 2, i) and image.intensity.shape == (3, 4)
    assert image.intensity[2, 0] == 1 and image.intensity[0, 3] == pytest.approx(4)
    assert image.plane[2, 0] == 2500 and image.plane[0, 3] == 2501


def test_kept_points_keep_their_places_and_phases() -> None:
    at = np.array([[0, 0, 0.25], [PITCH, 0, 0.25], [2 * PITCH, 0, 0.25]])
    held = Held(
        chrmc.PointCloud(at + np.array([3e-6, 0, 4e-6]), np.ones(3), np.array([7.0, 8, 9])), None
    )
    seen = chrmc.PointCloud(at[1:], np.array([1.0, 0.7]), np.zeros(2))
    matcher = Matcher("strict", PITCH, 1e-4)
    after, correction = correct(held, ObjectFrame("thing", seen), matcher)
    assert len(correction.removed) == 2 and len(correction.added) == 1
    assert np.array_equal(after.cloud.phase, [8.0, 0.0])
    assert np.array_equal(after.cloud.positions[0], held.cloud.positions[1])
    signed = correction.signed
    waves = signed.amplitude * np.exp(1j * signed.phase)
    assert np.allclose(waves, [-np.exp(7j), -np.exp(9j), 0.7])


def test_points_that_did_not_change_are_no_correction() -> None:
    """Without identities, several to a pixel: which is which is told by all they are."""
    rng = np.random.default_rng(2)
    places = rng.integers(0, 3, (40, 3)) * 1e-9 + (0, 0, 0.2)
    cloud = chrmc.PointCloud(places, rng.integers(1, 3, 40), rng.integers(0, 2, 40))
    mixed = cloud.select(rng.permutation(40))
    other = chrmc.PointCloud(places[:2], np.full(2, 9.0), np.zeros(2))
    obj = ObjectFrame("o", chrmc.PointCloud.concatenate([mixed.select(slice(5, None)), other]))
    after, correction = correct(Held(cloud, None), obj, Matcher("exact", PITCH, 1e-4))
    assert len(correction.removed) == 5 and len(correction.added) == 2
    rows = [
        sorted(map(tuple, np.c_[c.positions, c.amplitude, c.phase].tolist()))
        for c in (after.cloud, obj.cloud)
    ]
    assert rows[0] == rows[1]


@given(st.floats(-0.02, 0.02), st.floats(-0.02, 0.02), st.floats(1e-4, 0.5))
def test_showable_is_what_the_check_passes(x: float, y: float, z: float) -> None:
    cloud = chrmc.PointCloud(np.array([[x, y, z]]), np.ones(1), np.zeros(1))
    if showable(cloud, SMALL, 532e-9, full_band(SMALL))[0]:
        check_showable(cloud, SMALL, 532e-9, full_band(SMALL))
    else:
        with pytest.raises(ValueError, match="no pixel"):
            check_showable(cloud, SMALL, 532e-9, full_band(SMALL))


def test_a_chain_makes_what_is_asked_for_once() -> None:
    made: list[int] = []

    def update(number: int, state: int) -> int:
        made.append(number)
        return state + number

    chain: Chain[int] = Chain(0)
    makers = [
        chain.then(
            lambda state, n=n: update(n, state),
            lambda state: np.full((1, 1), state, dtype=np.complex64),
            lambda: np.full((1, 1), -1, dtype=np.complex64),
        )
        for n in (1, 2, 3)
    ]
    assert made == []
    assert makers[1]() == 3 and makers[1]() == 3 and made == [1, 2]
    assert makers[0]() == -1 and makers[2]() == 6 and made == [1, 2, 3]


@pytest.mark.parametrize("method", ["tr-nlut", "mc-nlut", "mpeg-nlut", "3dmc-nlut"])
def test_objects_that_come_and_go(method: str) -> None:
    planes = DepthPlanes(0.2, 1e-4, 50)
    rng = np.random.default_rng(0)
    picture = rng.uniform(0.3, 1, (4, 5)).astype(np.float32)
    places = [None, (3, 4), (3, 6), None, (2, 2)]

    def read(number: int) -> RGBDFrame:
        frame = RGBDFrame.empty((12, 17))
        intensity, depth, owner = frame.intensity, frame.depth.copy(), frame.object_id
        intensity[9:11, 10:15], depth[9:11, 10:15], owner[9:11, 10:15] = 0.5, 0.2001, 2
        place = places[number - 1]
        if place is not None:
            here = (slice(place[0], place[0] + 4), slice(place[1], place[1] + 5))
            intensity[here], depth[here], owner[here] = picture, 0.2003, 1
        return RGBDFrame(intensity, depth, owner)

    scene = RGBDScene("blink", read, 5, (12, 17), PITCH, {1: "guest", 2: "host"}, planes)
    for frame in video(scene, SMALL, cgh="rt", compensation=method):
        truth = reference_field(frame.shown, SMALL, chrmc.WAVELENGTH)
        assert relative_error(frame.field, truth) < 1e-5
        assert len(frame.shown) == len(frame.cloud)
        assert np.allclose(np.sort(frame.shown.intensity), np.sort(frame.cloud.intensity))
