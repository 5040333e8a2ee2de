"""`bench plan` keeps its rows one by one and goes on behind them."""

from pathlib import Path

import pytest

from chrmc import SLM
from chrmc.bench import planned
from chrmc.bench.kept import KeptRows
from chrmc.bench.planned import Case, Row, bodies, one_core, rows

CASE = Case(
    "few", lambda: bodies(1, 5, (1e-3, 1e-3, 1e-3), 0.005), SLM("small", 160, 100, 40e-6), 2
)


def test_rows_that_are_done_are_not_measured_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(planned, "BRIEF", 0.02)
    path = tmp_path / "plan.json"
    with one_core():
        made = rows(CASE, KeptRows(path, ["here"], Row))
        before = [next(made), next(made)]  # and stopped
        after = list(rows(CASE, KeptRows(path, ["here"], Row)))
    assert after[:2] == before and [row.what for row in after] == ["tolerance"] * 3 + ["budget"]
    for row in after:
        assert row.met == ((row.middle if row.what == "budget" else row.error) <= row.asked)
        assert 0 < row.best <= row.measured and row.first > 0
    assert all(row.met for row in after[:3])
    assert after[3].asked == pytest.approx(1.3 * after[1].measured)
