"""The sweep over extremes: cases follow from seeds, faults are told, refusals are none."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from chrmc import SLM, WAVELENGTH, compute_field
from chrmc.bench import extremes, extremes_cases, extremes_table
from chrmc.bench.extremes_worker import Worker
from chrmc.cgh import METHODS
from chrmc.cli.bench_extremes import command
from chrmc.optics.passband import full_band
from chrmc.reference import reference_field, relative_error


def test_a_case_follows_from_its_seed() -> None:
    kinds, methods = set(), set()
    for seed in range(150):
        case = extremes.case_of(seed)
        assert case == extremes.case_of(seed)
        kinds.add(case.kind)
        methods.add(case.method)
        assert 1e-3 <= case.depth <= 100 and 1e-6 <= case.tolerance <= 1e-1
    assert kinds == set(extremes.KINDS) and methods == set(METHODS)
    cloud = extremes.cloud_of(extremes.case_of(3))
    assert np.array_equal(cloud.positions, extremes.cloud_of(extremes.case_of(3)).positions)


def test_the_sampled_error_is_the_whole_one() -> None:
    slm = SLM("s", 120, 90, 16e-6)
    random = np.random.default_rng(0)
    cloud = extremes.PointCloud(
        random.uniform((-3e-4, -3e-4, 0.1), (3e-4, 3e-4, 0.101), (300, 3)),
        np.ones(300),
        random.random(300),
    )
    made = compute_field(cloud, slm, WAVELENGTH, "fresnel")
    truth = reference_field(cloud, slm, WAVELENGTH)
    whole = relative_error(made, truth)
    made[:] *= 1.02
    found = extremes.sampled_error(made, cloud, slm, WAVELENGTH, full_band(slm))
    assert found == pytest.approx(np.hypot(whole, 0.02), rel=0.3)
    # Before a promise is called broken, many more pixels are asked: here all of them.
    whole = relative_error(made, truth)
    confirmed = extremes.sampled_error(made, cloud, slm, WAVELENGTH, full_band(slm), 0.0)
    assert confirmed == pytest.approx(whole, rel=1e-3)


def test_an_error_of_few_shapes_is_allowed_less() -> None:
    """Few nodes for many points: their phases are one draw, by chance twice the expected error."""
    out = extremes.run(extremes.case_of(883012))
    assert not out.fault and not out.refused and out.error > 0


def test_points_are_tried_in_their_own_footprints() -> None:
    """Deep and near, on a panel that is wider than any footprint: outside of it waves are steeper
    than nodes, and finer ones were tried for minutes."""
    out = extremes.run(extremes.case_of(7300143))
    assert not out.fault and not out.refused and out.cpu < 5
    assert out.error < 2 * out.expected


def test_errors_that_few_pixels_hold_are_met() -> None:
    """Half of the error is on a hundredth of the pixels: a look at twelve missed it."""
    out = extremes.run(extremes.case_of(311775))
    assert not out.fault and not out.refused and out.error > 0


@pytest.mark.parametrize("seed", [20261229, 20261619])
def test_what_would_be_searched_for_minutes_is_left(seed: int) -> None:
    # Nodes that double precision cannot tell; filters of soft edges of thousands of pixels.
    out = extremes.run(extremes.case_of(seed))
    assert not out.fault and out.cpu < 10


@pytest.mark.parametrize(("seed", "method"), [(424442, "wrp"), (424541, "nlut")])
def test_short_cuts_that_take_longer_than_the_true_sum_are_refused(seed: int, method: str) -> None:
    """Points 22 m away of a panel of one column; 241 depth planes, each of one point."""
    out = extremes.run(extremes.case_of(seed))
    assert not out.fault and out.cpu < 5
    assert re.fullmatch(rf"{method} would take about \d+ s here, .*: use rt or curved", out.refused)


@pytest.mark.parametrize("video", extremes_cases.VIDEOS)
def test_every_way_to_make_a_video_is_tried(video: str) -> None:
    case = replace(
        plain(1), kind="video", video=video, method=extremes_cases.VIDEOS[video], count=20
    )
    out = extremes.run(case)
    assert not out.fault and not out.refused and out.error > 0
    assert (extremes.promised(case) < 1) == (video != "3dmc-nlut")


@pytest.mark.parametrize("seed", [8100195, 8100374, 8101695, 3123553])
def test_a_body_that_leaves_the_panel_is_no_reason_to_refuse(seed: int) -> None:
    out = extremes.run(extremes.case_of(seed))
    assert not out.fault and not out.refused


FIRST = extremes.case_of(0)


def plain(seed: int, **changed: object) -> extremes.Case:
    return replace(
        FIRST, seed=seed, kind="box", method="curved", slm=SLM("s", 200, 150, 16e-6),
        wavelength=WAVELENGTH, band="real", depth=0.2, count=40, tolerance=1e-3, **changed,
    )  # fmt: skip


def test_a_broken_promise_is_a_fault_and_exit_status_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(extremes, "case_of", plain)
    arguments = ["--minutes", "0.00001", "--seed", "7", "--out", str(tmp_path)]
    runner = CliRunner()
    good = runner.invoke(command, arguments)
    assert good.exit_code == 0, good.output
    assert (tmp_path / "extremes.png").stat().st_size > 5000
    monkeypatch.setattr(extremes, "promised", lambda case: 1e-12)
    bad = runner.invoke(command, arguments)  # goes on after it
    assert bad.exit_code == 1 and "seed 8, box: error " in bad.output
    rows = extremes_table.read(tmp_path / "extremes.csv")
    assert [row["seed"] for row in rows] == ["7", "8"]
    assert "times what is promised" in rows[1]["fault"] and not rows[0]["fault"]


def test_cases_that_do_not_end_are_ended_and_the_next_one_is_tried(tmp_path: Path) -> None:
    """Endless, dead, raising and wrong methods: each a fault, told as what it is."""
    own = tmp_path / "own.py"
    own.write_text(
        "import os, time\n"
        "def endless(*given): time.sleep(100)\n"
        "def busy(*given):\n"
        "    while True: pass\n"
        "def dead(*given): os._exit(3)\n"
        "def raising(*given): raise KeyError('x')\n"
        "def infinite(cloud, slm, *rest):\n"
        "    import numpy as np\n"
        "    return np.full(slm.shape, np.inf, np.complex64)\n"
    )
    with Worker() as worker:
        for name, fault in (
            ("endless", "ended after 1 s, 0 of"), ("busy", "ended after "), ("dead", "status 3"),
            ("raising", "KeyError"), ("infinite", "not finite"),
        ):  # fmt: skip
            case = replace(plain(3), method=f"{own}:{name}")
            found = worker.run(case, 1 / 3 / extremes.limit(case))
            assert fault in found.fault and found.seconds < 5, found
        assert not worker.run(plain(3)).fault
    slow = extremes.Outcome(plain(3), error=1e-9, cpu=1 + extremes.limit(plain(3)))
    assert "processor seconds" in extremes.judged(slow).fault
    long = replace(plain(3), kind="video")
    for frames, fault in ((90, False), (20, True)):
        video = extremes.Outcome(long, error=1e-9, cpu=600.0, frames=frames)
        assert bool(extremes.judged(video).fault) == fault
