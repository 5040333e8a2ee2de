"""Meshes: glTF, OBJ, PLY and STL, read by trimesh, with colours, textures and materials."""

import logging
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.scene.points import PointCloud
from chrmc.scene.sources.beside import check_tree, file_beside
from chrmc.scene.sources.cloud import NAMES, cloud_of, find_column
from chrmc.scene.sources.gltf_motion import Bent, Motion, read_motion
from chrmc.scene.sources.model import Model, only_line
from chrmc.scene.sources.paint import paint_of, pictures_of_any_size
from chrmc.scene.surface.surface import Surface, join


def read_mesh(path: Path) -> Model:
    """The bodies of a mesh file: one, or one per moving node of an animated glTF.

    Raises ValueError or OSError, in one line, for a file that holds nothing to show. Faces of no
    area and those with NaN or infinite corners are left out, and counted in the notes.
    """
    # Coordinates whose squares are no numbers make faces without an area, which are left out.
    with np.errstate(all="ignore"):
        return _read(path)


def _read(path: Path) -> Model:
    absent: list[str] = []
    if path.suffix.lower() in (".glb", ".gltf"):
        check_tree(path)
    scene = _load(path, absent)
    kind = path.suffix.lower()
    if kind in (".ply", ".stl"):
        (_check_ply if kind == ".ply" else _check_stl)(path, scene)
    motion = read_motion(path) if path.suffix.lower() in (".glb", ".gltf") else Motion()
    if motion.compressed:
        raise ValueError(f"{path} is compressed by Draco: export it without compression")
    notes = list(motion.notes)
    if absent:
        notes.append(f"{path.name}: {', '.join(dict.fromkeys(absent))} is absent; shown without it")
    try:
        parts, loose, dropped = _parts(scene, motion, path)
    except (ValueError, IndexError) as error:
        raise OSError(
            f"{path} is damaged: its triangles make no sense ({only_line(error)})"
        ) from None
    except OSError as error:
        raise OSError(f"{path}: {error}") from None
    if dropped:
        notes.append(f"{path.name}: {dropped} faces of no area or without a place left out")
    if not parts:
        return _only_points(path, loose, dropped, notes)
    bodies: dict[str, Surface | PointCloud] = {n: _closed(join(s)) for n, s in parts.items()}
    open_ones = [n for n, b in bodies.items() if isinstance(b, Surface) and not b.closed]
    if open_ones:
        notes.append(
            f"{', '.join(open_ones[:3])}{' …' if len(open_ones) > 3 else ''}: the surface is not "
            "closed, so both of its sides are shown"
        )
    up = "z" if path.suffix.lower() == ".stl" else "y"
    poses = {n: motion.poses[n] for n in bodies if n in motion.poses}
    return Model(bodies, poses, up, motion.rate, motion.frames, notes=tuple(notes))


def _parts(
    scene: Any, motion: Motion, path: Path
) -> tuple[dict[str, list[Surface]], list[PointCloud], int]:
    """Surfaces by moving node, clouds, and the number of faces that had to go."""
    parts: dict[str, list[Surface]] = {}
    loose: list[PointCloud] = []
    dropped = 0
    for node in scene.graph.nodes_geometry:
        geometry = scene.geometry[scene.graph[node][1]]
        if np.ndim(getattr(geometry, "faces", 0)) != 2 or not len(geometry.faces):
            place = np.asarray(getattr(geometry, "vertices", ()), dtype=np.float64)
            if hasattr(geometry, "faces") or hasattr(geometry, "colors"):  # no lines
                colours = getattr(geometry, "colors", None)
                known = colours is not None and len(colours) == len(place) > 0
                shown = np.asarray(colours)[:, :3] / 255 if known else None
                loose.append(cloud_of(place, colour=shown, **_scalars(geometry, len(place))))
            continue
        if path.suffix.lower() == ".stl":  # whose triangles share no corners
            with np.errstate(invalid="ignore"):
                geometry.merge_vertices()
        bent = _bent(geometry, node, motion)
        if bent is not None and bent.placed:
            name, to_body = None, np.eye(4)
        else:
            name, to_body = _body_of(scene, node, motion)
        surface, lost = _surface(geometry, to_body, bent)
        dropped += lost
        if len(surface.faces):
            parts.setdefault(name or path.stem, []).append(surface)
    return parts, loose, dropped


def _scalars(geometry: Any, count: int) -> dict[str, NDArray[np.float64]]:
    """Amplitude or intensity, and phase, where a .ply has them beside its places."""
    raw = getattr(geometry, "metadata", {}).get("_ply_raw", {}).get("vertex", {}).get("data")
    if raw is None:
        return {}
    names = list(raw) if isinstance(raw, dict) else list(raw.dtype.names)
    plain = [name.lower().removeprefix("scalar_") for name in names]
    column: dict[str, int] = {}
    for key, called in NAMES.items():
        find_column(column, plain, key, called)
    if "amplitude" in column:
        column.pop("intensity", None)
    found = {k: np.asarray(raw[names[c]], np.float64).reshape(-1) for k, c in column.items()}
    return {key: values for key, values in found.items() if len(values) == count}


def _load(path: Path, absent: list[str]) -> Any:
    try:
        import trimesh
    except ImportError:
        raise ValueError(
            f"{path.name}: meshes are read by trimesh; install it with pip install 'chrmc[scenes]'"
        ) from None

    # trimesh logs what it skips; what matters of it is in the notes.
    logging.getLogger("trimesh").addHandler(logging.NullHandler())

    class Beside(trimesh.resolvers.FilePathResolver):
        """Files beside the mesh, also when named as Windows does; absent ones are noted."""

        def get(self, name: str) -> bytes:
            file = file_beside(path.parent, name)
            if file is not None:
                return file.read_bytes()
            absent.append(name.strip().replace("\\", "/"))
            raise FileNotFoundError(f"{absent[-1]} is not in its folder")

    files = Beside(str(path))
    try:
        with pictures_of_any_size():
            return trimesh.load_scene(path, resolver=files, process=False)
    except Exception as error:  # trimesh lets whatever went wrong in its parsers through
        raise OSError(
            f"{path} cannot be read as a mesh ({only_line(error)}): write it again, or convert it"
        ) from None


def _check_ply(path: Path, scene: Any) -> None:
    """OSError for a .ply that holds less than its header says: trimesh takes what is there."""
    with path.open("rb") as file:
        head = file.read(1 << 16)
    declared = {k: int(n) for k, n in re.findall(rb"\nelement (vertex|face) (\d{1,15})\s", head)}
    there = sum(len(getattr(g, "vertices", ())) for g in scene.geometry.values())
    faces = sum(len(getattr(g, "faces", ())) for g in scene.geometry.values())
    if there < declared.get(b"vertex", 0) or (declared.get(b"face", 0) and not faces):
        raise OSError(
            f"{path} is cut short: {there} of {declared.get(b'vertex', 0)} vertices and {faces} of "
            f"{declared.get(b'face', 0)} faces are there; write it again"
        )


def _check_stl(path: Path, scene: Any) -> None:
    """OSError for an .stl that ends before it should."""
    if any(len(getattr(g, "faces", ())) for g in scene.geometry.values()):
        return
    with path.open("rb") as file:
        head = file.read(84)
        file.seek(max(path.stat().st_size - 1024, 0))
        tail = file.read()
    if head.lstrip().startswith(b"solid"):
        if b"facet" in tail and b"endsolid" not in tail:
            raise OSError(f"{path} is cut short: it has no endsolid; write it again")
        return
    declared, there = int.from_bytes(head[80:84], "little"), max(path.stat().st_size - 84, 0) // 50
    if len(head) == 84 and there < declared:
        raise OSError(
            f"{path} is cut short: {there} of {declared} triangles are there; write it again"
        )


def _only_points(path: Path, loose: list[PointCloud], dropped: int, notes: list[str]) -> Model:
    if any(len(cloud) for cloud in loose):
        return Model({path.stem: PointCloud.concatenate(loose)}, notes=tuple(notes))
    why = f"none of its {dropped} faces has an area" if dropped else "no faces and no points"
    raise ValueError(f"{path} holds nothing to show: {why}; export it as triangles")


def _body_of(scene: Any, node: str, motion: Motion) -> tuple[str | None, NDArray[np.float64]]:
    """The moving node that carries a node, or None, and (4, 4) the node's place in it."""
    parents = scene.graph.transforms.parents
    above: str | None = node
    while above is not None and above not in motion.poses:
        above = parents.get(above)
    matrix = np.asarray(scene.graph.get(node)[0], dtype=np.float64)
    if above is None:
        return None, matrix
    carrier = np.asarray(scene.graph.get(node, frame_from=above)[0], dtype=np.float64)
    return above, np.diag([*motion.scales[above], 1.0]) @ carrier


def _bent(geometry: Any, node: str, motion: Motion) -> Bent | None:
    """What bends a geometry: known by its vertices, since trimesh names parts anew."""
    vertices = np.asarray(geometry.vertices, dtype=np.float64)
    for bent in motion.bent:
        same = bent.rest.shape == vertices.shape and np.allclose(bent.rest, vertices, atol=1e-6)
        if same and (node == bent.node or node.startswith(f"{bent.node}_")):
            return bent
    return None


def _surface(
    geometry: Any, matrix: NDArray[np.float64], bent: Bent | None = None
) -> tuple[Surface, int]:
    """A geometry at its place, and how many of its faces had to go."""
    vertices = np.asarray(geometry.vertices, dtype=np.float64)
    shape = None
    if bent is not None:
        vertices = bent.at(0)
    faces = np.asarray(geometry.faces, dtype=np.intp)
    with np.errstate(invalid="ignore", over="ignore"):
        vertices = vertices @ matrix[:3, :3].T + matrix[:3, 3]
        finite = np.asarray(np.isfinite(vertices).all(axis=1))
        corner = vertices[faces]
        area = np.linalg.norm(
            np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1
        )
        longest = np.ptp(corner, axis=1).max(axis=1)
        whole = finite[faces].all(axis=1) & (area > 1e-12 * longest**2) & (area > 0)
    index = np.flatnonzero(whole)
    normals = np.asarray(geometry.vertex_normals) @ np.linalg.pinv(matrix[:3, :3])
    length = np.linalg.norm(np.nan_to_num(normals), axis=1, keepdims=True)
    normals = np.nan_to_num(normals) / np.where(length > 0, length, 1)
    paint = paint_of(geometry, index)
    kept = faces[index]
    if np.linalg.det(matrix[:3, :3]) < 0:  # mirrored by its node: the outside turns over
        kept = kept[:, ::-1]
        inner = paint

        def paint(face: NDArray[np.intp], weights: NDArray[np.float64]) -> NDArray[np.float64]:
            return inner(face, weights[:, ::-1])

    # Corners of no face are not shown: they must not count for the size, nor be infinite.
    used, flat = np.unique(kept, return_inverse=True)
    if bent is not None:

        def shape(frame: int) -> NDArray[np.float64]:
            return bent.at(frame)[used] @ matrix[:3, :3].T + matrix[:3, 3]

    smooth = normals[used] if bent is None else None
    surface = Surface(vertices[used], flat.reshape(kept.shape), paint, smooth, shape=shape)
    return surface, len(faces) - len(index)


def _closed(surface: Surface) -> Surface:
    """The surface with its faces outward, and whether they enclose a body."""
    from dataclasses import replace

    import trimesh

    used, faces = np.unique(surface.faces, return_inverse=True)
    # Corners at one place are one: seams of colours and textures are no holes.
    size = np.ptp(surface.vertices[used], axis=0).max()
    _, same = np.unique(
        np.rint(surface.vertices[used] / (1e-6 * size)), axis=0, return_inverse=True
    )
    merged = same.reshape(-1)[faces.reshape(surface.faces.shape)]
    _, first = np.unique(same.reshape(-1), return_index=True)
    solid = trimesh.Trimesh(surface.vertices[used][first], merged, process=False)
    closed = bool(solid.is_watertight and solid.is_winding_consistent)
    if not closed or solid.volume > 0:
        return replace(surface, closed=closed)
    turned = surface.faces[:, ::-1]
    paint = surface.paint
    return replace(surface, faces=turned, paint=lambda f, w: paint(f, w[:, ::-1]))
