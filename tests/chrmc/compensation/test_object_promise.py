"""A factor is shown only where expectation and a look at its pixels agree that it is right."""

import numpy as np
import pytest

from chrmc import SLM, WAVELENGTH, PointCloud, Pose, video
from chrmc.cgh.curved.interface import Budget, field_of, low_rank, plane_of
from chrmc.compensation.ch_rmc_object.promise import Promise
from chrmc.encoding import coding_for
from chrmc.optics.passband import full_band
from chrmc.reference import reference_field, relative_error
from chrmc.scene.point_scene import PointScene
from chrmc.window import Window

PANEL = SLM("small", 240, 160, 16e-6)


def points(count: int, seed: int = 1) -> PointCloud:
    random = np.random.default_rng(seed)
    positions = (random.random((count, 3)) - 0.5) * 5e-4 + np.array([0, 0, 0.2])
    return PointCloud(positions, np.ones(count), random.uniform(0, 6.3, count))


@pytest.mark.parametrize(
    ("count", "frames", "looked"),
    [(60, None, True), (60, 3, True), (5001, None, True), (5001, 3, False), (5001, 8, True)],
)
def test_a_wrong_factor_is_refused_when_it_is_looked_at(
    count: int, frames: int | None, looked: bool
) -> None:
    window, band = Window.full(PANEL), full_band(PANEL)
    cloud = points(count)
    low = low_rank(cloud, PANEL, WAVELENGTH, window, band)
    (factor,) = low.factors
    plane = plane_of(PANEL, WAVELENGTH, window, band)
    promise = Promise(plane, 1e-3)
    assert promise.kept(factor, cloud, low.budget, frames)
    assert not promise.kept(
        factor, cloud, Budget(2e-6 * low.budget.light, low.budget.light), frames
    )
    for part in (factor.real, factor.imag):
        part *= np.float32(1.003)
    assert promise.kept(factor, cloud, low.budget, frames) == (not looked)
    assert Promise(plane, 1e-2).kept(factor, cloud, low.budget, frames)


def test_objects_that_cancel_are_looked_at_together() -> None:
    window, band = Window.full(PANEL), full_band(PANEL)
    one = points(60)
    other = PointCloud(one.positions, 0.99 * one.amplitude, one.phase + np.pi)
    made = [low_rank(cloud, PANEL, WAVELENGTH, window, band) for cloud in (one, other)]
    both = PointCloud.concatenate([one, other])
    plane = plane_of(PANEL, WAVELENGTH, window, band)
    promise = Promise(plane, 1e-3)
    total = made[0].budget + made[1].budget
    factors = [low.factors[0] for low in made]
    for part in (factors[1].real, factors[1].imag):
        part *= np.float32(1.0005)  # little of each, much of what they leave
    expected = promise.together(factors, both, total)
    truth = reference_field(both, PANEL, WAVELENGTH)
    made_together = field_of(factors, PANEL, WAVELENGTH, window)
    assert expected > 1e-3
    assert 0.5 < expected / relative_error(made_together, truth) < 2
    apart = [
        made[0].factors[0],
        low_rank(points(60, 2), PANEL, WAVELENGTH, window, band).factors[0],
    ]
    united = PointCloud.concatenate([one, points(60, 2)])
    assert promise.together(apart, united, total) == pytest.approx(total.relative, rel=0.3)


@pytest.mark.parametrize("left", [1e-4, 1e-7])
def test_bodies_that_all_but_cancel_are_shown(left: float) -> None:
    """What the low-rank form cannot hold, the exact sum does; frames before and after are looked up
    as ever."""
    one = points(40)
    body = PointCloud(one.positions - (0, 0, 0.2), one.amplitude, one.phase)
    other = PointCloud(body.positions, (1 - left) * body.amplitude, body.phase + np.pi)
    poses = [Pose.from_rotvec([0, 1e-3 * k, 0], [0, 0, 0.2]) for k in range(4)]
    seen = {"other": [np.full(40, k in (1, 3)) for k in range(4)]}
    scene = PointScene(
        "cancel", {"body": body, "other": other}, {"body": poses, "other": poses}, seen
    )
    made = video(scene, PANEL, WAVELENGTH, compensation="ch-rmc-object", tolerance=1e-3)
    carrier = np.exp(2j * np.pi * coding_for("real", PANEL).carrier * PANEL.y())[:, None]
    for number, frame in enumerate(made):
        truth = reference_field(frame.cloud, PANEL, WAVELENGTH)
        assert relative_error(frame.field, truth) <= 1e-3
        assert relative_error(frame.signal, (truth * carrier).real) <= 1.5e-3
        exact = frame.record.reuse.get("other", "") == frame.record.reuse["body"] != ""
        assert exact == (number in (1, 3)), frame.record.reuse


def test_what_double_precision_cannot_hold_is_refused_when_it_is_asked_for() -> None:
    one = points(40)
    other = PointCloud(one.positions, one.amplitude, one.phase + np.pi * (1 + 1e-15))
    still = [Pose(np.eye(3), np.zeros(3))]
    scene = PointScene("dark", {"one": one, "other": other}, {"one": still, "other": still})
    (frame,) = video(scene, PANEL, WAVELENGTH, compensation="ch-rmc-object", tolerance=1e-3)
    for part in ("field", "signal"):
        with pytest.raises(ValueError, match="waves all but cancel"):
            getattr(frame, part)
