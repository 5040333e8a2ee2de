"""The run along a scene that `chrmc bench rmc` plots, on a small panel."""

from pathlib import Path

import numpy as np
import pytest

from chrmc.bench.rmc import runs
from chrmc.cli.bench_rmc import draw
from chrmc.scene.path import arc_path, poses_along
from chrmc.scene.point_scene import PointScene
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM


def test_runs_with_and_without_keys(tmp_path: Path) -> None:
    slm = SLM("panel", 420, 90, 8.1e-6)
    rng = np.random.default_rng(0)
    positions, headings, _ = arc_path(0.0, 1.5e-3, [(0.015, 7)])
    poses = poses_along(positions + np.array([1e-4, 0.25]), headings, 0.0)
    body = PointCloud(
        rng.uniform(-1, 1, (15, 3)) * [2e-4, 1e-4, 1e-4], np.ones(15), rng.uniform(0, 6, 15)
    )
    scene = PointScene("arc", {"car": body}, {"car": poses})
    free, keyed = runs([scene], slm, cgh="rt", rekey={"rekey_every": 3}, radius=0.24)
    assert free.keys == [1] and keyed.keys == [1, 4, 7]
    assert keyed.label == "key every 3 frames"
    assert free.errors[0] == 0 and free.errors[-1] > 0
    assert max(keyed.errors) < max(free.errors)
    summary = free.summary()
    assert summary["error_worst"] == max(free.errors)
    assert summary["psnr_worst"] == min(free.measure("psnr")[1:])
    assert summary["points"] == pytest.approx(15 / 8)
    target = tmp_path / "plots" / "rmc.png"
    draw([free, keyed], target)
    assert target.read_bytes().startswith(b"\x89PNG")
    assert [p.name for p in target.parent.iterdir()] == ["rmc.png"]
