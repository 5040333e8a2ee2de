"""Basebands by non-uniform Fourier transforms against sums point by point."""

import numpy as np
import pytest

from chrmc import LC_R_1080, SLM, WAVELENGTH, PointCloud, compute_field
from chrmc.cgh.curved import clusters, nonuniform, plane_of
from chrmc.cgh.curved.axes import cluster_axes
from chrmc.cgh.curved.nonuniform import nonuniform_baseband
from chrmc.cgh.curved.tables import exact_baseband
from chrmc.cgh.curved.wave import Wave
from chrmc.encoding import coding_for
from chrmc.optics.passband import UNLIMITED
from chrmc.reference import reference_field, relative_error
from chrmc.window import Window


def cloud(size: tuple[float, float, float], place: tuple[float, float, float]) -> PointCloud:
    random = np.random.default_rng(5)
    positions = (random.random((100, 3)) - 0.5) * size + place
    return PointCloud(positions, random.uniform(0.2, 1, 100), random.uniform(0, 6.3, 100))


def missed(points: PointCloud, slm: SLM, tolerance: float) -> tuple[float, float] | None:
    """Error at the nodes over the rms there, and what was expected."""
    window, coding = Window.full(slm), coding_for("ssb", slm)
    plane = plane_of(slm, WAVELENGTH, window, coding.passband)
    its = clusters.reference_of(clusters.bounding_box(points.positions), plane)
    axes = cluster_axes(points, its, plane, tolerance)
    made = nonuniform_baseband(points, axes, its, plane, tolerance)
    if made is None:
        return None
    again = nonuniform_baseband(points, axes, its, plane, tolerance)
    assert again is not None and again[0].tobytes() == made[0].tobytes()
    real, imag = exact_baseband(points, *axes, Wave(its, WAVELENGTH, plane.reach))
    weights = []
    for axis in axes:
        weight = np.zeros(len(axis.nodes))
        for run in axis.runs:
            weight[run.nodes] = run.weight
        weights.append(weight)
    total = weights[1] @ (real.astype(float) ** 2 + imag**2) @ weights[0]
    error = weights[1] @ ((made[0] - real) ** 2 + (made[1] - imag) ** 2) @ weights[0]
    return float(np.sqrt(error / total)), made[2].relative


@pytest.mark.parametrize(
    ("size", "place"),
    [
        ((1.6e-3, 6e-4, 7e-4), (1.9e-3, 1.1e-3, 0.252)),
        ((1.6e-3, 6e-4, 7e-4), (-6e-3, -3.9e-3, 0.252)),  # at the rim: two edges at once
        ((1.6e-3, 6e-4, 0.0), (0.0, 0.0, 0.252)),
        ((8e-4, 8e-4, 3e-3), (0.0, 0.0, 0.3)),  # deep: slices
        ((2e-3, 2e-3, 2e-3), (0.0, 0.0, 1.0)),  # no edge on the panel
    ],
)
@pytest.mark.parametrize("tolerance", [1e-2, 1e-3])
def test_the_baseband_is_that_of_the_sum(
    size: tuple[float, float, float],
    place: tuple[float, float, float],
    tolerance: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(nonuniform, "_SLICE", 20)
    found = missed(cloud(size, place), LC_R_1080, tolerance)
    assert found is not None
    error, expected = found
    assert error <= tolerance and error <= 2 * expected and expected <= 0.75 * tolerance


def test_without_edges_it_is_as_exact_as_asked() -> None:
    points = cloud((2e-3, 2e-3, 2e-3), (0.0, 0.0, 1.0))
    for tolerance in (1e-4, 1e-5):
        found = missed(points, LC_R_1080, tolerance)
        assert found is not None and found[0] <= 0.6 * tolerance


def test_edges_that_no_filter_is_good_enough_for_are_left_to_the_points() -> None:
    assert missed(cloud((1.6e-3, 6e-4, 7e-4), (0.0, 1.1e-3, 0.252)), LC_R_1080, 1e-5) is None


def test_many_points_that_graze_the_panel_are_not_transformed() -> None:
    """Their grid of directions would go past the horizon."""
    random = np.random.default_rng(2)
    slm, count = SLM("fine", 40, 60, 1e-6), 30_000
    points = PointCloud(
        (random.random((count, 3)) - 0.5) * 1e-6 + (0.0, 0.02, 0.006),
        np.ones(count), random.uniform(0, 6.3, count),
    )  # fmt: skip
    wavelength, tolerance = 8e-6, 1e-3
    assert count >= nonuniform.MANY_POINTS
    with np.errstate(all="raise", under="ignore"):
        made = compute_field(
            points, slm, wavelength, "curved", passband=UNLIMITED, tolerance=tolerance
        )
    truth = reference_field(points, slm, wavelength, passband=UNLIMITED)
    assert relative_error(made, truth) < tolerance
