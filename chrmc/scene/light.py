"""One scene in the light of several lasers: the same points, an amplitude for each wavelength."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from chrmc.colour import laser_powers
from chrmc.ranges import WAVELENGTH_RANGE
from chrmc.scene.derived import DerivedScene
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Scene, SceneFrame, as_scene


def cloud_in_light(cloud: PointCloud, wavelengths: Sequence[float], index: int) -> PointCloud:
    """A cloud as one of several lasers shows it: amplitude·√power, the power from its colour.

    White points keep their amplitude with every laser; `cloud` itself where all are white.
    """
    if cloud.colour is None:
        return cloud
    power = laser_powers(cloud.colour, wavelengths)[:, index]
    return PointCloud(cloud.positions, cloud.amplitude * np.sqrt(power), cloud.phase)


@dataclass(frozen=True, eq=False, repr=False)
class SceneInLight(DerivedScene):
    """A scene as the laser wavelengths[index] shows it; a scene in its own right.

    Its points are the scene's, in the same order and places; only amplitudes differ.
    """

    wavelengths: tuple[float, ...]
    index: int

    @property
    def wavelength(self) -> float:
        """Of this laser, metres."""
        return self.wavelengths[self.index]

    def frame(self, number: int) -> SceneFrame:
        """Frame `number` in this laser's light."""
        frame = self.scene.frame(number)
        objects = tuple(
            replace(
                o,
                cloud=self._lit(o.cloud),
                body=None if o.body is None else self._same_body(o.name, o.body, self._lit),
            )
            for o in frame.objects
        )
        return SceneFrame(frame.number, objects)

    def _lit(self, cloud: PointCloud) -> PointCloud:
        return cloud_in_light(cloud, self.wavelengths, self.index)


def scenes_in_light(scene: Scene, wavelengths: Sequence[float]) -> tuple[SceneInLight, ...]:
    """A scene for each of several lasers.

    wavelengths : metres, visible, all different; a further laser is one further number
    """
    lasers = tuple(WAVELENGTH_RANGE.of(w) for w in wavelengths)
    if len(set(lasers)) != len(lasers) or not lasers:
        raise ValueError(f"{len(lasers)} lasers need as many different wavelengths, not {lasers}")
    laser_powers([[1.0, 1.0, 1.0]], lasers)  # refuses lasers that mix to no white
    complete = as_scene(scene)
    return tuple(SceneInLight(complete, lasers, k) for k in range(len(lasers)))
