"""A manifest from a stranger: one line or a video, nothing else, and nothing outside its folder."""

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import chrmc
from chrmc.pictures import write_grey

GOOD: dict[str, Any] = {
    "format": 1,
    "slm": {"name": "s", "width": 8, "height": 6, "pixel_pitch": 8e-6, "bits": 8, "refresh": 60.0,
            "fill_factor": 1.0},
    "wavelength": 532e-9,
    "scene": {"name": "s", "form": "points", "pixel_pitch": 4e-5, "frame_count": 2,
              "objects": ["dot"]},
    "methods": {"cgh": "rt", "compensation": "none", "options": {}},
    "encoding": "ssb",
    "scale": 1.5,
    "response": {"name": "linear"},
    "frames": [
        {"number": 1, "file": "frame_0001.tif", "sha256": "", "stage_seconds": {"HC": 0.1},
         "objects": [{"name": "dot", "position": [0, 0, 0.1], "depth": 0.1,
                      "box": [[0, 0, 0.1], [0, 0, 0.1]]}]}
    ],
}  # fmt: skip


def written(folder: Path, manifest: Any) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "manifest.json").write_text(json.dumps(manifest))
    return folder


def changed(path: tuple[Any, ...], value: Any) -> dict[str, Any]:
    manifest: Any = copy.deepcopy(GOOD)
    inner = manifest
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    return manifest  # type: ignore[no-any-return]


def refused(folder: Path) -> str:
    with pytest.raises(ValueError) as caught:
        chrmc.open_video(folder)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 600
    return str(caught.value)


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (("wavelength",), 1, "wavelength 1 m"),
        (("wavelength",), 1e308, "wavelength"),
        (("wavelength",), 1e-320, "wavelength"),
        (("wavelength",), 10**40, "wavelength"),
        (("wavelength",), "532e-9", "must be a number"),
        (("wavelength",), float("nan"), "finite"),
        (("slm", "width"), 8.0, "whole number"),
        (("slm", "width"), 10**40, "between 1 and"),
        (("slm", "height"), float("inf"), "whole number"),
        (("slm", "pixel_pitch"), 1e308, "pixel_pitch"),
        (("slm", "refresh"), float("inf"), "refresh"),
        (("slm", "refresh"), 1e29, "refresh"),
        (("slm", "refresh"), "often", "refresh"),
        (("slm", "colour"), 1, "slm must have"),
        (("slm",), [], "slm must be an object"),
        (("scene", "pixel_pitch"), 0, "pixel_pitch"),
        (("scene", "name"), 5, "must be text"),
        (("encoding",), "magic", "none of ssb"),
        (("encoding",), ["ssb"], "none of ssb"),
        (("scale",), 0, "scale"),
        (("response",), {"levels": [[1, 2]]}, "response"),
        (("response",), {"levels": "many"}, "response"),
        (("frames",), {}, "frames must be a list"),
        (("frames", 0), 1, "a frame must be an object"),
        (("frames", 0, "number"), "1", "frame number must be a whole number"),
        (("frames", 0, "number"), 0, "frame number must lie"),
        (("frames", 0, "file"), "../secret.tif", "plain file name"),
        (("frames", 0, "file"), "/etc/passwd", "plain file name"),
        (("frames", 0, "file"), "manifest.json", "plain file name"),
        (("frames", 0, "file"), "a\\b.tif", "plain file name"),
        (("frames", 0, "objects"), 5, "objects must be a list"),
        (("frames", 0, "objects", 0, "position"), [0, 0], "3 numbers"),
        (("frames", 0, "objects", 0, "position"), [0, 0, 1e999], "finite"),
        (("frames", 0, "objects", 0, "box"), [[0, 0, 1]], "two corners"),
        (("frames",), GOOD["frames"] * 2, "listed twice"),
    ],
)
def test_what_cannot_be_is_named(tmp_path: Path, path: Any, value: Any, words: str) -> None:
    assert words in refused(written(tmp_path / "v", changed(path, value)))


def test_the_good_one_is_taken(tmp_path: Path) -> None:
    video = chrmc.open_video(written(tmp_path / "v", GOOD))
    assert video.numbers == [1]


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    found = [path] if path else []
    if isinstance(value, dict):
        found += [p for k, v in value.items() for p in places(v, (*path, k))]
    elif isinstance(value, list):
        found += [p for k, v in enumerate(value) for p in places(v, (*path, k))]
    return found


ODD = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8), st.just(10**45),
    st.lists(st.integers(), max_size=3), st.dictionaries(st.text(max_size=3), st.integers()),
)  # fmt: skip


@settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(st.sampled_from(places(GOOD)), ODD)
def test_anything_anywhere_is_a_video_or_one_line(
    tmp_path: Path, path: tuple[Any, ...], value: Any
) -> None:
    folder = written(tmp_path / "v", changed(path, value))
    try:
        video = chrmc.open_video(folder)
    except ValueError as error:
        assert "\n" not in str(error)
    else:
        assert len(repr(video)) < 2500
        assert "table" in video._repr_html_()


def test_deep_and_endless_json_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "manifest.json").write_text("[" * 100_000)
    refused(tmp_path)
    (tmp_path / "manifest.json").write_text("9" * 100_000)
    refused(tmp_path)


def test_a_frame_that_is_a_link_out_of_the_folder_is_not_read(tmp_path: Path) -> None:
    secret = tmp_path / "secret.tif"
    write_grey(secret, np.zeros((6, 8), np.uint8))
    folder = written(tmp_path / "v", GOOD)
    (folder / "frame_0001.tif").symlink_to(secret)
    with pytest.raises(ValueError, match="leads out of"):
        chrmc.open_video(folder).read(1)


def test_a_folder_that_is_a_link_and_one_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    with pytest.raises((ValueError, OSError)) as caught:
        chrmc.generate("car-house", tmp_path / "file", frames=(1, 1))
    assert "\n" not in str(caught.value)
    assert (tmp_path / "file").read_text() == "mine"
