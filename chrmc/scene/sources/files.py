"""Scenes from what users have: files, several at once, text, scene.toml, recordings."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from chrmc.scene.load import HAS_ITS_POINTS
from chrmc.scene.points import PointCloud
from chrmc.scene.rgbd import DepthPlanes
from chrmc.scene.scene import Scene
from chrmc.scene.sources import readable
from chrmc.scene.sources.build import Built, build
from chrmc.scene.sources.export import is_export, read_export
from chrmc.scene.sources.recording import is_recording, read_recording
from chrmc.scene.sources.world import World, split_depth, world_of
from chrmc.scene.sources.world_toml import read_world
from chrmc.slm import LC_R_1080, SLM

PLANES = 256
"""Of the RGB-D form."""


def is_source(words: str) -> bool:
    """Whether this module knows what to do with a word of the command line."""
    path = Path(words)
    if path.suffix.lower() == ".toml" or is_recording(path):
        return True
    source = words if path.exists() else split_depth(words)[0]
    return readable(source) or is_recording(Path(source))


def load_sources(
    words: Sequence[str],
    form: str = "points",
    *,
    slm: SLM = LC_R_1080,
    wavelength: float | None = None,
    density: float | None = None,
    points: int | None = None,
    fit: bool = False,
) -> Scene:
    """The scene of one or several files, each at a depth where `@` says so.

    slm, wavelength : what they are sized and sampled for
    density : resolution cells of the SLM per point; points : on all surfaces, instead
    fit : scale and shift so that no frame leaves what the SLM shows
    """
    _check(density, points)
    single = Path(words[0]) if len(words) == 1 else None
    if single is not None and is_recording(single):
        return read_recording(single, slm, wavelength, density, points, fit)
    if single is not None and is_export(single):
        if (density, points, fit) != (None, None, False):
            raise ValueError(HAS_ITS_POINTS.format(single))
        return read_export(single)
    built = build_sources(
        words, slm=slm, wavelength=wavelength, density=density, points=points, fit=fit
    )
    return built.cast.points() if form == "points" else pictures(built, slm)


def build_sources(
    words: Sequence[str],
    *,
    slm: SLM = LC_R_1080,
    wavelength: float | None = None,
    density: float | None = None,
    points: int | None = None,
    fit: bool = False,
) -> Built:
    """Bodies and poses of files, and the world that was understood."""
    _check(density, points)
    world = _world(words)
    if density is not None or points is not None:
        world = replace(world, density=density, points=points)
    return build(world, slm, wavelength, fit)


def _check(density: float | None, points: int | None) -> None:
    if density is not None and not 1e-4 <= density <= 1e6:
        raise ValueError(f"--density is resolution cells per point, such as 0.5, not {density:g}")
    if points is not None and not 1 <= points <= 20_000_000:
        raise ValueError(f"--points must lie between 1 and 20 million, not {points}")
    if density is not None and points is not None:
        raise ValueError("density and points both say how many points there are; keep one")


def _world(words: Sequence[str]) -> World:
    toml = [w for w in words if Path(w).suffix.lower() == ".toml"]
    if toml and len(words) > 1:
        raise ValueError(f"{toml[0]} is a scene of its own: name it alone, and others inside it")
    return read_world(Path(toml[0])) if toml else world_of(list(words))


def pictures(built: Built, slm: SLM) -> Scene:
    """The RGB-D form: pictures of the panel's own raster, in 256 planes of depth."""
    cast = replace(built.cast, pixel_pitch=slm.pixel_pitch)
    low, high = np.inf, -np.inf
    for name, body in cast.bodies.items():
        reach = body.positions if isinstance(body, PointCloud) else body.vertices
        radius = float(np.linalg.norm(reach, axis=1).max(initial=0.0))
        for pose in cast.poses[name]:
            low = min(low, pose.translation[2] - radius)
            high = max(high, pose.translation[2] + radius)
    low = max(low, 1e-4)
    step = max((high - low) / (PLANES - 1), 1e-6)
    return cast.pictures(slm.shape, DepthPlanes(low, step, PLANES))


def cloud_from_file(path: str | Path, fit: SLM | None, points: int | None) -> PointCloud:
    """See `PointCloud.from_file`."""
    if fit is None:
        from chrmc.scene.sources import read_model

        model = read_model(str(path))
        clouds = [b for b in model.bodies.values() if isinstance(b, PointCloud)]
        if len(clouds) == len(model.bodies):
            return PointCloud.concatenate(clouds)
    scene = load_sources([str(path)], slm=fit or LC_R_1080, points=points)
    return scene.frame(1).cloud
