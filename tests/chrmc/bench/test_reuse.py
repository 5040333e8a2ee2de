"""The bench of reuse: its bodies, and that it measures what it says."""

from pathlib import Path

import numpy as np
import pytest

from chrmc import SLM, WAVELENGTH
from chrmc.bench import endurance
from chrmc.bench.endurance import Endured, crossing, endured
from chrmc.bench.kept import KeptRows
from chrmc.bench.reuse import Case, ellipsoid_scene, reuse
from chrmc.bench.rivals import corrected_signal
from chrmc.encoding import coding_for
from chrmc.reference import reference_samples

PANEL = SLM("a quarter of the paper's", 320, 200, 16e-6)
CASE = Case((8e-4, 4e-4, 5e-4), 400, 0.2, 0.5, 4)


def test_the_side_towards_the_hologram_is_seen_and_turns() -> None:
    scene = ellipsoid_scene(CASE)
    first, last = (scene.frame(n).objects[0] for n in (1, 4))
    assert abs(len(first.cloud) - 400) < 60
    assert first.cloud.positions[:, 2].max() <= 0.2 + 1e-9
    assert 0 < len(np.setxor1d(first.ids, last.ids)) < 40
    half = np.array(CASE.size) / 2
    np.testing.assert_allclose(np.linalg.norm(scene.bodies["body"].positions / half, axis=1), 1)


def test_both_ways_are_timed_and_checked() -> None:
    row = reuse(CASE, PANEL, WAVELENGTH, always=True)
    assert row.later > 0 and row.fresh > 0 and row.first > 0 and 0 < row.ratio < 100
    assert row.error <= 1e-3
    assert "what it would cost afresh" in row.how[0] and "sphere" in row.how[1]


@pytest.mark.parametrize(("terms", "error"), [(2, 6e-4), (3, 1e-5)])
def test_the_rivals_are_as_exact_as_they_are_said_to_be(terms: int, error: float) -> None:
    coding = coding_for("ssb", PANEL)
    cloud = ellipsoid_scene(CASE).frame(1).cloud
    signal = corrected_signal(cloud, PANEL, WAVELENGTH, coding, terms)
    rows, columns = np.random.default_rng(0).integers(0, (200, 320), (300, 2)).T
    truth = reference_samples(cloud, PANEL, WAVELENGTH, rows, columns, passband=coding.passband)
    truth *= np.exp(2j * np.pi * coding.carrier * PANEL.y(rows))
    assert np.linalg.norm(signal[rows, columns] - truth.real) <= error * np.linalg.norm(truth.real)


def test_bodies_that_cross_hide_one_another_and_are_looked_at_in_every_frame() -> None:
    scene = crossing(200, 4, bodies=3)
    assert len(scene.frame(2).objects) == 3
    *_, last = endured(scene, PANEL, WAVELENGTH, 1e-2)
    assert last.frames == 4 and 0 < last.error <= 1 and last.keys >= 1


def test_a_long_turn_that_was_stopped_goes_on_behind_its_last_group(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(endurance, "GROUP", 2)
    scene, path = endurance.spinning(200, 5), tmp_path / "turns.json"
    whole = list(endured(scene, PANEL, WAVELENGTH, 1e-2))
    kept = KeptRows(path, ["here"], Endured)
    assert kept.of("spin", 1e-2) is None
    kept.take(whole[1])  # stopped in frame 3
    before = KeptRows(path, ["here"], Endured).of("spin", 1e-2)
    assert before == whole[1] and before.frames == 2
    rest = list(endured(scene, PANEL, WAVELENGTH, 1e-2, before))
    assert [one.frames for one in rest] == [3, 4, 5]
    assert (rest[-1].error, rest[-1].keys) == (whole[-1].error, whole[-1].keys)
    with pytest.raises(ValueError, match="made with here, not elsewhere"):
        KeptRows(path, ["elsewhere"], Endured)
    again = KeptRows(path, ["elsewhere"], Endured, anew=True)
    assert again.of("spin", 1e-2) is None and path.exists()  # until there is a new row
    path.write_text("[]")
    with pytest.raises(ValueError, match="no record of a bench"):
        KeptRows(path, ["here"], Endured, anew=True)
    with pytest.raises(ValueError, match="no record of a bench"):
        KeptRows(path, ["here"], Endured)
