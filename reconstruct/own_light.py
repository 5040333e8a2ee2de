"""How much of a frame's light must be the objects', so that noise does not drown them.

An encoding adds light of its own: a twin image, the noise of few grey levels, of a phase without
its amplitude. How much depends on the part of the panel that the objects light. So what an
encoding leaves them is tried: points of random phase in the cells of their maps are encoded and
read again.
"""

from collections.abc import Sequence

import numpy as np

from chrmc.cgh import DEFAULT_METHOD, compute_field
from chrmc.grey_levels import encode
from chrmc.optics.footprint import coverage
from chrmc.scene.points import PointCloud
from reconstruct.four_f_system import FourF
from reconstruct.target import Target

OWN_LIGHT = 0.5
"""Of the share that the encoding leaves the objects: with less, noise has more light than they."""
_SEED = 7


def least_light(targets: Sequence[Target], system: FourF) -> float:
    """Share of a frame's light that must be the objects'; 0 where their light is not known."""
    return OWN_LIGHT * light_left(targets, system)


def light_left(targets: Sequence[Target], system: FourF) -> float:
    """Share of a frame's light that its encoding leaves the objects, about."""
    optics = system.slm, system.wavelength, system.coding.passband
    points = _stand_in(targets)
    points = points.select(coverage(points, *optics) > 0)
    if not points.amplitude.any():
        return 0.0
    field = compute_field(
        points, system.slm, system.wavelength, DEFAULT_METHOD, passband=optics[2], tolerance=1e-2
    )
    found = system.field(encode(field, system.slm, system.coding.name, response=system.response))
    both = np.vdot(field, field).real * np.vdot(found, found).real
    return float(abs(np.vdot(field, found)) ** 2 / both) if both > 0 else 0.0


def _stand_in(targets: Sequence[Target]) -> PointCloud:
    """A point in the middle of each lit cell; none where an object's light is not known."""
    clouds, known = [], all(target.power is not None for target in targets)
    for target in targets:
        light = target.light
        if light is None:
            return PointCloud.empty()
        cell = np.argwhere(light.lit)
        y, x = ((cell - (np.array(light.light.shape) - 1) / 2) * light.cell + light.centre).T
        z = light.depth[light.lit]
        power = 1.0 if not known or target.power is None else target.power
        amplitude = z * np.sqrt(power * light.light[light.lit])
        clouds.append(PointCloud(np.column_stack([x, y, z]), amplitude, np.zeros(len(z))))
    whole = PointCloud.concatenate(clouds)
    brightest = float(whole.amplitude.max(initial=0)) or 1.0
    phase = np.random.default_rng(_SEED).uniform(0, 2 * np.pi, len(whole))
    return PointCloud(whole.positions, whole.amplitude / brightest, phase)
