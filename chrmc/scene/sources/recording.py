"""Recordings of depth cameras and renderers: colour and depth with a perspective camera.

Colour and 16-bit depth pictures (PNG, TIFF) with a JSON of intrinsics, as RealSense, Open3D and the
TUM RGB-D set write them, or OpenEXR frames whose scene.json has a `camera`, `scale`, `offset` or
`depth_unit`.
"""

import re
from dataclasses import replace
from math import ceil, sqrt
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.colour import LUMINANCE, hue, linear
from chrmc.files import inside, read_json, read_text
from chrmc.progress import progress
from chrmc.ranges import short
from chrmc.scene.exr import read_exr
from chrmc.scene.points import PointCloud
from chrmc.scene.read_folder import numbered
from chrmc.scene.scene_json import SCENE_FILE
from chrmc.scene.sources.camera import Camera, camera_of
from chrmc.scene.sources.frames import CloudScene
from chrmc.scene.sources.images import read_samples
from chrmc.scene.sources.model import MOST_FRAMES, Model
from chrmc.scene.sources.volume import DEPTH, box, cell
from chrmc.scene.sources.world import number
from chrmc.scene.surface.recorded import Recorded
from chrmc.slm import SLM, WAVELENGTH

CAMERA_FILES = ("camera.json", "intrinsics.json", "camera_intrinsics.json", "calibration.json")
CAMERA_WORDS = {"camera", "scale", "offset", "depth_unit"}
ENDINGS = (".png", ".tif", ".tiff", ".jpg", ".jpeg")
TUM_SCALE = 1 / 5000
"""Metres per unit of the depth pictures of the TUM RGB-D set."""
TUM_CAMERA = (525.0, 525.0, 319.5, 239.5)
Pair = tuple[Path, Path]
"""Colour and depth of one frame."""
CLOSEST = 1e-6
"""Seconds between two frames."""
PAIR_WITHIN = 0.02
"""Seconds between the stamps of a colour and a depth picture of one frame."""
SEED = 20180917
EDGE = 0.05
"""Share of its depth by which a pixel may differ from its neighbours before it counts as one that
the camera mixed from an edge's two sides."""


def is_recording(path: Path) -> bool:
    """Whether a folder holds colour and depth pictures in a way that this module reads."""
    if not path.is_dir():
        return False
    if (path / "rgb.txt").is_file() and (path / "depth.txt").is_file():
        return True
    return any((path / name).is_file() for name in CAMERA_FILES) or bool(_words(path))


def _words(folder: Path) -> dict[str, Any]:
    """The scene.json of a folder of EXR frames, if it speaks of a camera."""
    path = folder / SCENE_FILE
    if not path.is_file():
        return {}
    content = read_json(path, "scene folder")
    if not isinstance(content, dict) or not CAMERA_WORDS & set(content):
        return {}
    return content


def read_recording(
    folder: Path,
    slm: SLM,
    wavelength: float | None = None,
    density: float | None = None,
    points: int | None = None,
    fit: bool = False,
) -> CloudScene:
    """A recording as a scene: what the camera saw, scaled to what the SLM shows.

    density : resolution cells of the SLM per pixel that is kept, default 0.25; points : of the
        first frame, instead
    fit : so that all frames lie in what the SLM shows, not the first one alone, whatever `scale`
        and `offset` say
    Pixels of depth 0 (no measurement) are left out, and so are pixels on the edge between two
    depths. Colour and depth pictures are paired by their time stamps or numbers; one without a
    partner is left out, and said.
    """
    pairs, notes, _ = _pairs(folder)
    light, depth, _ = _read(pairs[0])
    camera = _camera(folder, depth.shape)
    first, _ = _positions(light, depth, camera)
    if not len(first):
        raise ValueError(f"{pairs[0][1]} has no pixel with a depth: nothing to show")
    seen = [first]
    if fit:
        camera = replace(camera, scale=None, offset=None)
        for pair in progress(pairs[1:], "fit", unit="frame"):
            light, depth, _ = _read(pair)
            seen.append(_positions(light, depth, camera, 4)[0])
    low, high = np.percentile(np.concatenate(seen), [1, 99], axis=0)
    middle = (low + high) / 2
    width, height = box(slm, wavelength or WAVELENGTH, DEPTH)
    scale = camera.scale
    if scale is None:
        size = high - low
        scale = float(min(width / size[0], height / size[1], 0.1 * DEPTH / max(size[2], 1e-9)))
    offset = np.array(camera.offset or [0, 0, DEPTH]) - (0 if camera.offset else scale * middle)
    x, y = cell(slm, wavelength or WAVELENGTH, DEPTH)
    finest = min(x, y) / 2 if density is None else sqrt(density * x * y)
    spacing = scale * camera.pixel(float(np.median(first[:, 2])))
    step = max(1, int(finest / spacing))
    if points is not None:
        step = max(1, ceil(sqrt(len(first) / points)))
    why = " (the SLM resolves no more)" if density is points is None else ""
    notes.append(
        f"{folder.name}: {len(pairs)} frames, {(high - low)[0]:.3g} × {(high - low)[1]:.3g} × "
        f"{(high - low)[2]:.3g} m wide, tall and deep, shown {scale:.3g} times as large about "
        f"{offset[2] + scale * middle[2]:.4g} m"
        + (f", every {step}th row and column{why}" if step > 1 else "")
    )

    def read(number: int) -> dict[str, PointCloud]:
        cloud = _cloud(pairs[number - 1], camera, step)
        return {folder.name: replace(cloud, positions=offset + scale * cloud.positions)}

    return CloudScene(
        name=folder.resolve().name,
        read=read,
        frame_count=len(pairs),
        object_names=(folder.name,),
        notes=tuple(notes),
    )


def recorded_model(folder: Path) -> Model:
    """A recording as one object among others: metres about the camera, x right, y down.

    Frames follow each other at the rate of the time stamps, a missing one is its predecessor
    again; without stamps one picture is one frame.
    """
    if not is_recording(folder):
        raise ValueError(
            f"{folder} is no recording: it needs colour and depth pictures with the camera's JSON, "
            "or EXR frames with a scene.json that speaks of a camera"
        )
    pairs, notes, stamps = _pairs(folder)
    _, depth, _ = _read(pairs[0])
    camera = _camera(folder, depth.shape)

    def read(frame: int, step: int) -> PointCloud:
        return _cloud(pairs[shown[frame]], camera, step)

    rate, shown = None, np.arange(len(pairs))
    if len(stamps) > 1:
        since = np.array(stamps) - stamps[0]
        pause = max(float(np.quantile(np.diff(since), 0.5, method="lower")), CLOSEST)
        rate = 1 / pause
        count = int(min(round(since[-1] * rate) + 1, MOST_FRAMES))
        # Half a frame early counts as in time.
        shown = np.searchsorted(since, (np.arange(count) + 0.5) / rate) - 1
    if not len(read(0, 1)):
        raise ValueError(f"{pairs[0][1]} has no pixel with a depth: nothing to show")
    spacing = camera.pixel(float(np.median(read(0, 1).positions[:, 2])))
    body = Recorded.of(read, spacing)
    note = f"{folder.name}: {len(pairs)} pictures; its points have no identity from frame to frame"
    return Model({folder.name: body}, up="-y", rate=rate, frames=len(shown), notes=(*notes, note))


def _cloud(pair: Pair, camera: Camera, step: int) -> PointCloud:
    """What the camera saw, in its axes."""
    light, depth, colour = _read(pair)
    positions, index = _positions(light, depth, camera, step)
    phases = np.random.default_rng(SEED).uniform(0, 2 * np.pi, depth.shape)
    shown = None if colour is None else colour[index]
    # Lambert: a pixel's light is what its solid angle sends, whatever its distance.
    return PointCloud(positions, np.sqrt(light[index]), phases[index], shown)


def _camera(folder: Path, shape: tuple[int, ...]) -> Camera:
    words = _words(folder)
    if words:
        return camera_of(words, str(folder / SCENE_FILE), shape, unit=1.0)
    path = next((folder / n for n in CAMERA_FILES if (folder / n).is_file()), None)
    if path is None:
        return Camera(*TUM_CAMERA, TUM_SCALE)
    return camera_of(read_json(path, "recording"), str(path), shape)


def _pairs(folder: Path) -> tuple[list[Pair], list[str], list[float]]:
    """Colour and depth pictures of each frame in order of time, what was left out, and seconds of
    each frame where a list says them."""
    if (folder / "rgb.txt").is_file() and (folder / "depth.txt").is_file():
        colour, depth = (_listed(folder, folder / f) for f in ("rgb.txt", "depth.txt"))
        within = PAIR_WITHIN
    elif _words(folder):
        files = numbered(folder)
        return [(inside(folder, path), path) for path in files], [], []
    else:
        colour, depth = _found(folder)
        within = 0.0
    notes, pairs, times, used = [], [], [], set()
    stamps = np.array(sorted(colour))
    for stamp in sorted(depth):
        nearest = stamps[np.abs(stamps - stamp).argmin()]
        if abs(nearest - stamp) <= within and nearest not in used:
            used.add(nearest)
            pairs.append((inside(folder, colour[nearest]), inside(folder, depth[stamp])))
            times.append(stamp)
    lonely = len(depth) + len(colour) - 2 * len(pairs)
    if lonely:
        notes.append(f"{folder.name}: {lonely} pictures have no partner of their time; left out")
    if not pairs:
        raise ValueError(f"{folder}: no colour picture goes with a depth picture; see the docs")
    return pairs, notes, times if within else []


def _listed(folder: Path, path: Path) -> dict[float, Path]:
    """Stamps and files of a list as the TUM set has it."""
    found: dict[float, Path] = {}
    for line in read_text(path).splitlines():
        words = line.split()
        if len(words) < 2 or words[0].startswith("#"):
            continue
        try:
            stamp = number(float(words[0]), "a time stamp")
        except ValueError:
            raise ValueError(f"{path}: {short(line)} is no time stamp and file") from None
        if (folder / words[1]).is_file():
            found[stamp] = folder / words[1]
    if not found:
        raise ValueError(f"{path} lists no file that is there")
    return found


def _found(folder: Path) -> tuple[dict[float, Path], dict[float, Path]]:
    """Pictures by the number in their names: in folders called color or rgb and depth, or with
    these words in their names."""
    kinds: dict[bool, dict[float, Path]] = {False: {}, True: {}}
    for path in sorted(folder.rglob("*")):
        if path.suffix.lower() not in ENDINGS or path.name.startswith("."):
            continue
        words = path.relative_to(folder).as_posix().lower()
        deep = "depth" in words
        if not deep and not re.search(r"colou?r|rgb|image", words):
            continue
        digits = re.findall(r"\d+(?:\.\d+)?", path.stem)
        if not digits:
            raise ValueError(f"{path} has no number in its name: which frame is it?")
        kinds[deep][float(digits[-1])] = path
    if not kinds[False] or not kinds[True]:
        raise ValueError(
            f"{folder} needs colour and depth pictures: folders rgb and depth, or files such as "
            "color_0001.png and depth_0001.png"
        )
    return kinds[False], kinds[True]


Pictures = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64] | None]


def _read(pair: Pair) -> Pictures:
    """(H, W) light, (H, W) depth in the file's unit, and (H, W, 3) hue, None of grey."""
    if pair[0].suffix.lower() == ".exr":
        frame, _ = read_exr(pair[0])
        colour = None if frame.colour is None else frame.colour.astype(np.float64)
        return frame.intensity.astype(np.float64), np.where(frame.lit, frame.depth, 0), colour
    samples, raw = read_samples(pair[0]), read_samples(pair[1])
    if raw.dtype != np.uint16:
        raise ValueError(f"{pair[1]} has 8 bits; depth pictures have 16")
    if samples.shape[:2] != raw.shape[:2]:
        raise ValueError(
            f"{pair[0].name} has {samples.shape[1]} × {samples.shape[0]} pixels, {pair[1].name} "
            f"{raw.shape[1]} × {raw.shape[0]}: align colour and depth first"
        )
    coloured = samples.shape[2] >= 3
    rgb = linear(samples[:, :, : 3 if coloured else 1] / np.iinfo(samples.dtype).max)
    light = rgb @ LUMINANCE if coloured else rgb[:, :, 0]
    return light, raw[:, :, 0].astype(np.float64), hue(rgb) if coloured else None


def _positions(
    light: NDArray[np.float64], depth: NDArray[np.float64], camera: Camera, step: int = 1
) -> tuple[NDArray[np.float64], Any]:
    """(N, 3) metres in the camera's axes (x right, y down), and the pixels."""
    known = (depth > 0) & (depth != 65535) & (light > 0)
    # A pixel far from both neighbours of a row or column lies between two surfaces.
    for axis in (0, 1):
        before, after = np.roll(depth, 1, axis), np.roll(depth, -1, axis)
        far = np.minimum(np.abs(depth - before), np.abs(depth - after)) > EDGE * depth
        known &= ~far
    kept = np.zeros_like(known)
    kept[::step, ::step] = True
    v, u = np.nonzero(known & kept)
    return camera.place(u, v, depth[v, u]), (v, u)
