"""One object's hologram from frame to frame: computed, carried, corrected, and how wrong it is.

An error is relative to the light that a computation has. What is carried on, taken out again or
cancelled by another object leaves less light and the same error: so each track keeps the error
itself, and a sum is judged by the light that it has.
"""

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh import Method, field_and_error, method_named
from chrmc.compensation.ch_rmc_paper.blank import difference, extent, intersection
from chrmc.compensation.ch_rmc_paper.carry import Motion, carried_window, carry, moved
from chrmc.compensation.ch_rmc_paper.cylinder import Cylinder
from chrmc.compensation.ch_rmc_paper.error_correction import Rule, match, snr
from chrmc.compensation.held import showable
from chrmc.encoding import Coding
from chrmc.record import FrameRecord
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import ObjectFrame
from chrmc.slm import SLM
from chrmc.window import Window

_UNSTATED = 1e-5
"""Relative error that stands for one that a CGH method does not state, of exact sums for one."""
_WORSE = 2.0
"""Times a method's own error that a sum of its fields may have, where no tolerance is given."""


@dataclass(frozen=True, eq=False)
class Track:
    """What the video knows of one object.

    field : (H, W) its hologram; cloud : the points that are in it; ids : theirs, or None
    cylinder : of its present arc, or None
    missed : square of the L2 error that the CGH method expects of what it put in
    stated : relative error of what it last computed of the object afresh
    blank : pixels that its last motion left to compute
    carried : whether it holds more than was computed of the very points: whether any of it was
        carried, or shows points where they were
    """

    field: NDArray[np.complex64]
    cloud: PointCloud
    ids: NDArray[np.intp] | None
    missed: float
    stated: float
    cylinder: Cylinder | None = None
    blank: int = 0
    carried: bool = False

    @cached_property
    def power(self) -> float:
        """‖field‖²."""
        return power(self.field)


@dataclass(frozen=True)
class Work:
    """What every motion needs: the setting, and the CGH method on a window with its account."""

    slm: SLM
    wavelength: float
    cgh: str | Method
    coding: Coding
    cgh_options: dict[str, Any]
    radius: float
    rule: Rule
    snr_threshold: float
    pixel_pitch: float
    plane_spacing: float

    @property
    def states(self) -> bool:
        """Whether the CGH method says how wrong it is."""
        return method_named(self.cgh).field_and_error is not None

    def compute(self, cloud: PointCloud, window: Window) -> tuple[NDArray[np.complex64], float]:
        """The cloud's field on the window, and its relative error as the method expects it."""
        field, error = field_and_error(
            cloud,
            self.slm,
            self.wavelength,
            self.cgh,
            window=window,
            passband=self.coding.passband,
            **self.cgh_options,
        )
        if error is None:  # few waves are summed one by one, well within any tolerance
            error = min(_UNSTATED, self.cgh_options.get("tolerance", 1.0) / 2)
        return field, error

    def add(
        self,
        field: NDArray[np.complex64],
        cloud: PointCloud,
        window: Window,
        record: FrameRecord,
        sign: int = 1,
    ) -> float:
        """Add the cloud's field (or take it away) on the window, and book point·pixels; the square
        of the L2 error of that."""
        passband = self.coding.passband
        part = intersection(window, extent(cloud, self.slm, self.wavelength, passband))
        if not part.size:
            return 0.0
        made, error = self.compute(cloud, part)
        field[part.slices] += sign * made
        record.point_pixels += len(cloud) * part.size
        return error**2 * power(made)

    def fresh(self, cloud: PointCloud) -> Track:
        """Points computed on the whole panel, booked nowhere."""
        field, error = self.compute(cloud, Window.full(self.slm))
        return Track(field, cloud, None, error**2 * power(field), error)

    def key(self, obj: ObjectFrame, record: FrameRecord) -> Track:
        """The object computed afresh."""
        field = np.zeros(self.slm.shape, dtype=np.complex64)
        with record.stage("HC"):
            missed = self.add(field, obj.cloud, Window.full(self.slm), record)
        record.points_computed += len(obj.cloud)
        record.points_added += len(obj.cloud)
        stated = sqrt(missed / power(field)) if missed else 0.0
        return Track(field, obj.cloud, obj.ids, missed, stated)

    def advance(
        self, track: Track, obj: ObjectFrame, motion: Motion, record: FrameRecord
    ) -> tuple[Track, dict[str, Any]]:
        """The object one frame on, and notes on it."""
        slm, passband = self.slm, self.coding.passband
        with record.stage("EC"):
            before, ids = track.cloud, track.ids
            after = moved(before, motion)
            kept = showable(after, slm, self.wavelength, passband)
            if not kept.all():  # the arc leads some to where no pixel can show them
                before, after = before.select(kept), after.select(kept)
                ids = None if ids is None else ids[kept]
            both = None if ids is None or obj.ids is None else (ids, obj.ids)
            matching = match(
                after, obj.cloud, self.rule, self.pixel_pitch, self.plane_spacing, both
            )
            ratio = snr(after, obj.cloud, matching)
            correct = ratio < self.snr_threshold
            removed = after.select(matching.wrong)
            added = obj.cloud.select(matching.missing)
            shown = after
            if correct:
                shown = PointCloud.concatenate([after.select(~matching.wrong), added])
                if ids is not None and obj.ids is not None:
                    ids = np.concatenate([ids[~matching.wrong], obj.ids[matching.missing]])
        notes = {"snr": float(ratio) if np.isfinite(ratio) else None, "corrected": bool(correct)}
        cylinder, blank = track.cylinder, 0
        inexact = track.carried or motion is not None or not _same(shown, ids, obj)
        missed = track.missed
        if motion is None:
            reused = Window.full(slm)
            field = track.field.copy() if correct else track.field
        else:
            with record.stage("PE"):
                middle = track.cloud.centroid
                if not np.isfinite(middle).all():  # unlit points: any middle will do
                    middle = track.cloud.positions.mean(axis=0)
            carried, cylinder = carry(
                track.field, middle, motion, slm, self.wavelength, self.radius, record, cylinder
            )
            with record.stage("HC"):
                reused = carried_window(before, after, motion, slm, self.wavelength, passband)
                whole = extent(shown, slm, self.wavelength, passband)
                reused = intersection(reused, whole)
                field = np.zeros_like(carried)
                field[reused.slices] = carried[reused.slices]
                if missed:  # spread over the light, of which so much is left
                    missed *= power(field[reused.slices]) / (track.power or 1.0)
                for part in difference(whole, reused):
                    missed += self.add(field, shown, part, record)
                    blank += part.size
        if correct:
            with record.stage("EC"):
                # Blanks were filled with the corrected points already.
                missed += self.add(field, removed, reused, record, sign=-1)
                missed += self.add(field, added, reused, record)
            record.points_removed += len(removed)
            record.points_added += len(added)
            record.points_computed += len(removed) + len(added)

        found = Track(field, shown, ids, missed, track.stated, cylinder, blank, inexact)
        return found, notes

    def spoilt(self, tracks: Collection[Track], light: float) -> bool:
        """Whether tracks are more wrong than the CGH method promises.

        light : squared L2 norm of what they have together
        """
        promised = self.cgh_options.get("tolerance")
        if promised is None:
            promised = _WORSE * max((track.stated for track in tracks), default=0.0)
        return sum(track.missed for track in tracks) > promised**2 * light

    def together(
        self, tracks: Collection[Track], shown: PointCloud
    ) -> tuple[NDArray[np.complex64], float | None, bool]:
        """The field of all objects, its relative error as the CGH method expects it (None where it
        says nothing), and whether the points were computed together as the objects' light cancels.

        shown : the points of all objects
        """
        field = np.zeros(self.slm.shape, dtype=np.complex64)
        for track in tracks:
            field += track.field
        light, afresh = power(field), False
        if self.spoilt(tracks, light):
            field, error = self.compute(shown, Window.full(self.slm))
            afresh = True
        else:
            missed = sum(track.missed for track in tracks)
            error = sqrt(missed / light) if light > 0 else 0.0
        return field, error if self.states else None, afresh


def power(field: NDArray[np.complex64]) -> float:
    """‖field‖², summed in double precision."""
    parts = np.ascontiguousarray(field).view(np.float32)
    return float(np.einsum("ij,ij->", parts, parts, dtype=np.float64))


def _same(cloud: PointCloud, ids: NDArray[np.intp] | None, obj: ObjectFrame) -> bool:
    """Whether points are an object's own, in any order; so where identities are unknown, as what is
    carried then is what is shown."""
    if ids is None or obj.ids is None:
        return True
    if len(ids) != len(obj.ids):
        return False
    mine, its = np.argsort(ids), np.argsort(obj.ids)
    return np.array_equal(ids[mine], obj.ids[its]) and all(
        np.array_equal(a[mine], b[its])
        for a, b in (
            (cloud.positions, obj.cloud.positions),
            (cloud.amplitude, obj.cloud.amplitude),
            (cloud.phase, obj.cloud.phase),
        )
    )
