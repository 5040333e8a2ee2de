"""The bench of reuse: its bodies, and that it measures what it says."""

import numpy as np

from chrmc import SLM, WAVELENGTH
from chrmc.bench.reuse import Case, ellipsoid_scene, reuse

PANEL = SLM("a quarter of the paper's", 320, 200, 16e-6)
CASE = Case((8e-4, 4e-4, 5e-4), 400, 0.2, 0.5, 4)


def test_the_side_towards_the_hologram_is_seen_and_turns() -> None:
    scene = ellipsoid_scene(CASE)
    first, last = (scene.frame(n).objects[0] for n in (1, 4))
    assert abs(len(first.cloud) - 400) < 60
    assert first.cloud.positions[:, 2].max() <= 0.2 + 1e-9
    assert 0 < len(np.setxor1d(first.ids, last.ids)) < 40
    half = np.array(CASE.size) / 2
    np.testing.assert_allclose(np.linalg.norm(scene.bodies["body"].positions / half, axis=1), 1)


def test_both_ways_are_timed_and_checked() -> None:
    row = reuse(CASE, PANEL, WAVELENGTH, always=True)
    assert row.later > 0 and row.fresh > 0 and row.first > 0 and 0 < row.ratio < 100
    assert row.error <= 1e-3
    assert "what it would cost afresh" in row.how[0] and "sphere" in row.how[1]
