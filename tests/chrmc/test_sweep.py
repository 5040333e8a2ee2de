"""A sweep: what its recipe means, a table that goes on where it was cut off, and its plot."""

import csv
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from chrmc.cli.main import main
from chrmc.cli.sweep_plot import draw, plotted_columns
from chrmc.cli.sweep_recipe import read_recipe
from chrmc.sweep.run import run_sweep
from chrmc.sweep.table import COLUMNS

ROOT = Path(__file__).parents[2]
SCENE = """
import numpy as np
import chrmc

rng = np.random.default_rng(3)
cloud = chrmc.PointCloud(
    rng.uniform(-5e-4, 5e-4, (200, 3)), rng.uniform(0.5, 1, 200), rng.uniform(0, 6, 200)
)
poses = [chrmc.Pose.from_rotvec([0, 0.004 * k, 0], [0, 0, 0.25]) for k in range(6)]
scene = chrmc.PointScene("turning", {"car": cloud}, {"car": poses})
"""
RECIPE = """
scenes = ["turning.py:scene"]
methods = ["curved", "fresnel", { name = "own", compensation = "ch-rmc-object" }]
tolerances = [1e-2, 1e-4]
encodings = ["ssb", "real"]
slms = "240x150:40um"
frames = "2:3"
check = "2"
"""

SHORT = RECIPE.replace(', { name = "own", compensation = "ch-rmc-object" }', "").replace(
    ', "real"', ""
)
"""Three rows."""


@pytest.fixture
def recipe(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "turning.py").write_text(SCENE)
    (tmp_path / "r.toml").write_text(RECIPE)
    return tmp_path / "r.toml"


def status_of(*arguments: str) -> int:
    with pytest.raises(SystemExit) as ended:
        main(list(arguments))
    return int(ended.value.code or 0)


def table(path: Path) -> list[dict[str, str]]:
    """The CSV's rows, times and the machine aside."""
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    return [{k: v for k, v in r.items() if not k.startswith(("seconds", "machine"))} for r in rows]


def test_a_recipe_is_all_combinations_of_its_lists(recipe: Path) -> None:
    cases = read_recipe(recipe)
    found = [(c.names["method"], c.names["tolerance"], c.names["encoding"]) for c in cases]
    assert found == [
        (m, t, e)
        for m, tolerances in (("curved", (1e-2, 1e-4)), ("fresnel", (None,)), ("own", (1e-2, 1e-4)))
        for t in tolerances
        for e in ("ssb", "real")
    ]
    assert {c.frames for c in cases} == {(2, 3)}
    assert {c.checked for c in cases} == {(2,)}
    first = cases[0].recipe
    assert first is not None
    assert (first.compensation, first.options["tolerance"], first.slm.width) == ("none", 1e-2, 240)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("tolerance = [1e-3]", "a sweep has no 'tolerance' (did you mean tolerances?)"),
        ('methods = ["curvd"]', "unknown method 'curvd' (did you mean curved?)"),
        ('methods = [{ chg = "wrp" }]', "a method has no 'chg' (did you mean cgh?)"),
        ('methods = [{ cgh = "wrp", compensation = "ch-rmc-paper", set = { radus = 1 } }]',
         "did you mean radius?"),
        ('methods = [{ cgh = "curved", set = { tolerance = 1 } }]', "stands in tolerances"),
        ("methods = []", "methods is empty"),
        ("methods = [3]", "a method is a name or a table, not 3"),
        ('encodings = ["sbs"]', "unknown encoding 'sbs' (did you mean ssb?)"),
        ("tolerances = [2.0]", "tolerance 2 lies outside"),
        ('tolerances = ["x"]', "a tolerance must be a number"),
        ('slms = ["lcr"]', "'lcr' is no SLM"),
        ('frames = "4:9"', "there is no frame 9"),
        ('frames = [1, 4]', "is no frame range"),
        ("check = [7]", "check names frame 7; made are 1 to 6"),
        ('wavelength = "532mm"', "no plausible wavelength"),
        ('scenes = ["car-hause"]', "did you mean car-house?"),
        ("group = 0", "group must lie between"),
        ("frames = '1:2'\nframes = '2'", "is no TOML"),
    ],
)  # fmt: skip
def test_a_bad_recipe_is_one_line(
    line: str, words: str, recipe: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scenes = "" if line.startswith("scenes") else 'scenes = ["turning.py:scene"]\n'
    recipe.write_text(f'{scenes}slms = "240x150:40um"\n{line}\n' if "slms" not in line else
                      f"{scenes}{line}\n")  # fmt: skip
    assert status_of("sweep", str(recipe)) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert str(recipe) in told
    assert words in told
    assert not (recipe.parent / "r").exists()


def test_a_table_a_plot_and_a_second_run_that_makes_nothing(
    recipe: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recipe.write_text(SHORT)
    assert status_of("sweep", "r.toml", "--plot", "tolerance,error", "--out", "p.svg") == 0
    rows = table(Path("r/sweep.csv"))
    assert len(rows) == 3
    assert Path("r/sweep.csv").read_text().splitlines()[0] == ",".join(COLUMNS)
    for row in rows:
        assert row["refused"] == ""
        if row["tolerance"]:
            assert 0 < float(row["error"]) <= float(row["tolerance"])
            assert float(row["psnr"]) > 25
        assert row["frames"] == "2"
    assert "2 of 3 rows have both" in capsys.readouterr().out
    assert b"<svg" in Path("p.svg").read_bytes()
    assert sorted(p.name for p in Path("r").iterdir()) == ["rows", "sweep.csv", "sweep.txt"]
    before = {p: p.read_bytes() for p in Path("r").rglob("*") if p.is_file()}
    assert status_of("sweep", "r.toml") == 0
    assert {p: p.read_bytes() for p in Path("r").rglob("*") if p.is_file()} == before
    assert "fresnel" in Path("r/sweep.txt").read_text()


def test_what_is_cut_off_goes_on_and_what_has_grown_makes_only_the_new(recipe: Path) -> None:
    made: list[Any] = []

    def judge(video: Any, numbers: Sequence[int], scene: Any) -> dict[str, float]:
        made.append(video.folder)
        if len(made) == 2:
            raise KeyboardInterrupt
        return {"psnr": float(len(video))}

    recipe.write_text(SHORT)
    cases, folder = read_recipe(recipe), recipe.parent / "v"
    with pytest.raises(KeyboardInterrupt):
        run_sweep(cases, folder, judge, "here")
    assert len(table(folder / "sweep.csv")) == 1
    assert len(list((folder / "videos").iterdir())) == 1  # its frames are not made again
    rows = run_sweep(cases, folder, judge, "here")
    assert (len(rows), len(made)) == (3, 4)
    assert not (folder / "videos").exists()
    recipe.write_text(SHORT.replace("1e-4]", "1e-4, 1e-3]"))
    assert len(run_sweep(read_recipe(recipe), folder, judge, "here", keep_videos=True)) == 4
    assert len(made) == 5
    assert len(list((folder / "videos").iterdir())) == 1
    # Another scene of the same name is another row.
    (recipe.parent / "turning.py").write_text(SCENE.replace("default_rng(3)", "default_rng(4)"))
    recipe.write_text(SHORT)
    run_sweep(read_recipe(recipe), folder, judge, "here")
    assert len(made) == 8


def test_rows_made_anew_replace_those_of_before_one_by_one(recipe: Path) -> None:
    recipe.write_text(SHORT)
    folder, cases = recipe.parent / "v", read_recipe(recipe)
    run_sweep(cases, folder, lambda *_: {"psnr": 1.0}, "before")
    table_before = (folder / "sweep.csv").read_bytes()
    with pytest.raises(OSError, match="scheduler"):
        run_sweep(cases, folder, lambda *_: {}, "now", anew=True, scheduler="tcp://127.0.0.1:1")
    assert (folder / "sweep.csv").read_bytes() == table_before
    assert len(list((folder / "rows").glob("*.json"))) == 3
    rows = run_sweep(cases, folder, lambda *_: {"psnr": 2.0}, "now", anew=True)
    assert [(row["psnr"], row["machine"]) for row in rows] == [(2.0, "now")] * 3


def test_a_row_that_somebody_wrote_is_one_line(recipe: Path) -> None:
    recipe.write_text(SHORT)
    folder, cases = recipe.parent / "v", read_recipe(recipe)
    run_sweep(cases, folder, lambda *_: {}, "here")
    for content in ('{"psnr": "x"}', '{"nothing": 1}', '{"seconds": [1]}', "[]"):
        next((folder / "rows").glob("*.json")).write_text(content)
        with pytest.raises(ValueError, match="is no row of a sweep: remove it"):
            run_sweep(cases, folder, lambda *_: {}, "here")


def test_choices_that_do_not_fit_make_a_row_that_says_so(recipe: Path) -> None:
    recipe.write_text(
        'scenes = ["turning.py:scene"]\nslms = ["240x150:40um", "24x30:900um"]\nframes = "1"\n'
        'methods = ["curved"]\nencodings = ["ssb", "offaxis"]\n'
    )
    rows = run_sweep(read_recipe(recipe), recipe.parent / "v", lambda *_: {}, "here")
    assert len(rows) == 4
    for row in rows:
        assert row.get("refused") or np.isfinite(row["error"])


@pytest.mark.parametrize("text", ["seconds", "seconds,errer", "error,method", "a,b,c"])
def test_a_plot_of_no_columns_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="--plot"):
        plotted_columns(text)


@pytest.mark.parametrize("kind", ["png", "pdf", "svg"])
def test_a_plot_of_words_over_numbers(kind: str, tmp_path: Path) -> None:
    rows = [
        {"scene": "s", "method": m, "encoding": "ssb", "slm": "p", "tolerance": t, "psnr": p}
        for m, t, p in (("a", 1e-2, 20.0), ("a", 1e-3, 30.0), ("b", None, None))
    ]
    assert draw(rows, "method", "psnr", tmp_path / f"p.{kind}") == 2
    assert (tmp_path / f"p.{kind}").stat().st_size > 1000
    with pytest.raises(ValueError, match="no row has both"):
        draw(rows, "method", "ssim", tmp_path / f"q.{kind}")


def documented() -> str:
    text = (ROOT / "docs/sweeps.md").read_text("utf-8")
    return re.findall(r"```toml\n(.*?)```", text, flags=re.DOTALL)[0]


def test_the_documents_recipe_is_one(recipe: Path) -> None:
    recipe.write_text(documented())
    cases = read_recipe(recipe)
    assert len(cases) == (3 + 3 + 1) * 2
    assert not any(case.refused for case in cases)
    for name in re.findall(r"`(\w+)`", (ROOT / "docs/sweeps.md").read_text().split("| column")[1]
                           .split("\n\n")[0]):  # fmt: skip
        assert name in COLUMNS


@pytest.mark.long
@pytest.mark.timeout(1200)
def test_the_documents_recipe_runs(recipe: Path) -> None:
    recipe.write_text(documented())
    assert status_of("sweep", "r.toml", "--plot", "seconds,error", "--out", "tradeoff.pdf") == 0
    rows = table(Path("r/sweep.csv"))
    assert len(rows) == 14
    assert all(float(row["in_focus"]) == 1 for row in rows if row["method"] != "paper")
    assert Path("tradeoff.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.long
@pytest.mark.timeout(1200)
def test_kills_at_any_moment_end_in_the_same_table(recipe: Path) -> None:
    def start(folder: str) -> "subprocess.Popen[bytes]":
        return subprocess.Popen(
            [sys.executable, "-m", "chrmc", "sweep", "r.toml", "--folder", folder],
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stdout=subprocess.DEVNULL,
        )

    assert start("whole").wait() == 0
    rng = np.random.default_rng()
    begun = time.monotonic()
    assert start("warm").wait() == 0
    usual = time.monotonic() - begun
    for _ in range(12):
        process = start("killed")
        try:
            process.wait(timeout=rng.uniform(0.3, 0.8) * usual)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.wait()
        if Path("killed/sweep.csv").exists():
            assert len(table(Path("killed/sweep.csv"))) <= 10
    assert start("killed").wait() == 0
    assert table(Path("killed/sweep.csv")) == table(Path("whole/sweep.csv"))
    assert sorted(p.name for p in Path("killed").iterdir()) == ["rows", "sweep.csv", "sweep.txt"]
    assert not list(Path("killed").rglob("*.partial*"))
