"""Waves along one axis of the hologram, over the separable reference wave."""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.wave import Reference, Wave, axis_cycles, phasors
from chrmc.optics.footprint import taper

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Along:
    """Waves of points along one axis, over the separable reference wave.

    x, z : (N,) places of the points along the axis, and their depths
    far : of the reference, along the other axis
    reach : half-width of a footprint per depth
    centre, z_centre : of the reference, along the axis
    rest : places along the axis (N, n) or (n,), the points' (N, 1) x and z, to what is not
        separable, on some line across; None without it
    """

    x: Floats
    z: Floats
    far: float
    reach: float
    centre: float
    z_centre: float
    wavelength: float
    rest: Callable[[Floats, Floats, Floats], NDArray[np.complex128]] | None = None

    def cycles(self, t: Floats) -> Floats:
        """(N, len(t)) cycles of the waves at places t."""
        return axis_cycles(
            t, self.x, np.hypot(self.z, self.far), self.centre, self.z_centre, self.wavelength
        )

    def waves(self, t: Floats) -> NDArray[np.complex128]:
        """(N, len(t)) waves at places t."""
        cycles = self.cycles(t)
        out = phasors(2 * pi * (cycles - np.rint(cycles)))
        if self.rest is not None:
            out *= self.rest(t, self.x[:, None], self.z[:, None])
        return out

    def weights(self, t: Floats) -> Floats:
        """(N, len(t)) soft footprint."""
        return taper(t - self.x[:, None], (self.reach * self.z)[:, None])


@dataclass(frozen=True)
class Across:
    """The other axis: what is not separable grows with the square of the distance from the centre.

    lines : two places, for which filters are made
    centre : of the reference
    """

    lines: tuple[float, float]
    centre: float

    def shares(self, t: Floats) -> tuple[Floats, Floats]:
        """(n,) weights of either line's filter at places t."""
        near, far = ((line - self.centre) ** 2 for line in self.lines)
        if far - near <= 1e-9 * far:  # all targets on one line, as on a panel of one column
            return np.ones(len(t)), np.zeros(len(t))
        share = ((t - self.centre) ** 2 - near) / (far - near)
        return 1 - share, share


def across(targets: tuple[float, float], centre: float) -> Across:
    """Two lines on which the square of the distance is about that of most targets."""
    ends = [(end - centre) ** 2 for end in targets]
    least = 0.0 if targets[0] < centre < targets[1] else min(ends)
    side = 1.0 if ends[1] > ends[0] else -1.0
    away = [sqrt(least + part * (max(ends) - least)) for part in (0.1, 0.75)]
    return Across((centre + side * away[0], centre + side * away[1]), centre)


def waves_along(wave: Wave, axis: int, points: Floats, across: Floats | None = None) -> Along:
    """Waves of points (3, N) along x (0) or y (1).

    across : (N,) place on the other axis where each is looked at; None without what is not
        separable
    """
    one = wave.reference
    far, centre, z_centre = ((one.far_y, one.x, one.z_x), (one.far_x, one.y, one.z_y))[axis]
    rest = None
    if across is not None:
        place = points[1 - axis][:, None]
        rest = rest_along(one, axis, across[:, None], place, wave.wavelength)
    return Along(
        points[axis], points[2], far, wave.reach[axis], centre, z_centre, wave.wavelength, rest
    )


def rest_along(
    reference: Reference, axis: int, line: Floats, place: Floats, wavelength: float
) -> Callable[[Floats, Floats, Floats], NDArray[np.complex128]]:
    """What is not separable along an axis, on a line across it, of points at a place across."""

    def rest(t: Floats, x: Floats, z: Floats) -> NDArray[np.complex128]:
        offsets = (t - x, line - place) if axis == 0 else (line - place, t - x)
        return reference.residual(*offsets, z, wavelength)

    return rest
