"""Nodes: how few there are, and what they tell."""

from itertools import product
from math import hypot, inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chrmc import SLM, WAVELENGTH, PointCloud
from chrmc.cgh import curved
from chrmc.cgh.curved.bandwidth import Extent, Needs
from chrmc.cgh.curved.nodes import Line, make_axis
from chrmc.optics.passband import UNLIMITED, full_band
from chrmc.reference import reference_field, relative_error
from chrmc.window import Window


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4, 1e-5, 1e-6])
def test_a_single_point_takes_few_nodes_that_tell_it(tolerance: float) -> None:
    """Its nodes span many times the panel, where the wave is less separable than on it."""
    slm = SLM("small", 320, 200, 8e-6)
    point = PointCloud(np.array([[0, 0, 0.12]]), np.ones(1), np.zeros(1))
    plane = curved.plane_of(slm, WAVELENGTH, Window.full(slm), full_band(slm))
    factor, budget = curved.make_factor(point, plane, tolerance)
    assert len(factor.axis_x.nodes) <= 16 and budget.relative < tolerance
    truth = reference_field(point, slm, WAVELENGTH)
    made = curved.field_of([factor], slm, WAVELENGTH, Window.full(slm))
    assert relative_error(made, truth) < tolerance


@settings(max_examples=60, deadline=None)
@given(
    tolerance=st.sampled_from([1e-2, 1e-3, 1e-4]),
    depth=st.floats(0.5, 4),
    middle=st.floats(-0.7, 0.7),
    size=st.floats(-3, -0.5),
    thickness=st.floats(-3, -0.7),
    across=st.floats(0.05, 0.5),
    waves=st.floats(0.3, 2),
)
def test_waves_whose_frequency_changes_are_told_everywhere(
    tolerance: float,
    depth: float,
    middle: float,
    size: float,
    thickness: float,
    across: float,
    waves: float,
) -> None:
    """From half a panel's width away to four: there a wave's frequency is no one number."""
    pitch, count = 1e-6, 1000
    width = pitch * count
    z, wavelength = depth * width, width * 10 ** (size - waves)
    centre, half = middle * width, width * 10**size / 2
    deep = z * 10**thickness / 2
    z_centre = hypot(z, 0.6 * across * width)
    extent = Extent(
        centre - half, centre + half, z - deep, z + deep, centre, z_centre, across * width, 0.0
    )
    line = Line(-width / 2, pitch, count)
    x, depths = np.array([extent.low, extent.high]), np.array([extent.z_low, extent.z_high])
    axis = make_axis(line, x, depths, Needs(extent, wavelength, inf, tolerance, width, 20.0))

    def wave(t: np.ndarray, x: float, z: float) -> np.ndarray:
        own = np.hypot(t - centre, z_centre) - z_centre
        return np.exp(2j * np.pi / wavelength * (np.hypot(t - x, z) - z - own))

    for corner in product(x, [*depths, *np.hypot(depths, across * width)]):
        nodes = wave(axis.nodes, *corner)
        told = np.concatenate(
            [nodes[b.nodes] if b.matrix is None else b.matrix @ nodes[b.nodes] for b in axis.blocks]
        )
        assert np.sqrt(np.mean(np.abs(told - wave(line.places, *corner)) ** 2)) < 3 * tolerance


@pytest.mark.parametrize("count", [150, 560])
@pytest.mark.parametrize("tolerance", [2.6e-7, 5e-7, 1e-6])
def test_values_in_single_precision_are_told_to_the_tightest_tolerances(
    tolerance: float, count: int
) -> None:
    """Along both axes at once: weights of 15 and more near a block's ends make much of rounding."""
    frequency, pitch, z = 0.2, 1.0, 1e3
    extent = Extent(-1.0, 1.0, z, z, 0.0, z, 0.0, 0.0)
    line = Line(-count / 2, pitch, count)
    needs = Needs(extent, 1 / (z * frequency), inf, tolerance, count * pitch, 60.0)
    axis = make_axis(line, np.array([-1.0, 1.0]), np.full(2, z), needs)

    def read(values: np.ndarray) -> np.ndarray:
        return np.concatenate(
            [
                values[b.nodes] if b.matrix is None else b.matrix @ values[b.nodes]
                for b in axis.blocks
            ]
        )

    for share in (0.5, 0.9, 0.99):
        nodes, truth = (
            np.exp(2j * np.pi * share * frequency * t) for t in (axis.nodes, line.places)
        )
        single = np.outer(nodes, nodes.conj()).astype(np.complex64)
        missed = read(read(single).T).T - np.outer(truth, truth.conj())
        assert np.sqrt(np.mean(np.abs(missed) ** 2)) < tolerance


def test_points_beside_the_panel_take_as_few_nodes_as_their_directions_ask_for() -> None:
    """Their waves lean one way: against a reference as far aside they are all but still."""
    slm = SLM("column", 1, 1823, 31e-6)
    random = np.random.default_rng(0)
    positions = (random.random((3000, 3)) - 0.5) * (1e-4, 0, 0) + (-0.084, -0.049, 0.1227)
    cloud = PointCloud(positions, np.ones(3000), random.uniform(0, 2 * np.pi, 3000))
    plane = curved.plane_of(slm, 4e-7, Window.full(slm), UNLIMITED)
    factor, budget = curved.make_factor(cloud, plane, 1e-3)
    assert len(factor.axis_y.nodes) < 80 and budget.relative < 1e-3
    made = curved.field(cloud, slm, 4e-7, Window.full(slm), UNLIMITED, tolerance=1e-3)
    truth = reference_field(cloud, slm, 4e-7, footprint=None)
    assert relative_error(made, truth) < 1e-3
