"""The animations of a glTF file: a rigid motion per animated node, and surfaces that bend."""

from base64 import b64decode
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from chrmc.scene.scene import Pose
from chrmc.scene.sources.beside import file_beside
from chrmc.scene.sources.model import MOST_FRAMES, only_line

RATE = 24.0
"""Frames per second at which animations are sampled."""
_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTH = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


@dataclass(frozen=True, eq=False)
class Bent:
    """A part of a mesh that a skin or its shapes bend.

    rest : (V, 3) its vertices in the file; node : index of the one that carries it
    at : frame 0, 1, … to (V, 3) vertices
    placed : whether `at` gives them in the file's axes (a skin) or in the node's (shapes)
    """

    rest: NDArray[np.float64]
    node: str
    at: Callable[[int], NDArray[np.float64]]
    placed: bool


@dataclass(frozen=True)
class Motion:
    """poses : node name (as trimesh calls it) to its pose in the file, per frame
    scales : node name to (3,) its size in the first frame, which the pose leaves out
    bent : what is no rigid body; frames : of the whole animation
    compressed : whether its triangles are packed in a way that is not read here
    """

    poses: dict[str, list[Pose]] = field(default_factory=dict)
    scales: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    rate: float | None = None
    bent: tuple[Bent, ...] = ()
    frames: int = 1
    compressed: bool = False
    notes: tuple[str, ...] = ()


def read_motion(path: Path) -> Motion:
    """All animations of a file at once, sampled at 24 frames a second."""
    try:
        import pygltflib
    except ImportError:
        raise ValueError(
            f"{path.name}: animations are read by pygltflib; install it with pip install "
            "'chrmc[scenes]'"
        ) from None
    try:
        gltf = pygltflib.GLTF2().load(str(path))
        if gltf is None:
            return Motion()
        if "KHR_draco_mesh_compression" in (gltf.extensionsRequired or ()):
            return Motion(compressed=True)
        channels = _channels(gltf)
        if not channels:
            return Motion()
        return _sampled(gltf, channels, path)
    except KeyboardInterrupt:
        raise
    except Exception as error:  # whatever a damaged file leads the decoder to
        raise OSError(f"{path}: its animation cannot be read ({only_line(error)})") from None


_Channel = tuple[NDArray[np.float64], NDArray[np.float64], str]


def _channels(gltf: Any) -> dict[tuple[int, str], _Channel]:
    """(node, path) to times, values and interpolation."""
    found: dict[tuple[int, str], _Channel] = {}
    for animation in gltf.animations:
        for channel in animation.channels:
            node, what = channel.target.node, channel.target.path
            if node is None or what not in (*_REST, "weights"):
                continue
            sampler = animation.samplers[channel.sampler]
            times = _accessor(gltf, sampler.input)[:, 0]
            values = _accessor(gltf, sampler.output)
            kind = sampler.interpolation or "LINEAR"
            rows = len(times) * (3 if kind == "CUBICSPLINE" else 1)
            if what == "weights" and rows and len(values) % rows == 0:
                values = values.reshape(rows, -1)  # one number per shape
            if len(times) == 0 or len(values) != rows:
                raise ValueError(f"{len(times)} times but {len(values)} values in an animation")
            found[node, what] = (times, values, kind)
    return found


def _accessor(gltf: Any, index: int, whole: bool = False) -> NDArray[np.float64]:
    """(N, K) numbers of an accessor; whole numbers are normalised unless they mean themselves."""
    accessor = gltf.accessors[index]
    view = gltf.bufferViews[accessor.bufferView]
    data = _buffer(gltf, view.buffer)
    kind = np.dtype(_TYPES[accessor.componentType])
    width = _WIDTH[accessor.type]
    start = (view.byteOffset or 0) + (accessor.byteOffset or 0)
    stride = view.byteStride or width * kind.itemsize
    values = np.ndarray((accessor.count, width), kind, data, start, (stride, kind.itemsize)).astype(
        np.float64
    )
    if whole or kind.kind == "f":
        return values
    return np.maximum(values / np.iinfo(kind).max, -1)


def _buffer(gltf: Any, index: int) -> bytes:
    uri = gltf.buffers[index].uri
    if uri is None:
        return bytes(gltf.binary_blob())
    if uri.startswith("data:"):  # of any type: pygltflib knows one of them
        return b64decode(uri.partition(",")[2])
    file = file_beside(Path(gltf._path), unquote(uri))
    if file is None:
        raise ValueError(f"{uri} is not in its folder")
    return file.read_bytes()


def _sampled(gltf: Any, channels: dict[tuple[int, str], _Channel], path: Path) -> Motion:
    names = _names(gltf)
    parents = {child: k for k, node in enumerate(gltf.nodes) for child in node.children or ()}
    first = min(float(times[0]) for times, _, _ in channels.values())
    last = max(float(times[-1]) for times, _, _ in channels.values())
    count = round((last - first) * RATE) + 1
    if not 0 < count <= MOST_FRAMES:
        raise ValueError(f"it lasts {last - first:.4g} s")
    times = [min(first + k / RATE, last) for k in range(count)]
    moving = {node for node, what in channels if what != "weights"}
    poses: dict[str, list[Pose]] = {names[node]: [] for node in moving}
    scales: dict[str, NDArray[np.float64]] = {}
    worlds: list[list[NDArray[np.float64]]] = []
    grows = False
    for time in times:
        local = [_local(gltf, node, channels, time) for node in range(len(gltf.nodes))]
        worlds.append([_world(node, local, parents) for node in range(len(gltf.nodes))])
        for node in moving:
            matrix = worlds[-1][node]
            scale = np.linalg.norm(matrix[:3, :3], axis=0)
            name = names[node]
            grows |= not np.allclose(scale, scales.setdefault(name, scale), rtol=1e-3)
            rotation = _nearest_rotation(matrix[:3, :3] / np.where(scale > 0, scale, 1))
            poses[name].append(Pose(rotation, matrix[:3, 3]))
    notes = []
    if grows:
        notes.append(f"{path.name}: sizes that its animation changes are kept as in frame 1")
    bent = (*_skinned(gltf, worlds, names), *_morphing(gltf, channels, times, names))
    if bent:
        notes.append(
            f"{path.name}: bends (a skin or shapes that morph): its points keep their place on the "
            "surface but are no rigid body, so every frame is computed afresh"
        )
    return Motion(poses, scales, RATE, bent, count, notes=tuple(notes))


def _skinned(
    gltf: Any, worlds: list[list[NDArray[np.float64]]], names: dict[int, str]
) -> Iterator[Bent]:
    """Linear blend skinning: Σ weight · joint · inverse of the joint at rest · vertex."""
    for index, node in enumerate(gltf.nodes):
        if node.skin is None or node.mesh is None:
            continue
        skin = gltf.skins[node.skin]
        inverse = np.tile(np.eye(4), (len(skin.joints), 1, 1))
        if skin.inverseBindMatrices is not None:
            inverse = _accessor(gltf, skin.inverseBindMatrices).reshape(-1, 4, 4)
            inverse = inverse.transpose(0, 2, 1)
        for part in gltf.meshes[node.mesh].primitives:
            rest = _accessor(gltf, part.attributes.POSITION)
            joint = _accessor(gltf, part.attributes.JOINTS_0, whole=True).astype(np.intp)
            weight = _accessor(gltf, part.attributes.WEIGHTS_0)
            weight = weight / np.maximum(weight.sum(axis=1, keepdims=True), 1e-12)
            extended = np.column_stack([rest, np.ones(len(rest))])

            def at(
                frame: int,
                joints: Any = tuple(skin.joints),
                inverse: NDArray[np.float64] = inverse,
                joint: NDArray[np.intp] = joint,
                weight: NDArray[np.float64] = weight,
                extended: NDArray[np.float64] = extended,
            ) -> NDArray[np.float64]:
                world = np.array([worlds[frame][j] for j in joints]) @ inverse
                blended = np.einsum("vk,vkij->vij", weight, world[joint])
                return np.asarray(np.einsum("vij,vj->vi", blended, extended)[:, :3])

            yield Bent(rest, names[index], at, placed=True)


def _morphing(
    gltf: Any, channels: dict[tuple[int, str], _Channel], times: list[float], names: dict[int, str]
) -> Iterator[Bent]:
    """Vertices plus weighted differences."""
    for index, node in enumerate(gltf.nodes):
        channel = channels.get((index, "weights"))
        if channel is None or node.mesh is None or node.skin is not None:
            continue
        for part in gltf.meshes[node.mesh].primitives:
            rest = _accessor(gltf, part.attributes.POSITION)
            differences = np.array(
                [
                    np.zeros_like(rest)
                    if _target(target) is None
                    else _accessor(gltf, _target(target))
                    for target in part.targets or ()
                ]
            ).reshape(-1, *rest.shape)

            def at(
                frame: int,
                channel: _Channel = channel,
                rest: NDArray[np.float64] = rest,
                differences: NDArray[np.float64] = differences,
            ) -> NDArray[np.float64]:
                weights = _at(*channel, times[frame], turning=False)[: len(differences)]
                return np.asarray(rest + np.einsum("s,svx->vx", weights, differences))

            yield Bent(rest, names[index], at, placed=False)


def _target(target: Any) -> Any:
    """Accessor of a shape's differences of places."""
    return target.get("POSITION") if isinstance(target, dict) else target.POSITION


def _world(
    node: int, local: list[NDArray[np.float64]], parents: dict[int, int]
) -> NDArray[np.float64]:
    matrix, seen = local[node], {node}
    while node in parents:
        node = parents[node]
        if node in seen:
            raise ValueError("a node is its own ancestor")
        seen.add(node)
        matrix = local[node] @ matrix
    return matrix


def _nearest_rotation(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """The proper rotation next to a matrix."""
    u, _, vt = np.linalg.svd(matrix)
    return np.asarray(u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt)


def _names(gltf: Any) -> dict[int, str]:
    """Names of the nodes as trimesh makes them unique."""
    from trimesh.util import unique_name

    index: dict[str, int] = {}
    counts: dict[str, int] = {}
    for k, node in enumerate(gltf.nodes):
        index[unique_name(node.name or str(k), index, counts=counts)] = k
    return {k: name for name, k in index.items()}


def _local(
    gltf: Any, index: int, channels: dict[tuple[int, str], _Channel], time: float
) -> NDArray[np.float64]:
    """(4, 4) a node's place in its parent at a time."""
    node = gltf.nodes[index]
    if node.matrix is not None and not any((index, p) in channels for p in _REST):
        return np.array(node.matrix, dtype=np.float64).reshape(4, 4).T
    value = {}
    for what, rest in _REST.items():
        channel = channels.get((index, what))
        own = getattr(node, what)
        value[what] = (
            np.array(rest if own is None else own)
            if channel is None
            else _at(*channel, time, turning=what == "rotation")
        )
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat(value["rotation"]).as_matrix() * value["scale"]
    matrix[:3, 3] = value["translation"]
    return matrix


_REST = {"translation": [0.0, 0, 0], "rotation": [0.0, 0, 0, 1], "scale": [1.0, 1, 1]}


def _at(
    times: NDArray[np.float64],
    values: NDArray[np.float64],
    kind: str,
    time: float,
    turning: bool,
) -> NDArray[np.float64]:
    """A channel's value at a time, held before its first and after its last key."""
    if len(times) == 1 or time <= times[0] or time >= times[-1]:
        end = 0 if len(times) == 1 or time <= times[0] else len(times) - 1
        return values[3 * end + 1] if kind == "CUBICSPLINE" else values[end]
    k = int(np.searchsorted(times, time, side="right")) - 1
    step = times[k + 1] - times[k]
    u = (time - times[k]) / step
    if kind == "STEP":
        return np.asarray(values[k])
    if kind == "CUBICSPLINE":
        p0, m0 = values[3 * k + 1], step * values[3 * k + 2]
        m1, p1 = step * values[3 * k + 3], values[3 * k + 4]
        u2, u3 = u * u, u**3
        return np.asarray(
            (2 * u3 - 3 * u2 + 1) * p0
            + (u3 - 2 * u2 + u) * m0
            + (3 * u2 - 2 * u3) * p1
            + (u3 - u2) * m1
        )
    if turning:
        turn = Slerp([0, 1], Rotation.from_quat(values[k : k + 2]))(u)
        return np.asarray(turn.as_quat())
    return np.asarray((1 - u) * values[k] + u * values[k + 1])
