"""Even nodes with least-squares interpolation: as exact as asked for, with few nodes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from chrmc.cgh.curved import band
from chrmc.cgh.curved.band import Grid
from chrmc.cgh.curved.chebyshev import node_count

TOLERANCES = [5e-2, 5e-3, 5e-4, 5e-5, 5e-6, 5e-7]


def missed_waves(grid: Grid, targets: int, nyquist: float, tolerance: float) -> np.ndarray:
    """rms error over the targets, for frequencies from 0 to the band's end."""
    frequencies = np.linspace(0, nyquist / 2, 25)[:, None]
    per = grid.spacings / grid.targets
    power = np.zeros(25)
    for number in range(grid.blocks):
        start = number * grid.targets
        count = min(grid.targets, targets - start)
        matrix = band.band_matrix(grid, count, nyquist, tolerance)
        assert matrix.shape == (count, grid.nodes(grid.targets))
        t = start + np.arange(count) + 0.5
        first = 0.5 - grid.margin - grid.before(count)
        x = start + (first + np.arange(matrix.shape[1])) / per
        exact = np.exp(2j * np.pi * frequencies * t)
        power += np.sum(np.abs(exact - np.exp(2j * np.pi * frequencies * x) @ matrix.T) ** 2, 1)
    return np.sqrt(power / targets)


@given(st.integers(100, 3000), st.floats(0.1, 0.7), st.sampled_from(TOLERANCES))
@settings(max_examples=60, deadline=None)
def test_a_short_last_block_is_read_as_well_as_the_others(
    targets: int, nyquist: float, tolerance: float
) -> None:
    grid = band.band_grid(targets, nyquist, tolerance, 15)
    if grid is None or grid.blocks == 1:
        return
    last = targets - (grid.blocks - 1) * grid.targets
    matrix = band.band_matrix(grid, last, nyquist, tolerance)
    per = grid.spacings / grid.targets
    waves = 2j * np.pi * np.linspace(0.02, 0.98, 13)[:, None] * nyquist / 2
    first = 0.5 - grid.margin - (matrix.shape[1] - grid.nodes(last))
    read = np.exp(waves * (first + np.arange(matrix.shape[1])) / per) @ matrix.T
    missed = np.abs(read - np.exp(waves * (np.arange(last) + 0.5)))
    assert np.sqrt(np.mean(missed**2)) < 3 * tolerance


@given(
    st.integers(20, 2000), st.floats(1e-3, 0.8), st.floats(0.01, 500), st.sampled_from(TOLERANCES)
)
@settings(max_examples=60, deadline=None)
def test_waves_are_read_as_well_where_footprints_end_slowly(
    targets: int, nyquist: float, wide: float, tolerance: float
) -> None:
    """Of edges a hundred times as wide as their run they were missed by up to 1000 times that."""
    width = max(5.0, wide * targets)
    grid = band.edge_grid(targets, nyquist, width, 2.0 * targets, tolerance, 60)
    if grid is None:
        return
    matrix = band.edge_matrix(grid, grid.targets, nyquist, width, tolerance)
    per = grid.spacings / grid.targets
    waves = 2j * np.pi * np.linspace(0.02, 0.98, 13)[:, None] * nyquist / 2
    read = np.exp(waves * (0.5 - grid.margin + np.arange(matrix.shape[1])) / per) @ matrix.T
    missed = np.abs(read - np.exp(waves * (np.arange(grid.targets) + 0.5)))
    assert np.sqrt(np.mean(missed**2)) < 2 * tolerance


@pytest.mark.parametrize("tolerance", TOLERANCES)
@pytest.mark.parametrize(("targets", "waves"), [(1920, 58), (1050, 34), (1920, 200), (300, 3)])
def test_waves_of_the_band_are_read_off_few_nodes(
    targets: int, waves: float, tolerance: float
) -> None:
    nyquist = 2 * waves / targets
    grid = band.band_grid(targets, nyquist, tolerance, 15)
    assert grid is not None
    missed = missed_waves(grid, targets, nyquist, tolerance)
    # One node more or less changes the error three to five times.
    assert np.sqrt(np.mean(missed**2)) < 2.5 * tolerance
    assert missed.max() < 4 * tolerance
    if waves > 10:
        assert grid.count(targets) < 0.9 * node_count(np.pi * waves, tolerance)


@given(st.integers(20, 400), st.floats(0.01, 60), st.sampled_from(TOLERANCES))
@settings(max_examples=60, deadline=None)
def test_any_run_is_read_as_asked_or_pixel_by_pixel(
    targets: int, waves: float, tolerance: float
) -> None:
    nyquist = 2 * waves / targets
    grid = band.band_grid(targets, nyquist, tolerance, 15)
    if grid is not None:
        assert grid.count(targets) < targets
        assert missed_waves(grid, targets, nyquist, tolerance).max() < 6 * tolerance


def test_variogram_is_that_of_the_edge() -> None:
    def edge(s: float) -> float:
        return float(np.cos(np.pi / 2 * np.clip(s, 0, 1)) ** 2)

    for lag in (1e-3, 0.1, 0.4, 0.99, 1.7):
        exact, _ = quad(
            lambda s, lag=lag: (edge(s) - edge(s + lag)) ** 2 / 2, -2, 2,
            points=[-lag, 0, 1 - lag, 1], limit=200,
        )  # fmt: skip
        assert band.variogram(np.array([lag, -lag])) == pytest.approx([exact, exact], rel=1e-7)


@pytest.mark.parametrize("tolerance", TOLERANCES)
@pytest.mark.parametrize(
    ("targets", "nyquist"), [(184, 0.05), (73, 0.05), (300, 0.06), (200, 0.2), (300, 0.37)]
)
def test_soft_edges_are_resolved_wherever_they_fall(
    targets: int, nyquist: float, tolerance: float
) -> None:
    width, lit = 51.0, 1000.0
    grid = band.edge_grid(targets, nyquist, width, lit, tolerance, 15)
    if grid is None:  # no fewer nodes than pixels
        assert tolerance < 1e-5
        return
    starts = np.linspace(0, targets - width, 40)[:, None]
    frequencies = np.linspace(-nyquist / 2, nyquist / 2, 9)[:, None, None]

    def waves(t: np.ndarray) -> np.ndarray:
        edge = np.cos(np.pi / 2 * np.clip((t - starts) / width, 0, 1)) ** 2
        return np.asarray(edge * np.exp(2j * np.pi * frequencies * t))

    power = 0.0
    for number in range(grid.blocks):
        start = number * grid.targets
        count = min(grid.targets, targets - start)
        matrix = band.edge_matrix(grid, count, nyquist, width, tolerance)
        first = 0.5 - grid.margin - grid.before(count)
        x = start + (first + np.arange(matrix.shape[1])) * grid.targets / grid.spacings
        t = start + np.arange(count) + 0.5
        power += float(np.sum(np.abs(waves(t) - waves(x) @ matrix.T) ** 2))
    missed = np.sqrt(power / (40 * 9) / lit)
    assert missed < tolerance
    if nyquist < 0.1 and tolerance < 1e-3:  # and not much better than asked for
        assert missed > 0.1 * tolerance


def test_what_double_precision_cannot_tell_has_no_nodes() -> None:
    # More nodes were tried one by one, for minutes.
    assert band.band_grid(1689, 8.6 / 1689, 9.3e-10, 20.0) is None
    assert band.band_grid(1689, 8.6 / 1689, 9.3e-7, 20.0) is not None


@pytest.mark.parametrize("tolerance", [1e-7, 1e-9, 1e-12])
@pytest.mark.parametrize("nyquist", [1e-4, 1e-3, 1e-2])
def test_equations_past_double_precision_are_no_singular_ones(
    nyquist: float, tolerance: float
) -> None:
    for targets in (120, 500, 2000):
        grids = (
            band.band_grid(targets, nyquist, tolerance, 60.0),
            band.edge_grid(targets, nyquist, targets / 5, targets, tolerance, 60.0),
        )
        # Nodes that are fewer than pixels, or none: a matrix of theirs is finite.
        assert all(grid is None or grid.count(targets) < targets for grid in grids)
