import numpy as np
import pytest

from chrmc.optics.propagation import propagate
from reconstruct import crosscheck

P, LAMBDA = 8.1e-6, 532e-9


def window(n):
    return np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 2


FIELD = (window(60)[:, None] * window(72)) * np.exp(
    2j * np.pi * np.add.outer(np.arange(60) * 0.03, np.arange(72) * -0.05)
)


def test_the_direct_sum_and_the_angular_spectrum_agree():
    depth = 15e-3
    ours = propagate(FIELD, P, LAMBDA, -depth)
    rows, columns = np.array([30, 21, 40]), np.array([36, 50, 20])
    direct = crosscheck.rayleigh_sommerfeld(FIELD, P, LAMBDA, depth, rows, columns)
    assert np.linalg.norm(ours[rows, columns] - direct) < 2e-3 * np.linalg.norm(direct)


@pytest.mark.skipif(not crosscheck.package_there(), reason="chrmc[crosscheck] is optional")
def test_the_independent_package_agrees():
    for depth in (2e-3, 15e-3):  # its two ways: transfer function and impulse response
        ours = propagate(FIELD, P, LAMBDA, -depth)
        theirs = crosscheck.package_propagate(FIELD, P, LAMBDA, depth)
        assert np.linalg.norm(ours - theirs) < 1e-2 * np.linalg.norm(theirs)


@pytest.mark.skipif(crosscheck.package_there(), reason="chrmc[crosscheck] is there")
def test_its_absence_is_told():
    with pytest.raises(OSError, match="crosscheck"):
        crosscheck.package_propagate(FIELD, P, LAMBDA, 1e-2)
