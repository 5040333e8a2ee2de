"""The sensible ways to make a scene's holograms, what each takes, and the one to take."""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import partial
from importlib import import_module
from itertools import pairwise, product
from math import hypot, inf, sqrt
from typing import Any

import numpy as np

from chrmc.cgh import METHODS, CGHMethod, OperationCounts, method_named
from chrmc.compensation import (
    COUNTED,
    COUNTED_WHOLE,
    DEFAULT_TOLERANCE,
    OBJECT_CGH,
    scene_wavelength,
)
from chrmc.compensation.counted import VideoCost
from chrmc.encoding import Coding, coding_for
from chrmc.optics.footprint import check_showable
from chrmc.planning.choice import Choice, pick, sentence
from chrmc.planning.errors import PROMISED, expected_error
from chrmc.planning.rates import Rates, machine_rates
from chrmc.ranges import TOLERANCE_RANGE, Range
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Scene, SceneFrame, as_scene, frame_range
from chrmc.slm import LC_R_1080, SLM
from chrmc.window import Window

GROUP = 96
"""Frames of a group whose method carries something from frame to frame: key frames, which cost up
to ten frames, then take less than a tenth."""
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
"""That are tried where none is asked for; and what lies in the middle of two, reckoned."""
BUDGET = Range("budget", 1e-6, 1e6, unit="s")
_LONGER = 4  # groups that are tried, in GROUPs
_MANY = 500  # points of which some are counted
_CORNERS = 100_000  # points from which the corners of their box are looked at first

# From the field to the signal, on one core, and from there to 8 bits, on all: bytes and steps of
# Python, as measured.
_TO_SIGNAL, _FROM_SIGNAL, _STEPS = 240.0, 60.0, 400.0


@dataclass(frozen=True)
class Plan:
    """What `plan` found.

    choices : all ways that were looked at; taken : the one to take
    met : whether it meets what was asked for
    why : in one sentence
    tolerance, budget : what was asked for
    """

    scene: str
    choices: tuple[Choice, ...]
    taken: Choice
    met: bool
    why: str
    tolerance: float | None
    budget: float | None

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)

    def __str__(self) -> str:
        return f"{self.scene}: {self.why}"


def plan(
    scene: Scene,
    slm: SLM = LC_R_1080,
    *,
    tolerance: float | None = None,
    budget: float | None = None,
    wavelength: float | None = None,
    encoding: Coding | str = "ssb",
    frames: tuple[int, int] | None = None,
    rates: Rates | None = None,
    every: bool = True,
) -> Plan:
    """The way to make a scene's holograms: the cheapest that meets a tolerance, the most accurate
    that meets a budget, or with both whether there is one, and the nearest if not.

    scene : see `load_scene`
    tolerance : largest relative field error; default 1e-3 where there is no budget either
    budget : seconds per frame, on the average
    wavelength : metres; default the scene's, else 532 nm
    encoding : or its name; frames : (first, last), default all
    rates : of a machine; default this one's
    every : look at every way, those too that cannot be the one to take

    Nothing is computed but counts, from the first frame that shows anything.
    """
    scene = as_scene(scene)
    if tolerance is not None:
        tolerance = TOLERANCE_RANGE.of(tolerance)
    if budget is not None:
        budget = BUDGET.of(budget)
    elif tolerance is None:
        tolerance = DEFAULT_TOLERANCE
    wavelength = scene_wavelength(scene, wavelength)
    coding = encoding if isinstance(encoding, Coding) else coding_for(encoding, slm)
    numbers = frame_range(scene, frames)
    shown = first_lit(scene, numbers)
    look = _Look(scene, shown, numbers, slm, wavelength, coding, rates or machine_rates())
    choices = tuple(look.choices(tolerance, budget, every))
    if every:
        choices += tuple(look.published())
    taken, met = pick(choices, tolerance, budget)
    why = sentence(taken, met, choices, tolerance, budget)
    return Plan(str(scene.name), choices, taken, met, why, tolerance, budget)


def first_lit(scene: Scene, numbers: range) -> SceneFrame:
    """The first of a scene's frames, or another where that shows nothing."""
    tried = dict.fromkeys((numbers[0], numbers[len(numbers) // 2], numbers[-1]))
    found = [scene.frame(numbers[0])]
    for number in list(tried)[1:]:
        if len(found[-1].cloud):
            break
        found.append(scene.frame(number))
    return found[-1] if len(found[-1].cloud) else found[0]


@dataclass(frozen=True, eq=False)
class _Look:
    """A frame, and what it is looked at with."""

    scene: Scene
    frame: SceneFrame
    numbers: range
    slm: SLM
    wavelength: float
    coding: Coding
    rates: Rates

    def choices(
        self, tolerance: float | None, budget: float | None, every: bool
    ) -> Iterator[Choice]:
        """All ways without the published videos, the default first."""
        self._check()
        if budget is not None and not every:
            exact, objects = self._around(budget, tolerance)
        else:
            asked = [] if tolerance is None else [tolerance]
            if budget is not None:
                asked += [t for t in TOLERANCES if t != tolerance]
            exact = [way for t in asked if (way := self._exact(t)) is not None]
            objects = self._by_object(exact[0]) if exact else []
        if budget is not None:
            exact += between(exact)
        sure = [alike(way, exact[0], one) for way in objects for one in exact] + exact
        yield from sure
        most = inf
        if not every:
            most = min((way.mean for way in sure), default=inf) if budget is None else budget
        for name in METHODS:
            if name != OBJECT_CGH:
                for settings in method_named(name).settings:
                    way = self._of(name, settings, most)
                    if way is not None:
                        yield way
                    elif not every:
                        break  # its finer settings take longer still

    def _check(self) -> None:
        """ValueError where points cannot be shown; of very many only where the corners of their
        box cannot."""
        cloud = self.frame.cloud
        if len(cloud) > _CORNERS:
            x, y, z = (sorted({c.min(), c.max()}) for c in cloud.positions.T)
            places = np.array(list(product(x, y, z)))
            brightest = np.full(len(places), np.abs(cloud.amplitude).max())
            with suppress(ValueError):
                corners = PointCloud(places, brightest, np.zeros(len(places)))
                return check_showable(corners, self.slm, self.wavelength, self.coding.passband)
        check_showable(cloud, self.slm, self.wavelength, self.coding.passband)

    def _exact(self, tolerance: float) -> Choice | None:
        return self._of(OBJECT_CGH, {"tolerance": tolerance})

    def _around(self, budget: float, tolerance: float | None) -> tuple[list[Choice], list[Choice]]:
        """Frames afresh at tolerances on both sides of a budget, the asked one among them, and
        object by object at the first."""
        found: dict[float, Choice | None] = {}
        objects: list[Choice] = []
        first: Choice | None = None

        def keeps(tolerance: float) -> bool:
            nonlocal first, objects
            way = found.setdefault(tolerance, self._exact(tolerance))
            if way is None:
                return False
            if first is None:
                first, objects = way, self._by_object(way)
            return any(alike(c, first, way).keeps(budget) for c in [*objects, first])

        if tolerance is not None:
            keeps(tolerance)
        low, high = -1, len(TOLERANCES)
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if keeps(TOLERANCES[middle]) else (low, middle)
        return [way for way in found.values() if way is not None], objects

    def _of(self, name: str, options: Mapping[str, Any], most: float = inf) -> Choice | None:
        """A CGH method without compensation; None of one that takes more seconds than `most`."""
        method = method_named(name)
        if method.cost is None:
            return None
        try:
            counts = self._counts(method, options)
            seconds = self.rates.seconds(counts, method.shares_cores)
            seconds += self._encoding(method.signal is not None)
            if seconds > most:
                return None
            error = expected_error(
                method, self.frame.cloud, self.slm, self.wavelength, self.coding.passband, **options
            )
        except ValueError:  # which it cannot do at all
            return None
        return Choice(
            name, "none", dict(options), 1, seconds, seconds, error, "tolerance" in options,
            counts.memory,
        )  # fmt: skip

    def _counts(self, method: CGHMethod, options: Mapping[str, Any]) -> OperationCounts:
        """What a frame takes; of many points some are counted, and a straight line goes on."""
        assert method.cost is not None
        cloud, window = self.frame.cloud, Window.full(self.slm)
        count = partial(
            method.cost, slm=self.slm, wavelength=self.wavelength, window=window,
            passband=self.coding.passband, **options,
        )  # fmt: skip
        step = len(cloud) // _MANY
        if not step or method.takes("tolerance"):  # those that do take some points by themselves
            return count(cloud)
        some = cloud.select(slice(None, None, step))
        few = some.select(slice(None, None, 2))
        on = (len(cloud) - len(some)) / (len(some) - len(few))
        return count(some).onward(count(few), on)

    def _encoding(self, signal: bool) -> float:
        """Seconds from what a method makes to 8 bits."""
        pixels = self.slm.width * self.slm.height
        seconds = self.rates.seconds(OperationCounts(bytes=_FROM_SIGNAL * pixels, calls=_STEPS))
        if signal and not self.coding.needs_field:
            return seconds
        return seconds + self.rates.seconds(OperationCounts(bytes=_TO_SIGNAL * pixels), False)

    def _by_object(self, afresh: Choice) -> list[Choice]:
        """The video methods that tell objects apart, at a tolerance of frames afresh."""
        shared = method_named(OBJECT_CGH).shares_cores
        later = range(self.frame.number + 1, min(self.frame.number + GROUP, self.numbers.stop))
        extra = self._encoding(True)
        out = []
        for name, module in COUNTED.items():
            try:
                found = import_module(module).cost(
                    self.scene, self.frame.objects, later, self.slm, self.wavelength, self.coding,
                    tolerance=afresh.tolerance,
                )  # fmt: skip
            except ValueError:
                continue
            for group in self._groups():
                frames = min(group, len(self.numbers))
                key = sum((o.key for o in found), OperationCounts())
                mean = sum((o.mean(frames) for o in found), OperationCounts())
                first, average = (self.rates.seconds(c, shared) + extra for c in (key, mean))
                out.append(
                    replace(
                        afresh, compensation=name, group=group, key=first, mean=average,
                        memory=max(key.memory, mean.memory),
                        objects={o.name: o.how for o in found},
                    )
                )  # fmt: skip
        return out

    def published(self) -> Iterator[Choice]:
        """The video methods that are counted as a whole."""
        numbers = self.numbers[self.numbers.index(self.frame.number) :]
        for name, module in COUNTED_WHOLE.items():
            try:
                found: VideoCost | None = import_module(module).cost(
                    name, self.scene, numbers, self.slm, self.wavelength, self.coding
                )
            except ValueError:
                continue
            if found is None:
                continue
            method = method_named(found.cgh)
            options = {"tolerance": DEFAULT_TOLERANCE} if method.takes("tolerance") else {}
            error = expected_error(
                method, self.frame.cloud, self.slm, self.wavelength, self.coding.passband, **options
            )
            extra = self._encoding(False)
            key, later = (
                self.rates.seconds(counts, method.shares_cores) + extra
                for counts in (found.key, found.later)
            )
            group = min(found.serves, GROUP)
            yield Choice(
                found.cgh, name, options, group, key, later + (key - later) / group,
                None if error is None else hypot(error, found.carried), False,
                max(found.key.memory, found.later.memory),
            )  # fmt: skip

    def _groups(self) -> list[int]:
        more = len(self.numbers) > GROUP
        return [GROUP, _LONGER * GROUP] if more else [GROUP]


def alike(way: Choice, afresh: Choice, other: Choice) -> Choice:
    """`way`, whose tolerance is that of `afresh`, at that of `other`, a frame afresh: tolerances
    change the times of all ways about alike."""
    more = other.mean / afresh.mean
    return replace(
        way, options=other.options, error=other.error, key=way.key * more, mean=way.mean * more
    )


def between(ways: list[Choice]) -> list[Choice]:
    """Ways at tolerances halfway between neighbours', reckoned from theirs."""
    ordered = sorted(ways, key=lambda way: way.tolerance or 0.0)
    out = []
    for a, b in pairwise(ordered):
        low, high = a.tolerance or 0.0, b.tolerance or 0.0
        if high < 5 * low:
            continue
        middle = float(f"{sqrt(low * high):.0e}")
        seconds = sqrt(a.mean * b.mean)
        out.append(
            replace(
                a, options={**a.options, "tolerance": middle}, key=seconds, mean=seconds,
                error=PROMISED * middle,
            )
        )  # fmt: skip
    return out
