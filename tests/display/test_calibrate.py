"""A simulated panel whose true response is known: the closed loop must find it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import chrmc
import display
from chrmc.cli.main import main
from chrmc.response_fit import SEED, fit_response
from chrmc.response_map import basis

PANEL = chrmc.SLM("small", 240, 160, 8.1e-6)
GREY = np.arange(256) / 255


def s_curve(grey: np.ndarray) -> np.ndarray:
    """Of a twisted nematic panel between polarisers: sin² of a retardance that bends, and leaks."""
    return 0.01 + 0.99 * np.sin(np.pi / 2 * grey**1.3 * (1.15 - 0.15 * grey)) ** 2


CURVES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "twisted": s_curve,
    "gamma 2.2": lambda g: 0.005 + g**2.2,
    "falling": lambda g: 1.02 - s_curve(g),
    "straight": lambda g: 0.02 + g,
}


def meter(
    screen: display.Screen, curve: Callable, noise: float, seed: int = 0
) -> Callable[[int], float]:
    """A power meter behind the panel: what is on the screen counts, not what was asked for."""
    rng = np.random.default_rng(seed)

    def power(grey: int) -> float:
        light = float(curve(screen.read()[..., 0] / 255).mean())
        return 3e-4 * (light + noise * rng.standard_normal())

    return power


@pytest.mark.parametrize("name", CURVES)
def test_the_true_response_is_found_to_one_per_cent(name: str) -> None:
    curve = CURVES[name]
    with display.Screen(headless=True, slm=chrmc.SLM("tiny", 16, 12, 8e-6)) as screen:
        fit = display.calibrate_response(screen, meter(screen, curve, 0.005), settle=0)
    truth = 3e-4 * curve(GREY)
    assert np.abs(fit.intensity - truth).max() < 0.01 * truth.max()
    assert (np.diff(fit.intensity) * (1 if truth[-1] > truth[0] else -1) >= 0).all()
    # The uncertainty is what it says: two deviations hold nearly everywhere.
    assert (np.abs(fit.intensity - truth) < 3 * fit.uncertainty + 1e-3 * truth.max()).mean() > 0.9
    assert 2e-4 < fit.uncertainty.mean() / truth.max() < 5e-3
    amplitude = np.abs(fit.response.levels)
    bright = truth > 0.05 * truth.max()
    true = np.sqrt(truth / truth.max())
    assert np.abs(amplitude - true)[bright].max() < 0.01


@settings(max_examples=8, deadline=None)
@given(st.floats(0.7, 3), st.floats(1e-9, 1e9), st.integers(0, 1000))
def test_any_gamma_unit_and_noise(gamma: float, unit: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    levels = np.repeat(np.arange(0, 256, 8), 3)
    readings = unit * ((levels / 255) ** gamma + 0.003 * rng.standard_normal(len(levels)))
    fit = fit_response(levels.tolist(), readings.tolist())
    assert np.abs(fit.intensity / unit - np.clip(GREY, 0, 248 / 255) ** gamma)[:249].max() < 0.015


def vignetted(grey: np.ndarray) -> np.ndarray:
    """(…, H, W) intensity of a panel under a beam that falls off, the bright end bent more."""
    y, x = (np.linspace(-1, 1, n) for n in PANEL.shape)
    terms = basis(y, x, 2)
    shape = 1 + np.tensordot([0.08, -0.05, -0.15, 0.04, -0.1], terms, axes=1)
    g = np.asarray(grey) / 255
    return s_curve(g) * shape + 0.05 * g * (1 - g) * terms[0]


def as_shown(levels: np.ndarray) -> np.ndarray:
    """Amplitude that the vignetted panel puts on the wave."""
    return np.sqrt(vignetted(levels.astype(float)))


def test_a_map_over_the_panel_takes_its_error_away(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)

    def camera(grey: int) -> np.ndarray:
        picture = vignetted(np.full(PANEL.shape, float(grey)))[::4, ::4]
        return picture + 0.01 * rng.standard_normal(picture.shape)

    with display.Screen(headless=True, slm=PANEL) as screen:
        mapped = display.calibrate_response(screen, camera, settle=0, repeats=2, degree=2)
    again = chrmc.GreyResponse.from_csv(mapped.write(tmp_path / "map.csv"))
    flat = chrmc.GreyResponse(again.levels)
    wanted = np.random.default_rng(6).uniform(0, 1, PANEL.shape).astype(np.float32)

    def error(response: chrmc.GreyResponse) -> float:
        shown = as_shown(response.grey(wanted))
        design = np.stack([np.ones(wanted.size), wanted.ravel()], axis=1)
        rest = shown.ravel() - design @ np.linalg.lstsq(design, shown.ravel(), rcond=None)[0]
        return float(np.std(rest) / np.std(shown))

    assert error(flat) > 0.08
    assert error(again) < 0.01
    assert np.abs(again.amplitude(again.grey(wanted)) * np.sqrt(mapped.intensity.max())
                  - as_shown(again.grey(wanted)))  .max() < 0.015  # fmt: skip
    kept = chrmc.GreyResponse.from_dict(again.as_dict())
    assert np.array_equal(kept.tilt, again.tilt)


def test_a_mapped_response_makes_holograms(tmp_path: Path) -> None:
    """Through --response, the encoding and the 4-f system: the true panel shows the field."""
    from reconstruct import FourF

    levels = np.arange(0, 256, 15).tolist()
    fit = fit_response(levels, [vignetted(np.full(PANEL.shape, float(g))) for g in levels], 2)
    path = fit.write(tmp_path / "map.csv")
    dots = chrmc.PointCloud([[0, 0, 0.02], [2e-4, 1e-4, 0.021]], [1.0, 1.0], [0.0, 1.0])
    band = chrmc.coding_for("ssb", PANEL).passband
    field = chrmc.compute_field(dots, PANEL, 532e-9, passband=band, tolerance=1e-4)

    ideal = FourF(PANEL, 532e-9, scale=120.0).field(display.encode(field, PANEL, scale=120.0))

    def error(response: chrmc.GreyResponse) -> float:
        frame = display.encode(field, PANEL, scale=120.0, response=response)

        class Panel(chrmc.GreyResponse):
            def amplitude(self, frame: np.ndarray) -> np.ndarray:
                return as_shown(frame).astype(np.float32)

        true = Panel(response.levels)
        found = FourF(PANEL, 532e-9, response=true, scale=120.0).field(frame)
        factor = np.vdot(ideal, found) / np.vdot(ideal, ideal)
        return float(np.linalg.norm(found - factor * ideal) / np.linalg.norm(factor * ideal))

    mapped = chrmc.GreyResponse.from_csv(path)
    flat = chrmc.GreyResponse(mapped.levels)
    print(f"field error: one curve {error(flat):.3f}, map {error(mapped):.3f}")
    assert error(mapped) < 0.4 * error(flat)


def test_a_camera_sees_the_panel(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """OpenCV plays a recording of the bench in place of a live camera: the panel beside dark walls,
    each level for the pictures that are thrown away, being older than the flip, and those kept."""
    cv2 = pytest.importorskip("cv2")
    levels = np.rint(np.linspace(0, 255, 9)).astype(int)
    rng = np.random.default_rng(SEED)
    shown = np.concatenate([rng.permutation(levels) for _ in range(2)])
    noise, before, count = np.random.default_rng(9), 0, 0
    for grey in shown:
        for seen in [before] * 4 + [grey] * 4:
            picture = np.full((40, 60, 3), 12.0)
            fall = 1 - 0.1 * np.linspace(-1, 1, 24)[None, :, None]
            picture[8:24, 20:44] = 200 * s_curve(np.array(seen / 255)) * fall
            picture += noise.normal(0, 1.5, picture.shape)
            name = str(tmp_path / f"bench_{count:04d}.png")
            assert cv2.imwrite(name, np.clip(np.rint(picture), 0, 255).astype(np.uint8))
            count += 1
        before = grey
    out = tmp_path / "response.csv"
    command = ["calibrate-response", "--headless", "--slm", "16x12:8um", "--settle", "0"]
    command += ["--camera", str(tmp_path / "bench_%04d.png"), "--steps", "9", "--repeats", "2"]
    command += ["--region", "20,8,24,16", "--map", "1", "--wavelength", "532nm"]

    def run(*more: str) -> int:
        with pytest.raises(SystemExit) as ended:
            main([*command, *more])
        return int(ended.value.code or 0)

    assert run("--out", str(out)) == 0
    found = chrmc.GreyResponse.from_csv(out)
    true = s_curve(GREY)
    assert np.abs(np.abs(found.levels) ** 2 - true / true.max()).max() < 0.02
    assert found.wavelength == pytest.approx(532e-9) and found.tilt is not None
    x, y = found.tilt[255] * np.abs(found.levels[255]) ** 2
    assert x == pytest.approx(-0.1, abs=0.01) and y == pytest.approx(0, abs=0.01)
    assert run("--out", str(out), "--repeats", "3") == 2
    assert "gave no picture" in capsys.readouterr().err
    assert run("--out", str(out), "--region", "50,8,24,16") == 2
    assert "reaches beyond" in capsys.readouterr().err


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "meter.py").write_text(
        "import numpy as np\n"
        "rng = np.random.default_rng(1)\n"
        "def power(grey):\n"
        "    return 5 * (grey / 255) ** 2 + 0.1 + 0.01 * rng.standard_normal()\n"
        "def broken(grey):\n"
        "    return 'bright'\n"
    )

    def run(*words: object) -> int:
        with pytest.raises(SystemExit) as ended:
            main(["calibrate-response", *(str(word) for word in words)])
        return int(ended.value.code or 0)

    out, plot = tmp_path / "response.csv", tmp_path / "response.png"
    shown = ("--headless", "--slm", "16x12:8um", "--settle", 0, "--out", out)
    assert run(*shown, "--measure", f"{tmp_path}/meter.py:power", "--plot", plot) == 0
    assert "132 readings" in capsys.readouterr().out and plot.stat().st_size > 10_000
    response = chrmc.GreyResponse.from_csv(out)
    assert np.abs(response.levels[128]) ** 2 == pytest.approx((5 * 0.252 + 0.1) / 5.1, abs=0.01)
    # Readings from elsewhere, in any order.
    rows = [f"{g},{5 * (g / 255) ** 2 + 0.1}" for g in (255, 0, 32, 200, 96, 64, 128, 160, 230)]
    (tmp_path / "readings.csv").write_text("grey,power\n" + "\n".join(rows) + "\n")
    assert run("--csv", tmp_path / "readings.csv", "--out", out) == 0
    capsys.readouterr()
    for words, said in (
        (("--out", out), "say where the light comes from"),
        ((*shown, "--measure", f"{tmp_path}/meter.py:broken"), "no number or picture"),
        ((*shown, "--measure", f"{tmp_path}/meter.py:power", "--map", 1), "needs pictures"),
        ((*shown, "--camera", 77), "camera"),
        (("--csv", tmp_path / "readings.csv", "--out", "x.txt"), "written as .csv"),
    ):
        assert run(*words) == 2
        assert said in capsys.readouterr().err
    with pytest.raises(ValueError, match="all readings are alike"):
        fit_response([0, 60, 120, 180, 255], [1.0] * 5)
    with pytest.raises(ValueError, match="too few"):
        fit_response([0, 255], [0.0, 1.0])


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "light",
    [
        lambda grey: -grey,
        lambda grey: 1e300 * (grey + 1),
        lambda grey: 1e-310 * (grey + 1),
        lambda grey: np.full((4, 4), 1e300 * (grey + 1)),
        lambda grey: np.zeros((0, 4)),
        lambda grey: np.where(np.arange(16).reshape(4, 4) == 3, np.nan, grey + 1.0),
    ],
)
def test_light_that_no_meter_gives_is_refused_in_one_line(light: Any) -> None:
    grey = list(range(0, 256, 15)) * 2
    with pytest.raises(ValueError, match="reading") as raised:
        fit_response(grey, [light(g) for g in grey])
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    "asked",
    [{"steps": 9.5}, {"steps": "9"}, {"repeats": 10**12}, {"repeats": None}, {"settle": "x"},
     {"settle": float("nan")}, {"degree": "1"}, {"wavelength": "red"}, {"wavelength": 638}],
    ids=str,
)  # fmt: skip
def test_what_cannot_be_measured_is_refused_before_it_is_shown(asked: dict[str, Any]) -> None:
    shown: list[int] = []
    with (
        display.Screen(headless=True, slm=PANEL) as screen,
        pytest.raises(ValueError, match=next(iter(asked))),
    ):
        display.calibrate_response(screen, shown.append, **{"settle": 0, **asked})
    assert not shown
