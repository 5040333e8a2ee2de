"""The demo, in colours: it needs the real panel, so it takes a while."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from chrmc.cli.main import main

SCENE = """
import numpy as np
from chrmc import PointCloud, PointScene, Pose
def scene():
    rng = np.random.default_rng(0)
    places = rng.uniform(-4e-4, 4e-4, (500, 3)) * (1, 1, 0.2)
    colour = np.tile([1.0, 0.4, 0.4], (500, 1))
    body = PointCloud(places, np.ones(500), rng.uniform(0, 6, 500), colour)
    return PointScene("patch", {"patch": body}, {"patch": [Pose(np.eye(3), [0, 0, 0.25])]})
"""


@pytest.mark.long
def test_a_demo_in_colours(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "patch.py").write_text(SCENE)
    out = tmp_path / "demo"
    words = ["demo", f"{tmp_path / 'patch.py'}:scene", "--wavelength", "638nm,532nm,450nm"]
    for made in ("3 made, 0 kept", "0 made, 3 kept"):
        with pytest.raises(SystemExit) as ended:
            main([*words, "--out", str(out)])
        told = capsys.readouterr().out
        assert ended.value.code == 0, told
        assert made in told and "3 frames in 3 flips" in told
    for laser in ("638 nm", "532 nm", "450 nm"):
        assert laser in told
    assert "450nm/frame_0001.tif" in (out / "flips.csv").read_text("utf-8")
    assert "450 nm" in (out / "summary.txt").read_text("utf-8")
    picture = np.asarray(Image.open(out / "montage.png").convert("RGB")).astype(int)
    assert (picture[..., 0] - picture[..., 1] > 40).mean() > 1e-3
