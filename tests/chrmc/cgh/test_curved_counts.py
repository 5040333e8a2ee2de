"""How many clusters, nodes, terms and places a hologram takes: no more than the fits say.

The errors of all of them are tested elsewhere; here that they are reached with as little as before.
"""

from dataclasses import replace

import numpy as np
import pytest

import chrmc
from chrmc.cgh import curved
from chrmc.cgh.curved import clusters
from chrmc.cgh.curved.axes import cluster_axes
from chrmc.cgh.curved.band import Grid, band_grid, edge_grid
from chrmc.cgh.curved.baseband import series_for
from chrmc.cgh.curved.cost import cost_of, readable_by_a_part
from chrmc.cgh.curved.levels import levels_for
from chrmc.cgh.curved.nonuniform import readable, transforms_pay
from chrmc.cgh.curved.rays import rays_pay
from chrmc.cgh.curved.taps import taps_for
from chrmc.encoding import coding_for
from chrmc.slm import LC_R_1080, SLM, WAVELENGTH
from chrmc.window import Window

SMALL = SLM("small", 480, 300, 8.1e-6)
Box = tuple[int, tuple[float, float, float], tuple[float, float, float]]


def points(*boxes: Box) -> chrmc.PointCloud:
    """So many points in boxes of a size in a place, metres."""
    made = []
    for count, size, place in boxes:
        random = np.random.default_rng(1)
        positions = (random.random((count, 3)) - 0.5) * size + place
        made.append(chrmc.PointCloud(positions, np.ones(count), np.zeros(count)))
    return chrmc.PointCloud.concatenate(made)


FEW = points((6, (1e-3, 1e-3, 1e-3), (0, 0, 0.1)))
CAR = points((300, (6e-3, 3e-3, 4e-3), (2e-3, 1e-3, 0.25)))
PAIR = points(
    (900, (3e-3, 3e-3, 2e-3), (-5e-3, 0, 0.2)), (700, (2e-3, 3e-3, 2e-3), (5e-3, 1e-3, 0.3))
)
MANY = points((20_000, (8e-3, 5e-3, 4e-3), (0, 0, 0.25)))
DENSE = points((40_000, (2e-3, 1e-3, 1e-3), (0, 0, 0.2)))
DEEP = points((3000, (2e-3, 1e-3, 2e-2), (0, 0, 0.03)))
THICK = points((120_000, (2e-3, 1e-3, 1e-3), (0, 0, 0.25)))
ASIDE = points((300, (1e-3, 1e-3, 1e-3), (0.1, 0, 0.25)))
CASES = [
    # cloud, panel, encoding, tolerance; clusters; nodes of the first one's runs, and blocks, along
    # x and along y
    (FEW, SMALL, "ssb", 1e-3, 1, ([94], 4), ([15, 51, 10], 5)),
    (CAR, LC_R_1080, "ssb", 1e-3,
     2, ([82, 363, 50], 23), ([128, 142, 68], 20)),
    (CAR, LC_R_1080, "ssb", 1e-5,
     2, ([137, 384, 80], 28), ([315, 154, 161], 39)),
    (PAIR, LC_R_1080, "real", 1e-4,
     6, ([155, 78], 11), ([195, 20], 12)),
    (MANY, LC_R_1080, "ssb", 1e-3,
     1, ([359, 523, 360], 62), ([209, 123, 209], 33)),
    (DENSE, SMALL, "ssb", 1e-3,
     1, ([101], 5), ([38], 2)),
    (DEEP, SMALL, "real", 1e-3,
     1, ([480], 1), ([137, 27, 136], 3)),
]  # fmt: skip
Nodes = tuple[list[int], int]


@pytest.mark.parametrize(
    ("cloud", "slm", "encoding", "tolerance", "number", "along_x", "along_y"),
    CASES,
    ids=["few", "car", "car, tight", "pair", "many", "dense", "deep"],
)
def test_clusters_and_nodes_of_a_hologram(
    cloud: chrmc.PointCloud, slm: SLM, encoding: str, tolerance: float,
    number: int, along_x: Nodes, along_y: Nodes,
) -> None:  # fmt: skip
    window, passband = Window.full(slm), coding_for(encoding, slm).passband
    plane = replace(curved.plane_of(slm, WAVELENGTH, window, passband), points=len(cloud))
    parts = clusters.split(cloud, plane)
    assert len(parts) == number and sum(len(part) for part in parts) == len(cloud)
    reference = clusters.reference_of(clusters.bounding_box(parts[0].positions), plane)
    axes = cluster_axes(parts[0], reference, plane, tolerance)
    for axis, (nodes, blocks) in zip(axes, (along_x, along_y), strict=True):
        assert [run.nodes.stop - run.nodes.start for run in axis.runs] == pytest.approx(
            nodes, abs=1
        )
        assert len(axis.blocks) == blocks


@pytest.mark.parametrize(
    ("targets", "nyquist", "tolerance", "block", "grid"),
    [
        (1920, 58 / 1920, 5e-3, 20, Grid(4, 480, 18, 2)),
        (1920, 58 / 1920, 5e-4, 20, Grid(4, 480, 19, 3)),
        (1920, 58 / 1920, 5e-6, 20, Grid(4, 480, 21, 5)),
        (300, 3 / 300, 1e-3, 20, Grid(1, 300, 7, 1)),
        (1200, 200 / 1200, 1e-4, 15, Grid(17, 71, 16, 4)),
        (100, 0.95, 1e-3, 20, None),
    ],
)
def test_even_nodes_of_a_band(
    targets: int, nyquist: float, tolerance: float, block: float, grid: Grid | None
) -> None:
    assert band_grid(targets, nyquist, tolerance, block) == grid


@pytest.mark.parametrize(
    ("targets", "nyquist", "width", "lit", "tolerance", "block", "grid"),
    [
        (184, 0.05, 150, 300, 1e-3, 20, Grid(1, 184, 16, 2)),
        (184, 0.05, 150, 300, 1e-5, 20, Grid(3, 62, 18, 2)),
        (600, 0.3, 60, 900, 1e-3, 15, Grid(16, 38, 16, 3)),
        (60, 0.9, 30, 60, 1e-4, 15, None),
    ],
)
def test_even_nodes_where_footprints_end(
    targets: int, nyquist: float, width: float, lit: float, tolerance: float, block: float,
    grid: Grid | None,
) -> None:  # fmt: skip
    assert edge_grid(targets, nyquist, width, lit, tolerance, block) == grid


@pytest.mark.parametrize(
    ("tolerance", "count", "oversampling"),
    [(1e-2, 6, 1.6444), (2e-3, 8, 1.6724), (2e-4, 10, 1.7957), (2e-6, 14, 1.9599)],
)
def test_neighbours_and_density_of_taps(tolerance: float, count: int, oversampling: float) -> None:
    taps = taps_for(tolerance)
    assert taps.count == count and taps.table.shape == (1025, count)
    assert taps.oversampling == pytest.approx(oversampling, rel=2e-3)
    assert taps.step(500.0) == pytest.approx(1 / (1000 * oversampling), rel=2e-3)


@pytest.mark.parametrize(
    ("cloud", "slm", "encoding", "tolerance", "grid", "sums", "terms", "samples", "levels"),
    [
        (CAR, LC_R_1080, "ssb", 1e-3, (1, 1, 1), 5.383e8, 9, (8, 8), [0]),
        (CAR, LC_R_1080, "ssb", 1e-5, (1, 1, 1), 1.536e9, 22, (10, 11), [0, 1, 5]),
        (MANY, LC_R_1080, "ssb", 1e-3, (8, 2, 1), 2.783e10, 14, (8, 9), [0, 3, 8]),
        (MANY, LC_R_1080, "ssb", 1e-5, (8, 2, 1), 5.195e10, 38, (11, 11), [0, 3, 8, 15, 26]),
        (DEEP, SMALL, "real", 1e-3, (4, 1, 2), 1.2e10, 57, (23, 20), [0]),
    ],
    ids=["car", "car, tight", "many", "many, tight", "deep"],
)
def test_sub_clusters_terms_and_levels(
    cloud: chrmc.PointCloud, slm: SLM, encoding: str, tolerance: float, grid: clusters.Grid,
    sums: float, terms: int, samples: tuple[int, int], levels: list[int],
) -> None:  # fmt: skip
    window, passband = Window.full(slm), coding_for(encoding, slm).passband
    plane = replace(curved.plane_of(slm, WAVELENGTH, window, passband), points=len(cloud))
    part = max(clusters.split(cloud, plane), key=len)
    box = clusters.bounding_box(part.positions)
    reference = clusters.reference_of(box, plane)
    axes = cluster_axes(part, reference, plane, tolerance)
    nodes = len(axes[0].nodes), len(axes[1].nodes)
    assert clusters.leaf_grid(box, len(part), nodes, plane, tolerance) == grid
    assert clusters.cost_of_sums(box, len(part), nodes, plane, tolerance) == pytest.approx(
        sums, rel=2e-2
    )
    series = series_for(part, axes, reference, plane, tolerance)
    assert series is not None
    assert (series.terms, series.values.shape[1:]) == (terms, samples)
    found, missed = levels_for(part, axes, reference, plane, tolerance, series)
    assert [level.terms.start for level in found] == levels
    # Each level beyond the first may miss 0.3 of the tolerance.
    assert missed <= 0.3001 * tolerance * len(levels) ** 0.5
    sizes = [len(level.axis_x.nodes) * len(level.axis_y.nodes) for level in found]
    assert sizes == sorted(sizes, reverse=True)


@pytest.mark.parametrize(("tolerance", "read"), [(1e-2, True), (1e-3, True), (1e-4, False)])
def test_a_part_of_an_edge_tells_whether_filters_will_do(tolerance: float, read: bool) -> None:
    cloud = points((2000, (2e-3, 1e-3, 1e-3), (0, 0, 0.25)))
    window = Window.full(LC_R_1080)
    plane = curved.plane_of(LC_R_1080, WAVELENGTH, window, coding_for("ssb", LC_R_1080).passband)
    reference = clusters.reference_of(clusters.bounding_box(cloud.positions), plane)
    axes = cluster_axes(cloud, reference, plane, tolerance)
    assert (readable(cloud, axes, reference, plane, tolerance) is not None) == read
    assert readable_by_a_part(cloud, axes, reference, plane, tolerance) == read


@pytest.mark.parametrize(
    ("count", "size", "pay"),
    [
        (20_000, (2e-3, 1e-3, 1e-3), False),  # few
        (100_000, (2e-3, 1e-3, 1e-3), True),
        (1_000_000, (2e-3, 1e-3, 1e-3), True),
        (100_000, (6e-3, 2e-3, 1.5e-2), False),  # a large grid, and a deep body's long series
        (1_000_000, (5e-3, 3e-3, 3e-3), False),  # a large grid for each of 24 slices
    ],
)
def test_transforms_pay_where_grids_are_small(
    count: int, size: tuple[float, float, float], pay: bool
) -> None:
    cloud = points((2000, size, (0, 0, 0.25)))
    window = Window.full(LC_R_1080)
    plane = curved.plane_of(LC_R_1080, WAVELENGTH, window, coding_for("ssb", LC_R_1080).passband)
    box = clusters.bounding_box(cloud.positions)
    reference = clusters.reference_of(box, plane)
    axes = cluster_axes(cloud, reference, plane, 1e-2)
    assert transforms_pay(count, box, axes, reference, plane, 1e-2) == pay


@pytest.mark.parametrize(
    ("cloud", "slm", "encoding", "tolerance", "products", "phasors", "moved", "calls", "memory"),
    [
        (FEW, SMALL, "ssb", 1e-3, 0, 6.912e6, 0, 200, 0),
        (CAR, LC_R_1080, "ssb", 1e-3, 2.362e9, 1.33e6, 2.074e9, 27_420, 2.767e7),
        (CAR, LC_R_1080, "ssb", 1e-5, 6.398e9, 4.849e6, 6.069e9, 41_384, 2.767e7),
        (PAIR, LC_R_1080, "real", 1e-4, 4.412e9, 3.81e6, 2.281e9, 65_780, 2.778e7),
        (MANY, LC_R_1080, "ssb", 1e-3, 3.552e10, 3.764e7, 4.631e9, 164_088, 2.925e7),
        (DEEP, SMALL, "real", 1e-3, 1.43e10, 1.408e7, 4.701e9, 76_016, 1.025e7),
        (THICK, LC_R_1080, "ssb", 1e-3, 2.015e8, 6.264e7, 2.48e7, 63_420, 3.725e7),
        (THICK, LC_R_1080, "ssb", 1e-5, 5.748e10, 3.769e8, 4.827e9, 340_528, 3.725e7),
        (ASIDE, LC_R_1080, "ssb", 1e-3, 0, 307_200, 1.843e7, 11_500, 2.767e7),
    ],
    ids=["few", "car", "car, tight", "pair", "many", "deep", "thick", "thick, tight", "aside"],
)
def test_what_a_hologram_is_foretold_to_take(
    cloud: chrmc.PointCloud, slm: SLM, encoding: str, tolerance: float,
    products: float, phasors: float, moved: float, calls: float, memory: float,
) -> None:  # fmt: skip
    """With the weights as they were measured; who changes one measures it anew."""
    window, passband = Window.full(slm), coding_for(encoding, slm).passband
    plane = curved.plane_of(slm, WAVELENGTH, window, passband)
    counts = cost_of(cloud, replace(plane, points=len(cloud)), tolerance)
    found = counts.products, counts.phasors, counts.bytes, counts.calls, counts.memory
    assert found == pytest.approx((products, phasors, moved, calls, memory), rel=5e-3)


@pytest.mark.parametrize(
    ("count", "depth", "tolerance", "pay"),
    [
        (1000, 0.02, 1e-3, True),
        (20_000, 0.02, 1e-3, False),  # sub-clusters take less of many
        (30, 0.08, 1e-6, True),
        (300, 0.08, 1e-3, False),  # the low-rank form takes less
        (30, 0.11, 1e-6, False),  # footprints cover a third of the panel
        (20_000, 0.02, 1e-6, False),  # less than by nodes, but more than 8 s
    ],
)
def test_rays_pay_where_footprints_are_small_and_nodes_many(
    count: int, depth: float, tolerance: float, pay: bool
) -> None:
    cloud = points((count, (8e-3, 4e-3, 1e-3), (0, 0, depth)))
    window, passband = Window.full(LC_R_1080), coding_for("real", LC_R_1080).passband
    plane = replace(curved.plane_of(LC_R_1080, WAVELENGTH, window, passband), points=count)
    assert rays_pay(cloud, LC_R_1080, WAVELENGTH, window, passband, plane, tolerance) == pay
