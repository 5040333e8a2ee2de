"""What a chart and its grid hold, against directions and ranges drawn at random."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import jv

from chrmc.compensation.ch_rmc_object.chart import View, mean_rotation, path, slopes, views_of
from chrmc.compensation.ch_rmc_object.grid import layer_count, make_grid
from chrmc.scene.scene import Pose

WAVELENGTH = 532e-9


def poses(turn: list[float], count: int = 5) -> list[Pose]:
    return [
        Pose(
            Rotation.from_rotvec(np.array(turn) * k).as_matrix(),
            np.array([2e-3 - 1e-3 * k, 5e-4 * k, 0.2 + 4e-3 * k]),
        )
        for k in range(count)
    ]


@pytest.mark.parametrize("turn", [[0.0, 0.02, 0.0], [0.03, -0.05, 0.04], [0.0, 0.0, 0.2]])
def test_views_hold_all_directions_and_ranges_and_little_more(turn: list[float]) -> None:
    every = poses(turn)
    to_chart = mean_rotation(every)
    middle = np.array([1e-4, -2e-4, 3e-4])
    low, high = np.linspace(-8e-3, -5e-3, 5), np.linspace(5e-3, 7e-3, 5)
    sides = (low, high), (0.5 * low, 0.6 * high)
    views = views_of(every, middle, to_chart, sides)
    random = np.random.default_rng(0)
    for k, pose in enumerate(every):
        q = np.zeros((4000, 3))
        for axis, (first, last) in enumerate(sides):
            q[:, axis] = random.uniform(first[k], last[k], len(q))
        q[:4, :2] = [(x[k], y[k]) for x in sides[0] for y in sides[1]]
        q[4:600, 0] = random.choice([sides[0][0][k], sides[0][1][k]], 596)
        turned = to_chart @ pose.rotation.T

        down = turned[:, 1]
        centre = pose.rotation @ middle + pose.translation
        d = (q - centre) @ turned.T
        r = np.linalg.norm(d, axis=1)
        for values, (least, most) in (
            (d[:, 0] / r, views.alpha), (d[:, 1] / r, views.beta), (1 / r, views.s)
        ):  # fmt: skip
            assert least[k] <= values.min() and values.max() <= most[k]
            assert most[k] - least[k] <= 1.12 * np.ptp(values) + 1e-9
        # How much α changes with β down a column of the hologram.
        ahead = d + 1e-7 * down
        ahead /= np.linalg.norm(ahead, axis=1)[:, None]
        change = ahead - d / r[:, None]
        slope = np.abs(change[:, 0] / change[:, 1]).max()
        assert 0.99 * slope <= views.tilt[k] <= 1.06 * slope + 1e-3
    some = views.until(3)
    assert some.alpha == (views.alpha[0][:3].min(), views.alpha[1][:3].max())
    assert some.s == (views.s[0][:3].min(), views.s[1][:3].max())
    assert some.tilt == views.tilt[:3].max()


def test_the_mean_rotation_is_a_rotation_half_way() -> None:
    both = [Pose(Rotation.from_rotvec([0, a, 0]).as_matrix(), np.zeros(3)) for a in (-0.1, 0.5)]
    mean = mean_rotation(both)
    assert np.allclose(mean, Rotation.from_rotvec([0, 0.2, 0]).as_matrix(), atol=1e-12)
    assert np.linalg.det(mean) == pytest.approx(1)


def test_a_view_that_a_chart_can_hold() -> None:
    flat = View((-0.3, 0.2), (-0.1, 0.4), (3.0, 5.0), 0.5)
    assert flat.whole
    for bad in (
        View((-0.5, 0.2), (-0.1, 0.4), (3.0, 5.0), 0.5),
        View((-0.3, 0.6), (-0.1, 0.4), (3.0, 5.0), 0.5),
        View((-0.3, 0.2), (-0.6, 0.4), (3.0, 5.0), 0.5),
        View((-0.3, 0.2), (-0.1, 0.4), (3.0, 5.0), 1.01),
    ):
        assert not bad.whole


@pytest.mark.parametrize("half", [(1e-3, 5e-4, 8e-4), (2e-4, 6e-4, 1e-4)])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
def test_a_grid_is_fine_enough_for_its_points_and_reaches_past_the_view(
    half: tuple[float, float, float], tolerance: float
) -> None:
    view = View((-0.06, 0.04), (-0.02, 0.05), (4.0, 5.0), 0.3)
    grid = make_grid(np.array(half), view, (0.08, 0.05), WAVELENGTH, tolerance)
    random = np.random.default_rng(1)
    a, b = (random.uniform(*span, 20_000) for span in (view.alpha, view.beta))
    a[:2], b[:2] = view.alpha, view.beta
    delta = random.choice([-1.0, 1.0], (len(a), 3)) * half
    gamma = np.sqrt(1 - a**2 - b**2)
    steep = (
        np.abs(delta[:, 0] + delta[:, 2] * a / gamma).max() / WAVELENGTH,
        np.abs(delta[:, 1] + delta[:, 2] * b / gamma).max() / WAVELENGTH,
    )
    assert steep[0] <= grid.bandwidth[0] <= 1.06 * steep[0]
    down = steep[1] + view.tilt * grid.bandwidth[0]
    assert 0.99 * down <= grid.bandwidth[1] <= 1.06 * down
    for axis, span in enumerate((view.alpha, view.beta)):
        step = grid.step[axis]
        assert (
            step <= 0.02 and step <= 1 / (2 * grid.bandwidth[axis] * grid.taps.oversampling) * 1.001
        )
        last = grid.first[axis] + step * (grid.count[axis] - 1)
        # Half of the neighbours that are read, and a few more.
        room = (grid.taps.count // 2 + 1) * step
        assert grid.first[axis] + room < span[0] and last - room > span[1]
        assert last - grid.first[axis] < span[1] - span[0] + 2 * room + 14 * step
    assert grid.span == view.s
    assert np.all((grid.layers > 4.0) & (grid.layers < 5.0))
    assert grid.tile[0] <= grid.count[0] and grid.tile[1] <= grid.count[1]
    assert 0.04 <= grid.tile[0] * grid.step[0] <= 0.04 + 2.1 * grid.step[0]


@pytest.mark.parametrize(
    ("swing", "tolerance"), [(0.01, 1e-3), (0.5, 1e-4), (3.0, 1e-3), (2, 1e-6)]
)
def test_layers_are_as_many_as_bessel_functions_say(swing: float, tolerance: float) -> None:
    count = layer_count(swing, tolerance)
    assert np.sqrt(2) * jv(count, swing) <= tolerance
    assert count == 1 or np.sqrt(2) * jv(count - 2, swing) > tolerance


def test_layers_follow_the_rms_of_a_boxs_squares() -> None:
    """The path's second order is (Δ_1² + Δ_2²)/2r: over a box drawn at random."""
    random = np.random.default_rng(5)
    for half in ((1e-3, 4e-4, 0.0), (6e-4, 9e-4, 0.0)):
        x, y = (random.uniform(-h, h, 400_000) for h in half[:2])
        rms = np.sqrt(np.mean((x * x + y * y) ** 2))
        for deep in np.linspace(0.05, 3, 60):
            view = View((-0.01, 0.01), (-0.01, 0.01), (4.0, 4.0 + deep), 0.0)
            grid = make_grid(np.array(half), view, (0.02, 0.02), WAVELENGTH, 1e-4)
            swing = np.pi * rms * deep / 2 / WAVELENGTH
            allowed = [layer_count(share * swing, 0.3e-4) for share in (0.985, 1.015)]
            assert allowed[0] <= len(grid.layers) <= allowed[1]


def test_slopes_are_those_of_the_path() -> None:
    place, r, step = (np.array(3e-4), np.array(-2e-4), np.array(5e-4)), 0.2, 1e-6
    for a, b in ((0.0, 0.0), (0.1, -0.05), (-0.2, 0.15)):
        found = slopes(np.array(a), np.array(b), place, r)
        for slope, da, db in zip(found, (step, 0), (0, step), strict=True):
            ends = [path(np.array(a + s * da), np.array(b + s * db), place, r) for s in (1, -1)]
            assert slope == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-6)
