"""Nodes of clusters that take hardly any."""

import numpy as np
import pytest

from chrmc import SLM, WAVELENGTH, PointCloud
from chrmc.cgh import curved
from chrmc.optics.passband import full_band
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
