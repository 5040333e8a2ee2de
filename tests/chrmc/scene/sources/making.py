"""Scenes' files that tests make: pictures, tracks, recordings, renderers' frames, animations."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh

from chrmc.cli.main import main

FEW = 3000


def run(*words: object) -> int:
    with pytest.raises(SystemExit) as ended:
        main([str(w) for w in words])
    return int(ended.value.code or 0)


def write_picture(path: Path, samples: np.ndarray) -> Path:
    import OpenImageIO as oiio

    if samples.ndim == 2:
        samples = samples[:, :, None]
    height, width, channels = samples.shape
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), oiio.ImageSpec(width, height, channels, str(samples.dtype)))
    assert out.write_image(np.ascontiguousarray(samples))
    out.close()
    return path


def track_rows() -> str:
    """Five rows that slide along x and turn about z."""
    rows = [(n / 10, 0.1 * n, 0.0, 0.0, 0.0, 0.0, 0.1 * n) for n in range(5)]
    return "time,x,y,z,rx,ry,rz\n" + "\n".join(",".join(map(str, row)) for row in rows)


def animated(models: Path, path: Path) -> None:
    """Two real meshes on two nodes: one slides and turns, one swings under a still parent."""
    import pygltflib

    scene = trimesh.Scene()
    wuson = trimesh.load_mesh(models / "STL" / "Wuson.stl")
    spider = trimesh.load_mesh(models / "STL" / "Spider_binary.stl")
    scene.add_geometry(wuson, node_name="wuson")
    scene.add_geometry(
        spider, node_name="spider", transform=trimesh.transformations.translation_matrix([4, 1, 0])
    )
    scene.export(path)
    gltf = pygltflib.GLTF2().load(str(path))
    names = [n.name for n in gltf.nodes]
    blob = bytearray(gltf.binary_blob())

    def accessor(values: np.ndarray, kind: str) -> int:
        while len(blob) % 4:
            blob.append(0)
        data = np.ascontiguousarray(values, "<f4").tobytes()
        view = pygltflib.BufferView(buffer=0, byteOffset=len(blob), byteLength=len(data))
        gltf.bufferViews.append(view)
        blob.extend(data)
        gltf.accessors.append(
            pygltflib.Accessor(
                bufferView=len(gltf.bufferViews) - 1,
                componentType=5126,
                count=len(values),
                type=kind,
                min=[float(np.min(values))],
                max=[float(np.max(values))],
            )
        )
        return len(gltf.accessors) - 1

    time = accessor(np.array([0.0, 0.5]), "SCALAR")
    slide = accessor(np.array([[0, 0, 0], [2.0, 0, 0]]), "VEC3")
    half = np.sqrt(0.5)
    swing = accessor(np.array([[0, 0, 0, 1], [0, half, 0, half]]), "VEC4")
    gltf.animations.append(
        pygltflib.Animation(
            samplers=[
                pygltflib.AnimationSampler(input=time, output=slide),
                pygltflib.AnimationSampler(input=time, output=swing),
            ],
            channels=[
                pygltflib.AnimationChannel(
                    sampler=k,
                    target=pygltflib.AnimationChannelTarget(node=names.index(node), path=what),
                )
                for k, (node, what) in enumerate([("wuson", "translation"), ("spider", "rotation")])
            ],
        )
    )
    for node in gltf.nodes:  # an animated node has no matrix
        if node.matrix is not None and node.name == "spider":
            node.matrix, node.translation = None, [4.0, 1.0, 0.0]
    gltf.buffers[0].byteLength = len(blob)
    gltf.set_binary_blob(bytes(blob))
    gltf.save(str(path))


def recording(folder: Path, tum: bool) -> None:
    """A wall at 2 m with a box at 1 m in its upper left, holes, stamps out of order, one depth
    picture missing."""
    folder.mkdir()
    rgb, depth = folder / "rgb", folder / "depth"
    rgb.mkdir(), depth.mkdir()
    stamps = [2.0, 1.0, 3.0, 4.0]
    lists: dict[str, list[str]] = {"rgb": ["# stamp file"], "depth": ["# stamp file"]}
    for stamp in stamps:
        colour = np.full((48, 64, 3), 60, np.uint8)
        far = np.full((48, 64), 10000 if tum else 2000, np.uint16)
        colour[6:20, 8:24] = 250
        far[6:20, 8:24] //= 2
        far[30:34, 40:50] = 0
        name = f"{stamp:.6f}.png" if tum else f"color_{int(stamp):04d}.png"
        deep = f"{stamp + 0.008:.6f}.png" if tum else f"depth_{int(stamp):04d}.png"
        write_picture(rgb / name, colour)
        lists["rgb"].append(f"{stamp:.6f} rgb/{name}")
        if stamp != 3.0:
            write_picture(depth / deep, far)
            lists["depth"].append(f"{stamp + 0.008:.6f} depth/{deep}")
    if tum:
        for kind, lines in lists.items():
            (folder / f"{kind}.txt").write_text("\n".join(lines))
    camera = {"fx": 60.0, "fy": 60.0, "ppx": 31.5, "ppy": 23.5, "depth_scale": 0.001}
    if tum:
        camera["depth_scale"] = 5000
    (folder / "intrinsics.json").write_text(json.dumps({"color": {}, "camera": camera}))


def blender_frame(path: Path, shift: float) -> None:
    """Multilayer EXR as Blender writes it: a lit square at 5 m before a far background."""
    import OpenImageIO as oiio

    height, width = 40, 60
    names = ["ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B",
             "ViewLayer.Combined.A", "ViewLayer.Depth.Z"]  # fmt: skip
    data = np.zeros((height, width, 5), np.float32)
    data[:, :, 4] = 1e10
    data[5:15, 10:20, :4] = 1
    data[5:15, 10:20, 4] = 5 + shift
    data[30:, 50:, :3] = 0.3  # a sky that is lit, but nowhere
    data[30:, 50:, 3] = 1
    spec = oiio.ImageSpec(width, height, 5, "float")
    spec.channelnames = tuple(names)
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), spec) and out.write_image(data)
    out.close()
