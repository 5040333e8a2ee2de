"""Parts of object-centred CH-RMC: taps, sphere, soft edges as filters, against exact sums."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from chrmc import LC_R_1080, SLM, WAVELENGTH, PointCloud
from chrmc.cgh.curved.interface import plane_of, reference_cycles, taps_for
from chrmc.compensation.ch_rmc_object.chart import mean_rotation, path
from chrmc.compensation.ch_rmc_object.group import Group
from chrmc.compensation.ch_rmc_object.plan import Plan, outline_of, planned, views_ahead
from chrmc.compensation.ch_rmc_object.sphere import NotCovered
from chrmc.compensation.ch_rmc_object.transforms import transformed_tile
from chrmc.encoding import coding_for
from chrmc.reference import relative_error
from chrmc.scene.scene import ObjectFrame, Pose
from chrmc.threads import THREADS
from chrmc.window import Window

SMALL = SLM("a quarter of the paper's", 320, 200, 16e-6)


def body(count: int, size: tuple[float, float, float], seed: int = 1) -> PointCloud:
    random = np.random.default_rng(seed)
    return PointCloud(
        (random.random((count, 3)) - 0.5) * size,
        random.uniform(0.3, 1, count),
        random.uniform(0, 6.3, count),
    )


def seen(points: PointCloud, turn: list[float], place: list[float]) -> ObjectFrame:
    """A body in a pose, all of it seen."""
    pose = Pose(Rotation.from_rotvec(turn).as_matrix(), np.array(place))
    cloud = PointCloud(pose.apply(points.positions), points.amplitude, points.phase)
    return ObjectFrame("body", cloud, points, np.arange(len(points)), pose)


def plan_of(obj: ObjectFrame, slm: SLM, tolerance: float, encoding: str = "ssb") -> Plan:
    window = Window.full(slm)
    plane = plane_of(slm, WAVELENGTH, window, coding_for(encoding, slm).passband)
    assert obj.body is not None
    return planned(obj, outline_of(obj.body), plane, tolerance)


def exact(
    cloud: PointCloud,
    plan: Plan,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    weights: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None,
) -> NDArray[np.complex128]:
    """(y, x) sum of spherical waves over the plan's reference wave, in double precision."""
    out = np.zeros((len(y), len(x)), dtype=complex)
    for j, (px, py, pz) in enumerate(cloud.positions):
        r = np.sqrt((x - px) ** 2 + (y[:, None] - py) ** 2 + pz**2)
        wave = cloud.amplitude[j] / r * np.exp(1j * (2 * np.pi / WAVELENGTH * r + cloud.phase[j]))
        out += wave if weights is None else wave * weights[0][j] * weights[1][j][:, None]
    its = plan.wave.reference
    cycles = reference_cycles(x, its.x, its.z_x, WAVELENGTH)
    cycles = cycles + reference_cycles(y, its.y, its.z_y, WAVELENGTH)[:, None]
    return out * np.exp(-2j * np.pi * cycles)


@pytest.mark.parametrize("tolerance", [1e-2, 2e-4, 2e-6])
def test_taps_keep_their_tolerance_up_to_the_bands_end_and_know_their_error(
    tolerance: float,
) -> None:
    taps = taps_for(tolerance)
    at = np.random.default_rng(0).uniform(30, 60, 400)
    first, weight = taps.weights(at)
    grid = np.arange(100.0)
    end = 1 / (2 * taps.oversampling)
    for share in (0.1, 0.5, 0.9, 1.0):
        wave = np.exp(2j * np.pi * share * end * grid)
        got = np.sum(weight * wave[first[:, None] + np.arange(taps.count)], axis=1)
        error = np.sqrt(np.mean(np.abs(got - np.exp(2j * np.pi * share * end * at)) ** 2))
        assert error <= 1.2 * tolerance + 1e-6
        known = float(taps.rms_error(np.array(share), 1.0))
        assert known <= 1.01 * tolerance and abs(known - error) <= 0.3 * tolerance + 1e-6
    beyond = float(taps.rms_error(np.array(1.2), 1.0))
    assert beyond > 2 * tolerance  # the band has an end, and it is known


def test_the_path_has_no_cancellation() -> None:
    r, place = 0.25, (1e-9, -2e-9, 3e-9)
    alpha, beta = np.array(0.03), np.array(-0.02)
    gamma = np.sqrt(1 - alpha**2 - beta**2)
    first_order = -(place[0] * alpha + place[1] * beta - place[2] * gamma)
    assert path(alpha, beta, place, r) == pytest.approx(first_order, rel=1e-6)


@pytest.mark.parametrize(
    ("turn", "depth"),
    [
        ((0.06, 0, 0), 0.2), ((-0.06, 0, 0), 0.2), ((0, 0.06, 0), 0.2), ((0, -0.06, 0), 0.2),
        ((0, 0, 0), 0.15), ((0, 0, 0), 0.25),
    ],
    ids=["down", "up", "left", "right", "nearer", "farther"],
)  # fmt: skip
def test_a_frame_beyond_the_chart_is_said_to_be(
    turn: tuple[float, float, float], depth: float
) -> None:
    """On all sides: what lies beyond is never read from what happens to stand there."""
    points = body(60, (8e-4, 4e-4, 6e-4))
    frames = [seen(points, [0, 0, 0], [0, 0, 0.2]), seen(points, [0, 0, 0], [0, 0, 0.201])]
    window = Window.full(SMALL)
    plane = plane_of(SMALL, WAVELENGTH, window, coding_for("ssb", SMALL).passband)
    outline = outline_of(points)
    first = planned(frames[0], outline, plane, 1e-3)
    poses = [frame.pose for frame in frames if frame.pose is not None]
    group = Group(first, outline, poses, plane, 1e-3)
    visible = np.ones(len(points), dtype=bool)
    for frame in (*frames, seen(points, list(turn), [0, 0, depth])):
        plan = planned(frame, outline, plane, 1e-3)
        x, y = (reading.places for reading in plan.readings)
        assert frame.pose is not None
        given = frame.pose, plan.wave.reference, x, y, visible
        if frame in frames:
            assert group._plain(*given).shape == (len(x), len(y))
        else:
            with pytest.raises(NotCovered):
                group._plain(*given)


@pytest.mark.parametrize("place", [(6e-3, 3e-3, 0.2), (-6e-3, -3e-3, 0.2), (0, 0, 0.4)])
def test_views_ahead_hold_the_places_that_later_frames_read(place: tuple[float, ...]) -> None:
    """And little more: what lies beyond is summed and never looked at."""
    points = body(60, (8e-4, 4e-4, 6e-4))
    frames = [
        seen(points, [0, 0.02 * k, 0], [(1 - 0.02 * k) * place[0], place[1], place[2] + 1e-3 * k])
        for k in range(3)
    ]
    plane = plane_of(
        LC_R_1080, WAVELENGTH, Window.full(LC_R_1080), coding_for("ssb", LC_R_1080).passband
    )
    outline = outline_of(points)
    plans = [planned(frame, outline, plane, 1e-3) for frame in frames]
    poses = [frame.pose for frame in frames if frame.pose is not None]
    to_chart = mean_rotation(poses)
    views = views_ahead(plans[0], outline, poses, to_chart, plane)
    for k, (pose, plan) in enumerate(zip(poses, plans, strict=True)):
        x, y = (reading.places for reading in plan.readings)
        ends = np.meshgrid([x.min(), x.max()], [y.min(), y.max()], 0.0)
        seen_from = np.stack(ends, -1).reshape(-1, 3) - pose.apply(outline.middle[None])
        directions = seen_from @ (to_chart @ pose.rotation.T).T
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        for axis, (low, high) in enumerate((views.alpha, views.beta)):
            own = directions[:, axis]
            room = np.array([own.min() - low[k], high[k] - own.max()]) / np.ptp(own)
            assert np.all(room > 0.025) and np.all(room < 0.09)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
def test_the_sphere_holds_a_turning_bodys_light(tolerance: float) -> None:
    points = body(200, (8e-4, 4e-4, 6e-4))
    frames = [
        seen(points, [0.03 * k, -0.05 * k, 0.04 * k], [3e-4, 2e-4 * k, 0.2 + 1e-3 * k])
        for k in range(4)
    ]
    window = Window.full(SMALL)
    plane = plane_of(SMALL, WAVELENGTH, window, coding_for("ssb", SMALL).passband)
    outline = outline_of(points)
    plans = [planned(frame, outline, plane, tolerance) for frame in frames]
    poses = [frame.pose for frame in frames if frame.pose is not None]
    group = Group(plans[0], outline, poses, plane, tolerance)
    visible = np.ones(len(points), dtype=bool)
    random = np.random.default_rng(3)
    for number, (frame, plan) in enumerate(zip(frames, plans, strict=True)):
        x, y = (reading.places for reading in plan.readings)
        shown = PointCloud(
            frame.cloud.positions[visible], frame.cloud.amplitude[visible],
            frame.cloud.phase[visible],
        )  # fmt: skip
        got = group._plain(poses[number], plan.wave.reference, x, y, visible)
        error = relative_error(got.T, exact(shown, plan, x, y))
        assert error <= 0.5 * tolerance
        assert error / 3 <= group.sphere.expected_error(visible) <= 0.4 * tolerance
        visible = visible ^ (random.random(len(points)) < 0.1)  # some come, some go


@pytest.mark.parametrize("nearer", [1e-3, 1e-2])  # a frame: directions err most, or layers of range
def test_every_points_own_error_is_known(nearer: float) -> None:
    """Corners err more than the middle; what is seen is averaged by its power."""
    corner = np.array([4e-4, 2e-4, 3e-4])
    places = corner * [[-1, -1, -1], [-1, -1, 1], [-1, 1, -1], [0, 0, 0], [1, 0, 0]]
    points = PointCloud(places, np.array([1.0, 2.0, 1.0, 0.5, 1.0]), np.zeros(5))
    frames = [
        seen(points, [0.03 * k, -0.05 * k, 0.04 * k], [3e-4, 2e-4 * k, 0.2 + nearer * k])
        for k in range(4)
    ]
    window = Window.full(SMALL)
    plane = plane_of(SMALL, WAVELENGTH, window, coding_for("ssb", SMALL).passband)
    plans = [planned(frame, outline_of(points), plane, 1e-3) for frame in frames]
    poses = [frame.pose for frame in frames if frame.pose is not None]
    group = Group(plans[0], outline_of(points), poses, plane, 1e-3)
    known, found = [], []
    for j in range(len(points)):
        squares = []
        alone = np.arange(len(points)) == j
        for frame, plan, pose in zip(frames, plans, poses, strict=True):
            x, y = (reading.places for reading in plan.readings)
            got = group._plain(pose, plan.wave.reference, x, y, alone)
            squares.append(relative_error(got.T, exact(frame.cloud.select(alone), plan, x, y)) ** 2)
        known.append(group.sphere.expected_error(alone))
        found.append(np.sqrt(np.mean(squares)))
        assert 0.65 < known[j] / found[j] < 1.4
    power = points.amplitude**2
    mean, measured = (np.sqrt(power @ np.square(each) / power.sum()) for each in (known, found))
    assert 0.72 < mean / measured < 1.1
    sphere = group.sphere
    assert sphere.expected_error(np.ones(5, dtype=bool)) == pytest.approx(mean, rel=1e-6)
    # Of nothing what the series drop is left, and rounding.
    nothing = sphere.expected_error(np.zeros(5, dtype=bool))
    assert nothing**2 - sphere.dropped**2 == pytest.approx(2 * 5e-7**2, rel=0.02)


@pytest.mark.parametrize(
    "place",
    [
        pytest.param([5e-3, 1.2e-3, 0.252], id="left and lower edge"),
        pytest.param([-5e-3, -1.2e-3, 0.25], id="right and upper edge"),
        pytest.param([0.0, 0.0, 0.2], id="all four edges and corners"),
        pytest.param([9e-3, 6e-3, 0.3], id="beyond the rim"),
        pytest.param([1e-3, 0.0, 0.26], id="upper and lower edge, near the middle"),
    ],
)
def test_strips_at_full_size_are_filtered_from_the_plain_baseband(place: list[float]) -> None:
    points = body(60, (1.6e-3, 6.2e-4, 7e-4))
    obj = seen(points, [0.0, 0.3, 0.0], place)
    plan = plan_of(obj, LC_R_1080, 1e-3)
    assert plan.from_points == (False, False)
    x, y = (reading.places for reading in plan.readings)
    plain = exact(obj.cloud, plan, x, y)
    wide = plan.readings[0].of(plain.T.copy(), len(plan.axes[0].nodes), y)
    got = plan.readings[1].of(wide.T.copy(), len(plan.axes[1].nodes), plan.axes[0].nodes)
    its = [
        axis.weights(obj.cloud.positions[:, i], obj.cloud.positions[:, 2], plan.wave.reach[i])
        for i, axis in enumerate(plan.axes)
    ]
    truth = exact(obj.cloud, plan, plan.axes[0].nodes, plan.axes[1].nodes, (its[0], its[1]))
    # As pixels see it: every node weighs as the pixels that it stands for.
    weight = np.ones(truth.shape)
    for i, axis in enumerate(plan.axes):
        for run in axis.runs:
            part = (slice(None), run.nodes) if i == 0 else (run.nodes,)
            weight[part] *= run.weight if i == 0 else run.weight[:, None]
    power = float(np.sum(weight * np.abs(truth) ** 2))
    error = np.sqrt(float(np.sum(weight * np.abs(got - truth) ** 2)) / power)
    assert any(run.tapered for axis in plan.axes for run in axis.runs)
    expected = np.sqrt(plan.missed / power)
    assert error <= 0.6e-3
    assert error / 2 <= expected <= 0.6e-3


def test_long_strips_are_filtered_part_by_part() -> None:
    points = body(60, (5e-3, 5e-3, 5e-3))
    obj = seen(points, [0.0, 0.0, 0.0], [1e-3, 5e-4, 0.25])
    plan = plan_of(obj, LC_R_1080, 7e-4)
    along, axis = plan.readings[0], plan.axes[0]
    strips = [run for run in axis.runs if run.tapered]
    assert not plan.from_points[0] and len(along.filters) > len(axis.runs)
    y = plan.readings[1].places[::40]
    got = along.of(exact(obj.cloud, plan, along.places, y).T.copy(), len(axis.nodes), y)
    x_places, _, depths = obj.cloud.positions.T
    soft = axis.weights(x_places, depths, plan.wave.reach[0]), np.ones((len(points), len(y)))
    truth = exact(obj.cloud, plan, axis.nodes, y, soft).T
    for run in strips:
        error = np.sum(run.weight[:, None] * np.abs((got - truth)[run.nodes]) ** 2)
        assert error <= 1e-6 * sum(
            float(np.sum(r.weight[:, None] * np.abs(truth[r.nodes]) ** 2)) for r in axis.runs
        )


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3])
def test_filters_do_not_blow_up_the_error_of_what_they_read(tolerance: float) -> None:
    obj = seen(body(60, (1.6e-3, 6.2e-4, 7e-4)), [0.0, 0.3, 0.0], [0.0, 0.0, 0.2])
    plan = plan_of(obj, LC_R_1080, tolerance)
    matrices = [m for r in plan.readings for f in r.filters for m in f.matrices]
    assert len(matrices) == 8  # four strips, two lines across each
    assert max(float(np.linalg.norm(m, axis=1).max()) for m in matrices) < 2


def test_a_tighter_tolerance_has_its_strips_from_the_points() -> None:
    obj = seen(body(60, (1.6e-3, 6.2e-4, 7e-4)), [0.0, 0.3, 0.0], [5e-3, 1.2e-3, 0.252])
    plan = plan_of(obj, LC_R_1080, 1e-5)
    assert plan.from_points == (True, True) and plan.missed == 0


@pytest.mark.parametrize(("tolerance", "kind"), [(1e-3, np.complex64), (3e-5, np.complex128)])
def test_transforms_give_the_sum_of_many_points_in_a_tile_of_directions(
    tolerance: float, kind: type[np.complexfloating]
) -> None:
    points = body(3000, (1.6e-3, 7e-4, 8e-4))
    alpha, beta = 0.13 + 3e-4 * np.arange(60), -0.02 + 3e-4 * np.arange(41)
    made = transformed_tile(points, (alpha, beta), np.array([4.0]), WAVELENGTH, tolerance)
    assert made is not None
    (got,), missed = made
    assert got.dtype == kind and got.shape == (41, 60)
    random = np.random.default_rng(0)
    rows, columns = random.integers(0, 41, 40), random.integers(0, 60, 40)
    a, b = alpha[columns], beta[rows]
    # The hologram's place itself, r away in the direction (α, β, −γ).
    at = 0.25 * np.stack([a, b, -np.sqrt(1 - a * a - b * b)], axis=1)
    far = np.linalg.norm(at[:, None] - points.positions, axis=2)
    turns = (far - 0.25) / WAVELENGTH + points.phase / (2 * np.pi)
    truth = np.sum(points.amplitude * 0.25 / far * np.exp(2j * np.pi * turns), axis=1)
    assert relative_error(got[rows, columns], truth) <= 2 * missed <= 4 * tolerance


def test_the_last_bits_do_not_depend_on_which_thread_is_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    points = body(7000, (4e-4, 3e-4, 2e-4))
    frame = seen(points, [0, 0, 0], [0, 0, 0.2])
    window = Window.full(SMALL)
    plane = plane_of(SMALL, WAVELENGTH, window, coding_for("ssb", SMALL).passband)
    plan = plan_of(frame, SMALL, 1e-3)
    x, y = (reading.places for reading in plan.readings)
    read = []
    for threads in ("1", "2", "4", "4"):
        monkeypatch.setenv(THREADS, threads)
        assert frame.pose is not None
        group = Group(plan, outline_of(points), [frame.pose], plane, 1e-3)
        every = np.ones(len(points), dtype=bool)
        read.append(group._plain(frame.pose, plan.wave.reference, x, y, every))
    for other in read[1:]:
        assert np.array_equal(read[0], other)
