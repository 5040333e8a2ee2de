"""What a newcomer meets: names that are nearly right, lists in --help, a summary in plain words."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from chrmc.cgh import METHODS
from chrmc.cli.main import group, main
from chrmc.cli.names import settings
from chrmc.compensation import COMPENSATIONS
from chrmc.scene.load import BUILT_IN
from chrmc.store.differences import refuse_another
from chrmc.store.summary import STAGES, summary
from chrmc.store.video import open_video

ROOT = Path(__file__).parents[3]


@pytest.mark.parametrize(
    ("arguments", "meant"),
    [
        (["generat"], "generate"),
        (["bench", "sped"], "speed"),
        (["check", "--frame", "3", "x"], "--frames"),
        (["generate", "car-hose", "--out", "x"], "car-house"),
        (["generate", "car-house", "--out", "x", "--cgh", "curvd"], "curved"),
        (["generate", "car-house", "--out", "x", "--compensation", "mc-nlt"], "mc-nlut"),
        (["generate", "car-house", "--out", "x", "--set", "tolerence=0.1"], "tolerance"),
        (["generate", "car-house", "--out", "x", "--cgh", "wrp", "--set", "plane=2"], "planes"),
    ],
)
def test_a_slip_is_answered_with_the_name_that_was_meant(
    arguments: list[str], meant: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert "id you mean" in told
    assert meant in told.split("id you mean")[1]


@pytest.mark.parametrize("name", ["display", "reconstruct"])
@pytest.mark.parametrize("command", [["monitors"], ["--help"]])
def test_a_file_that_hides_a_package_is_named(
    name: str, command: list[str], tmp_path: Path
) -> None:
    (tmp_path / f"{name}.py").write_text("raise SystemExit('the wrong file was run')\n")
    shown = subprocess.run(
        [sys.executable, "-m", "chrmc", *command],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    assert shown.returncode == 2
    assert shown.stderr.count("\n") == 1
    assert str(tmp_path / f"{name}.py") in shown.stderr
    assert "rename" in shown.stderr


def test_help_lists_methods_and_the_settings_of_each() -> None:
    shown = CliRunner().invoke(group, ["generate", "--help"], terminal_width=10_000).output
    for name in (*METHODS, *COMPENSATIONS):
        assert name in shown
    assert "radius" in settings()["ch-rmc-paper"]
    assert "cache" not in settings()["curved"]
    for names in settings().values():
        assert all(name in shown for name in names)


@pytest.mark.parametrize(
    ("words", "found"),
    [
        ("chrmc gen", {"generate"}),
        ("chrmc generate car", set(BUILT_IN)),
        ("chrmc generate car-house --cgh nl", {"nlut", "nlut-1d"}),
        ("chrmc generate car-house --surface ", {"object", "paper"}),
    ],
)
def test_the_shell_completes_commands_scenes_and_methods(words: str, found: set[str]) -> None:
    shown = subprocess.run(
        [sys.executable, "-m", "chrmc"],
        env={
            **os.environ,
            "PYTHONPATH": str(ROOT),
            "_CHRMC_COMPLETE": "bash_complete",
            "COMP_WORDS": words,
            "COMP_CWORD": str(words.count(" ")),
        },
        capture_output=True,
        text=True,
        check=True,
    )
    assert {line.partition(",")[2] for line in shown.stdout.splitlines()} == found


def record(number: int, **values: object) -> dict[str, object]:
    obj = {"name": "car", "coverage": 0.5, "points": 100}
    return {
        "number": number,
        "file": f"frame_{number:04d}.tif",
        "sha256": "0" * 64,
        "key": number == 1,
        "points_computed": 60,
        "stage_seconds": {"RMC": 0.002, "HC": 0.006},
        "error_reference": 0.12,
        "error_reuse": 0.09,
        "objects": [obj],
        **values,
    }


def lines_of(stored: Path, tmp_path: Path, frames: list[dict[str, object]]) -> list[str]:
    """The summary of a video with the records given."""
    manifest = json.loads((stored / "manifest.json").read_text())
    first = manifest["frames"][0]
    manifest["frames"] = [{**first, **frame} for frame in frames]
    (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    return list(summary(open_video(tmp_path)))


def test_the_summary_s_times_are_milliseconds_per_frame(stored_video: Path, tmp_path: Path) -> None:
    lines = lines_of(stored_video, tmp_path, [record(1), record(2), record(3)])
    rows = {line.split()[0]: line.split()[1:] for line in lines}
    assert rows["RMC"][:2] == ["2.00", "25.0%"]
    assert rows["HC"][:2] == ["6.00", "75.0%"]
    assert rows["total"] == ["8.00"]
    assert rows["stage"][:3] == ["ms", "per", "frame"]
    assert "3 frames, 1 of them key frames" in lines


def test_the_summary_explains_stages_points_and_both_errors(
    stored_video: Path, tmp_path: Path
) -> None:
    text = "\n".join(lines_of(stored_video, tmp_path, [record(1), record(2)]))
    assert STAGES["RMC"] in text
    assert STAGES["HC"] in text
    assert "60 of 100 visible" in text
    assert "worst 1.2e-01" in text
    assert "worst 9.0e-02" in text
    assert "rekey_error" in text


def test_videos_of_key_frames_alone_say_why(stored_video: Path) -> None:
    assert "without compensation" in next(iter(summary(open_video(stored_video))))


def test_what_is_computed_afresh_says_why_and_what_is_reused_is_told(
    stored_video: Path, tmp_path: Path
) -> None:
    manifest = json.loads((stored_video / "manifest.json").read_text())
    manifest["methods"]["compensation"] = "ch-rmc-object"
    stored = tmp_path / "stored"
    stored.mkdir()
    (stored / "manifest.json").write_text(json.dumps(manifest))
    things = [{"name": "car", "points": 90}, {"name": "house", "points": 10}]
    first = {"car": "afresh: looking up would cost 3 times as much", "house": "afresh: it rests"}
    frames = [record(1, objects=things, reuse=first)]
    frames += [record(n, objects=things, key=True, reuse={"car": "afresh"}) for n in (2, 3)]
    assert lines_of(stored, tmp_path, frames)[0] == (
        "3 frames: car is computed afresh in each (looking up would cost 3 times as much), "
        "house is reused"
    )


def test_an_option_that_differs_is_named_once_and_as_it_is_typed() -> None:
    before = {
        "wavelength": 532e-9,
        "slm": {"name": "lc-r", "pixel_pitch": 8.1e-6},
        "methods": {"cgh": "curved", "options": {"tolerance": 1e-3}, "auto": {"tolerance": 1e-3}},
    }
    wanted = {
        "wavelength": 633e-9,
        "slm": {"name": "other", "pixel_pitch": 8e-6},
        "methods": {"cgh": "curved", "options": {"tolerance": 1e-2}, "auto": {"tolerance": 1e-2}},
    }
    with pytest.raises(ValueError, match="another video") as told:
        refuse_another(Path("v"), {**before, "slm": wanted["slm"]}, wanted)
    assert "(wavelength 532nm, not 633nm; tolerance 0.001, not 0.01):" in str(told.value)
    with pytest.raises(ValueError, match=r"slm name lc-r, not other; pixel_pitch 8.1um, not 8um\)"):
        refuse_another(Path("v"), before, {**before, "slm": wanted["slm"]})


def test_every_stage_that_is_booked_has_plain_words(stored_video: Path) -> None:
    booked = {
        part.split('"')[0]
        for path in (ROOT / "chrmc").rglob("*.py")
        for part in path.read_text().split('.stage("')[1:]
    }
    assert booked <= set(STAGES)
    assert {s for f in open_video(stored_video).frames for s in f["stage_seconds"]} <= set(STAGES)


def test_the_page_of_the_command_line_tells_the_stages_alike() -> None:
    page = (ROOT / "docs" / "command-line.md").read_text()
    for name, words in STAGES.items():
        assert f"| `{name}` | {words} |" in page
