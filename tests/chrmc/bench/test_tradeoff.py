"""The trade-off table: real measurements of a small scene, and what is derived from them."""

import csv
import io
from pathlib import Path

import numpy as np
import pytest

from chrmc import SLM, WAVELENGTH, load_scene
from chrmc.bench import speed, tradeoff
from chrmc.cgh import METHODS
from chrmc.cli.main import main
from chrmc.coding import coding_for
from chrmc.footprint import reach, taper
from chrmc.video import COMPENSATIONS

PANEL = SLM("small", 320, 200, 40e-6)


def test_every_cgh_method_and_setting_is_timed_and_measured() -> None:
    clouds = tradeoff.synthetic(30, PANEL, 2)
    coding = coding_for("real", PANEL)
    entries = tradeoff.cgh_entries("thirty", clouds, PANEL, WAVELENGTH, coding)
    assert {e.method for e in entries} == set(METHODS)
    done = [e for e in entries if not e.refused]
    assert all(len(e.seconds) == len(e.errors) == 2 and min(e.seconds) > 0 for e in done)
    by_label = {e.label: e for e in done}
    for tolerance in tradeoff.TOLERANCES:
        entry = by_label[f"curved tolerance {tolerance:g}"]
        assert entry.error <= tolerance
        if entry.predicted is not None:
            assert entry.predicted <= tolerance
    assert by_label["rt"].error < 1e-5


def test_every_video_method_is_measured() -> None:
    scene = load_scene("car-house")
    coding = coding_for("real", PANEL)
    entries = tradeoff.video_entries(scene, PANEL, WAVELENGTH, coding, range(1, 2))
    assert {e.method for e in entries} == set(COMPENSATIONS)
    exact = [e for e in entries if "object, tolerance 1e-05" in e.setting]
    assert len(exact) == 1 and exact[0].error <= 1e-5
    assert all(len(e.seconds) == 1 for e in entries if not e.refused)


def test_the_front_holds_what_nothing_beats_in_both() -> None:
    def entry(seconds: float, error: float, scene: str = "a") -> tradeoff.Entry:
        return tradeoff.Entry(scene, "cgh", "m", "", 1, [seconds], [error])

    entries = [entry(1, 1e-1), entry(2, 1e-2), entry(3, 5e-2), entry(2.5, 1e-2), entry(9, 1, "b")]
    entries.append(tradeoff.Entry("a", "cgh", "m", "", 1, refused="left out"))
    tradeoff.mark_front(entries)
    assert [e.front for e in entries] == [True, True, False, False, True, False]


def test_slow_methods_are_left_out_with_the_time() -> None:
    clouds = tradeoff.synthetic(400, PANEL, 1)
    coding = coding_for("real", PANEL)
    entries = tradeoff.cgh_entries("many", clouds, PANEL, WAVELENGTH, coding, limit=1e-9)
    rt = next(e for e in entries if e.method == "rt")
    assert rt.refused.startswith("left out: about") and not rt.seconds
    assert all(e.seconds for e in entries if e.method == "curved")


def test_the_rival_is_the_fresnel_field_on_the_carrier() -> None:
    cloud = speed.surface_cloud(20, PANEL)
    coding = coding_for("ssb", PANEL)
    got = speed.fresnel_signal(cloud, PANEL, WAVELENGTH, coding)
    x, y = PANEL.x(), PANEL.y()[:, None]
    exact = np.zeros(PANEL.shape, dtype=complex)
    limits = [reach(WAVELENGTH, f) for f in (coding.passband.fx_max, coding.passband.fy_max)]
    for (px, py, pz), a, phase in zip(cloud.positions, cloud.amplitude, cloud.phase, strict=True):
        path = pz + ((x - px) ** 2 + (y - py) ** 2) / (2 * pz)
        weight = taper(x - px, pz * limits[0]) * taper(y - py, pz * limits[1])
        exact += weight * a / pz * np.exp(1j * (2 * np.pi / WAVELENGTH * path + phase))
    signal = (exact * np.exp(2j * np.pi * coding.carrier * y)).real
    assert np.linalg.norm(got - signal) < 1e-4 * np.linalg.norm(signal)


def test_command_writes_table_and_plot(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "table"
    with pytest.raises(SystemExit) as stop:
        main(["bench", "tradeoff", "--points", "10", "--rounds", "1", "--frames", "1", "--limit",
              "1", "--slm", "320x200:40e-6", "--encoding", "real", "--out", str(out)])  # fmt: skip
    assert stop.value.code == 0, capsys.readouterr().err
    text = (out / "tradeoff.csv").read_text(encoding="utf-8")
    assert text.startswith("# ") and "cores" in text.splitlines()[0]
    rows = list(csv.DictReader(io.StringIO(text.split("\n", 1)[1])))
    assert {row["scene"] for row in rows} == {"car-house", "1 point", "10 points"}
    assert any(row["front"] == "1" for row in rows)
    assert any(row["psnr_db"] for row in rows)
    assert (out / "tradeoff.png").read_bytes()[:4] == b"\x89PNG"
