"""Sub-clusters of wide, tall and deep bodies, and nodes that hold the small terms."""

import numpy as np
import pytest

from chrmc import LC_R_1080, SLM, WAVELENGTH, PointCloud
from chrmc.bench import extremes
from chrmc.cgh import curved
from chrmc.cgh.curved import baseband, clusters
from chrmc.cgh.curved.axes import cluster_axes
from chrmc.cgh.curved.clusters import Grid, bounding_box, reference_of
from chrmc.cgh.curved.series import make_series
from chrmc.cgh.curved.wave import by_curvature
from chrmc.encoding import coding_for
from chrmc.window import Window


def plane_for(slm: SLM, encoding: str) -> clusters.Plane:
    return curved.plane_of(slm, WAVELENGTH, Window.full(slm), coding_for(encoding, slm).passband)


@pytest.mark.parametrize("seed", [70014516, 70006735])
def test_terms_steeper_than_the_wave_are_not_read_off_nodes_made_for_it(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They were 24 times the tolerance off, in the first rows."""
    case = extremes.case_of(seed)
    cloud = extremes.cloud_of(case)
    plane = curved.plane_of(
        case.slm, case.wavelength, Window.full(case.slm), extremes.passband_of(case)
    )
    reference = reference_of(bounding_box(cloud.positions), plane)
    axes = cluster_axes(cloud, reference, plane, case.tolerance)
    given = cloud, axes, reference, plane, case.tolerance
    real, imag, missed = baseband.sum_points(*given, leaf=True)
    monkeypatch.setattr(clusters, "coarse_pays", lambda *_: False)
    whole_real, whole_imag, whole = baseband.sum_points(*given, leaf=True)
    assert whole.relative == 0.0
    apart = np.hypot(real - whole_real, imag - whole_imag)
    light = np.hypot(whole_real, whole_imag)
    assert np.linalg.norm(apart) <= 0.5 * case.tolerance * np.linalg.norm(light)
    assert missed.relative <= 0.3 * case.tolerance


@pytest.mark.parametrize(
    ("size", "depth", "least"),
    [
        ((2e-2, 2e-2, 2e-3), 0.1, (8, 4, 1)),  # footprints of 3 mm, a sixth of the body
        ((2e-3, 4e-2, 2e-3), 0.1, (1, 16, 1)),
        ((4e-2, 1e-3, 2e-3), 0.1, (16, 1, 1)),
        ((3e-3, 3e-3, 0.3), 0.3, (1, 1, 4)),
    ],
)
def test_a_body_is_cut_where_it_is_long(size: tuple[float, ...], depth: float, least: Grid) -> None:
    box = np.array([[-s / 2, s / 2] for s in size]) + np.array([[0], [0], [depth]])
    grid = clusters.leaf_grid(box, 50_000, (1500, 1000), plane_for(LC_R_1080, "ssb"), 1e-3)
    assert all(found >= wanted for found, wanted in zip(grid, least, strict=True))
    few = clusters.leaf_grid(box, 150, (1500, 1000), plane_for(LC_R_1080, "ssb"), 1e-3)
    assert few == (1, 1, 1)


def test_sums_in_sub_clusters_of_depth_too_are_the_same() -> None:
    slm = SLM("small", 300, 200, 8e-6)
    random = np.random.default_rng(5)
    places = (random.random((3000, 3)) - 0.5) * (2e-3, 1.5e-3, 0.1) + (5e-4, 0, 0.15)
    cloud = PointCloud(places, np.ones(3000), random.uniform(0, 6.3, 3000))
    plane = plane_for(slm, "real")
    box = bounding_box(places)
    reference = reference_of(box, plane)
    axes = cluster_axes(cloud, reference, plane, 1e-4)
    parts = clusters.leaves(cloud, box, (2, 3, 4))
    assert len(parts) == 24 and sum(map(len, parts)) == 3000
    # By equal steps of 1/z.
    assert np.ptp([np.ptp(1 / part.positions[:, 2]) for part in parts]) < 0.2
    apart = baseband._from_leaves(parts, axes, reference, plane, 1e-4, 100)
    whole = baseband.sum_points(cloud, axes, reference, plane, 1e-6, leaf=True)
    light = np.linalg.norm(whole[0] + 1j * whole[1])
    error = np.linalg.norm(apart[0] - whole[0] + 1j * (apart[1] - whole[1]))
    assert error <= 1e-4 * light


def test_points_of_each_cell_are_found_again() -> None:
    random = np.random.default_rng(1)
    places = random.uniform(0.1, 0.2, (500, 3))
    cloud = PointCloud(places, np.ones(500), np.zeros(500))
    box, grid = bounding_box(places), (3, 1, 4)
    parts = clusters.leaves(cloud, box, grid)
    cells = clusters.cells(places, box, grid)
    assert sorted(set(cells.tolist())) == list(range(12))
    for number, part in enumerate(parts):
        assert np.array_equal(part.positions, places[cells == number])
    assert not clusters.cells(places, box, (1, 1, 1)).any()


@pytest.mark.parametrize(
    "seed",
    [
        5511437,  # two tall clusters near a panel
        70011139,  # 44,538 points that all but cancel on one pixel
        71000323,  # one point's footprint ends in the middle of another's edge
        4520038,  # a lattice of one phase on 8192 x 8192 pixels
        71000471,  # a lattice of one phase, whose error is largest at the panel's corners
        4411438,  # nearly all of the error in a corner of the panel
        pytest.param(6940338, marks=pytest.mark.long),  # a corner's series is longer than others
        71001455,  # edges a thousand times as wide as the panel
    ],
)
def test_seeds_that_broke_a_promise(seed: int) -> None:
    out = extremes.run(extremes.case_of(seed))
    assert not out.fault
    assert out.cpu < 15


def test_a_panel_of_one_column_has_a_length_of_nothing() -> None:
    box = np.array([[-1e-3, 1e-3], [-1e-3, 1e-3], [0.2, 0.21]])
    plane = plane_for(SLM("column", 1, 700, 8e-6), "real")
    assert clusters.leaf_grid(box, 90_000, (1, 60), plane, 1e-3)[0] == 1


def test_a_series_is_not_read_where_its_polynomials_run_away() -> None:
    box = np.array([[-1e-3, 1e-3], [-1e-3, 1e-3], [0.1, 0.11]])
    curvatures = np.sort(by_curvature(box.T).T, axis=1)
    plane = plane_for(LC_R_1080, "ssb")
    kernel = reference_of(box, plane).kernel(WAVELENGTH)
    series = make_series((-8e-3, 8e-3), (-4e-3, 4e-3), curvatures, kernel, 1e-3)
    assert series is not None
    inside, past = np.linspace(-8e-3, 8e-3, 9), np.linspace(-16e-3, 16e-3, 9)
    assert series.holds_at(inside, inside / 2) and not series.holds_at(past, inside / 2)
    near = series.on_nodes(inside * 1.001, inside / 2, np.float64)
    assert np.abs(near.to_x).max() < 1e3


@pytest.mark.parametrize(("depth", "times"), [(0.06, 3.0), (0.3, 1.2)])
def test_what_nodes_of_sub_clusters_miss_is_tried(depth: float, times: float) -> None:
    """The footprints of a near lattice end together, a few pixels into a sub-cluster's nodes."""
    slm, wavelength = SLM("tall", 1049, 2193, 5.7e-6), 635e-9
    steps = np.stack(np.meshgrid(*[np.arange(24) / 23 - 0.5] * 3, indexing="ij"), axis=-1)
    places = steps.reshape(-1, 3) * (7.2e-3, 11.9e-3, 2e-4) + (-9e-4, -4e-4, depth)
    random = np.random.default_rng(0)
    cloud = PointCloud(places, np.ones(len(places)), random.uniform(0, 2 * np.pi, len(places)))
    passband = coding_for("ssb", slm).passband
    plane = curved.plane_of(slm, wavelength, Window.full(slm), passband)
    reference = reference_of(bounding_box(places), plane)
    axes = cluster_axes(cloud, reference, plane, 1e-2)
    _, _, missed = baseband.sum_points(cloud, axes, reference, plane, 1e-2)
    made_for = baseband.NODE_SHARE * baseband.LEAF_SHARE * 1e-2
    assert missed.series is None
    assert times * made_for < missed.relative < 1.5 * times * made_for
