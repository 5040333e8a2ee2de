"""One step of motion: what is carried is right, and reused and filled parts meet exactly."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import chrmc
from chrmc.compensation.ch_rmc_paper.blank import difference, extent, intersection
from chrmc.compensation.ch_rmc_paper.carry import (
    Motion,
    Rotation,
    Translation,
    carried_window,
    carry,
    moved,
    translate,
)
from chrmc.encoding import coding_for
from chrmc.optics.footprint import reach, taper
from chrmc.optics.passband import Passband
from chrmc.optics.propagation import propagate
from chrmc.record import FrameRecord
from chrmc.reference import relative_error
from chrmc.slm import SLM, WAVELENGTH
from chrmc.window import Window

PANEL = SLM("panel", 480, 240, 8.1e-6)
RADIUS = 0.145
DEPTH = 0.25


def body(middle: tuple[float, float, float], seed: int = 0, count: int = 40) -> chrmc.PointCloud:
    rng = np.random.default_rng(seed)
    positions = rng.uniform(-1, 1, (count, 3)) * [3e-4, 2e-4, 2e-4] + middle
    return chrmc.PointCloud(positions, rng.uniform(0.3, 1, count), rng.uniform(0, 6.28, count))


def carried_by(
    cloud: chrmc.PointCloud, motion: Rotation | Translation, slm: SLM, passband: Passband
) -> tuple[np.ndarray, np.ndarray, Window]:
    """Carried field, field of the moved points, and the window on which they should agree."""
    field = chrmc.compute_field(cloud, slm, WAVELENGTH, passband=passband, method="rt")
    after = moved(cloud, motion)
    carried, _ = carry(field, cloud.centroid, motion, slm, WAVELENGTH, RADIUS, FrameRecord(1))
    truth = chrmc.compute_field(after, slm, WAVELENGTH, passband=passband, method="rt")
    return carried, truth, carried_window(cloud, after, motion, slm, WAVELENGTH, passband)


@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize("coding", ["real", "ssb"])
def test_about_its_own_centre(sign: int, coding: str) -> None:
    cloud = body((1e-4, -5e-5, DEPTH))
    motion = Rotation((1e-4, DEPTH), sign * 2e-3)
    passband = coding_for(coding, PANEL).passband
    carried, truth, window = carried_by(cloud, motion, PANEL, passband)
    lost = abs(DEPTH * motion.angle) / PANEL.pixel_pitch
    assert window.shape == (240, pytest.approx(480 - lost, abs=8))
    assert (window.column0 > 0) == (sign < 0)
    assert relative_error(carried[window.slices], truth[window.slices]) < 0.03
    # Not for want of motion: the field before is wrong altogether.
    before = chrmc.compute_field(cloud, PANEL, WAVELENGTH, passband=passband, method="rt")
    assert relative_error(before[window.slices], truth[window.slices]) > 0.5


@pytest.mark.parametrize(
    ("middle", "centre", "angle"),
    [
        ((3e-4, 0.0, DEPTH), (-1e-4, DEPTH + 0.015), 2e-3),
        ((-2e-4, 1e-4, DEPTH), (8e-4, DEPTH + 0.03), -3e-3),
        ((0.0, 0.0, DEPTH), (5e-4, DEPTH - 0.02), 1.7e-3),
    ],
)
def test_on_an_arc(
    middle: tuple[float, float, float], centre: tuple[float, float], angle: float
) -> None:
    passband = coding_for("real", PANEL).passband
    carried, truth, window = carried_by(body(middle), Rotation(centre, angle), PANEL, passband)
    assert relative_error(carried[window.slices], truth[window.slices]) < 0.05


@pytest.mark.parametrize(("columns", "rows"), [(0, 10), (-7, 0), (12, -5), (1, 1)])
def test_translation_by_whole_pixels_is_exact_to_the_edge(columns: int, rows: int) -> None:
    passband = coding_for("real", PANEL).passband
    motion = Translation((columns * PANEL.pixel_pitch, rows * PANEL.pixel_pitch, 0.0))
    carried, truth, window = carried_by(
        body((0.0, 0.0, DEPTH), 0, count=10), motion, PANEL, passband
    )
    assert relative_error(carried[window.slices], truth[window.slices]) < 2e-6


@given(st.floats(-3e-4, 3e-4), st.floats(-2e-4, 2e-4), st.floats(-4e-4, 4e-4), st.integers(0, 99))
@settings(max_examples=8, deadline=None)
def test_translation_is_exact(x: float, y: float, z: float, seed: int) -> None:
    passband = coding_for("real", PANEL).passband
    motion = Translation((x, y, z))
    carried, truth, window = carried_by(
        body((0.0, 0.0, DEPTH), seed, count=10), motion, PANEL, passband
    )
    assert window.size > 0.5 * PANEL.width * PANEL.height
    # The panel's own edges ring when the object moves in depth or by a fraction of a pixel.
    inner = intersection(window, Window(30, 210, 60, 420))
    limit = 0.02 if z else 0.01
    assert relative_error(carried[inner.slices], truth[inner.slices]) < limit


def test_there_and_back_returns_the_start_on_the_overlap() -> None:
    cloud = body((2e-4, 0.0, DEPTH))
    passband = coding_for("real", PANEL).passband
    there = Rotation((-1e-4, DEPTH + 0.015), 2e-3)
    back = Rotation(there.centre, -there.angle)
    start = chrmc.compute_field(cloud, PANEL, WAVELENGTH, passband=passband, method="rt")
    record = FrameRecord(1)
    middle = cloud.centroid
    field, cylinder = carry(start, middle, there, PANEL, WAVELENGTH, RADIUS, record)
    middle = moved(cloud, there).centroid
    field, _ = carry(field, middle, back, PANEL, WAVELENGTH, RADIUS, record, cylinder)
    lost = int(np.ceil(there.centre[1] * there.angle / PANEL.pixel_pitch)) + 6
    overlap = (slice(None), slice(lost, -lost))
    assert relative_error(field[overlap], start[overlap]) < 0.01
    assert set(record.stage_seconds) == {"PA", "CON", "RMC"}


def test_the_object_moves_where_the_rotation_takes_it() -> None:
    slm = SLM("wide", 480, 240, 8.1e-6)
    point = chrmc.PointCloud(
        np.array([[-60.5 * 8.1e-6, 10.5 * 8.1e-6, 0.06]]), np.ones(1), np.ones(1)
    )
    motion = Rotation((0.0, 0.08), 0.02)
    passband = coding_for("real", slm).passband
    field = chrmc.compute_field(point, slm, WAVELENGTH, passband=passband, method="rt")
    carried, _ = carry(field, point.centroid, motion, slm, WAVELENGTH, 0.04, FrameRecord(1))
    after = moved(point, motion).positions[0]
    assert after[0] < point.positions[0, 0]  # a positive angle carries the front towards −x
    image = np.abs(propagate(carried, slm.pixel_pitch, WAVELENGTH, -after[2])) ** 2
    row, column = np.unravel_index(np.argmax(image), image.shape)
    assert slm.x(column) == pytest.approx(after[0], abs=1.6 * slm.pixel_pitch)
    assert slm.y(row) == pytest.approx(after[1], abs=0.6 * slm.pixel_pitch)


windows = st.builds(
    lambda a, b, c, d: Window(min(a, b), max(a, b), min(c, d), max(c, d)),
    *[st.integers(0, 30) for _ in range(4)],
)


@given(windows, windows)
def test_difference_and_intersection_share_out_a_window(whole: Window, part: Window) -> None:
    count = np.zeros((30, 30), dtype=int)
    count[intersection(whole, part).slices] += 1
    for piece in difference(whole, part):
        assert piece.size > 0
        count[piece.slices] += 1
    expected = np.zeros((30, 30), dtype=int)
    expected[whole.slices] = 1
    np.testing.assert_array_equal(count, expected)


motions = st.one_of(
    st.builds(
        lambda x, dz, angle: Rotation((x, DEPTH + dz), angle),
        st.floats(-2e-3, 2e-3), st.floats(-0.02, 0.05), st.floats(-0.01, 0.01),
    ),
    st.builds(
        lambda x, y, z: Translation((x, y, z)),
        st.floats(-2e-3, 2e-3), st.floats(-1e-3, 1e-3), st.floats(-5e-3, 5e-3),
    ),
    st.none(),
)  # fmt: skip


@given(motions, st.floats(-6e-3, 6e-3), st.sampled_from(["real", "ssb"]), st.integers(0, 9))
@settings(max_examples=60, deadline=None)
def test_reused_and_filled_cover_the_footprint_once(
    motion: Motion, x: float, coding: str, seed: int
) -> None:
    slm = SLM("long", 1600, 60, 8.1e-6)
    passband = coding_for(coding, slm).passband
    before = body((x, 0.0, DEPTH), seed, count=6)
    after = moved(before, motion)
    reused = carried_window(before, after, motion, slm, WAVELENGTH, passband)
    whole = extent(after, slm, WAVELENGTH, passband)
    count = np.zeros(slm.shape, dtype=int)
    count[intersection(reused, whole).slices] += 1
    for piece in difference(whole, reused):
        count[piece.slices] += 1
    lit = np.zeros(slm.shape, dtype=bool)
    for xj, yj, zj in after.positions:
        half_x, half_y = (
            np.array(zj * reach(WAVELENGTH, f)) for f in (passband.fx_max, passband.fy_max)
        )
        lit |= (taper(slm.y() - yj, half_y)[:, None] * taper(slm.x() - xj, half_x)) > 0
    assert count.max(initial=0) <= 1
    assert np.all(count[lit] == 1)
    if isinstance(motion, Rotation) and reused.size:
        # Reused columns: on the panel before, and inside the flat part of every footprint.
        x_now = slm.x(reused.columns)
        x_then = x_now + motion.centre[1] * np.tan(motion.angle)
        assert np.abs(x_then).max() <= slm.x()[-1]
        for now, then in zip(after.positions, before.positions, strict=True):
            tangent = reach(WAVELENGTH, passband.fx_max)
            assert np.abs(x_now - now[0]).max() <= 0.9 * now[2] * tangent + 1e-12
            assert np.abs(x_then - then[0]).max() <= 0.9 * then[2] * tangent + 1e-12


def pixels(lit: np.ndarray) -> tuple[int, int]:
    """First and one past the last of a mask, (0, 0) for none."""
    index = np.flatnonzero(lit)
    return (int(index[0]), int(index[-1]) + 1) if len(index) else (0, 0)


def test_an_extent_is_the_smallest_window_of_all_footprints() -> None:
    slm = SLM("small", 90, 60, 8.1e-6)
    passband = coding_for("ssb", slm).passband
    for place in ((1e-4, -5e-5, 2e-3), (0.0, 0.0, 4e-3), (3.5e-4, 2e-4, 1e-3), (0.0, 0.0, 0.1)):
        cloud = chrmc.PointCloud(
            np.array([place, (place[0] / 2, place[1], 2e-3)]), np.ones(2), np.zeros(2)
        )
        found = extent(cloud, slm, WAVELENGTH, passband)
        lit = [np.zeros(60, dtype=bool), np.zeros(90, dtype=bool)]
        for x, y, z in cloud.positions:
            lit[0] |= np.abs(slm.y() - y) <= z * reach(WAVELENGTH, passband.fy_max)
            lit[1] |= np.abs(slm.x() - x) <= z * reach(WAVELENGTH, passband.fx_max)
        assert (found.row0, found.row1, found.column0, found.column1) == (
            *pixels(lit[0]), *pixels(lit[1]),
        )  # fmt: skip
    assert extent(chrmc.PointCloud.empty(), slm, WAVELENGTH, passband).size == 0


@pytest.mark.parametrize("by", [(20, 0), (-20, 0), (0, 11), (-7, -9), (0, 0), (480, 0), (0, -240)])
def test_a_shift_leaves_what_it_brings_in_and_a_guard_beside_it(by: tuple[int, int]) -> None:
    columns, rows = by
    pitch, cloud = PANEL.pixel_pitch, body((0.0, 0.0, DEPTH), count=5)
    motion = Translation((columns * pitch, rows * pitch, 0.0))
    window = carried_window(
        cloud, moved(cloud, motion), motion, PANEL, WAVELENGTH, coding_for("real", PANEL).passband
    )

    def kept(count: int, step: int) -> tuple[int, int]:
        index = np.arange(count)
        first, last = max(step + 6, 0) if step > 0 else 0, count - 1 + min(step - 6, 0)
        return pixels((index >= first) & (index <= (last if step < 0 else count - 1)))

    expected = *kept(240, rows), *kept(480, columns)
    if max(expected) and window.size:
        assert (window.row0, window.row1, window.column0, window.column1) == expected
    else:
        assert window.size == 0 and (expected[1] == expected[0] or expected[3] == expected[2])


@pytest.mark.parametrize("z", [3e-3, -3e-3])
def test_a_step_in_depth_leaves_what_light_from_outside_reaches(z: float) -> None:
    """|z|·tan of the widest angle and two Fresnel zones in from every side, edges left out."""
    passband = coding_for("real", PANEL).passband
    cloud = body((0.0, 0.0, DEPTH), count=5)
    motion = Translation((0.0, 0.0, z))
    window = carried_window(cloud, moved(cloud, motion), motion, PANEL, WAVELENGTH, passband)
    margin = abs(z) * reach(WAVELENGTH, PANEL.nyquist) + 2 * np.sqrt(WAVELENGTH * abs(z))
    clear = [np.abs(t) <= np.abs(t).max() - margin for t in (PANEL.y(), PANEL.x())]
    assert (window.row0, window.row1, window.column0, window.column1) == (
        *pixels(clear[0]), *pixels(clear[1]),
    )  # fmt: skip
    # Near the panel's edge footprints end on it, and they widen: only their flat parts serve.
    slm = SLM("wide", 1600, 60, 8.1e-6)
    aside = body((4e-3, 0.0, 0.1), count=5)
    window = carried_window(aside, moved(aside, motion), motion, slm, WAVELENGTH, passband)
    before, after = aside.positions, moved(aside, motion).positions
    flat = np.ones(1600, dtype=bool)
    for x, _, deep in (*before, *after):
        flat &= np.abs(slm.x() - x) <= 0.9 * deep * reach(WAVELENGTH, passband.fx_max)
    flat &= np.abs(slm.x()) <= slm.x()[-1] - margin
    assert (window.column0, window.column1) == pixels(flat)


def test_a_motion_below_a_pixel_of_footprint_keeps_their_edges() -> None:
    passband = coding_for("real", PANEL).passband
    near = body((0.0, 0.0, 0.02), count=5)
    for pixel, whole in ((0.98, True), (1.02, False)):
        z = pixel * PANEL.pixel_pitch / reach(WAVELENGTH, passband.fx_max)
        motion = Translation((0.0, 0.0, z))
        window = carried_window(near, moved(near, motion), motion, PANEL, WAVELENGTH, passband)
        flat = [
            (np.abs(PANEL.x() - x) <= 0.9 * deep * reach(WAVELENGTH, passband.fx_max))
            for x, _, deep in near.positions
        ]
        assert (window.column1 - window.column0 > np.all(flat, axis=0).sum()) == whole


def test_the_phase_comes_out_right_far_from_the_axis_too() -> None:
    """Where the chain of thin conversions alone would leave 0.43 rad."""
    passband = coding_for("real", PANEL).passband
    motion = Rotation((-8e-3, 0.33), 3e-3)
    carried, truth, window = carried_by(body((0.0, 0.0, DEPTH)), motion, PANEL, passband)
    assert abs(np.angle(np.vdot(truth[window.slices], carried[window.slices]))) < 0.05


@pytest.mark.parametrize("angle", [5e-4, -5e-4])
def test_fringes_along_y_become_those_of_the_new_depth(angle: float) -> None:
    """Along x the method has its aberrations; along y the step in depth alone bends the fringe."""
    aside, depth = 4e-3, 0.06
    slm = SLM("high", 320, 360, 8.1e-6)
    passband = coding_for("real", slm).passband
    point = chrmc.PointCloud([[0, 0, depth]], [1.0], [0.0])
    motion = Rotation((-aside, depth), angle)
    after = moved(point, motion)
    field, truth = (
        chrmc.compute_field(cloud, slm, WAVELENGTH, passband=passband, method="rt")
        for cloud in (point, after)
    )
    carried, _ = carry(field, point.centroid, motion, slm, WAVELENGTH, 0.05, FrameRecord(1))
    middle = (slice(60, 300), slice(130, 190))
    off = np.angle(carried[middle] * truth[middle].conj()).mean(axis=1)
    bend = np.polyfit(slm.y()[middle[0]] / depth, off, 2)[0]
    step = abs(after.positions[0, 2] - depth)
    assert step == pytest.approx(aside * abs(angle), rel=1e-3)
    # Left at its old depth the fringe would be bent by half of this.
    assert abs(bend) < 0.1 * 2 * np.pi / WAVELENGTH * step


def test_light_that_a_shift_carries_off_the_panel_does_not_come_back_opposite() -> None:
    passband = coding_for("real", PANEL).passband
    field = chrmc.compute_field(
        body((0.0, 0.0, DEPTH)), PANEL, WAVELENGTH, passband=passband, method="rt"
    )
    for columns, rows in ((200, 0), (-200, 0), (0, 100), (0, -100)):
        motion = Translation((columns * PANEL.pixel_pitch, rows * PANEL.pixel_pitch, 0.0))
        shifted = np.abs(translate(field, motion, PANEL, WAVELENGTH))
        came_in = np.ones(PANEL.shape, dtype=bool)
        came_in[max(rows, 0) : 240 + min(rows, 0), max(columns, 0) : 480 + min(columns, 0)] = False
        assert shifted[came_in].max() < 1e-3 * shifted.max()
