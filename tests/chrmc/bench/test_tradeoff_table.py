"""The trade-off's table on disk, and the command that stops and goes on."""

import csv
import io
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from chrmc.bench.tradeoff_table import Entry, Table, from_csv, mark_front, to_csv
from chrmc.cli.bench_tradeoff import draw
from chrmc.cli.main import main

SMALL = ["--rounds", "1", "--frames", "1", "--limit", "1", "--slm", "320x200:40e-6",
         "--encoding", "real"]  # fmt: skip


def entry(seconds: float, error: float, scene: str = "a", kind: str = "cgh") -> Entry:
    return Entry(scene, kind, "m", f"{seconds:g}", 1, [seconds], [error])


def run(*arguments: str | Path) -> int:
    with pytest.raises(SystemExit) as stop:
        main(["bench", "tradeoff", *map(str, arguments)])
    assert isinstance(stop.value.code, int)
    return stop.value.code


def rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text.split("\n", 1)[1])))


def test_the_front_holds_what_nothing_beats_in_both() -> None:
    entries = [entry(1, 1e-1), entry(2, 1e-2), entry(3, 5e-2), entry(2.5, 1e-2), entry(9, 1, "b")]
    entries.append(Entry("a", "cgh", "m", "", 1, refused="left out"))
    mark_front(entries)
    assert [e.front for e in entries] == [True, True, False, False, True, False]


def test_a_table_is_read_as_it_was_written() -> None:
    written = [
        Entry("car, house", "video", "ch-rmc", 'surface "object"', 1208, [0.5, 0.1, 0.2],
              [1e-3, 2e-3, 1.5e-3], 1.8e-3, 94.25, "", True, None, 512, "a note"),
        Entry("b", "cgh", "rt", "", 10),
        Entry("b", "cgh", "wrp", "", 10, psnr=float("inf"), errors=[float("inf")], seconds=[1.0]),
    ]  # fmt: skip
    written[1].leave_out(7670.4)
    assert written[1].refused == "left out: about 7670 s a frame"
    read = from_csv(to_csv(written))
    assert to_csv(read) == to_csv(written)
    assert (read[0].time, read[0].error, len(read[0].seconds)) == (0.2, 2e-3, 3)
    assert read[1].reckoned == 7670 and not read[1].seconds


def test_the_plot_of_kept_rows_is_that_of_measured_ones(tmp_path: Path) -> None:
    entries = [entry(1, 1e-1), entry(2, 1e-2), entry(3, 5e-2), entry(2.5, 1e-2, kind="video")]
    mark_front(entries)
    draw(entries, "machine", tmp_path / "measured.png")
    draw(from_csv(to_csv(entries)), "machine", tmp_path / "kept.png")
    assert (tmp_path / "measured.png").read_bytes() == (tmp_path / "kept.png").read_bytes()
    entries[2].front = True
    draw(entries, "machine", tmp_path / "other.png")
    assert (tmp_path / "measured.png").read_bytes() != (tmp_path / "other.png").read_bytes()


def test_no_legend_lies_over_points_and_every_axis_has_ticks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept: list[Any] = []
    monkeypatch.setattr("chrmc.figures.save", lambda figure, path: kept.append(figure))
    entries = [entry(0.020, 1e-1, "1000000 points"), entry(0.021, 1e-5, "1000000 points"),
               entry(2e-6, 1e-2, "b"), entry(20, 1e-3, "b")]  # fmt: skip
    draw(entries, "machine", tmp_path / "t.png")
    (figure,) = kept
    figure.draw_without_rendering()  # lays it out
    assert [a.get_title() for a in figure.axes] == ["1,000,000 points, one frame", "b, one frame"]
    for axes in figure.axes:
        low, high = axes.get_xlim()
        assert 3 <= sum(low <= t <= high for t in axes.get_xticks()) <= 9
        assert axes.get_legend() is None
        told = [t.get_text() for t in axes.get_xticklabels()]
        assert all(word.endswith("s") for word in told if word)
        for legend in figure.legends:
            assert not legend.get_window_extent().overlaps(axes.get_window_extent())


def test_a_figure_of_another_kind_is_refused_before_the_work(tmp_path: Path) -> None:
    assert run("--out", tmp_path / "t", "--figure", "t.doc") == 2
    assert not (tmp_path / "t").exists()


def test_scenes_are_stored_one_by_one_and_kept(tmp_path: Path) -> None:
    path, made = tmp_path / "t.csv", []

    def make(scene: str, seconds: float) -> list[Entry]:
        made.append(scene)
        return [entry(seconds, 1e-2, scene), entry(2 * seconds, 1e-3, scene)]

    first = Table(path, ["this machine"])
    first.take("a", "cgh", ["m 1", "m 2"], lambda: make("a", 1))
    first.take("b", "cgh", ["m 3", "m 6"], lambda: make("b", 3))
    with pytest.raises(KeyboardInterrupt):
        first.take("c", "cgh", ["m 5", "m 10"], lambda: (_ for _ in ()).throw(KeyboardInterrupt))
    before = path.read_text(encoding="utf-8")
    assert made == ["a", "b"] and before.startswith("# this machine\n")

    second = Table(path, ["this machine"])
    second.take("c", "cgh", ["m 5", "m 10"], lambda: make("c", 5))
    # What was not asked for yet is neither measured anew nor lost.
    assert {row["scene"] for row in rows(path.read_text(encoding="utf-8"))} == {"a", "b", "c"}
    second.take("a", "cgh", ["m 1", "m 2"], lambda: make("a", 100))
    # A method more than there was: the whole scene is measured, as methods take turns.
    second.take("b", "cgh", ["m 7", "m 14"], lambda: make("b", 7))
    assert made == ["a", "b", "c", "b"]
    found = {(row["scene"], row["seconds"]) for row in rows(path.read_text(encoding="utf-8"))}
    assert found == {("c", "5"), ("c", "10"), ("a", "1"), ("a", "2"), ("b", "7"), ("b", "14")}
    assert all(e.front for e in second.entries)


def test_the_table_of_another_run_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    Table(path, ["2 cores", "3 rounds"]).take("a", "cgh", ["m 1"], lambda: [entry(1, 1)])
    before = path.read_bytes()
    for made_with, words in (
        (["2 cores", "5 rounds"], "“3 rounds”, not “5 rounds”"),
        (["2 cores"], "“3 rounds”, not “nothing”"),
        (["2 cores", "3 rounds", "images"], "“nothing”, not “images”"),
    ):
        with pytest.raises(ValueError, match=words):
            Table(path, made_with)
    assert path.read_bytes() == before
    assert Table(path, ["5 cores"], anew=True).kept == []
    for damaged in (before[:-30], b"\xff\xfe", b"", before.replace(b",runs", b",laps")):
        path.write_bytes(damaged)
        with pytest.raises(ValueError, match="--force"):
            Table(path, ["2 cores", "3 rounds"])


def test_command_writes_table_and_plot(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "table"
    assert run("--points", "10", *SMALL, "--out", out) == 0, capsys.readouterr().err
    text = (out / "tradeoff.csv").read_text(encoding="utf-8")
    assert text.startswith("# ") and "cores" in text.splitlines()[0]
    found = rows(text)
    assert {row["scene"] for row in found} == {"car-house", "1 point", "10 points"}
    assert any(row["front"] == "1" for row in found)
    assert any(row["psnr_db"] for row in found)
    assert (out / "tradeoff.png").read_bytes()[:4] == b"\x89PNG"


def test_stored_rows_are_drawn_whatever_they_were_made_with(tmp_path: Path) -> None:
    assert run("--draw-only", "--out", tmp_path) == 2  # there are none
    table = Table(tmp_path / "tradeoff.csv", ["another machine"])
    table.take("a", "cgh", ["m 1", "m 2"], lambda: [entry(1, 1e-1), entry(2, 1e-2)])
    before = table.path.read_bytes()
    assert run("--draw-only", "--out", tmp_path, "--figure", "t.svg") == 0
    assert "<svg" in (tmp_path / "t.svg").read_text(encoding="utf-8")
    assert table.path.read_bytes() == before and len(list(tmp_path.iterdir())) == 2


@pytest.mark.long
def test_a_killed_run_is_continued_by_the_same_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["car-house", "--no-images", *SMALL, "--out", str(tmp_path / "t")]
    code = "from chrmc.cli.main import main; main()"
    command = [sys.executable, "-c", code, "bench", "tradeoff", "--points", "1000", *arguments]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for shown in process.stdout:
            if shown.split("  ")[0].strip() == "" and "1 point " in shown:
                process.kill()
                break
    path = tmp_path / "t" / "tradeoff.csv"
    before = path.read_text(encoding="utf-8").splitlines()
    assert {row["scene"] for row in rows("\n".join(before))} >= {"car-house", "1 point"}

    assert run("--points", "100", *arguments) == 0
    assert f"{len(before) - 2} rows kept" in capsys.readouterr().out
    after = path.read_text(encoding="utf-8").splitlines()
    assert set(before) < set(after)  # to the last digit of the times: nothing was measured again
    assert {row["scene"] for row in rows("\n".join(after))} >= {"car-house", "100 points"}
    assert (tmp_path / "t" / "tradeoff.png").is_file()

    unchanged = path.read_bytes()
    assert run("--points", "1", *arguments, "--rounds", "2") == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and "rounds 1" in error and "--force" in error
    assert path.read_bytes() == unchanged
    assert run("--points", "0", *arguments, "--rounds", "2", "--force") == 0
    assert {r["scene"] for r in rows(path.read_text(encoding="utf-8"))} == {"car-house"}
