"""One look at a scene before its first hologram: the brightest frame, and what tells it apart.

All frames are looked at up to `LOOKED_AT` of them; of a longer scene that many, spread evenly, the
first and the last among them. The fingerprint is the SHA-256 of the points (places, amplitudes,
phases) of the frames looked at. The spot check is the same over at most `SPOTS` of them: it lets a
run that is continued rely on its manifest without a second look.
"""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from chrmc.encoding import Coding
from chrmc.optics.footprint import expected_power
from chrmc.progress import progress
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Scene
from chrmc.slm import SLM

LOOKED_AT = 1000
SPOTS = 16


@dataclass(frozen=True)
class Survey:
    """What one look at a scene tells.

    power : Σ expected_power of the brightest frame
    fingerprint, spot_check : hexadecimal SHA-256, see above
    """

    power: float
    fingerprint: str
    spot_check: str


def spread_frames(frame_count: int, most: int) -> list[int]:
    """At most so many frame numbers, spread evenly over 1 … frame_count, both ends included."""
    if frame_count <= most:
        return list(range(1, frame_count + 1))
    return np.unique(np.rint(np.linspace(1, frame_count, most)).astype(int)).tolist()


def looked_at(frame_count: int) -> list[int]:
    """Frame numbers of the whole look, those of the spot check among them."""
    every = spread_frames(frame_count, LOOKED_AT) + spread_frames(frame_count, SPOTS)
    return sorted(set(every))


def survey(scene: Scene, slm: SLM, wavelength: float, coding: Coding) -> Survey:
    """Look at a scene once, with a progress bar."""
    return surveys([(scene, wavelength)], slm, coding)[0]


def surveys(lit: Sequence[tuple[Scene, float]], slm: SLM, coding: Coding) -> list[Survey]:
    """Look at scenes of equally many frames side by side, each in light of its wavelength
    (metres)."""
    frame_count = lit[0][0].frame_count
    spots = set(spread_frames(frame_count, SPOTS))
    digests = [(hashlib.sha256(), hashlib.sha256()) for _ in lit]
    brightest = [0.0] * len(lit)
    for number in progress(looked_at(frame_count), "reading the scene"):
        for k, (scene, wavelength) in enumerate(lit):
            cloud = scene.frame(number).cloud
            _add(digests[k][0], cloud)
            if number in spots:
                _add(digests[k][1], cloud)
            power = expected_power(cloud, slm, wavelength, coding.passband)
            brightest[k] = max(brightest[k], float(power.sum()))
    return [
        Survey(power, whole.hexdigest(), part.hexdigest())
        for power, (whole, part) in zip(brightest, digests, strict=True)
    ]


def spot_check(scene: Scene) -> str:
    """The scene's spot check alone."""
    digest = hashlib.sha256()
    for number in spread_frames(scene.frame_count, SPOTS):
        _add(digest, scene.frame(number).cloud)
    return digest.hexdigest()


def fingerprint(scene: Scene) -> str:
    """The scene's fingerprint alone."""
    digest = hashlib.sha256()
    for number in looked_at(scene.frame_count):
        _add(digest, scene.frame(number).cloud)
    return digest.hexdigest()


def _add(digest: Any, cloud: PointCloud) -> None:
    for values in (cloud.positions, cloud.amplitude, cloud.phase):
        digest.update(np.ascontiguousarray(values).data)
