"""A look at few pixels tells of the whole frame."""

from dataclasses import replace

import numpy as np
import pytest

from chrmc import SLM, WAVELENGTH, PointCloud
from chrmc.cgh import curved
from chrmc.cgh.curved import predict, verify
from chrmc.cgh.curved.clusters import Plane
from chrmc.cgh.curved.nodes import Axis, Line
from chrmc.optics.passband import UNLIMITED
from chrmc.reference import reference_field, relative_error
from chrmc.window import Window

PANEL = SLM("panel", 320, 200, 16e-6)


def spoiled(axis: Axis) -> Axis:
    """The same with a wrong first and last target."""
    blocks = list(axis.blocks)
    for at in (0, -1):
        matrix = blocks[at].matrix
        assert matrix is not None
        matrix = matrix.copy()
        matrix[at] *= 1.05
        blocks[at] = replace(blocks[at], matrix=matrix)
    return replace(axis, blocks=tuple(blocks))


def test_ends_of_runs_count_as_the_few_pixels_that_they_are() -> None:
    random = np.random.default_rng(0)
    cloud = PointCloud(
        random.uniform((-3e-4, -3e-4, 0.1497), (3e-4, 3e-4, 0.1503), (80, 3)),
        random.uniform(0.2, 1, 80),
        random.uniform(0, 6.3, 80),
    )
    window = Window.full(PANEL)
    plane = curved.plane_of(PANEL, WAVELENGTH, window, UNLIMITED)
    factor, _ = curved.make_factor(cloud, plane, 1e-4)
    wrong = replace(factor, axis_x=spoiled(factor.axis_x), axis_y=spoiled(factor.axis_y))
    made = curved.field_of([wrong], PANEL, WAVELENGTH, window)
    whole = relative_error(made, reference_field(cloud, PANEL, WAVELENGTH, passband=UNLIMITED))
    seen = verify.measured_error([wrong], cloud, plane, 1e-4, 1e-4)
    assert seen == pytest.approx(whole, rel=0.3)


def test_a_tighter_frame_is_looked_at_more_closely() -> None:
    assert [verify.waves_looked_at(10**6, 10.0**-n) for n in (1, 3, 4, 6)] == [
        4e6,
        9e6,
        12e6,
        3.6e7,
    ]
    assert [verify.waves_looked_at(points, 1e-3) for points in (10, 1000)] == [1280, 50_000]


@pytest.mark.parametrize(
    ("error", "expected", "drawn"),
    [
        (5e-4, 4e-4, [9]),
        (5e-4, 2e-4, [9, 27]),  # more than twice what was expected
        (8e-4, 1e-3, [9, 27, 108]),  # near the tolerance: each draw leaves it open
        (1.4e-3, 1e-3, [9, 27]),  # past it
    ],
)
def test_more_pixels_are_drawn_where_few_leave_it_open(
    error: float, expected: float, drawn: list[int]
) -> None:
    rows, columns = ((np.arange(n), np.ones(n)) for n in (20, 30))
    lattice = verify.Lattice(rows, columns, np.ones((20, 30), dtype=complex))
    pixels: list[int] = []

    def exact(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        pixels.append(len(x))
        return np.full(len(x), 1 + error, dtype=complex)

    plane = Plane(Line(0.0, 1.0, 30), Line(0.0, 1.0, 20), WAVELENGTH, (1.0, 1.0))
    found = lattice.error(exact, plane, 10_000, 1e-3, expected)
    assert found == pytest.approx(error, rel=0.2) and pixels == drawn


@pytest.mark.parametrize(
    ("width", "points", "tolerance", "share"),
    [
        (320, 18, 1e-3, 1 / np.sqrt(1 + 3 / np.sqrt(4.5))),
        (320, 600, 1e-3, 0.65),
        (320, 8, 1e-3, 1 / np.sqrt(1 + 3 / np.sqrt(2))),
        (320, 7, 1e-3, 0.4),  # one draw of few phases may lie far from the mean
        (320, 7, 1e-6, np.hypot(0.4, 0.5)),  # but rounding is as it is
        (320, 7, 7e-7, 0.8),
        (320, 600, 1e-6, 0.8),
        (64, 600, 1e-3, 0.65),
    ],
)
def test_more_room_is_left_where_few_points_see_one_draw(
    width: int, points: int, tolerance: float, share: float
) -> None:
    panel = SLM("narrow", width, 200, 16e-6)
    random = np.random.default_rng(0)
    places = random.uniform((-3e-4, -3e-4, 0.1497), (3e-4, 3e-4, 0.1503), (60, 3))
    cloud = PointCloud(places, np.ones(60), np.zeros(60))
    plane = curved.plane_of(panel, WAVELENGTH, Window.full(panel), UNLIMITED)
    factor, budget = curved.make_factor(cloud, plane, 1e-3)
    allowed = predict.error_allowed([factor], tolerance, points)
    assert allowed == pytest.approx(share * tolerance)
    for part, kept in ((0.99, True), (1.01, False)):
        expected = replace(budget, error=(part * allowed) ** 2 * budget.light)
        assert predict.promise_kept([factor], expected, tolerance, points) == kept


@pytest.mark.parametrize(
    ("lit", "share"), [((1, 1), 0.5), ((2, 2), 0.5), ((4, 4), 1 / np.sqrt(2.5))]
)
def test_more_room_is_left_where_light_is_on_few_nodes(lit: tuple[int, int], share: float) -> None:
    random = np.random.default_rng(0)
    places = random.uniform((-3e-4, -3e-4, 0.1497), (3e-4, 3e-4, 0.1503), (60, 3))
    cloud = PointCloud(places, np.ones(60), np.zeros(60))
    plane = curved.plane_of(PANEL, WAVELENGTH, Window.full(PANEL), UNLIMITED)
    factor, _ = curved.make_factor(cloud, plane, 1e-3)
    dark = np.zeros_like(factor.real)
    some = dark.copy()
    some[5 : 5 + lit[0], 6 : 6 + lit[1]] = 1
    corner = replace(factor, real=some, imag=dark)
    assert predict.error_allowed([corner], 1e-3, 600) == pytest.approx(share * 1e-3)
    # Two such clusters are twice as many draws.
    both = predict.error_allowed([corner, corner], 1e-3, 600)
    n = max(1, 2 * lit[0] * lit[1] / 4)
    assert both == pytest.approx(1e-3 * min(0.65, 1 / np.sqrt(1 + 3 / np.sqrt(n))))


def test_the_points_that_are_tried_stand_for_all_of_the_light() -> None:
    random = np.random.default_rng(1)
    positions = random.uniform(1.0, 2.0, (400, 3))
    strength = random.uniform(0.1, 1.0, 400)
    strength[::9] = 0
    chosen, weight = predict.sample_points(strength, positions)
    assert len(chosen) == len(set(chosen.tolist())) == len(weight) <= 32
    assert weight.sum() == pytest.approx(strength.sum())
    aside = np.abs(positions - (positions.min(axis=0) + positions.max(axis=0)) / 2)
    for rank in (strength, aside[:, 0], aside[:, 1]):
        farthest = np.argsort(rank)[-4:]
        assert set(farthest) <= set(chosen)
    # These stand for themselves, the others for all others.
    own = strength[chosen]
    special = np.isclose(weight, own) & (own > 0)
    assert 4 <= special.sum() <= 12
    assert np.ptp(weight[~special & (own > 0)] / own[~special & (own > 0)]) < 1e-9
    assert len(predict.sample_points(strength[:33], positions[:33])[0]) <= 32
    few = predict.sample_points(strength[:32], positions[:32])
    assert np.array_equal(few[0], np.arange(32)) and np.array_equal(few[1], strength[:32])


def test_phases_that_are_alike_are_one_draw() -> None:
    random = np.random.default_rng(3)
    places, amplitude = random.random((5000, 3)) + 1, random.uniform(0.2, 1, 5000)
    alike = PointCloud(places, amplitude, np.full(5000, 2.0))
    assert predict.draws_of(alike) == 1
    mixed = PointCloud(places, amplitude, random.uniform(0, 6.3, 5000))
    assert 400 < predict.draws_of(mixed) <= 5000
    # Of a point and its opposite the sum says nothing.
    pair = PointCloud(places[:2], np.ones(2), np.array([0.0, np.pi]))
    assert predict.draws_of(pair) == 2
    assert predict.draws_of(alike.select(slice(0))) == 0


@pytest.mark.parametrize(
    ("phase", "count", "drawn"), [(0.0, 20_000, 50), (0.0, 100_000, 32), (6.3, 20_000, 8)]
)
def test_lattices_of_one_phase_are_looked_at_on_more_pixels(
    phase: float, count: int, drawn: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    random = np.random.default_rng(0)
    places = random.uniform((-3e-4, -3e-4, 0.1497), (3e-4, 3e-4, 0.1503), (count, 3))
    cloud = PointCloud(places, np.ones(count), random.uniform(0, 1, count) * phase)
    plane = curved.plane_of(PANEL, WAVELENGTH, Window.full(PANEL), UNLIMITED)
    factor, _ = curved.make_factor(cloud, plane, 1e-3)
    pixels: list[int] = []
    whole = verify.field_at
    monkeypatch.setattr(
        verify, "field_at", lambda *given: (pixels.append(len(given[1])), whole(*given))[1]
    )
    verify.measured_error([factor], cloud, plane, 2e-3, 1e-3)
    assert sum(pixels) == drawn


def test_what_was_wrong_once_is_not_expected_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """Errors of a lattice are not those of unrelated points; then more pixels are looked at."""
    random = np.random.default_rng(0)
    places = random.uniform((-3e-4, -3e-4, 0.1497), (3e-4, 3e-4, 0.1503), (6000, 3))
    cloud = PointCloud(places, np.ones(6000), random.uniform(0, 2 * np.pi, 6000))
    expected: list[float] = []

    def wrong_at_first(*given):  # type: ignore[no-untyped-def]
        expected.append(given[4])
        error, rounding = verify.look(*given)
        return 2e-3 if len(expected) == 1 else error, rounding

    monkeypatch.setattr(curved, "look", wrong_at_first)
    low = curved.low_rank(cloud, PANEL, WAVELENGTH, Window.full(PANEL), UNLIMITED, tolerance=1e-3)
    assert expected[0] > 0 and expected[1:] == [0.0] and low.error_predicted < 1e-3
