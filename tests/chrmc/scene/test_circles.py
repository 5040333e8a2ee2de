"""Circle fits and angles against circles that are known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chrmc.scene.circles import geometric, paper_angle, paper_circle, turn_angle
from chrmc.scene.path import rotation_y


def arc(centre, radius, start, step, count):
    """(count, 2) positions x, z turned by `step` about +y from frame to frame."""
    turn = start + step * np.arange(count)
    return np.asarray(centre) + radius * np.stack([np.sin(turn), np.cos(turn)], axis=1)


@settings(max_examples=40, deadline=None)
@given(
    radius=st.floats(1e-4, 1.0),
    start=st.floats(-4, 4),
    step=st.floats(3e-3, 0.3),
    count=st.integers(3, 40),
    x=st.floats(-0.1, 0.1),
    z=st.floats(0.1, 0.4),
)
def test_exact_arcs_give_their_circle(radius, start, step, count, x, z):
    found = geometric(arc((x, z), radius, start, step, count))
    # The sagitta decides how well rounding of the positions leaves the circle determined.
    sagitta = radius * (1 - np.cos(min(step * (count - 1), np.pi) / 2))
    slack = 1e-6 + 1e-15 / sagitta
    assert found.radius == pytest.approx(radius, rel=slack)
    assert found.centre == pytest.approx((x, z), abs=slack * radius + 1e-12)
    assert found.rms < 1e-12


@pytest.mark.parametrize("count", [3, 4, 5, 8, 12])
def test_whole_turns_and_two_places_in_turn_divide_by_nothing(count):
    """The circle's centre is the mean of the positions: no direction leads there from it."""
    random = np.random.default_rng(count)
    with np.errstate(all="raise", under="ignore"):
        for _ in range(40):
            centre, radius = random.random(2), random.uniform(0.1, 2)
            found = geometric(arc(centre, radius, random.random(), 2 * np.pi / count, count))
            assert found.radius == pytest.approx(radius, rel=1e-6)
            assert found.centre == pytest.approx(centre, abs=1e-6 * radius)
            back_and_forth = random.random((2, 2))[np.arange(count) % 2]
            assert geometric(back_and_forth).rms < np.ptp(back_and_forth, axis=0).max()


def test_straight_lines_and_single_places_are_lines():
    along = np.linspace(0, 1e-2, 9)
    for points in (
        np.stack([along, 2 * along + 0.25], axis=1),
        np.stack([along, np.full(9, 0.25)], axis=1),
        np.full((5, 2), 0.25),
    ):
        found = geometric(points)
        assert found.straight and found.rms < 1e-12


def test_short_noisy_arcs_are_not_made_smaller():
    rng = np.random.default_rng(3)
    exact = arc((0, 0.28), 36.74e-3, 3.0, np.radians(0.303), 31)
    radius = [geometric(exact + rng.normal(0, 5e-6, exact.shape)).radius for _ in range(300)]
    spread = np.std(radius) / np.sqrt(300) * 1.3
    assert np.median(radius) == pytest.approx(36.74e-3, abs=4 * spread)


def test_geometric_has_the_smallest_distances():
    rng = np.random.default_rng(4)
    for _ in range(20):
        points = arc((0, 0), 1, 0, 0.1, 12) + rng.normal(0, 0.02, (12, 2))
        best = geometric(points)
        for dx, dz, dr in np.eye(3) * 1e-4:
            away = np.hypot(*(points - np.array(best.centre) - [dx, dz]).T) - best.radius - dr
            assert np.sqrt((away**2).mean()) > best.rms


def test_too_few_or_missing_positions_are_refused():
    with pytest.raises(ValueError, match="N ≥ 3"):
        geometric([[0, 0], [1, 1]])
    with pytest.raises(ValueError, match="finite"):
        geometric([[0, 0], [1, 1], [np.nan, 2]])


def test_circle_through_three_points():
    assert paper_circle(*arc((1, 2), 3, 0.2, 0.7, 3)).centre == pytest.approx((1, 2))
    assert paper_circle(*arc((1, 2), 3, 0.2, 0.7, 3)).radius == pytest.approx(3)
    assert paper_circle((0, 0), (1, 1), (2, 2)).straight
    assert paper_circle((0, 0), (0, 0), (2, 2)).straight
    assert paper_circle((1, 1), (1, 1), (1, 1)).straight


def test_circle_of_the_printed_points_is_not_the_printed_circle():
    """Centimetres, section 3.3: the text says 31.36 cm."""
    found = paper_circle((46.42, 28.69), (46.29, 28.51), (46.14, 28.44))
    assert found.radius == pytest.approx(0.385, abs=0.001)


@settings(max_examples=60, deadline=None)
@given(angle=st.floats(-3.1, 3.1), start=st.floats(-4, 4))
def test_angle_is_that_of_the_rotation_about_y(angle, start):
    before = 0.02 * np.array([np.sin(start), 0, np.cos(start)])
    after = rotation_y(angle) @ before
    centre = np.array([3e-3, 0.27])
    found = turn_angle(centre, centre + before[[0, 2]], centre + after[[0, 2]])
    assert found == pytest.approx(angle, abs=1e-12)


def test_positive_angle_carries_z_towards_x():
    assert turn_angle((0, 0), (0, 1), (1, 0)) == pytest.approx(np.pi / 2)


def test_paper_angle_agrees_and_loses_digits_near_zero():
    for angle in (1e-3, 0.1, 1.0):
        first, second = arc((0, 0.27), 0.02, 2.9, angle, 2)
        assert paper_angle((0, 0.27), first, second) == pytest.approx(angle, abs=1e-7)
    lost, kept = [], []
    for k in range(40):
        first, second = arc((0, 0.27), 0.02, 2.9 + 0.01 * k, 1e-6, 2)
        lost.append(abs(paper_angle((0, 0.27), first, second) - 1e-6))
        kept.append(abs(turn_angle((0, 0.27), first, second) - 1e-6))
    assert max(kept) < 1e-13
    assert max(lost) > 1e-10
    assert paper_angle((0, 0), (0, 1), (0, 1)) == 0


def test_paper_angle_needs_an_isosceles_triangle():
    # Both positions on one side of the foot of the height: the true angle is a difference.
    true = abs(float(turn_angle((0, 0), (1, 1), (2, 1))))
    assert true == pytest.approx(np.arctan(2) - np.pi / 4)
    assert paper_angle((0, 0), (1, 1), (2, 1)) == pytest.approx(np.arctan(2) + np.pi / 4)
