"""What plans expect of published video methods, against what they do."""

import numpy as np
import pytest

import chrmc
from chrmc.cgh.counts import STATED
from chrmc.compensation import COUNTED_WHOLE
from chrmc.encoding import coding_for
from chrmc.planning.choices import plan
from chrmc.reference import reference_samples, relative_error

PANEL = chrmc.SLM("small", 480, 320, 24.3e-6)
FRAMES = 4


def riding(start: list[float], centre: list[float], turn: float) -> chrmc.PointScene:
    """A body on an arc about a vertical axis through `centre`, and one that stands still."""
    random = np.random.default_rng(1)
    body, still = (
        chrmc.PointCloud(
            random.uniform(-0.5, 0.5, (count, 3)) * [1.5e-3, 6e-4, 6e-4],
            random.uniform(0.5, 1, count),
            random.uniform(0, 6.28, count),
        )
        for count in (40, 20)
    )
    away = np.subtract(start, centre)
    poses = []
    for angle in turn * np.arange(24):
        turned = chrmc.Pose.from_rotvec([0.0, angle, 0.0])
        poses.append(chrmc.Pose(turned.rotation, turned.rotation @ away + centre))
    there = chrmc.Pose.from_rotvec([0.0, 0.3, 0.0], [1e-3, -1e-3, 0.27])
    return chrmc.PointScene(
        "riding", {"body": body, "still": still}, {"body": poses, "still": [there]}
    )


SCENES = {
    "behind": riding([-1e-3, 5e-4, 0.25], [-2e-3, 0.0, 0.266], 5e-3),
    "before": riding([2e-3, -5e-4, 0.23], [-4e-3, 0.0, 0.2], -4e-3),
}


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
@pytest.mark.parametrize("name", COUNTED_WHOLE)
def test_errors_within_a_factor_of_three(name: str, scene: chrmc.PointScene) -> None:
    found = plan(scene, PANEL, tolerance=1e-3, frames=(1, FRAMES), rates=STATED)
    (choice,) = [c for c in found.choices if c.compensation == name]
    coding = coding_for("ssb", PANEL)
    squares = []
    for frame in chrmc.video(
        scene, PANEL, cgh=choice.cgh, compensation=name, coding=coding, frames=(1, FRAMES)
    ):
        rows, columns = np.random.default_rng(1).integers(0, [[320], [480]], (2, 600))
        truth = reference_samples(
            frame.shown, PANEL, 532e-9, rows, columns, passband=coding.passband
        )
        squares.append(relative_error(frame.field[rows, columns], truth) ** 2)
    assert choice.error is not None
    assert 1 / 3 < choice.error / np.sqrt(np.mean(squares[1:])) < 3
    assert choice.key > 0 and choice.mean > 0
