"""Curved hologram: the field as a low-rank matrix around each cluster's spherical wave.

A cluster's field is S(x, y)·m(x, y), S the separable reference wave from its centre. The baseband
m varies slowly, so that a few hundred even nodes in x and about a hundred in y fix it, and the
hologram is A_y·M·A_x: two matrix products, no per-pixel transcendental.

plan      clusters, axes, nodes, bandwidth, band, chebyshev
sum       condense, baseband, series, levels, tables, wave; exact (direct), or quick (rays)
assemble  assembly
predict   predict, before a pixel is computed, and verify, on some pixels

docs/curved.md tells it in order.
"""

from dataclasses import dataclass, replace
from functools import partial
from math import hypot

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh import rt
from chrmc.cgh.counts import OperationCounts
from chrmc.cgh.curved import clusters
from chrmc.cgh.curved.assembly import (
    Factor,
    Floats,
    add_field,
    reference_cycles,
    sum_signals,
)
from chrmc.cgh.curved.baseband import first_aim, make_factor
from chrmc.cgh.curved.clusters import Plane
from chrmc.cgh.curved.cost import cost_of
from chrmc.cgh.curved.direct import BEARABLE, QUICK, SMALL
from chrmc.cgh.curved.exact import exact_field
from chrmc.cgh.curved.nodes import Line
from chrmc.cgh.curved.predict import FEW_POINTS, Budget, draws_of, error_allowed
from chrmc.cgh.curved.rays import by_rays, rays_pay
from chrmc.cgh.curved.refusal import Refusal
from chrmc.cgh.curved.verify import SURE, SURE_OF_FEW, look
from chrmc.cgh.curved.wave import phasor
from chrmc.cgh.method import CGHMethod
from chrmc.encoding import Coding
from chrmc.optics.footprint import reach
from chrmc.optics.passband import Passband
from chrmc.parallel import alone, in_parallel
from chrmc.ranges import real
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM
from chrmc.window import Window

TOLERANCES = (1e-6, 1e-1)
"""Smallest and largest relative L2 error that can be asked for."""

_NEAR = 5.0  # times a tolerance, up to which another one is named
_FOR_FEW = 0.6  # of the first aim, where less may be expected: another attempt takes longer
_MUCH, _HARDLY = 0.1, 0.5  # closer nodes, of the aim before; an error all but as large as before


def check_tolerance(tolerance: float) -> float:
    """Itself, or ValueError outside TOLERANCES."""
    low, high = TOLERANCES
    tolerance = real("tolerance", tolerance)
    if not low <= tolerance <= high:
        raise ValueError(
            f"tolerance must lie between {low:g} and {high:g}, not {tolerance:g}: single "
            "precision ends at the one, and the other is already a tenth of the light"
        )
    return tolerance


def plane_of(slm: SLM, wavelength: float, window: Window, passband: Passband) -> Plane:
    """The window's pixel centres and the footprint's reach, as clusters are planned on."""
    x, y = slm.x(window.columns), slm.y(window.rows)
    return Plane(
        Line(float(x[0]), slm.pixel_pitch, len(x)),
        Line(float(y[0]), slm.pixel_pitch, len(y)),
        wavelength,
        (reach(wavelength, passband.fx_max), reach(wavelength, passband.fy_max)),
    )


@dataclass(frozen=True, eq=False)
class LowRank:
    """A cloud's hologram on a window in low-rank form.

    factors : one for each cluster
    clouds : their points
    budget : expected power of the field's error, and of the field
    """

    factors: list[Factor]
    clouds: list[PointCloud]
    budget: Budget

    @property
    def error_predicted(self) -> float:
        """Expected relative L2 error of the field."""
        return self.budget.relative


@alone
def low_rank(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    window: Window,
    passband: Passband,
    *,
    tolerance: float = 1e-3,
) -> LowRank:
    """The cloud's hologram on a window, cluster by cluster.

    Raises Refusal when the tolerance cannot be met.
    """
    check_tolerance(tolerance)
    plane = replace(plane_of(slm, wavelength, window, passband), points=len(cloud))
    # The largest first, so that the others fit beside it.
    parts = sorted(clusters.split(cloud, plane), key=len, reverse=True)
    draws = min(draws_of(cloud), round(sum(clusters.speckles(part, plane) for part in parts)))
    aim, before, closer = first_aim(tolerance), np.inf, 1.0
    aim *= _FOR_FEW if draws < FEW_POINTS else 1.0
    made: dict[int, tuple[Factor, Budget]] = {}
    due, trusted = list(range(len(parts))), True
    for _ in range(4):
        make = partial(make_factor, plane=plane, tolerance=aim)
        made |= zip(due, in_parallel(make, [parts[number] for number in due]), strict=True)
        factors = [made[number][0] for number in range(len(parts))]
        budget = sum((budget for _, budget in made.values()), Budget(0.0, 0.0))
        error, allowed = budget.relative, error_allowed(factors, tolerance, draws)
        least = budget.least
        due = _missing({n: one.error for n, (_, one) in made.items()}, allowed**2 * budget.light)
        if error <= allowed:
            due = list(range(len(parts)))
            seen = look(factors, cloud, plane, tolerance, error if trusted else 0.0, draws)
            trusted = False  # what was wrong once is not expected again: more pixels are looked at
            error = max(error, hypot(*seen))
            allowed = (SURE if draws >= FEW_POINTS else SURE_OF_FEW) * tolerance
            least = max(least, seen[1])
            if error <= allowed:
                return LowRank(factors, parts, Budget(error**2 * budget.light, budget.light))
        if least > allowed or not np.isfinite(error):
            break  # as where waves all but cancel: denser nodes would not mend it
        if closer < _MUCH and error > _HARDLY * before:
            break  # nor do they where they did not so far, and the next would take minutes
        before, closer = error, max(0.7 * allowed / error, 1e-3)
        aim *= closer
    enough = float(f"{2 * tolerance * error / allowed:.1g}")
    # Far from it, as where waves cancel, what coarser nodes would do nobody has tried.
    more = f"allow {enough:g}, or " if enough <= min(_NEAR * tolerance, TOLERANCES[1]) else ""
    raise Refusal(
        f"the curved method cannot promise a tolerance of {tolerance:g} here: it expects an error "
        f"of {error:.3g}, as where waves all but cancel; {more}use rt"
    )


def _missing(errors: dict[int, float], allowed: float) -> list[int]:
    """Those of some clusters that are to be made anew, in order: the others may miss a quarter of
    what is allowed together.

    errors : powers of each; allowed : of all
    """
    kept, spent = set(), 0.0
    for number in sorted(errors, key=errors.__getitem__):
        spent += errors[number]
        if spent <= allowed / 4:
            kept.add(number)
    return [number for number in sorted(errors) if number not in kept]


def _reference_waves(
    part: Factor,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    wavelength: float,
    carrier: float = 0.0,
) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """(cos, sin) of the factor's reference wave along x, and along y with the carrier on it."""
    reference = part.reference
    return (
        phasor(reference_cycles(x, reference.x, reference.z_x, wavelength)),
        phasor(reference_cycles(y, reference.y, reference.z_y, wavelength) + carrier * y),
    )


@alone
def field_of(
    parts: list[Factor],
    slm: SLM,
    wavelength: float,
    window: Window,
    base: NDArray[np.complex64] | None = None,
) -> NDArray[np.complex64]:
    """(H, W) complex64 field from factors, on top of a copy of `base`."""
    x, y = slm.x(window.columns), slm.y(window.rows)
    out = np.zeros(window.shape, dtype=np.complex64) if base is None else base.copy()
    for part in parts:
        add_field(out, part, *_reference_waves(part, x, y, wavelength))
    return out


@alone
def signal_of(
    parts: list[Factor],
    slm: SLM,
    wavelength: float,
    window: Window,
    carrier: float,
    base: NDArray[np.float32] | None = None,
) -> NDArray[np.float32]:
    """(H, W) float32 Re(field·exp(+2πi·carrier·y)) from factors, plus `base`."""
    x, y = slm.x(window.columns), slm.y(window.rows)
    phases = [_reference_waves(part, x, y, wavelength, carrier) for part in parts]
    return sum_signals(window.shape, parts, phases, base)


def field(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    window: Window,
    passband: Passband,
    *,
    tolerance: float = 1e-3,
) -> NDArray[np.complex64]:
    """Complex field on the window.

    tolerance : relative L2 error of the field against the float64 sum of spherical waves with
        the soft footprint, 1e-6 to 1e-1

    Returns complex64 (H, W), Σ w·a/r·exp(i(kr + φ)).
    """
    return field_and_error(cloud, slm, wavelength, window, passband, tolerance=tolerance)[0]


def field_and_error(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    window: Window,
    passband: Passband,
    *,
    tolerance: float = 1e-3,
) -> tuple[NDArray[np.complex64], float | None]:
    """`field`, and the relative L2 error expected of it; None where it is the exact sum."""
    summed = _sum(cloud, slm, wavelength, window, passband, tolerance)
    if isinstance(summed, LowRank):
        return field_of(summed.factors, slm, wavelength, window), summed.error_predicted
    return summed[0].astype(np.complex64, copy=False), summed[1]


def signal(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    window: Window,
    coding: Coding,
    *,
    tolerance: float = 1e-3,
) -> NDArray[np.float32]:
    """Re(field·exp(+2πi·carrier·y)) on the window, (H, W) float32, for half the work of `field`."""
    return signal_and_error(cloud, slm, wavelength, window, coding, tolerance=tolerance)[0]


def signal_and_error(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    window: Window,
    coding: Coding,
    *,
    tolerance: float = 1e-3,
) -> tuple[NDArray[np.float32], float | None]:
    """`signal`, and the relative L2 error expected of the field; None where it is the exact sum."""
    summed = _sum(cloud, slm, wavelength, window, coding.passband, tolerance)
    if isinstance(summed, LowRank):
        coded = signal_of(summed.factors, slm, wavelength, window, coding.carrier)
        return coded, summed.error_predicted
    turn = 2 * np.pi * coding.carrier * slm.y(window.rows)[:, None]
    real = summed[0].real * np.cos(turn) - summed[0].imag * np.sin(turn)
    return real.astype(np.float32), summed[1]


def _sum(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    window: Window,
    passband: Passband,
    tolerance: float,
) -> LowRank | tuple[NDArray[np.complexfloating], float | None]:
    """The low-rank form; or the exact sum, where that is little work or nothing else will do."""
    check_tolerance(tolerance)
    plane = plane_of(slm, wavelength, window, passband)
    work = len(cloud) * window.size

    def exact() -> NDArray[np.complex128]:
        x, y = slm.x(window.columns), slm.y(window.rows)
        return exact_field(cloud, x, y, wavelength, plane.reach, tolerance)

    if work <= SMALL:
        return exact(), None
    given = cloud, slm, wavelength, window, passband
    pay = rays_pay(*given, plane, tolerance)
    if pay and (rays := by_rays(*given, plane, tolerance)) is not None:
        return rays
    try:
        return low_rank(*given, tolerance=tolerance)
    except Refusal:
        if not pay and work > QUICK and (rays := by_rays(*given, plane, tolerance)) is not None:
            return rays
        if work <= BEARABLE:
            return exact(), None
        raise


def cost(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    window: Window,
    passband: Passband,
    *,
    tolerance: float = 1e-3,
) -> OperationCounts:
    """What `signal` takes, counted from its plan."""
    check_tolerance(tolerance)
    plane = replace(plane_of(slm, wavelength, window, passband), points=len(cloud))
    small = len(cloud) * window.size <= SMALL
    if not small and rays_pay(cloud, slm, wavelength, window, passband, plane, tolerance):
        return rt.cost(cloud, slm, wavelength, window, passband)
    return cost_of(cloud, plane, tolerance)


METHOD = CGHMethod(
    field,
    cost=cost,
    signal=signal,
    field_and_error=field_and_error,
    signal_and_error=signal_and_error,
    settings=tuple({"tolerance": 10.0**-digits} for digits in range(1, 7)),
)
