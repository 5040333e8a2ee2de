"""Point clouds as scenes."""

from pathlib import Path

import numpy as np
import pytest

from chrmc import LC_R_1080, SLM, PointCloud, generate, load_scene
from chrmc.scene import sources
from chrmc.scene.sources.volume import box


def test_a_scene_format_is_one_file_and_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "bars.py").write_text(
        "import numpy as np\n"
        "from chrmc.scene.sources.cloud import cloud_of\n"
        "from chrmc.scene.sources.model import Model\n"
        "def read(path):\n"
        "    return Model({path.stem: cloud_of(np.loadtxt(path, delimiter='|'))}, up='-y')\n"
    )
    monkeypatch.setattr(sources, "__path__", [*sources.__path__, str(tmp_path)])
    monkeypatch.setitem(sources.READERS, ".bars", "bars:read")
    monkeypatch.chdir(tmp_path)
    Path("dots.bars").write_text("0|0|0\n2|0|0\n0|3|0\n")
    cloud = load_scene("dots.bars").frame(1).cloud
    x, y, z = (cloud.positions - cloud.positions[0]).T
    assert y[2] / x[1] == pytest.approx(1.5) and x[1] > 0 and not z.any()
    video = generate("dots.bars", "video", slm=SLM("small", 96, 64, 32e-6), cgh="fresnel")
    assert video.numbers == [1] and video.read(1).std() > 0
    near = load_scene("dots.bars@220mm").frame(1)  # as with any format
    assert near.objects[0].depth == pytest.approx(0.22)


def test_columns_by_name_and_by_number(tmp_path: Path) -> None:
    (tmp_path / "named.csv").write_text(
        "phase;z;y;x;amplitude\n0.5;3;2;1;2\n0.6;3;2;2;4\n0.7;3;0;1;1\n"
    )
    scene = load_scene(str(tmp_path / "named.csv"))
    cloud = scene.frame(1).cloud
    assert cloud.amplitude.tolist() == [2, 4, 1]
    assert cloud.phase.tolist() == [0.5, 0.6, 0.7]
    # y is up in such files, and this project's y runs down.
    assert cloud.positions[2, 1] > cloud.positions[0, 1]
    (tmp_path / "plain.xyz").write_text("3\n0 0 0 255 255 255\n1 0 0 0 0 0\n0 1 1 188 188 188\n")
    cloud = load_scene(str(tmp_path / "plain.xyz")).frame(1).cloud
    assert cloud.intensity == pytest.approx([1, 0, 0.5], abs=0.01)


def test_a_ply_of_points(models: Path) -> None:
    cloud = PointCloud.from_file(models / "PLY" / "points.ply", fit=LC_R_1080)
    assert len(cloud) == 4
    assert np.ptp(cloud.positions, axis=0).max() == pytest.approx(
        box(LC_R_1080, 532e-9, 0.25)[1] / 2
    )


def test_a_ply_s_own_amplitudes_and_phases(tmp_path: Path) -> None:
    head = "ply\nformat {} 1.0\nelement vertex 2\n" + "".join(
        f"property float {name}\n" for name in ("x", "y", "z", "scalar_Intensity", "phase")
    )
    rows = np.array([[0, 0, 0, 4, 0.5], [1, 2, 3, 9, 0.6]], "<f4")
    text = "\n".join(" ".join(map(str, row)) for row in rows)
    (tmp_path / "a.ply").write_text(head.format("ascii") + f"end_header\n{text}\n")
    binary = head.format("binary_little_endian").encode() + b"end_header\n" + rows.tobytes()
    (tmp_path / "b.ply").write_bytes(binary)
    for name in "ab":
        cloud = PointCloud.from_file(tmp_path / f"{name}.ply")
        assert cloud.amplitude.tolist() == [2, 3] and cloud.phase == pytest.approx([0.5, 0.6])


def test_npz_and_positions_left_where_they_are(tmp_path: Path) -> None:
    positions = np.array([[0, 0, 0.2], [1e-3, 2e-3, 0.21]])
    np.savez(tmp_path / "c.npz", positions=positions, amplitude=[1, 2], phase=[0, 1])
    assert PointCloud.from_file(tmp_path / "c.npz").positions == pytest.approx(positions)
    np.savez(tmp_path / "d.npz", positions=positions, amplitude=[1, 2, 3])
    with pytest.raises(ValueError, match=r"d\.npz.*2 positions but 3"):
        load_scene(str(tmp_path / "d.npz"))


@pytest.mark.parametrize(
    ("text", "words"),
    [("", "no point"), ("1 2\n3 4\n", "2 columns"), ("x,y\n1,2\n", "x, y and z")],
)
def test_bad_clouds(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(ValueError, match=words):
        load_scene(str(tmp_path / "bad.csv"))


def test_lines_without_numbers_are_counted(tmp_path: Path) -> None:
    (tmp_path / "holes.csv").write_text("x,y,z\n0,0,0\nnan,1,1\n1,1,1\n1,,2\n")
    scene = load_scene(str(tmp_path / "holes.csv"))
    assert len(scene.frame(1).cloud) == 2
    assert any("2 lines" in note for note in scene.notes)
