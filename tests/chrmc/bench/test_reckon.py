"""Time reckoned from fewer points: made-up costs whose truth is known."""

from collections.abc import Callable

import pytest

from chrmc.bench.reckon import reckon


class Work:
    """Seconds of so many points by a formula, and how much of it was run."""

    def __init__(self, formula: Callable[[int], float]) -> None:
        self.formula = formula
        self.runs: list[int] = []

    def __call__(self, count: int) -> float:
        self.runs.append(count)
        return self.formula(count)

    @property
    def spent(self) -> float:
        return sum(self.formula(n) for n in self.runs)


@pytest.mark.parametrize("each", [1e-6, 1e-4, 1e-2, 1.0])
@pytest.mark.parametrize("fixed", [0.0, 0.1, 2.0])
@pytest.mark.parametrize("count", [17, 1000, 1_000_000])
def test_a_straight_line_is_found(each: float, fixed: float, count: int) -> None:
    work = Work(lambda n: fixed + each * n)
    assert reckon(work, count, 10.0) == pytest.approx(fixed + each * count)
    assert max(work.runs) < count and work.spent < 30.0


def test_costs_that_level_off_are_not_taken_for_costs_of_every_point() -> None:
    """Twelve planes, of which every point fills one more, until all are filled."""
    work = Work(lambda n: 0.1 * min(n, 12) + 1e-4 * n)
    assert reckon(work, 100, 5.0, [(1, 0.1), (10, 1.0)]) < 5
    assert reckon(work, 10_000, 10.0) == pytest.approx(2.2)


def test_a_first_run_that_took_too_long_does_not_hide_the_slope() -> None:
    """Loading and planning cost a second once; the straight line would then point down."""
    calls = []

    def seconds(count: int) -> float:
        calls.append(count)
        return 1e-3 * count + (1.0 if len(calls) == 1 else 0.0)

    assert reckon(seconds, 100_000, 10.0) == pytest.approx(100, rel=0.1)


def test_what_is_known_is_not_run_again() -> None:
    work = Work(lambda n: 0.01 * n)
    assert reckon(work, 1000, 20.0, [(100, 1.0), (10, 0.1), (5000, 50.0)]) == pytest.approx(10)
    assert reckon(work, 10_000, 10.0, [(1000, 10.0), (100, 1.0)]) == pytest.approx(100)
    assert work.runs == []


def test_few_points_are_simply_computed() -> None:
    work = Work(lambda n: 1.0 * n)
    assert reckon(work, 16, 1e-9) == 0 and work.runs == []
    assert reckon(work, 10, 1e-9, [(1, 2.0)]) == 2.0
