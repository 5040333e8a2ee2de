"""One scene in the light of several lasers: the same points, an amplitude for each wavelength."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from chrmc.colour import laser_powers
from chrmc.ranges import WAVELENGTH_RANGE
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import DepthStep, Pose, Scene, SceneFrame, as_scene


def cloud_in_light(cloud: PointCloud, wavelengths: Sequence[float], index: int) -> PointCloud:
    """A cloud as one of several lasers shows it: amplitude·√power, the power from its colour.

    White points keep their amplitude with every laser; `cloud` itself where all are white.
    """
    if cloud.colour is None:
        return cloud
    power = laser_powers(cloud.colour, wavelengths)[:, index]
    return PointCloud(cloud.positions, cloud.amplitude * np.sqrt(power), cloud.phase)


@dataclass(frozen=True, eq=False)
class SceneInLight:
    """A scene as the laser wavelengths[index] shows it; a scene in its own right.

    Its points are the scene's, in the same order and places; only amplitudes differ.
    """

    scene: Scene
    wavelengths: tuple[float, ...]
    index: int
    _bodies: dict[str, tuple[PointCloud, PointCloud]] = field(default_factory=dict, repr=False)

    @property
    def name(self) -> str:
        """The scene's."""
        return self.scene.name

    @property
    def form(self) -> str:
        """The scene's."""
        return self.scene.form

    @property
    def frame_count(self) -> int:
        """The scene's."""
        return self.scene.frame_count

    @property
    def object_names(self) -> Sequence[str]:
        """The scene's."""
        return self.scene.object_names

    @property
    def wavelength(self) -> float:
        """Of this laser, metres."""
        return self.wavelengths[self.index]

    @property
    def pixel_pitch(self) -> float:
        """The scene's, metres."""
        return self.scene.pixel_pitch

    @property
    def planes(self) -> DepthStep | None:
        """The scene's."""
        return self.scene.planes

    def pose(self, name: str, number: int) -> Pose | None:
        """The scene's."""
        return self.scene.pose(name, number)

    def frame(self, number: int) -> SceneFrame:
        """Frame `number` in this laser's light."""
        frame = self.scene.frame(number)
        objects = tuple(
            replace(
                o,
                cloud=cloud_in_light(o.cloud, self.wavelengths, self.index),
                body=None if o.body is None else self._body(o.name, o.body),
            )
            for o in frame.objects
        )
        return SceneFrame(frame.number, objects)

    def _body(self, name: str, body: PointCloud) -> PointCloud:
        # One and the same body in all frames, as methods that reuse a body's light expect.
        known = self._bodies.get(name)
        if known is None or known[0] is not body:
            known = (body, cloud_in_light(body, self.wavelengths, self.index))
            self._bodies[name] = known
        return known[1]


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
