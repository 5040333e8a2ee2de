"""CH-RMC on a sphere around each object: the curved hologram where it is exact.

Rotating an object about its centre turns the directions of its light and changes nothing else;
any rigid motion is such a rotation and a new centre. So an object's baseband is summed once per
key group on a sphere of directions, in a few layers of range. A frame looks it up along the
turned directions at its few thousand nodes, takes the object's new spherical wave as reference,
adds and removes the points whose visibility changed, and multiplies two matrices.

Needs objects with a body and a pose (`ObjectFrame.body`, `.ids`, `.pose`). Where identities are
unknown (RGB-D frames) nothing says how a point moved, and a freshly quantised twin of a moved
point has another phase: such an object is computed afresh by the same low-rank form whenever its
points differ, and the frame is a key frame. The CGH method has to be `curved`: these are basebands.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from chrmc.cgh import Method
from chrmc.cgh.curved.interface import (
    SMALL,
    SURE,
    Budget,
    Factor,
    Refusal,
    alone,
    check_tolerance,
    low_rank,
    plane_of,
)
from chrmc.compensation import none
from chrmc.compensation.ch_rmc_object.choice import MOST_VALUES, Patience, choose, poses_ahead
from chrmc.compensation.ch_rmc_object.group import Group
from chrmc.compensation.ch_rmc_object.plan import Outline, Plan, outline_of, planned, same_light
from chrmc.compensation.ch_rmc_object.promise import AIM, Promise
from chrmc.compensation.ch_rmc_object.render import Renderer
from chrmc.compensation.ch_rmc_object.sphere import NotCovered
from chrmc.compensation.frame import VideoFrame
from chrmc.encoding import Coding
from chrmc.optics.footprint import check_showable
from chrmc.record import FrameRecord
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import ObjectFrame, Pose, Scene, SceneFrame
from chrmc.slm import SLM
from chrmc.window import Window


@dataclass(eq=False)
class _Track:
    """What is kept of one object from frame to frame.

    version : another for each time it is worked out
    """

    obj: ObjectFrame
    factors: list[Factor]
    budget: Budget
    group: Group | None
    version: int


def frames(
    scene: Scene,
    slm: SLM,
    wavelength: float,
    cgh: str | Method,
    numbers: range,
    coding: Coding,
    *,
    tolerance: float = 1e-3,
    reuse: str = "auto",
) -> Iterator[VideoFrame]:
    """Frames by object-centred CH-RMC.

    cgh : "curved"
    tolerance : relative L2 error of every frame's field against the float64 truth
    reuse : "auto" looks an object up where that costs less than computing it afresh, as counted
        from the shapes of the work, and sums up to 1e6 points times pixels one by one; "always"
        wherever it can be; the record's `reuse` says which

    The record's `error_predicted` stays below the tolerance: an object is keyed anew before it
    would pass it, and where no key frame helps the frame is made as without compensation, in double
    precision if need be, or refused by ValueError when it is asked for. `blank_share` is the share
    of the hologram in which soft footprint edges are summed from the points in every frame.
    """
    if cgh != "curved":
        name = cgh if isinstance(cgh, str) else getattr(cgh, "__name__", "this one")
        raise ValueError(
            f"ch-rmc with surface object works on the curved method's baseband, not on {name}: "
            "choose cgh curved, or surface paper"
        )
    check_tolerance(tolerance)
    if reuse not in ("auto", "always"):
        raise ValueError(f'reuse must be "auto" or "always", not {reuse!r}')
    return _Maker(scene, slm, wavelength, numbers, coding, tolerance, reuse == "always").frames()


class _Maker:
    def __init__(
        self,
        scene: Scene,
        slm: SLM,
        wavelength: float,
        numbers: range,
        coding: Coding,
        tolerance: float,
        always: bool,
    ) -> None:
        self._always = always
        self._scene, self._slm, self._wavelength = scene, slm, wavelength
        self._numbers, self._coding, self._tolerance = numbers, coding, tolerance
        self._window = Window.full(slm)
        self._plane = plane_of(slm, wavelength, self._window, coding.passband)
        self._promise = Promise(self._plane, tolerance)
        self._tracks: dict[str, _Track] = {}
        self._outlines: dict[str, Outline] = {}
        self._versions = 0
        self._patience = Patience()
        self._renderer = Renderer(slm, wavelength, self._window, coding)
        self._whole: tuple[tuple[int, ...], _Track | None, float] = (), None, 0.0

    def frames(self) -> Iterator[VideoFrame]:
        for number in self._numbers:
            scene_frame = self._scene.frame(number)
            waves = len(scene_frame.cloud) * self._slm.width * self._slm.height
            if waves <= SMALL and not self._always:
                yield self._plain(number, "so few waves are summed one by one")
                continue
            try:
                frame = self._frame(scene_frame)
            except Refusal:  # as where waves all but cancel: `curved` has other ways
                frame = self._plain(number, "the low-rank form is not exact enough")
            yield frame

    def _plain(self, number: int, why: str) -> VideoFrame:
        """A frame as without compensation: made, or refused, when it is asked for."""
        given = self._scene, self._slm, self._wavelength, "curved", range(number, number + 1)
        frame = next(none.frames(*given, self._coding, tolerance=self._tolerance))
        lit = [obj.name for obj in frame.scene_frame.objects if len(obj.cloud)]
        frame.record.reuse = dict.fromkeys(lit, f"afresh: {why}")
        return frame

    def _frame(self, scene_frame: SceneFrame) -> VideoFrame:
        record = FrameRecord(scene_frame.number, key=False)
        total = Budget(0.0, 0.0)
        tracks: list[_Track] = []
        moved: set[str] = set()
        for obj in scene_frame.objects:
            if len(obj.cloud) == 0:
                continue
            track = self._tracks.get(obj.name)
            with record.stage("PE"):
                same = track is not None and same_light(track.obj, obj)
            if track is None or not same:
                moved.add(obj.name)
                track = self._follow(track, obj, record)
                self._tracks.pop(obj.name, None)
                self._tracks[obj.name] = track  # last, as the latest that was made
            tracks.append(track)
            total += track.budget
        tracks, error = self._together(tracks, scene_frame.cloud, record, total)
        record.error_predicted = error
        names = {track.obj.name: track.version for track in tracks}
        still = {name: version for name, version in names.items() if name not in moved}
        objects = [(track.obj.name in still, track.factors) for track in tracks]
        return VideoFrame(
            scene_frame,
            record,
            self._renderer.of("field", objects, still, record),
            self._renderer.of("signal", objects, still, record),
        )

    @alone
    def _follow(self, track: _Track | None, obj: ObjectFrame, record: FrameRecord) -> _Track:
        """The object's factors in a frame: looked up if its group covers it, else keyed anew."""
        number = record.number
        if obj.body is None or obj.ids is None or obj.pose is None:
            self._check(obj.cloud)
            return self._afresh(obj, record, "its points are not known again")
        outline = self._outline(obj.name, obj.body)
        self._check_body(obj, outline)
        group = None if track is None else track.group
        if group is not None and group.body is obj.body:
            count = self._numbers.index(number)
            # Nodes that turn out too few for this frame are no reason for a key frame.
            for share in (AIM, 0.4 * AIM):
                found = self._looked_up(group, obj, outline, share * self._tolerance, record)
                if found is None:
                    break
                factor, budget = found
                if self._promise.kept(factor, obj.cloud, budget, count):
                    self._book(group, obj, record)
                    return self._track(obj, [factor], budget, group)
        elif track is not None and not self._patience.over(obj.name, number):
            return self._afresh(obj, record, "")
        later = [n for n in self._numbers if n > number]
        ahead = poses_ahead(self._scene, obj, later)
        before = None if track is None else track.obj.pose
        rested = before is not None and before.same_as(obj.pose)
        if not rested and all(pose.same_as(obj.pose) for pose in ahead):
            return self._afresh(obj, record, "it rests")  # and may do so all the time
        return self._keyed(obj, outline, [obj.pose, *ahead], number, record)

    def _outline(self, name: str, body: PointCloud) -> Outline:
        kept = self._outlines.get(name)
        if kept is None or kept.body is not body:
            kept = self._outlines[name] = outline_of(body)
        return kept

    def _check(self, cloud: PointCloud) -> None:
        check_showable(cloud, self._slm, self._wavelength, self._coding.passband)

    def _check_body(self, obj: ObjectFrame, outline: Outline) -> None:
        """What can be shown is convex, so that the rim speaks for all points inside."""
        assert obj.pose is not None
        rim = obj.pose.apply(outline.rim)
        try:
            self._check(PointCloud(rim, np.ones(len(rim)), np.zeros(len(rim))))
        except ValueError:
            self._check(obj.cloud)

    def _keyed(
        self,
        obj: ObjectFrame,
        outline: Outline,
        poses: list[Pose],
        number: int,
        record: FrameRecord,
    ) -> _Track:
        """A new group, if it pays, and the frame from it."""
        aim = AIM * self._tolerance
        for _ in range(3):
            with record.stage("CON"):
                plan = planned(obj, outline, self._plane, aim)
                free = self._room(obj.name)
                choice = choose(plan, outline, poses, self._plane, aim, free, self._always)
                if not choice.pays:
                    self._patience.put_off(obj.name, number, choice.frames)
                    return self._afresh(obj, record, choice.why)
                ahead = poses[: choice.frames]
                group = Group(plan, outline, ahead, self._plane, aim)
            found = self._looked_up(group, obj, outline, aim, record, plan)
            if found is None:
                break
            factor, budget = found
            if self._promise.kept(factor, obj.cloud, budget, None):
                self._patience.end(obj.name)
                self._book_key(obj, record)
                record.reuse[obj.name] = choice.why
                return self._track(obj, [factor], budget, group)
            aim *= max(0.5 * self._tolerance / budget.relative, 1e-3)
        self._patience.put_off(obj.name, number, 8)
        return self._afresh(obj, record, "a sphere would not be exact enough")

    def _together(
        self, tracks: list[_Track], cloud: PointCloud, record: FrameRecord, total: Budget
    ) -> tuple[list[_Track], float]:
        """Tracks, or one for all where the light of several objects cancels; and the relative error
        expected of them."""
        if len(tracks) < 2:
            return tracks, total.relative
        versions = tuple(track.version for track in tracks)
        known, whole, error = self._whole
        if known != versions:
            with record.stage("PA"):
                factors = [factor for track in tracks for factor in track.factors]
                error = self._promise.together(factors, cloud, total)
            whole = None
            if error > SURE * self._tolerance:
                obj = ObjectFrame("all objects", cloud)
                whole = self._afresh(obj, record, "their sum is less exact than each")
                error = whole.budget.relative
            self._whole = versions, whole, error
        return (tracks if whole is None else [whole]), error

    def _room(self, name: str) -> int:
        """Complex numbers that an object's sphere may hold; others longest unseen make room."""
        most = MOST_VALUES // self._numbers.step  # the frames between are another's, beside this
        held = {
            other: track.group.sphere.size
            for other, track in self._tracks.items()
            if other != name and track.group is not None
        }
        for other in list(held):
            if sum(held.values()) <= most // 2:
                break
            self._tracks[other].group = None
            del held[other]
        return most - sum(held.values())

    def _looked_up(
        self,
        group: Group,
        obj: ObjectFrame,
        outline: Outline,
        aim: float,
        record: FrameRecord,
        plan: Plan | None = None,
    ) -> tuple[Factor, Budget] | None:
        """A frame from a group; None where the group does not reach."""
        if plan is None:
            with record.stage("PA"):
                plan = planned(obj, outline, self._plane, aim)
        try:
            return group.factor(plan, record)
        except NotCovered:
            return None

    def _track(
        self, obj: ObjectFrame, factors: list[Factor], budget: Budget, group: Group | None
    ) -> _Track:
        self._versions += 1
        return _Track(obj, factors, budget, group, self._versions)

    def _afresh(self, obj: ObjectFrame, record: FrameRecord, why: str) -> _Track:
        """An object's factors straight from its points."""
        with record.stage("HC"):
            low = low_rank(
                obj.cloud,
                self._slm,
                self._wavelength,
                self._window,
                self._coding.passband,
                tolerance=self._tolerance,
            )
        self._book_key(obj, record)
        record.reuse[obj.name] = f"afresh: {why}" if why else "afresh"
        return self._track(obj, low.factors, low.budget, None)

    def _book_key(self, obj: ObjectFrame, record: FrameRecord) -> None:
        record.key = True
        record.points_computed += len(obj.cloud)
        record.points_added += len(obj.cloud)
        record.point_pixels += len(obj.cloud) * self._slm.width * self._slm.height

    def _book(self, group: Group, obj: ObjectFrame, record: FrameRecord) -> None:
        """Count what a frame from a group took."""
        count = group.count
        changed = count.appeared + count.vanished
        pixels = self._slm.width * self._slm.height
        record.points_computed += changed
        record.points_added += count.appeared
        record.points_removed += count.vanished
        record.point_pixels += changed * pixels + len(obj.cloud) * count.soft
        record.blank_share = max(record.blank_share, count.soft / pixels)
        record.reuse[obj.name] = "from its sphere" + (
            f", {count.directions} points summed in new directions" if count.directions else ""
        )
