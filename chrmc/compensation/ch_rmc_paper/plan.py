"""Parameter extraction (PE): what every object does between frames, from its positions."""

import numpy as np
from numpy.typing import NDArray

from chrmc.compensation.ch_rmc_paper.carry import Motion, Rotation, Translation
from chrmc.scene.motion import find_motion, position_noise
from chrmc.scene.scene import ObjectFrame, Scene

PIXEL_SHARE = 0.05
"""Noise of a centroid of pixels, in scene pixels: quantisation, and other sides coming to view."""


def plan(scene: Scene) -> dict[str, dict[int, Motion]]:
    """Object name to frame number to the motion that leads there; no entry where unknown.

    The whole scene is looked at, so that a clip or a resumed run finds the same arcs. An object's
    position is its pose's where that is known, else the centroid of its visible points.
    """
    count = scene.frame_count
    known = {name: True for name in scene.object_names}
    places = {name: np.full((count, 3), np.nan) for name in scene.object_names}
    for number in range(1, count + 1):
        for obj in scene.frame(number).objects:
            places[obj.name][number - 1] = place(obj)
            known[obj.name] &= obj.pose is not None
    least = PIXEL_SHARE * scene.pixel_pitch
    return {name: motions(path, 0.0 if known[name] else least) for name, path in places.items()}


def place(obj: ObjectFrame) -> NDArray[np.float64]:
    """(3,) where the object is, metres; NaN when it is not seen."""
    if len(obj.cloud) == 0:
        return np.full(3, np.nan)
    return obj.position if obj.pose is None else obj.pose.translation


def motions(path: NDArray[np.float64], least_noise: float = 0.0) -> dict[int, Motion]:
    """Frame number to motion, from (N, 3) positions of frames 1 … N and their noise, metres."""
    plane = path[:, [0, 2]]
    found = find_motion(plane, noise=max(least_noise, position_noise(plane)))
    out: dict[int, Motion] = {}
    for number in range(2, len(path) + 1):
        segment = found.at(number)
        if segment is None:
            continue
        by = path[number - 1] - path[number - 2]
        if segment.centre is not None:
            angle = found.angle(number)
            out[number] = Rotation(segment.centre, angle) if angle else None
        elif segment.kind == "translation" or abs(by[1]) > found.noise:
            out[number] = Translation((float(by[0]), float(by[1]), float(by[2])))
        else:
            out[number] = None
    return out
