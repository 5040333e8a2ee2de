"""Opaque means opaque: the z-buffer against rays, and Lambert's law."""

import numpy as np
import pytest

from chrmc.scene.car_house import actors
from chrmc.scene.path import rotation_y
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Pose
from chrmc.scene.shapes import Part, Solid, box, loft, plain
from chrmc.scene.surface.cast import Cast
from chrmc.scene.surface.seen import PIXELS_PER_SPACING
from chrmc.scene.surface.shading import Lamp
from chrmc.scene.surface.surface import from_solid
from chrmc.scene.visibility import first_hits, visible_points

SPACING = 12e-6
STILL = np.eye(3)


def at(z: float, turn: float = 0.0, x: float = 0.0) -> tuple[Pose, ...]:
    return (Pose(rotation_y(turn), np.array([x, 0.0, z])),)


def ball(radius: float) -> Solid:
    """A sphere of facets."""
    polar = np.linspace(0.02, np.pi - 0.02, 60)
    around = np.linspace(0, 2 * np.pi, 120, endpoint=False)
    rings = [
        [(radius * np.sin(p) * np.cos(a), radius * np.cos(p), radius * np.sin(p) * np.sin(a))
         for a in around] for p in polar
    ]  # fmt: skip
    return Solid((Part(loft(rings), plain(0.5)),))


@pytest.mark.parametrize("name", ["car", "house"])
@pytest.mark.parametrize("number", [1, 40])
def test_no_point_shows_that_a_ray_finds_hidden(name: str, number: int) -> None:
    actor = actors("car-house")[name]
    surface = from_solid(actor.solid)
    pose = Pose(actor.pose(number).rotation, np.array([0.0, 0.0, 0.252]))
    cast = Cast("one", {name: surface}, {name: (pose,)}, SPACING)
    shown = cast.points().frame(1).objects[0]
    # Perspective that keeps planes plane: its lines of sight run along z, where the exact rays
    # of the built-in scenes are.
    flat = perspective(pose.apply(actor.solid.triangles.reshape(-1, 3))).reshape(-1, 3, 3)
    place = perspective(shown.cloud.positions)
    towards = np.tile([0.0, 0.0, -1.0], (len(place), 1))
    # A step towards the hologram, so that a point's own face does not hide it.
    seen = visible_points(place - [0, 0, 2e-7], towards, flat)
    assert len(place) > 2000
    # Only within a pixel of an outline may a ray disagree.
    assert (~seen).mean() < 0.01
    doubtful = place[~seen] - [0, 0, 2e-7]
    pixel = SPACING / PIXELS_PER_SPACING
    near = np.zeros(len(doubtful), dtype=bool)
    for x in (-pixel, 0, pixel):
        for y in (-pixel, 0, pixel):
            beside, _ = first_hits(doubtful[:, 0] + x, doubtful[:, 1] + y, flat)
            near |= beside > doubtful[:, 2] - 6e-6
    assert near.all()


def perspective(world):
    return np.column_stack([0.252 * world[:, :2] / world[:, 2:], 0.504 - 0.252**2 / world[:, 2]])


def test_few_points_that_should_show_are_lost() -> None:
    surface = from_solid(ball(5e-4))
    cast = Cast("ball", {"ball": surface}, {"ball": at(0.25)}, SPACING)
    shown = cast.points().frame(1).objects[0].cloud
    # Even over the visible disc: as many per area everywhere, whatever the inclination.
    radius = np.hypot(*shown.positions[:, :2].T)
    edges = 5e-4 * np.sqrt(np.linspace(0, 1, 6))
    rings, _ = np.histogram(radius, edges)
    assert rings == pytest.approx(np.full(5, np.pi * 5e-4**2 / 5 / SPACING**2), rel=0.12)
    assert shown.positions[:, 2].max() < 0.25 + 1e-5


def test_one_body_hides_another_and_points_without_a_surface() -> None:
    wall = from_solid(Solid((Part(box((-5e-4, -5e-4, 0), (0, 5e-4, 1e-4)), plain(0.5)),)))
    far = from_solid(Solid((Part(box((-4e-4, -4e-4, 0), (4e-4, 4e-4, 1e-4)), plain(0.5)),)))
    rng = np.random.default_rng(3)
    dust = PointCloud(rng.uniform(-4e-4, 4e-4, (500, 3)) * [1, 1, 0], np.ones(500), np.zeros(500))
    cast = Cast(
        "three",
        {"wall": wall, "far": far, "dust": dust},
        {"wall": at(0.25), "far": at(0.26), "dust": at(0.255)},
        SPACING,
    )
    front, back, loose = cast.points().frame(1).objects
    assert front.cloud.positions[:, 0].max() < 1e-6
    # The shadow's edge is the wall's, drawn from the hologram's middle through x = 0.
    for obj in (back, loose):
        assert obj.cloud.positions[:, 0].min() > -3e-6
        assert len(obj.cloud) > 100
    assert (loose.cloud.positions[:, 0] > 0).sum() == (dust.positions[:, 0] > 0).sum()


def test_pictures_and_points_show_the_same() -> None:
    cast = Cast("ball", {"ball": from_solid(ball(5e-4))}, {"ball": at(0.25, x=2e-4)}, 5e-6,
                lamp=Lamp((-1.0, 0.0, -0.5)), pixel_pitch=25e-6)  # fmt: skip
    picture = cast.pictures((60, 80)).rgbd(1)
    cloud = cast.points().frame(1).cloud
    half = np.array([40, 30]) * 25e-6
    drawn, _, _ = np.histogram2d(
        cloud.positions[:, 1], cloud.positions[:, 0], bins=(60, 80),
        range=((-half[1], half[1]), (-half[0], half[0])), weights=cloud.intensity,
    )  # fmt: skip
    inner = picture.intensity > 0
    assert np.corrcoef(drawn[inner], picture.intensity[inner])[0, 1] > 0.93
    rows, columns = np.nonzero(inner)
    x = (columns - 39.5) * 25e-6 - 2e-4
    y = (rows - 29.5) * 25e-6
    exact = 0.25 - np.sqrt(np.clip(5e-4**2 - x**2 - y**2, 0, None))
    deep = np.hypot(x, y) < 4.5e-4
    assert picture.depth[inner][deep] == pytest.approx(exact[deep], abs=3e-6)


def test_lamp_on_the_left_lights_the_left_and_nothing_is_black() -> None:
    lamp = Lamp((-1.0, 0.0, 0.0), ambient=0.1)
    left, right, front = lamp.shade(np.array([[-1.0, 0, 0], [1, 0, 0], [0, 0, -1]]))
    assert left == pytest.approx(1)
    assert 0 < right < front < left
    with pytest.raises(ValueError, match="direction"):
        Lamp((0, 0, 0))


def test_behind_the_hologram_is_refused() -> None:
    cast = Cast("ball", {"ball": from_solid(ball(5e-4))}, {"ball": at(1e-4)}, SPACING)
    with pytest.raises(ValueError, match="behind the hologram"):
        cast.points().frame(1)


def test_what_stands_still_shows_the_same_points_beside_what_moves() -> None:
    house, car = (from_solid(actors("car-house")[name].solid) for name in ("house", "car"))
    poses = {
        "house": at(0.264),
        "car": tuple(at(0.25 + 1e-4 * k, 0.1 * k, 3e-3)[0] for k in range(4)),
    }
    scene = Cast("pair", {"house": house, "car": car}, poses, SPACING).points()
    first, *others = (scene.frame(n).objects for n in (1, 2, 3, 4))
    assert all(np.array_equal(o[0].ids, first[0].ids) for o in others)
    assert any(not np.array_equal(o[1].ids, first[1].ids) for o in others)
