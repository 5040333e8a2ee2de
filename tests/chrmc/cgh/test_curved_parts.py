"""The parts of the curved hologram: nodes, tables, series, prediction."""

import numpy as np
import pytest

from chrmc import LC_R_1080, SLM, WAVELENGTH, PointCloud
from chrmc.cgh import curved
from chrmc.cgh.curved import chebyshev, series, tables, wave
from chrmc.cgh.curved.along import across
from chrmc.cgh.curved.axes import cluster_axes
from chrmc.cgh.curved.baseband import first_aim, series_for
from chrmc.cgh.curved.clusters import bounding_box, reference_of
from chrmc.cgh.curved.levels import levels_for
from chrmc.cgh.curved.nodes import Axis
from chrmc.cgh.curved.predict import error_allowed
from chrmc.encoding import coding_for
from chrmc.optics.footprint import coverage
from chrmc.optics.passband import UNLIMITED
from chrmc.reference import reference_samples, relative_error
from chrmc.window import Window

REFERENCE = wave.Reference(0.0, 0.0, 0.2505, 4e-3, 3e-3)
LC_QUARTER = SLM("quarter", 480, 300, 16e-6)


@pytest.mark.parametrize("tolerance", [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6])
@pytest.mark.parametrize("kappa", [0.0, 0.3, 2.0, 11.0, 40.0, 150.0, 300.0])
def test_node_count_gives_the_error_asked_for_and_not_much_less(
    kappa: float, tolerance: float
) -> None:
    count = chebyshev.node_count(kappa, tolerance)
    u = np.linspace(-1, 1, 1001)
    frequencies = np.linspace(-1, 1, 41) * kappa

    def rms(n: int) -> float:
        values = np.exp(1j * np.outer(chebyshev.chebyshev(n), frequencies))
        missed = chebyshev.interpolation(n, u) @ values - np.exp(1j * np.outer(u, frequencies))
        return float(np.sqrt(np.mean(np.abs(missed) ** 2)))

    assert rms(count) <= 1.4 * tolerance
    if kappa > 1:
        assert rms(count - 4 - int(kappa > 50) * 4) > tolerance


def test_interpolation_is_exact_for_polynomials_and_at_the_nodes() -> None:
    targets = np.concatenate([np.linspace(-1, 1, 33), chebyshev.chebyshev(9)])
    matrix = chebyshev.interpolation(9, targets)
    for degree in range(9):
        np.testing.assert_allclose(
            matrix @ chebyshev.chebyshev(9) ** degree, targets**degree, atol=1e-14
        )


def test_cycles_keep_their_digits_at_a_hundred_metres() -> None:
    t, x, z = np.linspace(-9e-3, 9e-3, 7), np.array([1e-3, -2e-3]), np.array([100.0, 99.9])
    long = [np.asarray(v, dtype=np.longdouble) for v in (t, x[:, None], z[:, None])]
    own = np.sqrt(long[0] ** 2 + np.longdouble(99.95) ** 2) - np.longdouble(99.95)
    exact = (np.sqrt((long[0] - long[1]) ** 2 + long[2] ** 2) - long[2] - own) / WAVELENGTH
    got = wave.axis_cycles(t, x, z, 0.0, 99.95, WAVELENGTH)
    # √ at 100 m in 80-bit numbers keeps 5e-18 m, 1e-11 cycles.
    np.testing.assert_allclose(got, exact.astype(float), rtol=0, atol=3e-10)


def test_phasors_from_the_table_are_cosine_and_sine() -> None:
    random = np.random.default_rng(0)
    cycles = np.concatenate([random.uniform(-1e4, 1e4, 3000), np.arange(-9, 9) / 2048, [0.0]])
    cos, sin = wave.phasor(cycles)
    turn = 2 * np.pi * (cycles - np.rint(cycles))
    np.testing.assert_allclose(cos, np.cos(turn), rtol=0, atol=5e-12)
    np.testing.assert_allclose(sin, np.sin(turn), rtol=0, atol=5e-12)
    # Many waves in step do not add the errors up.
    assert abs(np.mean(cos - np.cos(turn))) < 1e-12 > abs(np.mean(sin - np.sin(turn)))


def test_interpolated_cycles_are_the_cycles() -> None:
    t = np.linspace(-8e-3, 8e-3, 400)
    random = np.random.default_rng(0)
    x, z = random.uniform(-5e-3, 5e-3, 20), random.uniform(0.02, 0.3, 20)
    exact = wave.axis_cycles(t, x, z, 1e-3, 0.1, WAVELENGTH)
    values, matrix = wave.phase_table(Axis(t, (), ()), x, z, 1e-3, 0.1, WAVELENGTH)
    assert matrix is not None
    np.testing.assert_allclose(values @ matrix, exact, rtol=0, atol=1e-8)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-6])
def test_series_has_the_terms_that_the_tolerance_needs_and_no_more(tolerance: float) -> None:
    random = np.random.default_rng(1)
    box = np.array([[-1e-3, 1e-3], [-5e-4, 5e-4], [1 / 0.251, 1 / 0.25]])
    made = series.make_series(
        (-8e-3, 8e-3), (-5e-3, 5e-3), box, REFERENCE.kernel(WAVELENGTH), tolerance
    )
    assert made is not None
    points = random.uniform(box[:, 0], box[:, 1], (300, 3))
    x, y = np.linspace(-8e-3, 8e-3, 31), np.linspace(-5e-3, 5e-3, 23)
    on = made.on_nodes(x, y, np.float64)
    real, imag = (
        np.array(part) for part in zip(*(on.of(term) for term in range(made.terms)), strict=True)
    )
    at = made.at_points(points)
    exact = REFERENCE.residual(
        x - points[:, 0, None, None],
        y[:, None] - points[:, 1, None, None],
        1 / points[:, 2, None, None],
        WAVELENGTH,
    )

    def missed(terms: int) -> float:
        got = np.tensordot(at[:terms], (real + 1j * imag)[:terms], (0, 0))
        return float(np.linalg.norm(got - exact) / np.linalg.norm(exact))

    count = made.terms
    assert missed(count) <= 1.3 * tolerance
    assert missed(count - 1) > 0.5 * tolerance


def test_exact_and_separable_basebands_agree() -> None:
    random = np.random.default_rng(2)
    cloud = PointCloud(
        random.uniform((-3e-4, -2e-4, 0.1), (3e-4, 2e-4, 0.1004), (50, 3)),
        random.uniform(0.5, 1, 50),
        random.uniform(0, 6, 50),
    )
    window = Window.full(LC_R_1080)
    band = coding_for("ssb", LC_R_1080).passband
    plane = curved.plane_of(LC_R_1080, WAVELENGTH, window, band)
    factor, _ = curved.make_factor(cloud, plane, 1e-5)
    real, imag = tables.exact_baseband(
        cloud, factor.axis_x, factor.axis_y,
        tables.Wave(factor.reference, WAVELENGTH, plane.reach),
    )  # fmt: skip
    assert relative_error(factor.real + 1j * factor.imag, real + 1j * imag) < 1e-5


def random_scene(seed: int, slm: SLM) -> PointCloud:
    """An object of 0.2 to 6 mm, 50 mm to 2 m away, on or off the axis, turned about all axes."""
    random = np.random.default_rng(seed)
    count = int(random.integers(100, 600))
    size = 10 ** random.uniform(np.log10(2e-4), np.log10(6e-3)) * random.uniform(0.3, 1, 3)
    turn, _ = np.linalg.qr(random.standard_normal((3, 3)))
    z = 10 ** random.uniform(np.log10(0.05), np.log10(2))
    centre = (*(random.uniform(-5e-3, 5e-3, 2) * min(1, z / 0.25)), z)
    positions = (random.random((count, 3)) - 0.5) * size @ turn.T + centre
    cloud = PointCloud(positions, random.uniform(0.2, 1, count), random.uniform(0, 6.3, count))
    shown = coverage(cloud, slm, WAVELENGTH, coding_for("ssb", slm).passband) > 0.01
    return cloud.select(shown)


def check_prediction(seed: int, slm: SLM, tolerance: float) -> None:
    cloud = random_scene(seed, slm)
    band = coding_for(("ssb", "real")[seed % 2], slm).passband
    window = Window.full(slm)
    made = curved.low_rank(cloud, slm, WAVELENGTH, window, band, tolerance=tolerance)
    field = curved.field_of(made.factors, slm, WAVELENGTH, window)
    random = np.random.default_rng(seed)
    rows, columns = random.integers(0, slm.height, 1500), random.integers(0, slm.width, 1500)
    truth = reference_samples(cloud, slm, WAVELENGTH, rows, columns, passband=band)
    measured = relative_error(field[rows, columns], truth)
    assert measured <= tolerance
    if measured < 1e-6:  # only rounding is left, whose size is an upper estimate
        assert made.error_predicted < 2e-6
        return
    assert measured / 3 <= made.error_predicted <= 3 * measured


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
def test_predicted_error_is_near_the_measured_one(seed: int, tolerance: float) -> None:
    check_prediction(seed, LC_QUARTER, tolerance)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(30))
@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4, 1e-5, 1e-6])
def test_predicted_error_is_near_the_measured_one_on_the_panel(seed: int, tolerance: float) -> None:
    check_prediction(seed, LC_R_1080, tolerance)


def test_a_box_of_one_point_needs_one_term() -> None:
    box = bounding_box(np.array([[1e-3, 2e-3, 5.0]]))
    made = series.make_series((-8e-3, 8e-3), (-5e-3, 5e-3), box, REFERENCE.kernel(WAVELENGTH), 1e-6)
    assert made is not None and made.terms == 1


@pytest.mark.parametrize(
    ("targets", "squares"),
    [
        ((-2.0, 5.0), (2.5, 18.75)),
        ((-5.0, 2.0), (2.5, 18.75)),
        ((3.0, 5.0), (10.6, 21.0)),
        ((-5.0, -3.0), (10.6, 21.0)),
    ],
)
def test_filters_are_made_on_two_lines_between_which_most_targets_lie(
    targets: tuple[float, float], squares: tuple[float, float]
) -> None:
    """What grows with the square of the distance is read off both exactly."""
    centre = 0.7
    made = across((targets[0] + centre, targets[1] + centre), centre)
    lines = np.array(made.lines) - centre
    np.testing.assert_allclose(lines**2, squares)
    assert np.all(lines > 0) if abs(targets[1]) > abs(targets[0]) else np.all(lines < 0)
    t = np.linspace(*targets, 9)
    near, far = made.shares(t + centre)
    for power in (0, 2):
        np.testing.assert_allclose(near * lines[0] ** power + far * lines[1] ** power, t**power)
    one = across((centre, centre), centre)
    assert one.shares(t[:2])[0].tolist() == [1, 1] and one.shares(t[:2])[1].tolist() == [0, 0]


def test_series_of_points_metres_apart_seen_from_a_narrow_panel() -> None:
    """More polynomials than samples: once thousands of each other's products were solved for."""
    box = np.array([[-0.1, 0.1], [-1.0, 1.0], [1 / 12.2, 1 / 12.1]])
    made = series.make_series((-5e-3, 5e-3), (-5e-4, 5e-4), box, REFERENCE.kernel(2e-6), 1e-3, 1e7)
    assert made is not None and len(made.orders) > 2 * made.values[0].size
    points = np.random.default_rng(2).uniform(box[:, 0], box[:, 1], (200, 3))
    x, y = np.linspace(-5e-3, 5e-3, 9), np.linspace(-5e-4, 5e-4, 7)
    on, at = made.on_nodes(x, y, np.float64), made.at_points(points)
    total = sum(
        (real + 1j * imag) * at[term][:, None, None]
        for term in range(made.terms)
        for real, imag in [on.of(term)]
    )
    exact = REFERENCE.residual(
        x - points[:, 0, None, None], y[:, None] - points[:, 1, None, None],
        1 / points[:, 2, None, None], 2e-6,
    )  # fmt: skip
    assert np.linalg.norm(total - exact) < 2e-3 * np.linalg.norm(exact)


def test_terms_of_very_many_nodes_are_added_up_as_they_come(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    random = np.random.default_rng(2)
    down, across = (tuple(random.normal(size=(3, 30, n))) for n in (150, 40))
    weights = series.OnNodes(
        *random.normal(size=(2, 5, 4, 3)), random.normal(size=(3, 40)),
        random.normal(size=(150, 4)),
    )  # fmt: skip
    scale = random.normal(size=(5, 30))

    def summed() -> np.ndarray:
        pieces, total = tables._products(across, down, scale, weights)
        for piece in pieces:
            piece()
        return np.array(total())

    whole = summed()
    monkeypatch.setattr(tables, "_MOST_VALUES", 0)
    np.testing.assert_allclose(summed(), whole, rtol=0, atol=1e-10 * np.abs(whole).max())


@pytest.mark.parametrize("tolerance", [1e-6, 1.3e-6, 2e-6, 1e-5])
@pytest.mark.parametrize(
    ("size", "depth"), [((2e-3, 1e-3, 1e-9), 0.25), ((1e-3, 1e-3, 2e-3), 0.1), ((0, 0, 0.5), 0.9)]
)
def test_the_first_attempt_leaves_room_for_rounding(
    size: tuple[float, float, float], depth: float, tolerance: float
) -> None:
    slm = SLM("half", 960, 600, 16e-6)
    random = np.random.default_rng(5)
    cloud = PointCloud(
        (random.random((200, 3)) - 0.5) * size + (1e-3, 0, depth), np.ones(200),
        random.uniform(0, 6.3, 200),
    )  # fmt: skip
    passband = coding_for("ssb", slm).passband
    plane = curved.plane_of(slm, WAVELENGTH, Window.full(slm), passband)
    factor, budget = curved.make_factor(cloud, plane, first_aim(tolerance))
    assert budget.relative <= error_allowed([factor], tolerance, len(cloud))


def test_small_terms_are_summed_in_single_precision() -> None:
    slm = SLM("wide", 480, 600, 16e-6)
    random = np.random.default_rng(4)
    places = random.uniform(-1, 1, (120, 3)) * (2e-3, 1e-3, 0.4) + (0, 0, 0.8)
    cloud = PointCloud(places, np.ones(120), random.uniform(0, 6.3, 120))
    plane = curved.plane_of(slm, WAVELENGTH, Window.full(slm), coding_for("real", slm).passband)
    reference = reference_of(bounding_box(places), plane)
    axes = cluster_axes(cloud, reference, plane, 1e-6)
    short = series_for(cloud, axes, reference, plane, 1e-6)
    assert short is not None and short.terms > 4
    levels, _ = levels_for(cloud, axes, reference, plane, 1e-6, short, 10**6)
    assert levels[0].precision is np.float64 and levels[-1].precision is np.float32
    single = sum(len(range(*one.terms.indices(short.terms))) for one in levels[1:])
    assert single >= short.terms / 2


def test_only_clusters_that_miss_are_made_anew() -> None:
    assert curved._missing({0: 1e-4, 1: 3.0, 2: 0.1, 3: 0.2}, 1.0) == [1, 3]
    assert curved._missing({0: 1.0, 1: 1.0}, 1.0) == [0, 1]
    assert curved._missing({0: 0.0, 1: 9.0}, 1.0) == [1]


def test_a_series_of_more_polynomials_than_waves_is_none() -> None:
    """On a panel of one row a tall body takes a thousand of them for some dozen nodes."""
    random = np.random.default_rng(3)
    size, place = (1e-3, 0.8, 0.1), (0.5, 0.0, 1.0)
    positions = (random.random((5000, 3)) - 0.5) * size + place
    cloud = PointCloud(positions, np.ones(5000), np.zeros(5000))
    found = []
    for height in (1, 2000):
        slm = SLM("row", 1500, height, 2e-6)
        plane = curved.plane_of(slm, 8.3e-6, Window.full(slm), UNLIMITED)
        its = reference_of(bounding_box(cloud.positions), plane)
        axes = cluster_axes(cloud, its, plane, 0.05)
        found.append(series_for(cloud, axes, its, plane, 0.05, count=1_600_000))
    assert found[0] is None and found[1] is not None
