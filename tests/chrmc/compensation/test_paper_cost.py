"""What the published method is expected to take and to miss, against what single points show."""

import numpy as np
import pytest

import chrmc
from chrmc.compensation.ch_rmc_paper.carry import Rotation, carry, moved
from chrmc.compensation.ch_rmc_paper.conversion import RADIUS
from chrmc.compensation.ch_rmc_paper.cost import _step, cost
from chrmc.compensation.ch_rmc_paper.cylinder import turned
from chrmc.encoding import coding_for
from chrmc.record import FrameRecord
from chrmc.reference import relative_error
from chrmc.scene.point_scene import PointScene
from chrmc.scene.scene import Pose
from chrmc.slm import SLM, WAVELENGTH

PANEL = SLM("panel", 480, 320, 16.2e-6)


def on_an_arc(
    place: tuple[float, float, float], centre: tuple[float, float], angle: float
) -> PointScene:
    """One point on an arc about the vertical axis through `centre`."""
    middle = np.array([centre[0], 0.0, centre[1]])
    away = np.array(place) - middle
    poses = []
    for number in range(24):
        turned = Pose.from_rotvec([0.0, number * angle, 0.0])
        poses.append(Pose(turned.rotation, turned.rotation @ away + middle))
    point = chrmc.PointCloud(np.zeros((1, 3)), np.ones(1), np.zeros(1))
    return PointScene("point", {"point": point}, {"point": poses})


@pytest.mark.parametrize(
    ("place", "centre", "angle", "last"),
    [
        ((0.0, 8e-4, 0.25), (-15e-3, 0.25), 2e-3, 2),  # two frames alone tell no arc
        ((2e-3, -1.5e-3, 0.23), (-4e-3, 0.2), -4e-3, 4),
    ],
)
def test_frames_are_as_wrong_as_expected(
    place: tuple[float, float, float], centre: tuple[float, float], angle: float, last: int
) -> None:
    scene, coding = on_an_arc(place, centre, angle), coding_for("ssb", PANEL)
    found = cost("ch-rmc-paper", scene, range(1, last + 1), PANEL, WAVELENGTH, coding)
    assert found is not None
    squares = []
    for frame in chrmc.video(
        scene, PANEL, cgh="rt", compensation="ch-rmc-paper", coding="ssb", frames=(1, last)
    ):
        cloud = scene.frame(frame.number).cloud
        truth = chrmc.compute_field(cloud, PANEL, WAVELENGTH, "rt", passband=coding.passband)
        squares.append(relative_error(frame.field, truth) ** 2)
    assert found.carried == pytest.approx(np.sqrt(np.mean(squares[1:])), rel=0.2)


@pytest.mark.parametrize(
    ("place", "centre", "angle"),
    [
        ((3e-4, -6e-4, 0.25), (-2e-2, 0.25), 1e-3),
        ((-5e-4, 5e-4, 0.23), (1.5e-2, 0.26), -2e-3),
        ((0.0, 8e-4, 0.2), (2e-2, 0.17), 2e-3),
    ],
)
def test_a_step_followed_along_rays_is_wrong_where_the_chain_is(
    place: tuple[float, float, float], centre: tuple[float, float], angle: float
) -> None:
    """To a few milliradians, pixel by pixel, of a point that is not its object's middle."""
    slm = SLM("fine", 480, 400, 8.1e-6)
    passband = coding_for("real", slm).passband
    point, motion = chrmc.PointCloud([place], [1.0], [0.0]), Rotation(centre, angle)
    middle = np.add(place, [2e-4, 1e-4, -3e-4])
    field, truth = (
        chrmc.compute_field(cloud, slm, WAVELENGTH, "rt", passband=passband)
        for cloud in (point, moved(point, motion))
    )
    carried, _ = carry(field, middle, motion, slm, WAVELENGTH, RADIUS, FrameRecord(1))
    row, column = (places.ravel() for places in np.mgrid[120:280:16, 180:300:12])
    x, y = slm.x(column)[None], slm.y(row)[None]
    lost, x_was, y_was = _step(point.positions, middle, x, y, motion, slm, WAVELENGTH)
    off = np.angle(carried[row, column] * truth[row, column].conj())
    assert np.ptp(off) > 0.05
    assert np.abs(off - lost[0]).max() < 0.01
    # The same ray turned back, on to the panel.
    back = turned(np.stack([x[0], y[0], 0 * x[0]], axis=1), centre, -angle)
    along = place[2] / (place[2] - back[:, 2:])
    there = np.array(place) + (back - place) * along
    assert np.abs(there[:, 0] - x_was[0]).max() < 0.1 * slm.pixel_pitch
    assert np.abs(there[:, 1] - y_was[0]).max() < 0.1 * slm.pixel_pitch
