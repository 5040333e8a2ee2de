"""Meshes are closed, points lie on them, and hidden points are really hidden."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from chrmc.scene.car_house import actors
from chrmc.scene.models import car, house
from chrmc.scene.path import rotation_y
from chrmc.scene.render import render
from chrmc.scene.scene import Pose
from chrmc.scene.shapes import Part, Solid, box, loft, plain, surface_raster, triangle_normals
from chrmc.scene.visibility import first_hits, visible_points


def volume(mesh):
    return np.einsum("ij,ij->", np.cross(mesh[:, 0], mesh[:, 1]), mesh[:, 2]) / 6


def moeller_trumbore(origin, direction, mesh):
    """Distances along a ray at which it meets triangles (Möller and Trumbore 1997)."""
    edge1, edge2 = mesh[:, 1] - mesh[:, 0], mesh[:, 2] - mesh[:, 0]
    h = np.cross(direction, edge2)
    a = np.einsum("ij,ij->i", edge1, h)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = origin - mesh[:, 0]
        u = np.einsum("ij,ij->i", s, h) / a
        q = np.cross(s, edge1)
        v = q @ direction / a
        t = np.einsum("ij,ij->i", edge2, q) / a
        return t[(u >= 0) & (v >= 0) & (u + v <= 1) & np.isfinite(t)]


@pytest.mark.parametrize("solid", [car(), house()], ids=["car", "house"])
def test_parts_are_closed_and_face_outwards(solid):
    for part in solid.parts:
        assert volume(part.triangles) > 0
        edges = {}
        for corners in np.rint(part.triangles * 1e9).astype(int):
            keys = [tuple(c) for c in corners]
            for a, b in zip(keys, keys[1:] + keys[:1], strict=True):
                edges[a, b] = edges.get((a, b), 0) + 1
        # Every edge is walked once each way.
        assert all(edges.get((b, a)) == n for (a, b), n in edges.items())


def test_box_has_its_volume():
    assert volume(box((0, 0, 0), (1, 2, 3))) == pytest.approx(6)


def test_loft_of_a_cone_frustum():
    turn = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    rings = [[(r * np.cos(t), y, r * np.sin(t)) for t in turn] for y, r in ((0, 2), (3, 1))]
    assert volume(loft(rings)) == pytest.approx(np.pi * 3 / 3 * (4 + 2 + 1), rel=1e-3)


def test_raster_lies_on_the_outer_surface_at_its_spacing():
    cube = Part(box((0, 0, 0), (1, 1, 1)), plain(1))
    inner = Part(box((0.3, 0.3, 0.3), (0.7, 0.7, 1.2)), plain(0.5))
    solid = Solid((cube, inner))
    points, triangle = surface_raster(solid, (0.02, 0.02, 0.02))
    corner = solid.triangles[triangle, 0]
    assert np.abs(((points - corner) * solid.normals[triangle]).sum(axis=1)).max() < 1e-12
    grey = solid.paint(points, triangle)
    on_cube = points[grey == 1]
    assert len(on_cube) == pytest.approx((6 - 0.16) / 0.02**2, rel=0.03)
    # Of the inner box only what sticks out is sampled.
    assert points[grey == 0.5][:, 2].min() > 1
    assert not np.any(np.all(np.abs(on_cube[:, :2] - 0.5) < 0.2, axis=1) & (on_cube[:, 2] > 0.99))


@pytest.mark.parametrize("number", [1, 44, 80])
@pytest.mark.parametrize("name", ["car", "house"])
def test_visible_points_are_those_that_rays_say(name, number):
    actor = actors("car-house-deep")[name]
    pose = actor.pose(number)
    mesh = pose.apply(actor.solid.triangles.reshape(-1, 3)).reshape(-1, 3, 3)
    points = pose.apply(actor.points.positions)
    visible = actor.visible(number)
    triangle = surface_raster(actor.solid, actor.spacing)[1]
    facing = (actor.solid.normals[triangle] @ pose.rotation.T)[:, 2] < -1e-9
    assert not visible[~facing].any()
    for k in np.random.default_rng(5).choice(np.flatnonzero(facing), 250, replace=False):
        hits = moeller_trumbore(points[k], np.array([0.0, 0.0, -1.0]), mesh)
        assert visible[k] == (not np.any(hits > 1e-9)), k


@settings(max_examples=40, deadline=None)
@given(st.floats(-3, 3), st.floats(-3, 3))
@example(-2.041311099004398e-08, 1.0)
def test_a_box_shows_the_faces_that_are_turned_to_the_hologram(angle, tilt):
    c, s = np.cos(tilt), np.sin(tilt)
    turn = rotation_y(angle) @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    solid = Solid((Part(box((-1, -1, -1), (1, 1, 1)), plain(1)),))
    points, triangle = surface_raster(solid, (0.3, 0.3, 0.3))
    seen = visible_points(
        points @ turn.T, solid.normals[triangle] @ turn.T, solid.triangles @ turn.T
    )
    towards = -(solid.normals[triangle] @ turn.T)[:, 2]
    decided = np.abs(towards) > 1e-6
    if not decided.all():  # a point on an edge also lies on the face that is seen from its side
        decided &= (np.abs(points) > 1 - 1e-9).sum(axis=1) == 1
    assert np.array_equal(seen[decided], towards[decided] > 0)


def test_first_hits_of_a_slope():
    mesh = box((-1, -1, 4), (1, 1, 5)) @ rotation_y(0.3).T
    x = np.array([4 * np.sin(0.3), 50.0])
    depth, triangle = first_hits(x, np.zeros(2), mesh)
    assert depth[0] == pytest.approx(4 * np.cos(0.3))
    assert np.isinf(depth[1])
    assert triangle_normals(mesh)[triangle[0]] == pytest.approx([-np.sin(0.3), 0, -np.cos(0.3)])


def test_render_shows_what_is_in_front():
    near = Solid((Part(box((-1.5, -1, -1), (1.5, 1, 1)), plain(0.25)),))
    far = Solid((Part(box((-3.5, -2, -1), (3.5, 2, 1)), plain(1.0)),))
    still = np.eye(3)
    cast = [
        (1, near, Pose(still, np.array([0, 0, 5.0]))),
        (2, far, Pose(still, np.array([0, 0, 9.0]))),
    ]
    frame = render(cast, (9, 9), 1.0)
    other = render(cast[::-1], (9, 9), 1.0)
    assert np.array_equal(frame.object_id, other.object_id)
    assert frame.object_id[4].tolist() == [0, 2, 2, 1, 1, 1, 2, 2, 0]
    assert (frame.depth[4, 4], frame.depth[4, 2]) == (4, 8)
    assert (frame.intensity[4, 4], frame.intensity[4, 2]) == (0.25, 1)
    assert not frame.lit[0].any()
