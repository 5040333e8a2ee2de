"""A cluster's points to its low-rank factor, by way of sub-clusters where there are many."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import ceil, hypot, sqrt
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved import clusters, condense
from chrmc.cgh.curved.assembly import Factor, add_field, reference_cycles
from chrmc.cgh.curved.axes import NODE_SHARE, Axes, axes_behind, cluster_axes
from chrmc.cgh.curved.clusters import Plane
from chrmc.cgh.curved.levels import SINGLE, levels_for, precision_for
from chrmc.cgh.curved.nonuniform import nonuniform_baseband, transforms_pay
from chrmc.cgh.curved.predict import ROUNDING, Budget, expected_error, together
from chrmc.cgh.curved.refusal import Refusal
from chrmc.cgh.curved.series import Remainder, Series, make_series
from chrmc.cgh.curved.tables import (
    MOST_AT_ONCE,
    Tables,
    exact_baseband,
    sum_levels,
    table_pieces,
)
from chrmc.cgh.curved.wave import Reference, Wave, by_curvature, phasor
from chrmc.parallel import in_parallel, run_all
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Reals = NDArray[np.floating]

LEAF_SHARE = 0.7  # of the tolerance, for sub-clusters
_SERIES_SHARE = 0.6  # of the tolerance, for the series

_MOST_TERMS, _FEW = 120, 16  # terms of a series; points that are not split for it
MOST_WAVES = 2e8
"""Points times nodes of a hologram up to which waves are summed one by one, a few seconds."""
_QUICK = 1e7  # the same up to which that is quicker than smaller clusters
_MOST_LEAVES = 2000  # sub-clusters of a cluster, some 20 ms each
_TRIED, _ON = 4, 16  # sub-clusters whose nodes are tried, on so many points
_SAMPLES = 0.1  # of a series, for each wave that it saves
_INSTEAD = 4  # times as many, where waves may not be summed one by one
_POLYNOMIALS = 8  # of a point, that take no less than one wave
TIGHT, _ROOM = 2e-5, 0.9  # tolerances of long attempts; of any, what nodes and series aim at


def first_aim(tolerance: float) -> float:
    """What nodes and series aim at: a little less, for luck, and with room for rounding where
    attempts are long."""
    if tolerance > TIGHT:
        return _ROOM * tolerance
    allowed = max(0.64 * tolerance**2 - 1.2 * ROUNDING**2, 0.1 * tolerance**2)
    return sqrt(allowed)


Summed = tuple[Reals, Reals, Remainder]
"""Real and imaginary baseband (n_y, n_x) at given nodes, and what it misses."""


def make_factor(cloud: PointCloud, plane: Plane, tolerance: float) -> tuple[Factor, Budget]:
    """The low-rank factor of one cluster and its expected error."""
    box = clusters.bounding_box(cloud.positions)
    reference = clusters.reference_of(box, plane)
    axes = cluster_axes(cloud, reference, plane, tolerance)
    if not axes[0].blocks or not axes[1].blocks:
        return _no_light(axes, reference), Budget(0.0, 0.0)
    wave = Wave(reference, plane.wavelength, plane.reach)
    places = plane.x.places, plane.y.places
    expected: list[Budget] = []
    way = condense.condensing_of(box, len(cloud), axes, plane, tolerance)
    few = cloud if way is None else condense.condensed(cloud, way)
    plane = replace(plane, points=ceil(plane.points * len(few) / len(cloud)))
    lost = 0.0 if way is None else condense.SHARE * tolerance

    def expect(missed: Remainder) -> None:
        missed = Remainder(missed.series, hypot(missed.relative, lost))
        expected.append(expected_error(axes, cloud, places, wave, missed))

    real, imag, missed = sum_points(few, axes, reference, plane, tolerance, beside=expect)
    if not expected:
        expect(missed)
    factor = Factor(*axes, reference, *_single(real, imag))
    return factor, together(expected[0], factor)


def _no_light(axes: Axes, reference: Reference) -> Factor:
    empty = np.zeros((len(axes[1].nodes), len(axes[0].nodes)), dtype=np.float32)
    return Factor(*axes, reference, empty, empty)


def _single(real: Reals, imag: Reals) -> tuple[Singles, Singles]:
    return real.astype(np.float32, copy=False), imag.astype(np.float32, copy=False)


def sum_points(
    cloud: PointCloud,
    axes: Axes,
    reference: Reference,
    plane: Plane,
    tolerance: float,
    leaf: bool = False,
    series: Series | None = None,
    beside: Callable[[Remainder], None] | None = None,
    room: int = _MOST_LEAVES,
) -> Summed:
    """The baseband of a cloud at given nodes.

    leaf : sum all points at once, not by sub-clusters
    series : one made for these points and nodes, if there is
    beside : done while products are formed, if they are, with what they miss
    room : sub-clusters that it may be cut into
    """
    box = clusters.bounding_box(cloud.positions)
    nodes = len(axes[0].nodes), len(axes[1].nodes)
    if not leaf and transforms_pay(len(cloud), box, axes, reference, plane, tolerance):
        transformed = nonuniform_baseband(cloud, axes, reference, plane, tolerance)
        if transformed is not None:
            return transformed
    grid = (1, 1, 1) if leaf else clusters.leaf_grid(box, len(cloud), nodes, plane, tolerance)
    if grid != (1, 1, 1):
        parts = clusters.leaves(cloud, box, grid)
        return _from_leaves(parts, axes, reference, plane, tolerance, room)
    wave = Wave(reference, plane.wavelength, plane.reach)
    tables: Tables | None = None
    if series is None:
        tables = Tables() if len(cloud) <= MOST_AT_ONCE else None
        pieces: list[Callable[[], Any]] = [
            partial(series_for, cloud, axes, reference, plane, tolerance)
        ]
        if tables is not None:
            pieces += table_pieces(cloud, axes, wave, precision_for(tolerance), tables)
        series = run_all(pieces)[0]
    if series is None or series.terms > _MOST_TERMS:
        # The rest of the wave changes too much over the cluster: smaller ones, or none at all.
        each, most = nodes[0] * nodes[1], MOST_WAVES / plane.points
        if len(cloud) > _FEW and (each > most or len(cloud) * each > _QUICK):
            parts = clusters.leaves(cloud, box, (2, 2, 2))
            if 1 < len(parts) <= room:
                return _from_leaves(parts, axes, reference, plane, tolerance, room)
        if each <= most:
            return *exact_baseband(cloud, *axes, wave), Remainder()
        # As of one sub-cluster of many: a series that takes longer than its waves would.
        series = series_for(cloud, axes, reference, plane, tolerance, _INSTEAD * len(cloud))
        if series is None or series.terms > _MOST_TERMS:
            raise Refusal(
                f"points at {1e3 * box[2, 0]:.3g} mm would take {each:.1e} waves "
                f"each, more than {most:.1e}: no short series fits them; move them farther away "
                "or closer together, or take fewer"
            )
    levels, between = levels_for(cloud, axes, reference, plane, tolerance, series)
    missed = Remainder(series, between)
    expect = None if beside is None else partial(beside, missed)
    fine, *others = sum_levels(cloud, levels, wave, series, tables, expect)
    if others:
        more = np.zeros(fine[0].shape, dtype=np.complex64)
        still_x, still_y = ((np.ones(n), np.zeros(n)) for n in nodes)
        for level, small in zip(levels[1:], others, strict=True):
            if (level.axis_x, level.axis_y) == axes:
                more.real += small[0]
                more.imag += small[1]
                continue
            carried = Factor(level.axis_x, level.axis_y, reference, *_single(*small))
            add_field(more, carried, still_x, still_y)
        np.add(fine[0], more.real, out=fine[0])
        np.add(fine[1], more.imag, out=fine[1])
    return *fine, missed


def series_for(
    cloud: PointCloud,
    axes: Axes,
    reference: Reference,
    plane: Plane,
    tolerance: float,
    count: int | None = None,
) -> Series | None:
    """The series of the non-separable rest for a cloud's points and some nodes; None where
    summing points one by one or by smaller clusters is less work.

    count : points that the cloud stands for, its own by default
    """
    count = len(cloud) if count is None else count
    waves = len(axes[0].nodes) * len(axes[1].nodes)
    series = make_series(
        axes[0].span,
        axes[1].span,
        clusters.bounding_box(by_curvature(cloud.positions)),
        reference.kernel(plane.wavelength),
        tolerance * _SERIES_SHARE,
        # Beyond that, summing one by one or a smaller cluster's series is less work.
        max(20_000, _SAMPLES * count * waves),
    )
    if series is not None and len(series.orders) > _POLYNOMIALS * waves:
        return None
    return series


def _from_leaves(
    parts: list[PointCloud],
    axes: Axes,
    reference: Reference,
    plane: Plane,
    tolerance: float,
    room: int,
) -> Summed:
    """Baseband at a cluster's nodes, summed over sub-clusters' own few nodes."""
    x, y = axes[0].nodes, axes[1].nodes
    # Hundreds of sub-clusters add their rounding up.
    total = np.zeros((len(y), len(x)), dtype=np.complex64 if tolerance >= SINGLE else np.complex128)
    own_x = reference_cycles(x, reference.x, reference.z_x, plane.wavelength)
    own_y = reference_cycles(y, reference.y, reference.z_y, plane.wavelength)
    aim = LEAF_SHARE * tolerance
    lock = Lock()
    tried = {int(number) for number in np.linspace(0, len(parts) - 1, _TRIED)}
    read: dict[int, Budget] = {}

    def carry(number: int) -> float:
        part = parts[number]
        centre = clusters.reference_of(clusters.bounding_box(part.positions), plane)
        behind = axes_behind(axes, part, centre, plane, NODE_SHARE * aim)
        if not behind[0].blocks or not behind[1].blocks:
            return 0.0
        if number in tried:
            some = part.select(np.linspace(0, len(part) - 1, min(len(part), _ON)).astype(int))
            wave = Wave(centre, plane.wavelength, plane.reach)
            apart = expected_error(behind, some, (x, y), wave, Remainder())
            each = len(part) / len(some)
            read[number] = Budget(each * (apart.error - apart.rounding), each * apart.light)
        real, imag, missed = sum_points(
            part, behind, centre, plane, aim, leaf=True, room=room // len(parts)
        )
        factor = Factor(*behind, centre, *_single(real, imag))
        turn_x = phasor(reference_cycles(x, centre.x, centre.z_x, plane.wavelength) - own_x)
        turn_y = phasor(reference_cycles(y, centre.y, centre.z_y, plane.wavelength) - own_y)
        with lock:
            add_field(total, factor, turn_x, turn_y)
        dropped = missed.series.dropped if missed.series is not None else 0.0
        return hypot(dropped, missed.relative)

    dropped = max(in_parallel(carry, list(range(len(parts)))))
    # Footprints that end among a sub-cluster's own nodes may miss more than these are made for.
    seen = sum((read[number] for number in sorted(read)), Budget(0.0, 0.0))
    between = max(NODE_SHARE * aim, seen.relative)
    return total.real.copy(), total.imag.copy(), Remainder(None, hypot(dropped, between))
