"""The commands that show and judge a stored video, on a small one."""

import json

import numpy as np
import pytest

from chrmc.cli.main import main
from chrmc.store import open_video
from reconstruct import four_f
from reconstruct.images import read_image


def run(capsys, *arguments):
    with pytest.raises(SystemExit) as stop:
        main([str(a) for a in arguments])
    out = capsys.readouterr()
    return stop.value.code, out.out, out.err


def test_check_passes_and_says_so(video, capsys):
    code, out, err = run(capsys, "check", video, "--frames", "all")
    assert code == 0 and "all 2 objects are in focus" in out and not err
    assert "(empty)" in out


def test_check_as_json_with_a_plot(video, capsys, tmp_path):
    plot = tmp_path / "f.png"
    code, out, _ = run(capsys, "check", video, "--json", "--plot", plot)
    content = json.loads(out)
    assert code == 0 and content["passed"] and plot.exists()
    assert [f["number"] for f in content["frames"]] == [1, 2, 3]
    found = content["frames"][0]["objects"][0]
    assert abs(found["depth_error"]) < 2e-4 and found["psnr"] is None


def test_check_fails_with_status_1(video, capsys):
    code, out, _ = run(capsys, "check", video, "--depth-tolerance", "1e-9")
    assert code == 1 and "FAILS" in out
    # The frames swapped: each object is where the other frame has it.
    manifest = json.loads((video / "manifest.json").read_text())
    other = video.parent / "swapped"
    other.mkdir(exist_ok=True)
    first, second, third = manifest["frames"]
    first["file"], second["file"] = second["file"], first["file"]
    for frame in (first, second, third):
        (other / frame["file"]).write_bytes((video / frame["file"]).read_bytes())
    (other / "manifest.json").write_text(json.dumps(manifest))
    code, out, _ = run(capsys, "check", other, "--frames", "1:2")
    assert code == 1 and "2 of 2 objects" in out


def test_reconstruct_writes_the_library_s_image(video, capsys, tmp_path):
    out = tmp_path / "a.exr"
    code, said, _ = run(
        capsys, "reconstruct", video, "--frame", 1, "--depth", 0.06, "--out", out
    )
    assert code == 0 and "60.000 mm" in said
    values, note = read_image(out)
    stored = open_video(video)
    want = four_f(stored.read(1), stored.slm, stored.wavelength, 0.06, scale=stored.scale)
    assert np.allclose(values, want, atol=1e-5 * want.max())
    assert note["frame"] == 1 and note["depth"] == 0.06


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["check", "DIR", "--frames", "9"], "no frame 9"),
        (["check", "DIR", "--frames", "x"], "no list of frames"),
        (["check", "NOWHERE"], "missing"),
        (["reconstruct", "DIR", "--frame", "9", "--depth", "0.06", "--out", "a.png"], "no frame 9"),
        (["reconstruct", "DIR", "--frame", "1", "--depth", "-1", "--out", "a.png"], "distance"),
        (["reconstruct", "DIR", "--frame", "1", "--depth", "0.06", "--out", "a.gif"], ".exr"),
        (["reconstruct", "DIR", "--frame", "1", "--out", "a.png"], "depth"),
    ],
)
def test_bad_requests_are_one_line_and_status_2(video, capsys, arguments, says):
    filled = [str(video) if a == "DIR" else a for a in arguments]
    code, _, err = run(capsys, *filled)
    assert code == 2 and says in err
    assert err.count("\n") == 1


def test_bench_propagation_prints_differences(video, capsys):
    code, out, _ = run(capsys, "bench", "propagation", video, "--pixels", "3")
    assert code == 0
    line = next(line for line in out.splitlines() if "direct sum" in line)
    assert float(line.split()[-1]) < 0.05
    assert "HCIPy" in out
    code, _, err = run(capsys, "bench", "propagation", video, "--frame", "3")
    assert code == 2 and "--depth" in err
