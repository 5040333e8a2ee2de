"""What the nodes of a cluster must resolve along one axis."""

from dataclasses import dataclass
from math import hypot, log10, sqrt

# Waves for each digit that a length near the largest frequency must hold: around it, and beside it.
# Measured with blocks of 6 to 200 waves at 1e-2 to 1e-6.
_BENT, _SLOPING = 0.55, 0.16


@dataclass(frozen=True)
class Extent:
    """A cluster along one axis: lateral and depth range, reference centre, offsets across.

    across, beside : largest and smallest distance of a target from a point along the other axis,
        metres
    """

    low: float
    high: float
    z_low: float
    z_high: float
    centre: float
    z_centre: float
    across: float
    beside: float


@dataclass(frozen=True)
class Needs:
    """What an axis's nodes must resolve.

    extent, wavelength : of the cluster
    reach : footprint half-width per depth, inf for none
    tolerance : rms error of interpolation, of the light
    lit : metres of the axis that the light falls on
    block : spacings of nodes that a block should have, about
    """

    extent: Extent
    wavelength: float
    reach: float
    tolerance: float
    lit: float
    block: float


def bandwidth(low: float, high: float, needs: Needs) -> float:
    """Cycles per metre that nodes from low to high must resolve, of waves against the reference.

    The largest local frequency |∂phase/∂t|/2π, and some more: a wave that reaches F and stays
    within E of it over a length l only holds frequencies beyond F, up to where E·l is some waves.
    """
    extent = needs.extent
    centre, far = extent.centre, extent.z_centre

    def frequency(t: float, x: float, z: float) -> float:
        d, own = t - x, t - centre
        return abs(d / hypot(d, z) - own / hypot(own, far)) / needs.wavelength

    def step_for(z: float) -> float:
        """Over so little of the run, and of the distance, frequencies are all but parabolas."""
        return min((high - low) / 8, z / 4)

    largest, where, of = 0.0, low, (extent.low, extent.z_low)
    for z in (hypot(extent.z_low, extent.beside), hypot(extent.z_high, extent.across)):
        # The directions of two points differ most between them, if they are side by side, and
        # this far aslant, if one is behind the other.
        aslant = (z * far) ** (2 / 3) / sqrt(z ** (2 / 3) + far ** (2 / 3))
        step = step_for(z)
        for x in (extent.low, extent.high):
            middle = (x + centre) / 2
            tried = (min(max(t, low), high) for t in (low, middle - aslant, middle, middle + aslant,
                                                      high))  # fmt: skip
            here, spot = max((frequency(t, x, z), t) for t in tried)
            for finer in (1.0, 0.5, 0.25, 0.125):  # points are both at once
                for t in (spot - finer * step, spot + finer * step):
                    if low <= t <= high and (there := frequency(t, x, z)) > here:
                        here, spot = there, t
            if here > largest:
                largest, where, of = here, spot, (x, z)
    step = step_for(of[1])
    if largest <= 0 or step <= 0:
        return largest
    waves = -log10(needs.tolerance)
    # Of about 1.25 nodes for each that Nyquist asks for.
    block = (high - low) / max(1.0, 2.5 * largest * (high - low) / needs.block)

    def fall(by: float) -> float:
        return largest - frequency(where + by, *of)

    if low + step <= where <= high - step:
        slope, bend = 0.0, max(fall(step) + fall(-step), 0.0) / (2 * step**2)
    else:
        inwards = step if where < low + step else -step
        bend = max(fall(2 * inwards) - 2 * fall(inwards), 0.0) / (2 * step**2)
        slope = max(fall(inwards) / step - bend * step, 0.0)
    bent = min((_BENT * waves) ** (2 / 3) * (bend / 4) ** (1 / 3), bend * block**2)
    sloping = min(sqrt(_SLOPING * waves * slope), slope * block / 2)
    return largest + max(bent, sloping)
