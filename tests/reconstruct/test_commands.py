"""The commands that show and judge a stored video, on a small one."""

import json

import numpy as np
import pytest

from chrmc.cli.main import main
from chrmc.store.video import open_video
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
    code, said, _ = run(capsys, "reconstruct", video, "--frame", 1, "--depth", 0.06, "--out", out)
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
        (["check", __file__], "is a file, no hologram video"),
        (["reconstruct", "DIR", "--frame", "9", "--depth", "0.06", "--out", "a.png"], "no frame 9"),
        (["reconstruct", "DIR", "--frame", "1", "--depth", "-1", "--out", "a.png"], "depth"),
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


def test_all_frames_into_a_folder_with_a_preview(video, capsys, tmp_path):
    out, preview = tmp_path / "r", tmp_path / "p.gif"
    code, said, _ = run(
        capsys, "reconstruct", video, "--all", "--follow", "cluster", "--format", "exr",
        "--out", out, "--preview", preview,
    )  # fmt: skip
    assert code == 0 and "3 frames" in said and preview.stat().st_size > 1000
    names = sorted(p.name for p in out.iterdir())
    assert names == [f"reconstruction_000{n}.exr" for n in (1, 2, 3)]
    stored = open_video(video)
    _, note = read_image(out / names[1])
    assert note["depth"] == stored.entry(2)["objects"][0]["depth"]


def test_a_focal_stack_with_depth_map(video, capsys, tmp_path):
    code, _, _ = run(
        capsys, "reconstruct", video, "--frame", 1, "--depths", "0.057:0.063:13", "--out", tmp_path
    )
    assert code == 0 and len(list(tmp_path.glob("depth_*mm.png"))) == 13
    depth, note = read_image(tmp_path / "depth_map.exr")
    assert note["unit"] == "metre"
    x, y, z = open_video(video).entry(1)["objects"][0]["position"]
    row, column = round(y / 8.1e-6 + 127.5), round(x / 8.1e-6 + 127.5)
    found = np.median(depth[row - 12 : row + 12, column - 12 : column + 12])
    assert found == pytest.approx(z, abs=3e-4)


def test_a_focal_stack_moves_and_warns_where_its_steps_are_too_coarse(video, capsys, tmp_path):
    preview = tmp_path / "p.gif"
    code, said, err = run(
        capsys, "reconstruct", video, "--frame", 1, "--depths", "0.05:0.07:4", "--out", tmp_path,
        "--preview", preview,
    )  # fmt: skip
    assert code == 0 and "4 depths at" in said and preview.stat().st_size > 1000
    assert "coarser than the depth of focus" in err and err.count("\n") == 1
    assert (tmp_path / "depth_map.png").stat().st_size > 5000
    code, _, err = run(
        capsys, "reconstruct", video, "--frame", 1, "--depths", "0.05:0.07:4", "--out", tmp_path,
        "--preview", tmp_path / "p.bmp",
    )  # fmt: skip
    assert code == 2 and "p.bmp" in err


def test_camera_and_energy(video, capsys, tmp_path):
    out = tmp_path / "c.png"
    code, said, _ = run(
        capsys, "reconstruct", video, "--frame", 1, "--follow", "cluster", "--out", out,
        "--camera", "4.05e-6:12", "--energy", "--lens1", "0.02", "--aperture", "4e-3x8e-3",
        "--tilt", "0,0.001", "--waist", "2e-3", "--fill-factor", "0.9",
    )  # fmt: skip
    assert code == 0
    account = [line for line in said.splitlines() if "light" in line]
    shares = [float(line.split("%")[0].split()[-1]) for line in account]
    assert sum(shares) == pytest.approx(100, abs=0.01)
    counts, note = read_image(out)
    assert counts.shape == (512, 512) and 255 < counts.max() <= 4095
    assert note["pixel_pitch"] == 4.05e-6


def test_panorama(video, capsys, tmp_path):
    out = tmp_path / "p.png"
    code, _, _ = run(capsys, "panorama", video, "--out", out)
    assert code == 0 and out.stat().st_size > 5000


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--frame", "1"], "--depth"),
        (["--frame", "1", "--depth", "0.06", "--follow", "cluster"], "--depth"),
        (["--depth", "0.06"], "--frame"),
        (["--all", "--follow", "boat"], "boat"),
        (["--frame", "1", "--depths", "3:2:1"], "NEAR:FAR:COUNT"),
        (["--frame", "1", "--depth", "0.06", "--aperture", "wide"], "--aperture"),
        (["--frame", "1", "--depth", "0.06", "--aperture", "1mmx2mmx3mm"], "sides"),
        (["--frame", "1", "--depth", "0.06", "--tilt", "1"], "--tilt"),
        (["--frame", "1", "--depth", "0.06", "--aperture-centre", "0,0"], "--aperture-centre"),
        (["--frame", "1", "--depth", "0.06", "--aberration", "none.exr"], "none.exr"),
        (["--frame", "1", "--depth", "0.06", "--camera", "x"], "--camera"),
        (["--all", "--depth", "0.06", "--preview", "a.bmp"], "a.bmp"),
        (["--all", "--depth", "0.06", "--frames", "1:9"], "no frame 9"),
    ],
)
def test_contradictions_are_one_line(video, capsys, tmp_path, arguments, says):
    code, _, err = run(capsys, "reconstruct", video, *arguments, "--out", tmp_path / "a.png")
    assert code == 2 and says in err and err.count("\n") == 1


def test_check_from_python(video):
    import reconstruct

    found = reconstruct.check(video, frames=[1, 2])
    assert [v.number for v in found] == [1, 2] and all(v.passed for v in found)
    assert found[0].objects[0].faults == [] and abs(found[0].objects[0].depth_error) < 2e-4
    assert len(reconstruct.check(open_video(video))) == 3
    with pytest.raises(ValueError, match="no frame 9"):
        reconstruct.check(video, [9])
