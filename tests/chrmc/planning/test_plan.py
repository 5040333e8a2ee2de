"""What a plan takes, on a machine of stated rates, and that it counts as scenes grow."""

import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import chrmc
from chrmc.cgh import OperationCounts, method_named
from chrmc.cgh.counts import KINDS
from chrmc.encoding import coding_for
from chrmc.optics.footprint import coverage
from chrmc.optics.passband import Passband
from chrmc.planning import rates
from chrmc.planning.choice import Choice, pick
from chrmc.planning.choices import plan
from chrmc.planning.rates import Rates
from chrmc.window import Window

PANEL = chrmc.SLM("quarter", 480, 300, 16.2e-6)
SPEEDS = {"products": 6e10, "phasors": 1.5e8, "lookups": 5e8, "transforms": 2e9, "bytes": 4e10,
          "calls": 1.8e6}  # fmt: skip
HERE = Rates(SPEEDS, SPEEDS, 2)


def some_scene(count: int, turn: float = 0.0, frames: int = 8) -> chrmc.PointScene:
    random = np.random.default_rng(1)
    body = chrmc.PointCloud(
        random.uniform(-5e-4, 5e-4, (count, 3)), np.ones(count), random.uniform(0, 6.28, count)
    )
    poses = [chrmc.Pose.from_rotvec([0, turn * n, 0], [0, 0, 0.25]) for n in range(frames)]
    return chrmc.PointScene("body", {"body": body}, {"body": poses})


def test_the_cheapest_that_meets_a_tolerance() -> None:
    found = plan(some_scene(300, 0.01), PANEL, tolerance=1e-4, rates=HERE)
    assert found.met and found.taken.meets(1e-4)
    fit = [c.mean for c in found.choices if c.meets(1e-4)]
    assert found.taken.mean <= min(fit) / 0.9
    assert not any(c.meets(1e-4) for c in found.choices if c.cgh == "fresnel")


def test_the_most_accurate_within_a_budget() -> None:
    loose, tight = (plan(some_scene(2000, 0.01), PANEL, budget=b, rates=HERE) for b in (0.02, 0.2))
    assert tight.met and tight.taken.mean <= 0.2
    assert loose.taken.error is not None and tight.taken.error is not None
    assert tight.taken.error <= loose.taken.error
    better = [c for c in tight.choices if c.within(1.0) < tight.taken.within(1.0)]
    assert not any(c.keeps(0.2) for c in better)


def test_nothing_meets_both_and_the_nearest_is_named() -> None:
    found = plan(some_scene(2000, 0.01), PANEL, tolerance=1e-6, budget=1e-4, rates=HERE)
    assert not found.met
    assert "nothing meets" in found.why
    json.dumps(found.as_dict(), allow_nan=False)


def test_what_rests_costs_one_frame_of_all() -> None:
    found = plan(some_scene(2000), PANEL, tolerance=1e-3, rates=HERE)
    assert found.taken.compensation == "ch-rmc-object"
    assert found.taken.objects == {"body": "it rests"}
    assert found.taken.mean < 0.5 * found.taken.key


@pytest.mark.parametrize("name", chrmc.cgh.METHODS)
def test_more_points_never_cost_less(name: str) -> None:
    method, band = method_named(name), coding_for("ssb", PANEL).passband
    times = []
    for count in (10, 100, 3000):
        cloud = some_scene(count).frame(1).cloud
        assert method.cost is not None
        counts = method.cost(cloud, PANEL, 532e-9, Window.full(PANEL), band)
        times.append(HERE.seconds(counts, method.shares_cores))
    assert times == sorted(times)


counts = st.builds(
    OperationCounts, **dict.fromkeys((*KINDS, "memory"), st.floats(0, 1e12)), )  # fmt: skip


@given(counts, counts)
def test_seconds_add_up(a: OperationCounts, b: OperationCounts) -> None:
    assert HERE.seconds(a + b) == pytest.approx(HERE.seconds(a) + HERE.seconds(b))
    assert HERE.seconds(a.times(3)) == pytest.approx(3 * HERE.seconds(a))
    assert (a + b).memory == max(a.memory, b.memory)


choices = st.lists(
    st.builds(
        Choice, st.just("m"), st.just("none"), st.fixed_dictionaries({}), st.just(1),
        st.floats(1e-3, 10), st.floats(1e-3, 10), st.floats(1e-7, 0.3), st.just(False),
        st.just(0.0),
    ), min_size=1, max_size=8,
).map(tuple)  # fmt: skip


@given(choices, st.floats(1e-6, 0.5), st.floats(1e-3, 10))
def test_a_pick_is_met_where_one_can_be(given: Any, tolerance: float, budget: float) -> None:
    taken, met = pick(given, tolerance, budget)
    assert met == any(c.meets(tolerance) and c.keeps(budget) for c in given)
    assert not met or (taken.meets(tolerance) and taken.keeps(budget))


def test_rates_are_measured_kept_and_measured_anew_elsewhere(
    tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    file = rates.rates_file()
    assert rates.kept_rates() is None
    made = rates.calibrate(0.02)
    assert rates.kept_rates() == made and set(made.alone) == set(KINDS)
    assert all(made.together[kind] <= made.alone[kind] for kind in KINDS)
    for damaged in ("{}", "[" * 100_000):
        file.write_text(damaged)
        assert rates.kept_rates() is None
    monkeypatch.setenv("CHRMC_THREADS", "7")
    assert rates.rates_file() != file


def test_waves_in_double_precision_count_for_more() -> None:
    fine, band = chrmc.SLM("fine", 4500, 4000, 1e-6), Passband(4.9e5, 4.9e5)
    method, window = method_named("rt"), Window.full(fine)
    assert method.cost is not None
    phasors = {}
    for depth in (5e-3, 1e-1):  # steep waves, and all but flat ones
        cloud = chrmc.PointCloud(np.array([[0, 0, depth]]), np.ones(1), np.zeros(1))
        lit = float(coverage(cloud, fine, 532e-9, band).sum()) * window.size
        phasors[depth] = method.cost(cloud, fine, 532e-9, window, band).phasors / lit
    assert phasors[5e-3] > 3 * phasors[1e-1]
