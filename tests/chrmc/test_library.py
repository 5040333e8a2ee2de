"""The library without the command line: a scene, a stored video, and what notebooks show."""

import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from threadpoolctl import threadpool_info

import chrmc
from chrmc.scene.path import rotation_y

PANEL = chrmc.SLM("small", 240, 160, 16e-6)
TURN = rotation_y(0.3)
FAST: dict[str, Any] = {"slm": PANEL, "cgh": "fresnel", "check_pixels": 16}


def moving_scene(count: int = 4, points: int = 30) -> chrmc.PointScene:
    rng = np.random.default_rng(5)
    body = chrmc.PointCloud(
        rng.uniform(-1e-4, 1e-4, (points, 3)), np.ones(points), rng.uniform(0, 6, points)
    )
    poses = [
        chrmc.Pose(rotation_y(0.01 * n).tolist(), [n * 2e-5, 0, 0.1])  # type: ignore[arg-type]
        for n in range(count)
    ]
    return chrmc.PointScene("mine", {"dots": body}, {"dots": poses})


def test_every_name_promised_is_there_and_importing_stays_light() -> None:
    assert len(chrmc.__all__) <= 30
    assert all(hasattr(chrmc, name) for name in chrmc.__all__)
    heavy = ["numpy", "OpenImageIO", "glfw", "moderngl", "matplotlib", "pandas", "click", "tqdm"]
    code = f"import sys, chrmc; print([m for m in {heavy} if m in sys.modules])"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout.strip() == "[]"


def test_a_scene_becomes_a_stored_video_that_is_opened_again(tmp_path: Path) -> None:
    video = chrmc.generate(moving_scene(), tmp_path / "v", frames=(2, 3), slm=PANEL, tolerance=1e-3)
    assert video.numbers == [2, 3]
    assert video.methods["auto"]["tolerance"] == 1e-3
    assert all(f["error_reference"] < 1e-3 for f in video.frames)
    again = chrmc.open_video(str(tmp_path / "v"))
    assert again == video
    assert again.read(3).shape == PANEL.shape
    whole = chrmc.generate(moving_scene(), tmp_path / "v", slm=PANEL, tolerance=1e-3)
    assert whole.numbers == [1, 2, 3, 4]
    assert whole.entry(2) == video.entry(2)


def test_python_and_the_command_line_have_one_set_of_defaults(tmp_path: Path) -> None:
    from click.testing import CliRunner

    from chrmc.cli.main import group

    panel = chrmc.SLM("240 × 150 SLM", 240, 150, 40e-6)
    made = chrmc.generate("car-house", tmp_path / "a", slm=panel, frames=(1, 1))
    arguments = ["generate", "car-house", "--out", str(tmp_path / "b"), "--frames", "1"]
    done = CliRunner().invoke(group, [*arguments, "--slm", "240x150:40e-6"], standalone_mode=False)
    assert done.exception is None
    other = chrmc.open_video(tmp_path / "b")
    assert (made.methods, made.encoding, made.scale) == (other.methods, other.encoding, other.scale)
    assert made.frames[0]["sha256"] == other.frames[0]["sha256"]


def test_a_function_is_a_method_and_the_manifest_names_it(tmp_path: Path) -> None:
    def paraxial(cloud, slm, wavelength, window, passband, *, strength=1.0):  # type: ignore[no-untyped-def]
        return strength * chrmc.compute_field(
            cloud, slm, wavelength, "fresnel", window=window, passband=passband
        )

    video = chrmc.generate(moving_scene(), tmp_path, slm=PANEL, cgh=paraxial, strength=2.0)
    assert video.methods["cgh"]["function"].endswith("paraxial")
    assert len(video.methods["cgh"]["sha256"]) == 64
    assert video.methods["options"] == {"strength": 2.0}
    assert "paraxial" in video._repr_html_()


def test_an_option_that_no_manifest_can_hold_leaves_nothing_behind(tmp_path: Path) -> None:
    def method(cloud, slm, wavelength, window, passband, *, thing=None):  # type: ignore[no-untyped-def]
        return np.zeros(window.shape, np.complex64)

    with pytest.raises(ValueError, match="option thing is <object"):
        chrmc.generate(moving_scene(), tmp_path / "v", slm=PANEL, cgh=method, thing=object())
    assert list(tmp_path.iterdir()) == []
    video = chrmc.generate(moving_scene(), tmp_path / "v", slm=PANEL, cgh=method, thing=np.inf)
    assert video.methods["options"] == {"thing": "inf"}


def test_another_video_is_refused_with_the_option_that_differs(tmp_path: Path) -> None:
    chrmc.generate(moving_scene(), tmp_path, slm=PANEL, frames=(1, 1), tolerance=1e-3)
    before = (tmp_path / "manifest.json").read_bytes()
    for change, words in (
        ({"tolerance": 1e-2}, "tolerance 0.001, not 0.01"),
        ({"wavelength": 6e-7}, "wavelength 532nm, not 600nm"),
        ({"response": chrmc.GreyResponse.from_gamma(1.8)}, "linear, not gamma:1.8"),
    ):
        with pytest.raises(ValueError, match=words) as caught:
            chrmc.generate(moving_scene(), tmp_path, **{"slm": PANEL, "tolerance": 1e-3} | change)
        assert len(str(caught.value)) < 350
    with pytest.raises(ValueError, match="the scene's points differ"):
        chrmc.generate(moving_scene(points=31), tmp_path, slm=PANEL, tolerance=1e-3)
    assert (tmp_path / "manifest.json").read_bytes() == before


@pytest.mark.parametrize("bad", [{"frames": (1, 500)}, {"tolerance": 5.0}, {"sharpness": 1}])
def test_force_with_a_bad_option_keeps_the_old_video(tmp_path: Path, bad: dict[str, Any]) -> None:
    chrmc.generate(moving_scene(), tmp_path, **FAST)
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}
    with pytest.raises(ValueError):
        chrmc.generate(moving_scene(), tmp_path, **{"slm": PANEL, "force": True} | bad)
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before


def test_force_replaces_the_video_and_nothing_else(tmp_path: Path) -> None:
    chrmc.generate(moving_scene(), tmp_path, **FAST)
    (tmp_path / "notes.txt").write_text("mine")
    video = chrmc.generate(
        moving_scene(), tmp_path, **FAST, frames=(1, 2), encoding="real", force=True
    )
    assert (video.encoding, video.numbers) == ("real", [1, 2])
    names = {p.name for p in tmp_path.iterdir()}
    assert names == {"manifest.json", "notes.txt", "frame_0001.tif", "frame_0002.tif"}


class Counted:
    """A scene written with the least that a scene needs, which counts what it is asked for."""

    name, form, object_names, wavelength, pixel_pitch = "counted", "points", ("dots",), None, 4e-5

    def __init__(self, frame_count: int) -> None:
        self.frame_count = frame_count
        self.asked: list[int] = []

    def frame(self, number: int) -> chrmc.SceneFrame:
        self.asked.append(number)
        cloud = chrmc.PointCloud([[1e-6 * number, 0, 0.1]], [1.0], [0.0])
        return chrmc.SceneFrame(number, (chrmc.ObjectFrame("dots", cloud),))


def test_a_scene_is_looked_at_once_and_hardly_again_on_resume(tmp_path: Path) -> None:
    scene: Any = Counted(80)
    chrmc.generate(scene, tmp_path, **FAST, frames=(1, 3))
    assert len(scene.asked) == 80 + 3
    scene.asked.clear()
    chrmc.generate(scene, tmp_path, **FAST, frames=(4, 5))
    assert len(scene.asked) == 16 + 2


def test_a_long_scene_is_looked_at_in_bounded_time(tmp_path: Path) -> None:
    scene: Any = Counted(50_000)
    chrmc.generate(scene, tmp_path, **FAST, frames=(7, 7))
    assert len(scene.asked) < 1020
    assert {1, 50_000} <= set(scene.asked)
    scene.asked.clear()
    chrmc.generate(scene, tmp_path, **FAST, frames=(8, 8))
    assert len(scene.asked) == 17


def test_what_is_no_scene_is_told_what_it_lacks(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="has no name, form"):
        chrmc.generate(object(), tmp_path / "v")  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("rotation", "words"),
    [
        (2 * np.eye(3), "no rotation"),
        (np.diag([1, 1, -1]), "mirrors"),
        (np.eye(3) + 1e-4, "no rotation"),
        (np.eye(2), r"\(3, 3\)"),
        ("turned", "real numbers"),
        (np.full((3, 3), np.nan), "NaN"),
    ],
)
def test_a_pose_that_is_no_rotation_is_refused(rotation: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        chrmc.Pose(rotation, [0, 0, 0])  # type: ignore[arg-type]


def test_poses_from_quaternions_and_vectors_turn_as_matrices_do() -> None:
    half = 0.15
    quaternion = 3 * np.array([0, np.sin(half), 0, np.cos(half)])
    for pose in (
        chrmc.Pose.from_quaternion(quaternion, [1, 2, 3]),
        chrmc.Pose.from_rotvec([0, 0.3, 0], [1, 2, 3]),
    ):
        np.testing.assert_allclose(pose.rotation, TURN, atol=1e-15)
        assert pose.translation.tolist() == [1, 2, 3]
    assert chrmc.Pose.from_rotvec([0, 0, 0]).rotation.tolist() == np.eye(3).tolist()
    np.testing.assert_allclose(
        chrmc.Pose.from_rotvec([np.pi, 0, 0]).rotation, np.diag([1, -1, -1]), atol=1e-15
    )
    with pytest.raises(ValueError, match="no rotation"):
        chrmc.Pose.from_quaternion([0, 0, 0, 0])


def test_representations_are_short(tmp_path: Path) -> None:
    scene = moving_scene()
    video = chrmc.generate(scene, tmp_path, **FAST)
    frame = next(chrmc.video(scene, PANEL, cgh="fresnel"))
    for thing in (scene, scene.frame(1), scene.bodies["dots"], scene.pose("dots", 1), video, frame,
                  chrmc.load_scene("car-house", form="rgbd"), chrmc.GreyResponse.linear(),
                  chrmc.show_field(frame.field)):  # fmt: skip
        assert len(repr(thing)) < 300, repr(thing)
    page = video._repr_html_()
    assert "mine" in page and "data:image/png;base64," in page
    assert chrmc.show_field(frame.field, PANEL)._repr_html_().count("data:image/png") == 2
    with pytest.raises(ValueError, match=r"\(H, W\)"):
        chrmc.show_field(np.zeros(5))


def test_threads_of_one_program_get_what_one_gets(tmp_path: Path) -> None:
    """Videos made, opened and encoded at once, and one that is refused while others are made."""
    import display

    scene = moving_scene()
    options: dict[str, Any] = FAST | {"cgh": "curved", "compensation": "ch-rmc-object"}
    threads = [pool["num_threads"] for pool in threadpool_info()]

    def made(name: str) -> list[bytes]:
        video = chrmc.generate(scene, tmp_path / name, **options)
        frames = chrmc.video(scene, PANEL, compensation="none", coding="ssb")
        levels = [display.encode(frame.field, PANEL) for frame in frames]
        read = [chrmc.open_video(tmp_path / name).read(n) for n in video.numbers]
        return [array.tobytes() for array in (*read, *levels)]

    def refused(name: str) -> None:
        with pytest.raises(RuntimeError, match="stops"):
            chrmc.generate(
                scene, tmp_path / name, **options | {"cgh": stops, "compensation": "none"}
            )

    def stops(*_: Any, **__: Any) -> Any:
        raise RuntimeError("stops")

    alone = made("alone")
    with ThreadPoolExecutor(4) as pool:
        others = [pool.submit(refused, f"refused{k}") for k in range(2)]
        for found in list(pool.map(made, ["a", "b", "c"])):
            assert found == alone
        assert all(other.result() is None for other in others)
    assert [pool["num_threads"] for pool in threadpool_info()] == threads


def test_a_field_is_exported_whole(tmp_path: Path) -> None:
    import OpenImageIO as oiio

    field = chrmc.compute_field(moving_scene().frame(1).cloud, PANEL, 532e-9, "fresnel")
    np.testing.assert_array_equal(np.load(chrmc.export_field(field, tmp_path / "a.npy")), field)
    path = chrmc.export_field(field, tmp_path / "a.exr", slm=PANEL, wavelength=532e-9)
    source = oiio.ImageInput.open(str(path))
    spec = source.spec()
    pixels = source.read_image(format="float")
    source.close()
    names = list(spec.channelnames)
    np.testing.assert_array_equal(
        pixels[..., names.index("real")] + 1j * pixels[..., names.index("imag")], field
    )
    assert float(spec.getattribute("wavelength")) == 532e-9
    with pytest.raises(ValueError, match=r"\.npy, \.exr"):
        chrmc.export_field(field, tmp_path / "a.mat")
    with pytest.raises(ValueError, match="complex"):
        chrmc.export_field(np.zeros((3, 3)), tmp_path / "b.npy")
    assert {p.name for p in tmp_path.iterdir()} == {"a.npy", "a.exr"}


def test_a_field_goes_into_hdf5_where_h5py_is(tmp_path: Path) -> None:
    field = np.array([[1 + 2j, 3]], np.complex64)
    try:
        import h5py
    except ImportError:
        with pytest.raises(ImportError, match="h5py"):
            chrmc.export_field(field, tmp_path / "a.h5")
        assert list(tmp_path.iterdir()) == []
        return
    chrmc.export_field(field, tmp_path / "a.h5", wavelength=5e-7)
    with h5py.File(tmp_path / "a.h5") as file:
        np.testing.assert_array_equal(file["field"][()], field)
        assert file["field"].attrs["wavelength"] == 5e-7


def test_records_become_a_table_where_pandas_is(tmp_path: Path) -> None:
    video = chrmc.generate(moving_scene(), tmp_path, **FAST)
    try:
        import pandas  # noqa: F401
    except ImportError:
        with pytest.raises(ImportError, match="pip install pandas"):
            video.to_dataframe()
        return
    table = video.to_dataframe()
    assert table.index.tolist() == [1, 2, 3, 4]
    assert table["depth dots"].between(0.0999, 0.1001).all()
    assert (table["seconds HC"] > 0).all()


def test_a_manifest_is_plain_json(tmp_path: Path) -> None:
    chrmc.generate(moving_scene(), tmp_path, **FAST)
    manifest = json.loads((tmp_path / "manifest.json").read_text())
    assert manifest["group"] == 1
    assert len(manifest["made_on"]) == 1
    assert manifest["made_on"][0]["numpy"] == np.__version__
    assert set(manifest["scene"]) >= {"name", "form", "fingerprint", "frame_count", "pixel_pitch"}


def test_a_video_is_played_and_checked_from_python(tmp_path: Path) -> None:
    import display
    import reconstruct

    panel = chrmc.SLM("quarter", 480, 300, 16e-6)
    scene = chrmc.load_scene("car-house")
    video = chrmc.generate(scene, tmp_path, slm=panel, frames=(1, 2), check_pixels=0)
    summary = display.play(video, headless=True, verify="frames", log=tmp_path / "flips.csv")
    assert summary.mismatches == 0
    assert (tmp_path / "flips.csv").read_text().count("\n") >= 2
    (verdict,) = reconstruct.check(tmp_path, [2], scene=scene, depth_tolerance=5e-3)
    assert {o.target.name for o in verdict.objects} == {"car", "house"}
    assert all(o.psnr is not None for o in verdict.objects)
    with pytest.raises(ValueError, match="no frame 9"):
        reconstruct.check(video, [9])
