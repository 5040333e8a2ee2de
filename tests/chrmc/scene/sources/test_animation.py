"""Animated, skinned and morphing glTF as scenes."""

from pathlib import Path

import numpy as np
import pytest

from chrmc import load_scene
from chrmc.scene.sources.files import build_sources
from chrmc.scene.sources.mesh import read_mesh

from .making import FEW, animated


def test_each_animated_node_is_a_rigid_object(models: Path, tmp_path: Path) -> None:
    path = tmp_path / "two.glb"
    animated(models, path)
    scene = load_scene(str(path), points=FEW)
    assert scene.frame_count == 13  # half a second at 24 frames a second, both ends
    assert set(scene.object_names) == {"two wuson", "two spider"}
    scale = 1 / 1000  # any: ratios only
    slide = [scene.pose("two wuson", n).translation for n in (1, 7, 13)]
    assert (slide[2] - slide[0])[0] > 0
    assert slide[1] - slide[0] == pytest.approx((slide[2] - slide[0]) / 2, abs=scale * 1e-6)
    first, last = (scene.pose("two spider", n) for n in (1, 13))
    turn = last.rotation @ first.rotation.T
    # A quarter turn about the file's y (up) is one about −y here: z, away, comes to −x.
    assert turn @ [0, 0, 1] == pytest.approx([-1, 0, 0], abs=1e-6)
    still = load_scene(str(path), points=FEW).frame(5)
    assert all(len(o.cloud) > 50 for o in still.objects)


def test_a_skinned_and_a_morphing_mesh_bend(models: Path) -> None:
    for name in (
        "glTF2/simple_skin/simple_skin.gltf",
        "glTF2/glTF-Sample-Models/AnimatedMorphCube-glTF/AnimatedMorphCube.gltf",
    ):
        built = build_sources([str(models / name)], points=FEW)
        scene = built.cast.points()
        assert any("bends" in note for note in scene.notes)
        assert scene.frame_count > 20
        (key,) = scene.object_names
        (surface,) = built.cast.drawn.values()
        first, middle = (scene.frame(n).objects[0] for n in (1, scene.frame_count // 3))
        assert middle.body is None and middle.pose is None and scene.pose(key, 2) is None
        # A point keeps its phase, and its place on the surface: two vertices' mid-point stays one.
        known = {p: k for k, p in enumerate(first.cloud.phase.tolist())}
        both = [(known[p], k) for k, p in enumerate(middle.cloud.phase.tolist()) if p in known]
        assert len(both) > 100
        before, after = surface.in_frame(0), surface.in_frame(scene.frame_count // 3 - 1)
        assert before.vertices == pytest.approx(surface.vertices, abs=1e-9)
        moved = np.linalg.norm(after.vertices - before.vertices, axis=1).max()
        assert moved > 1e-5
        a, b = np.array(both[::7]).T
        shift = np.linalg.norm(middle.cloud.positions[b] - first.cloud.positions[a], axis=1)
        assert 0 < shift.max() <= moved * (1 + 1e-6)


def test_skin_as_its_two_bones_say(models: Path) -> None:
    surface = next(iter(read_mesh(models / "glTF2/simple_skin/simple_skin.gltf").bodies.values()))
    # The upper bone turns by 90° about z at height 1 and back; what hangs on the lower one stays.
    assert surface.shape is not None
    frames = [surface.shape(k) for k in range(24 * 5 // 2)]
    low = surface.vertices[:, 1] == 0
    for vertices in frames:
        assert vertices[low] == pytest.approx(surface.vertices[low], abs=1e-6)
    top = surface.vertices[:, 1] == 2
    reach = [np.abs(v[top, 0] - surface.vertices[top, 0]).max() for v in frames]
    assert max(reach) > 0.5
    # Bones do not stretch: the way from the joint at height 1 to the top keeps its length.
    for vertices in frames:
        length = np.linalg.norm(vertices[top] - [0, 1, 0], axis=1)
        assert length == pytest.approx(
            np.linalg.norm(surface.vertices[top] - [0, 1, 0], axis=1), abs=1e-5
        )
