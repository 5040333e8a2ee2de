"""Few points in place of very many: the same light, and work that says so."""

from dataclasses import replace

import numpy as np
import pytest

from chrmc import LC_R_1080, SLM, WAVELENGTH, PointCloud
from chrmc.cgh import curved
from chrmc.cgh.counts import STATED
from chrmc.cgh.curved import condense
from chrmc.cgh.curved.axes import cluster_axes
from chrmc.cgh.curved.clusters import Plane, bounding_box, reference_of
from chrmc.cgh.curved.condense import Condensing, condensed, condensing_of
from chrmc.cgh.curved.direct import field_at
from chrmc.encoding import coding_for
from chrmc.optics.passband import UNLIMITED
from chrmc.window import Window

SMALL = SLM("small", 600, 400, 12e-6)
Three = tuple[float, float, float]


def cloud_in(size: Three, place: Three, count: int = 30_000) -> PointCloud:
    random = np.random.default_rng(count)
    return PointCloud(
        (random.random((count, 3)) - 0.5) * size + place,
        random.uniform(0.2, 1, count),
        random.uniform(0, 6.3, count),
    )


def plane_for(slm: SLM, encoding: str, points: int) -> Plane:
    band = UNLIMITED if encoding == "unlimited" else coding_for(encoding, slm).passband
    plane = curved.plane_of(slm, WAVELENGTH, Window.full(slm), band)
    return replace(plane, points=points)


def way_of(cloud: PointCloud, plane: Plane, tolerance: float) -> Condensing | None:
    box = bounding_box(cloud.positions)
    axes = cluster_axes(cloud, reference_of(box, plane), plane, tolerance)
    return condensing_of(box, len(cloud), axes, plane, tolerance)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4, 1e-5, 1e-6])
@pytest.mark.parametrize(
    ("size", "place", "encoding"),
    [
        ((2e-9, 2e-9, 2e-9), (0, 0, 0.25), "ssb"),
        ((0, 0, 0), (1e-3, 0, 0.1), "real"),
        ((2e-5, 2e-5, 1e-4), (1e-3, 2e-3, 0.25), "ssb"),
        ((3e-4, 1e-6, 1e-5), (1e-3, -2e-3, 0.12), "ssb"),
        ((1e-4, 0, 1e-5), (0, -2.2e-3, 0.05), "real"),
        ((1e-5, 3e-5, 1e-5), (5e-3, 2e-3, 0.08), "unlimited"),
    ],
)
def test_few_points_give_the_light_of_all(
    size: Three, place: Three, encoding: str, tolerance: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(condense, "_WORTH", 100.0)  # even where few nodes are as quick
    cloud, plane = cloud_in(size, place), plane_for(SMALL, encoding, 30_000)
    way = way_of(cloud, plane, tolerance)
    assert way is not None and way.count < len(cloud)
    few = condensed(cloud, way)
    assert len(few) <= way.count
    random = np.random.default_rng(1)
    x, y = (random.choice(line.places, 200) for line in plane.lines)
    truth = field_at(cloud, x, y, WAVELENGTH, plane.reach)
    made = field_at(few, x, y, WAVELENGTH, plane.reach)
    # The share that is given to it, with what 200 pixels may say too much.
    assert np.linalg.norm(made - truth) < 0.15 * tolerance * np.linalg.norm(truth)


def test_points_far_apart_stay_as_they_are() -> None:
    plane = plane_for(LC_R_1080, "ssb", 30_000)
    assert way_of(cloud_in((4e-3, 3e-3, 1e-3), (0, 0, 0.25)), plane, 1e-3) is None
    # Nor are footprints condensed whose faded ends are all that is seen.
    assert way_of(cloud_in((1e-5, 1e-5, 1e-6), (0, 8.9e-3, 0.25)), plane, 1e-3) is None


@pytest.mark.timeout(20)
def test_points_a_kilometre_apart_are_soon_left_as_they_are() -> None:
    """Boxes of a billion nodes are not counted one by one."""
    plane = plane_for(SMALL, "unlimited", 30_000)
    assert way_of(cloud_in((1e3, 1e3, 1e2), (0, 0, 97.0)), plane, 1e-2) is None


@pytest.mark.parametrize("size", [(2e-9, 2e-9, 2e-9), (3e-4, 1e-6, 1e-5)])
def test_many_points_close_together_are_little_work(size: Three) -> None:
    cloud = cloud_in(size, (0, 0, 0.25), 200_000)
    given = WAVELENGTH, Window.full(LC_R_1080), coding_for("ssb", LC_R_1080).passband
    counted = curved.cost(cloud, LC_R_1080, *given, tolerance=1e-6)
    thousand = curved.cost(cloud.select(slice(1000)), LC_R_1080, *given, tolerance=1e-6)
    assert STATED.seconds(counted) < 10 * STATED.seconds(thousand)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
def test_the_hologram_of_very_many_keeps_its_tolerance(tolerance: float) -> None:
    cloud = cloud_in((2e-4, 1e-5, 1e-5), (5e-4, 0, 0.1), 60_000)
    band = coding_for("ssb", SMALL).passband
    window = Window.full(SMALL)
    field = curved.field(cloud, SMALL, WAVELENGTH, window, band, tolerance=tolerance)
    again = curved.field(cloud, SMALL, WAVELENGTH, window, band, tolerance=tolerance)
    assert np.array_equal(field, again)
    random = np.random.default_rng(2)
    rows, columns = random.integers(0, 400, 150), random.integers(0, 600, 150)
    plane = plane_for(SMALL, "ssb", len(cloud))
    places = plane.x.places[columns], plane.y.places[rows]
    truth = field_at(cloud, *places, WAVELENGTH, plane.reach)
    missed = np.linalg.norm(field[rows, columns] - truth)
    assert missed < tolerance * np.linalg.norm(truth)
