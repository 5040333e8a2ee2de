"""The sweep over extremes: cases follow from seeds, faults are told, refusals are none."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from chrmc import SLM, WAVELENGTH, compute_field
from chrmc.bench import extremes, extremes_table
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
    slm = SLM("s", 160, 120, 16e-6)
    random = np.random.default_rng(0)
    cloud = extremes.PointCloud(
        random.uniform((-3e-4, -3e-4, 0.1), (3e-4, 3e-4, 0.101), (2000, 3)),
        np.ones(2000),
        random.random(2000),
    )
    made = compute_field(cloud, slm, WAVELENGTH, "fresnel")
    whole = relative_error(made, reference_field(cloud, slm, WAVELENGTH))
    made[:] *= 1.02
    found = extremes.sampled_error(made, cloud, slm, WAVELENGTH, full_band(slm))
    assert found == pytest.approx(np.hypot(whole, 0.02), rel=0.3)


def test_a_broken_promise_is_a_fault_and_exit_status_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from chrmc.cgh import curved

    seed = 7
    case = replace(
        extremes.case_of(seed), kind="box", method="curved", slm=SLM("s", 200, 150, 16e-6),
        wavelength=WAVELENGTH, band="real", depth=0.2, count=40, tolerance=1e-3,
    )  # fmt: skip
    monkeypatch.setattr(extremes, "case_of", lambda number: replace(case, seed=number))
    arguments = ["--minutes", "0.00001", "--seed", str(seed)]
    runner = CliRunner()
    good = runner.invoke(command, [*arguments, "--out", str(tmp_path / "good")])
    assert good.exit_code == 0, good.output
    assert (tmp_path / "good" / "extremes.png").stat().st_size > 5000
    method = curved.METHOD
    wrong = extremes.method_named("rt")

    def made(*given: object, tolerance: float) -> object:
        return 1.5 * wrong.field(*given), 1e-7  # type: ignore[arg-type]

    monkeypatch.setattr(
        curved, "METHOD", type(method)(method.field, field_and_error=made, signal=method.signal)
    )
    bad = runner.invoke(command, [*arguments, "--out", str(tmp_path / "bad")])
    assert bad.exit_code == 1 and f"seed {seed}, box: error 0.5" in bad.output
    rows = extremes_table.read(tmp_path / "bad" / "extremes.csv")
    assert "times what is promised" in rows[0]["fault"]
    again = runner.invoke(command, [*arguments, "--out", str(tmp_path / "bad")])  # goes on after it
    assert len(extremes_table.read(tmp_path / "bad" / "extremes.csv")) == 2, again.output
