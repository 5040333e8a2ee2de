import numpy as np
import pytest
from PIL import Image

from chrmc import SLM, PointCloud, generate, load_scene
from chrmc.cli.main import main
from chrmc.metrics import ssim
from chrmc.optics.propagation import Patch
from reconstruct.animation import movies_there
from reconstruct.looks import compare_with_view, looks, rendered_view
from reconstruct.metrics import scale_to
from reconstruct.sequence import system_of

P, LAMBDA, Z = 8.1e-6, 532e-9, 0.05
SLM_ = SLM("small", 256, 224, P)
CODE = """
import numpy as np
from chrmc import PointCloud, PointScene, Pose


def scene():
    rng = np.random.default_rng(0)
    u = rng.uniform(-1, 1, (3000, 2))
    bright = np.where(np.floor(u[:, 0] * 3) % 2, 1.0, 0.3)
    places = np.column_stack([u * [4e-4, 3e-4], 0 * bright])
    body = PointCloud(places, bright, rng.uniform(0, 6, 3000))
    return PointScene("plate", {"plate": body}, {"plate": [Pose(np.eye(3), [0, 0, 0.05])] * 2})
"""


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    folder = tmp_path_factory.mktemp("looks")
    (folder / "my_scene.py").write_text(CODE)
    scene = load_scene(f"{folder / 'my_scene.py'}:scene")
    return generate(scene, folder / "video", slm=SLM_, wavelength=LAMBDA), scene, folder


def test_looks_tend_to_the_rendered_view(stored):
    video, scene, _ = stored
    system = system_of(video)
    inner = np.s_[72:152, 80:176]
    patch = Patch((0.0, 0.0), (80, 96), P)
    view = rendered_view(scene.frame(1).cloud, system, Z, patch)
    mean, found = np.zeros(SLM_.shape), []
    for count, frame in enumerate(looks(video, scene, 1, 24), 1):
        mean += system.image(frame, Z)
        if count in (1, 6, 24):
            shown = mean[inner] * scale_to(mean[inner], view)
            found.append(ssim(shown, view))
    assert found[0] < found[1] < found[2] and found[2] > 0.75
    (alike,) = compare_with_view(mean / 24, scene.frame(1), system, Z)
    assert alike.name == "plate" and alike.ssim == pytest.approx(found[2], abs=0.1)
    assert compare_with_view(mean, scene.frame(1), system, Z + 0.02) == []


def test_the_first_look_is_the_stored_frame_and_draws_repeat(stored):
    video, scene, _ = stored
    a, b = (list(looks(video, scene, 2, 3)) for _ in range(2))
    assert np.array_equal(a[0], video.read(2)) and not np.array_equal(a[0], a[1])
    assert all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))
    with pytest.raises(ValueError, match="looks"):
        list(looks(video, scene, 1, 0))


def test_speckle_falls_with_the_root_of_the_looks(stored):
    video, scene, _ = stored
    system = system_of(video)
    inner = np.s_[72:152, 80:176]
    view = rendered_view(scene.frame(1).cloud, system, Z, Patch((0.0, 0.0), (80, 96), P))
    images = [system.image(f, Z)[inner] for f in looks(video, scene, 1, 16)]

    def off(image):
        return np.linalg.norm(image * scale_to(image, view) - view)

    one = np.mean([off(i) for i in images])
    assert off(np.mean(images, axis=0)) < 0.5 * one


def test_a_points_view_is_its_diffraction_pattern():
    """A rectangular aperture: sinc², first zero λz/A off; all of the light is in it."""
    from reconstruct import FourF

    system = FourF(SLM_, LAMBDA)
    cloud = PointCloud([[0.0, 0.0, Z]], [2.0], [0.0])
    patch = Patch((0.0, 0.0), (1, 2001), 1e-6)
    line = rendered_view(cloud, system, Z, patch)[0]
    zero = LAMBDA * Z / (2 * Z * np.tan(np.arcsin(LAMBDA / (2 * P)))) * 1e6
    zero = max(zero, LAMBDA * Z / (SLM_.width * P) * 1e6)
    x = np.arange(-1000, 1001)
    assert np.allclose(line / line.max(), np.sinc(x / zero) ** 2, atol=2e-3)
    whole = rendered_view(cloud, system, Z, Patch((0.0, 0.0), (801, 801), 4e-6))
    assert whole.sum() == pytest.approx(4.0, rel=0.03)


def run(capsys, *arguments):
    with pytest.raises(SystemExit) as stop:
        main([str(a) for a in arguments])
    out = capsys.readouterr()
    return stop.value.code, out.out, out.err


def test_looks_and_movies_on_the_command_line(stored, capsys, tmp_path):
    video, _, folder = stored
    code, said, err = run(
        capsys, "reconstruct", video.folder, "--frame", 1, "--follow", "plate", "--looks", 4,
        "--scene", f"{folder / 'my_scene.py'}:scene", "--out", tmp_path / "a.png",
        "--rendered", tmp_path / "view.png",
    )  # fmt: skip
    assert code == 0 and "against the rendered view, 4 looks" in said, err
    shown, view = (np.asarray(Image.open(tmp_path / n), float) for n in ("a.png", "view.png"))
    assert np.corrcoef(shown.ravel(), view.ravel())[0, 1] > 0.85
    assert shown[view > 60].mean() == pytest.approx(view[view > 60].mean(), rel=0.3)
    code, _, err = run(
        capsys, "reconstruct", video.folder, "--movie", "x.gif", "--rendered", "v.png"
    )
    assert code == 2 and "--rendered goes with --looks" in err
    for suffix in (".gif", ".mp4") if movies_there() else (".gif",):
        movie = tmp_path / f"m{suffix}"
        code, said, err = run(capsys, "reconstruct", video.folder, "--movie", movie)
        assert code == 0 and "2 frames" in said and movie.stat().st_size > 500, err
    with Image.open(tmp_path / "m.gif") as picture:
        assert picture.n_frames >= 1
    code, _, err = run(capsys, "reconstruct", video.folder, "--movie", movie, "--all")
    assert code == 2 and "--movie" in err
    code, _, err = run(capsys, "reconstruct", video.folder, "--frame", 1, "--depth", "50mm")
    assert code == 2 and "--out" in err
