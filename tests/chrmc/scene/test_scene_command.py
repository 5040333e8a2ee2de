"""`chrmc scene` from the outside."""

import pytest

from chrmc import load_scene
from chrmc.cli.main import main


def run(*arguments):
    """Exit status of a command line."""
    with pytest.raises(SystemExit) as caught:
        main(list(map(str, arguments)))
    return caught.value.code


def test_writes_a_folder_that_loads(tmp_path, capsys):
    assert run("scene", "car-house", "--out", tmp_path / "s", "--frames", "1:2") == 0
    assert "2 frames of 320 × 240 pixels, car, house" in capsys.readouterr().out
    scene = load_scene(tmp_path / "s")
    assert scene.frame_count == 2 and scene.name == "car-house"
    assert (tmp_path / "s" / "preview.png").read_bytes()[:4] == b"\x89PNG"
    assert run("scene", tmp_path / "s", "--out", tmp_path / "t", "--figure", "look.svg") == 0
    assert load_scene(tmp_path / "t").frame_count == 2
    assert "<svg" in (tmp_path / "t" / "look.svg").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "arguments",
    [
        ("scene", "nowhere", "--out", "{}/t"),
        ("scene", "car-house", "--out", "{}/t", "--frames", "80:81"),
        ("scene", "car-house", "--out", "{}/t", "--frames", "all"),
        ("scene", "car-house"),
        ("scene", "car-house", "--out", "{}/t", "--figure", "look.bmp"),
        ("scene", "car-house-deep", "--out", "{}/s"),
        ("scene", "{}/s", "--out", "{}/s", "--force"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(tmp_path, capfd, arguments):
    run("scene", "car-house", "--out", tmp_path / "s", "--frames", "1:1")
    before = {p.name: p.read_bytes() for p in (tmp_path / "s").iterdir()}
    capfd.readouterr()
    assert run(*(a.format(tmp_path) for a in arguments)) == 2
    said = capfd.readouterr()
    assert said.err.count("\n") == 1 and said.err.startswith("chrmc: ")
    assert before == {p.name: p.read_bytes() for p in (tmp_path / "s").iterdir()}
