"""What plans expect of published video methods, against what they do."""

from typing import Any

import numpy as np
import pytest
import scipy.fft

import chrmc
from chrmc.cgh.counts import STATED
from chrmc.compensation import COUNTED_WHOLE
from chrmc.compensation.ch_rmc_paper.cost import cost as paper_cost
from chrmc.compensation.nlut.cost import cost as nlut_cost
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


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
@pytest.mark.parametrize("name", [n for n in COUNTED_WHOLE if n.endswith("nlut")])
def test_nlut_videos_look_up_what_was_counted(name: str, scene: chrmc.PointScene) -> None:
    coding, numbers = coding_for("ssb", PANEL), range(1, 9)
    found = nlut_cost(name, scene, numbers, PANEL, chrmc.WAVELENGTH, coding)
    assert found is not None
    frames = chrmc.video(scene, PANEL, cgh="nlut", compensation=name, coding=coding, frames=(1, 8))
    # Of all frames, whose fields are not made: no more is known of them beforehand.
    work = [frame.record.point_pixels for frame in frames]
    later = [n for k, n in enumerate(work) if k % found.serves]
    counted = found.later.lookups / found.key.lookups
    assert 0.5 < counted / (np.mean(later) / work[0]) < 2


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_ch_rmc_as_published_transforms_what_was_counted(
    scene: chrmc.PointScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[float] = []
    for name, axes in (("fft", 1), ("ifft", 1), ("fft2", 2), ("ifft2", 2)):
        own = getattr(scipy.fft, name)

        def counted(x: Any, *args: Any, own: Any = own, axes: int = axes, **more: Any) -> Any:
            out = own(x, *args, **more)
            length = out.shape[more.get("axis", -1)] if axes == 1 else np.prod(out.shape[-2:])
            done.append(out.size * float(np.log2(length)))
            return out

        monkeypatch.setattr(scipy.fft, name, counted)
    coding = coding_for("ssb", PANEL)
    found = paper_cost("ch-rmc-paper", scene, range(1, 4), PANEL, chrmc.WAVELENGTH, coding)
    assert found is not None
    sums = []
    for frame in chrmc.video(
        scene, PANEL, cgh="rt", compensation="ch-rmc-paper", coding=coding, frames=(1, 3)
    ):
        assert frame.field.any()
        sums.append(sum(done))
        done.clear()
    assert 0.5 < found.later.transforms / np.mean(sums[1:]) < 2


def test_a_body_that_turns_in_its_place_is_beyond_ch_rmc_as_published() -> None:
    scene = riding([0.0, 0.0, 0.25], [0.0, 0.0, 0.25], 5e-3)
    found = plan(scene, PANEL, tolerance=1e-3, frames=(1, FRAMES), rates=STATED)
    (choice,) = [c for c in found.choices if c.compensation == "ch-rmc-paper"]
    assert choice.error is not None and choice.error > 0.3
