"""Pictures and text as scenes."""

from pathlib import Path

import numpy as np
import pytest

from chrmc import LC_R_1080, load_scene
from chrmc.scene.sources.volume import box

from .making import write_picture


def test_a_picture_stands_upright_at_its_depth(tmp_path: Path) -> None:
    samples = np.zeros((60, 90, 3), np.uint8)
    samples[:20, :30] = 255  # top left
    samples[-10:, -10:] = 188  # half the light, bottom right
    write_picture(tmp_path / "a.png", samples)
    scene = load_scene([f"{tmp_path / 'a.png'}@0.22", "text:F@0.28"], points=20_000)
    assert scene.object_names == ("a", "F")
    first, second = (o.cloud for o in scene.frame(1).objects)
    assert first.positions[:, 2] == pytest.approx(0.22)
    assert second.positions[:, 2] == pytest.approx(0.28)
    width, height = box(LC_R_1080, 532e-9, 0.22)
    assert first.positions[:, 0].min() == pytest.approx(-min(width, 1.5 * height) / 2, rel=0.02)
    left = first.positions[:, 0] < 0
    assert first.positions[left, 1].max() < 0 < first.positions[~left, 1].min()
    assert np.median(first.intensity[~left]) / np.median(first.intensity[left]) == pytest.approx(
        0.5, abs=0.02
    )
    # An F has its weight at the top and on the left.
    x, y = second.positions[:, 0], second.positions[:, 1]
    assert x.mean() < (x.min() + x.max()) / 2 and y.mean() < (y.min() + y.max()) / 2


def test_words_that_mean_nothing(tmp_path: Path) -> None:
    write_picture(tmp_path / "dark.png", np.zeros((4, 4, 3), np.uint8))
    for words, told in (
        (f"{tmp_path / 'dark.png'}", "black"),
        (f"{tmp_path / 'dark.png'}@near", "no depth"),
        (f"{tmp_path / 'dark.png'}@220000", "no depth"),
        ("text:", "says nothing"),
    ):
        with pytest.raises(ValueError, match=told):
            load_scene(words)
