"""How many clusters and nodes a hologram takes: as many as the fits of the nodes' density say."""

from dataclasses import replace

import numpy as np
import pytest

import chrmc
from chrmc.cgh import curved
from chrmc.cgh.curved import clusters
from chrmc.cgh.curved.baseband import cluster_axes
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
CASES = [
    # cloud, panel, encoding, tolerance; clusters; nodes of the first one's runs, and blocks, along
    # x and along y
    (FEW, SMALL, "ssb", 1e-3, 1, ([94], 4), ([15, 51, 10], 5)),
    (CAR, LC_R_1080, "ssb", 1e-3,
     2, ([82, 363, 50], 23), ([128, 142, 68], 20)),
    (CAR, LC_R_1080, "ssb", 1e-5,
     2, ([137, 384, 80], 28), ([315, 154, 161], 39)),
    (PAIR, LC_R_1080, "real", 1e-4,
     6, ([148, 78], 11), ([195, 20], 12)),
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
    axes = cluster_axes(parts[0], reference, curved.lines_of(slm, window), plane, tolerance)
    for axis, (nodes, blocks) in zip(axes, (along_x, along_y), strict=True):
        assert [run.nodes.stop - run.nodes.start for run in axis.runs] == pytest.approx(
            nodes, abs=1
        )
        assert len(axis.blocks) == blocks
