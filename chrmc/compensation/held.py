"""What a hologram holds: the points whose fringes sum up to it, and what must change in them."""

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh import Method, compute_field, method_named
from chrmc.compensation.ch_rmc_paper.error_correction import RULES, match, rule_named
from chrmc.compensation.frame import FieldMaker
from chrmc.optics.footprint import expected_power, reach
from chrmc.optics.passband import Passband
from chrmc.record import FrameRecord
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import ObjectFrame, Scene, SceneFrame
from chrmc.slm import SLM
from chrmc.window import Window

PLANE_SPACING = 1e-4
"""Depth-plane distance of scenes that name none, metres."""
EXACT = 1e-9
"""Metres within which the rule "exact" calls two places the same."""
WORN = 2500.0
"""Times the light that a hologram shows that may have been taken out of it since it was computed
whole: each amplitude leaves 1e-7 in rounding, so all of them 5e-6 of what is shown."""
CANCELLED = 1e-6
"""Share of the points' light, one by one, below which a sum of parts is not taken."""


@dataclass(frozen=True, eq=False)
class Held:
    """Points of one object in the hologram.

    ids : their identities, or None where unknown
    """

    cloud: PointCloud
    ids: NDArray[np.intp] | None

    @classmethod
    def of(cls, obj: ObjectFrame) -> "Held":
        """All that an object shows."""
        return cls(obj.cloud, obj.ids)

    @classmethod
    def empty(cls, like: ObjectFrame) -> "Held":
        """Nothing yet, of an object with or without identities."""
        ids = None if like.ids is None else np.zeros(0, dtype=np.intp)
        return cls(PointCloud.empty(), ids)

    def select(self, index: NDArray[np.bool_] | NDArray[np.intp]) -> "Held":
        """Some of the points."""
        return Held(self.cloud.select(index), None if self.ids is None else self.ids[index])

    def __len__(self) -> int:
        return len(self.cloud)


@dataclass(frozen=True)
class Matcher:
    """When a held point and one of the scene count as the same.

    rule : "exact" (same place to 1 nm, same intensity), or "strict" or "tolerant" as in
        `chrmc.compensation.ch_rmc_paper.error_correction`
    pixel_pitch, plane_spacing : of the scene's images, metres
    """

    rule: str
    pixel_pitch: float
    plane_spacing: float

    @classmethod
    def of(cls, scene: Scene, matching: str | None) -> "Matcher":
        """The matcher of a scene; default "exact" with known identities, else "strict".

        An RGB-D scene's points have no place within their pixel and plane, so "exact" means
        "strict" there.
        """
        if matching is None:
            matching = "strict" if scene.form == "rgbd" else "exact"
        if matching != "exact" and matching not in RULES:
            raise ValueError(
                f"unknown matching rule {matching!r}: choose one of exact, {', '.join(RULES)}"
            )
        if matching == "exact" and scene.form == "rgbd":
            matching = "strict"
        planes = scene.planes
        return cls(matching, scene.pixel_pitch, planes.step if planes else PLANE_SPACING)

    def compare(self, held: Held, obj: ObjectFrame) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Masks of the held points that the scene has not, and of its points that are not held."""
        exact = self.rule == "exact"
        rule = rule_named("strict" if exact else self.rule)
        pitch, spacing = self.pixel_pitch, self.plane_spacing
        if exact:
            pitch = spacing = 2 * EXACT
        if held.ids is not None and obj.ids is not None:
            found = match(held.cloud, obj.cloud, rule, pitch, spacing, (held.ids, obj.ids))
            return found.wrong, found.missing
        wrong, missing = _without_twins(held.cloud, obj.cloud)
        found = match(held.cloud.select(wrong), obj.cloud.select(missing), rule, pitch, spacing)
        wrong[wrong], missing[missing] = found.wrong, found.missing
        return wrong, missing


def _without_twins(a: PointCloud, b: PointCloud) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Masks of the points of two clouds but those that both have, each as often as both do."""
    rows = [np.column_stack([cloud.positions, cloud.amplitude, cloud.phase]) for cloud in (a, b)]
    _, kind = np.unique(np.concatenate(rows), axis=0, return_inverse=True)
    kind = kind.reshape(-1)
    keys = [_numbered(part, len(kind)) for part in (kind[: len(a)], kind[len(a) :])]
    _, i, j = np.intersect1d(keys[0], keys[1], return_indices=True)
    only_a, only_b = np.ones(len(a), dtype=bool), np.ones(len(b), dtype=bool)
    only_a[i] = only_b[j] = False
    return only_a, only_b


def _numbered(kind: NDArray[np.intp], most: int) -> NDArray[np.intp]:
    """(N,) keys that differ: of each kind how many stand before."""
    order = np.argsort(kind, kind="stable")
    before = np.empty_like(kind)
    before[order] = np.arange(len(kind)) - np.searchsorted(kind[order], kind[order])
    return kind * most + before


@dataclass(frozen=True, eq=False)
class Correction:
    """Points to take out of a hologram, and points to put in."""

    removed: PointCloud
    added: PointCloud

    @property
    def signed(self) -> PointCloud:
        """Both as one cloud, the removed ones negative: to the bit what was put in."""
        out = PointCloud(self.removed.positions, -self.removed.amplitude, self.removed.phase)
        return PointCloud.concatenate([out, self.added])

    def __len__(self) -> int:
        return len(self.removed) + len(self.added)


def objects_of(frame: SceneFrame, held: Mapping[str, Held]) -> list[ObjectFrame]:
    """A frame's objects, and without points those that are held and that it does not have."""
    present = {obj.name for obj in frame.objects}
    gone = [
        ObjectFrame(name, PointCloud.empty(), None, None if it.ids is None else it.ids[:0])
        for name, it in held.items()
        if name not in present
    ]
    return [*frame.objects, *gone]


def correct(held: Held, obj: ObjectFrame, matcher: Matcher) -> tuple[Held, Correction]:
    """What the hologram holds after correction, and the correction.

    Kept points keep their places and phases: they are what the hologram shows.
    """
    wrong, missing = matcher.compare(held, obj)
    correction = Correction(held.cloud.select(wrong), obj.cloud.select(missing))
    kept = held.select(~wrong)
    ids = None
    if kept.ids is not None and obj.ids is not None:
        ids = np.concatenate([kept.ids, obj.ids[missing]])
    return Held(PointCloud.concatenate([kept.cloud, correction.added]), ids), correction


def showable(
    cloud: PointCloud, slm: SLM, wavelength: float, passband: Passband
) -> NDArray[np.bool_]:
    """(N,) points that some pixel can show, as `chrmc.optics.footprint.check_showable` has it."""
    z = cloud.positions[:, 2]
    out = z > 0
    for axis, (count, f_max) in enumerate(
        ((slm.width, passband.fx_max), (slm.height, passband.fy_max))
    ):
        at = cloud.positions[:, axis]
        index = np.clip(np.rint(at / slm.pixel_pitch + (count - 1) / 2), 0, count - 1)
        gap = np.abs(at - (index - (count - 1) / 2) * slm.pixel_pitch)
        out &= gap < z * reach(wavelength, f_max)
    return out


@dataclass(frozen=True, eq=False)
class Computer:
    """A CGH method with everything but the points and the window, which keeps the ledger."""

    slm: SLM
    wavelength: float
    cgh: str | Method
    passband: Passband
    options: dict[str, Any]

    def compute(
        self, cloud: PointCloud, record: FrameRecord, stage: str, window: Window | None = None
    ) -> NDArray[np.complex64]:
        """The field of a cloud, its time booked on a stage; see `book` for the points."""
        return self._by(self.cgh, cloud, record, stage, window)

    def change(
        self, cloud: PointCloud, record: FrameRecord, stage: str, window: Window | None = None
    ) -> NDArray[np.complex64]:
        """The same of points that change a hologram: what others change with them must not decide
        how each is computed, or what is put in is not what is taken out."""
        method = method_named(self.cgh)
        if method.one_by_one is not None:
            method = replace(method, field=method.one_by_one)
        return self._by(method, cloud, record, stage, window)

    def settled(
        self, field: NDArray[np.complex64], shown: PointCloud, record: FrameRecord
    ) -> NDArray[np.complex64]:
        """A frame's field put together from parts; computed whole where their waves all but cancel,
        of which parts leave little but rounding."""
        if np.vdot(field, field).real >= CANCELLED * field.size * self.light(shown):
            return field
        return self.compute(shown, record, "HC")

    def _by(
        self,
        method: str | Method,
        cloud: PointCloud,
        record: FrameRecord,
        stage: str,
        window: Window | None,
    ) -> NDArray[np.complex64]:
        with record.stage(stage):
            return compute_field(
                cloud,
                self.slm,
                self.wavelength,
                method,
                window=window,
                passband=self.passband,
                **self.options,
            )

    def visible(self, held: Held) -> Held:
        """Without the points that no pixel can show: they have no fringe to hold."""
        mask = showable(held.cloud, self.slm, self.wavelength, self.passband)
        return held if mask.all() else held.select(mask)

    def light(self, cloud: PointCloud) -> float:
        """The power on the hologram that points are expected to have one by one."""
        return float(expected_power(cloud, self.slm, self.wavelength, self.passband).sum())

    def book(self, record: FrameRecord, correction: Correction) -> None:
        """Count a correction over the whole hologram."""
        record.points_computed += len(correction)
        record.points_added += len(correction.added)
        record.points_removed += len(correction.removed)
        record.point_pixels += len(correction) * self.slm.width * self.slm.height


S = TypeVar("S")


class Chain(Generic[S]):
    """Fields that follow from one another, computed only when one is asked for.

    Asking for a frame makes all frames before it. One that was passed by is made afresh from its
    points: the same field, to the CGH method's accuracy.
    """

    def __init__(self, state: S) -> None:
        self._state = state
        self._pending: deque[Callable[[S], S]] = deque()
        self._made = 0
        self._frames = 0

    def then(
        self,
        update: Callable[[S], S],
        render: Callable[[S], NDArray[np.complex64]],
        afresh: FieldMaker,
    ) -> FieldMaker:
        """The maker of the next frame's field.

        update : state before to state after; render : a new array from the state after
        """
        self._pending.append(update)
        self._frames += 1
        number = self._frames

        def make() -> NDArray[np.complex64]:
            if self._made > number:
                return afresh()
            while self._made < number:
                self._state = self._pending.popleft()(self._state)
                self._made += 1
            return render(self._state)

        return make
