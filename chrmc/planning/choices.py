"""The sensible ways to make a scene's holograms, what each takes, and the one to take."""

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from importlib import import_module
from math import log
from typing import Any

from chrmc.cgh import METHODS, OperationCounts, method_named
from chrmc.compensation import (
    COUNTED,
    DEFAULT_TOLERANCE,
    OBJECT_CGH,
    scene_wavelength,
)
from chrmc.encoding import Coding, coding_for
from chrmc.optics.footprint import check_showable
from chrmc.planning.errors import PROMISED, SAFE, expected_error
from chrmc.planning.rates import Rates, machine_rates
from chrmc.ranges import TOLERANCE_RANGE, Range
from chrmc.scene.scene import Scene, SceneFrame, as_scene, frame_range
from chrmc.slm import LC_R_1080, SLM
from chrmc.window import Window

GROUP = 96
"""Frames of a group whose method carries something from frame to frame: key frames, which cost up
to ten frames, then take less than a tenth."""
TOLERANCES = (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 1e-6)
"""That are tried where none is asked for."""
BUDGET = Range("budget", 1e-6, 1e6, unit="s")
_LONGER = 4  # groups that are tried, in GROUPs
_MUCH, _LITTLE = 0.67, 0.01  # of the time, and seconds: what an error check alone is not worth
_WORTH = 0.9  # of the time, from which another way than the first is taken

# From the field, or from the signal, to 8 bits: bytes and steps of one core, as measured.
_FROM_FIELD, _FROM_SIGNAL, _STEPS = 300.0, 60.0, 400.0


@dataclass(frozen=True)
class Choice:
    """One way to make a scene's holograms.

    cgh, compensation : methods by name; options : of theirs, the tolerance among them
    group : frames that share a key frame
    key, mean : expected seconds from points to 8 bits, of a key frame and of one on the average
    error : expected relative L2 error of the field; None where nothing is known
    sure : the method keeps the tolerance by itself
    memory : bytes held while a frame is made, about
    objects : what is done with each object, and why, where objects are told apart
    """

    cgh: str
    compensation: str
    options: Mapping[str, Any]
    group: int
    key: float
    mean: float
    error: float | None
    sure: bool
    memory: float
    objects: Mapping[str, str] = field(default_factory=dict)

    @property
    def tolerance(self) -> float | None:
        """That it is made with, if it takes one."""
        return self.options.get("tolerance")

    def meets(self, tolerance: float) -> bool:
        """Whether its error will stay below a tolerance."""
        return self.within(tolerance) <= 1 + 1e-9

    def within(self, tolerance: float) -> float:
        """How far it comes from meeting a tolerance: at most 1 where it does."""
        if self.sure and self.tolerance is not None:
            return self.tolerance / tolerance
        return float("inf") if self.error is None else SAFE * self.error / tolerance

    def __str__(self) -> str:
        said = "" if self.tolerance is None else f" at {self.tolerance:.2g}"
        others = {name: value for name, value in self.options.items() if name != "tolerance"}
        said += "".join(f" {name}={value}" for name, value in others.items())
        return f"{self.cgh}{said}, {self.compensation}"


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
) -> Plan:
    """The way to make a scene's holograms: the cheapest that meets a tolerance, the most accurate
    that meets a budget, or with both whether there is one, and the nearest if not.

    scene : see `load_scene`
    tolerance : largest relative field error; default 1e-3 where there is no budget either
    budget : seconds per frame, on the average
    wavelength : metres; default the scene's, else 532 nm
    encoding : or its name; frames : (first, last), default all
    rates : of a machine; default this one's

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
    choices = tuple(look.choices(tolerance, budget))
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

    def choices(self, tolerance: float | None, budget: float | None) -> Iterator[Choice]:
        """All ways, the default first."""
        check_showable(self.frame.cloud, self.slm, self.wavelength, self.coding.passband)
        tolerances = [] if tolerance is None else [tolerance]
        if budget is not None:
            tolerances += [t for t in TOLERANCES if t != tolerance]
        exact: list[Choice] = []
        for one in tolerances:
            exact += self._of(OBJECT_CGH, {"tolerance": one})
        yield from self._by_object(tolerances, exact)
        yield from exact
        for name in METHODS:
            if name != OBJECT_CGH:
                for settings in method_named(name).settings:
                    yield from self._of(name, settings)

    def _of(self, name: str, options: Mapping[str, Any]) -> Iterator[Choice]:
        """A CGH method without compensation."""
        method = method_named(name)
        if method.cost is None:
            return
        cloud = self.frame.cloud
        try:
            counts: OperationCounts = method.cost(
                cloud, self.slm, self.wavelength, Window.full(self.slm), self.coding.passband,
                **options,
            )  # fmt: skip
            error = expected_error(
                method, cloud, self.slm, self.wavelength, self.coding.passband, **options
            )
        except ValueError:  # which it cannot do at all
            return
        seconds = self.rates.seconds(counts, method.shares_cores)
        seconds += self._encoding(method.signal is not None)
        yield Choice(
            name, "none", dict(options), 1, seconds, seconds, error, "tolerance" in options,
            counts.memory,
        )  # fmt: skip

    def _encoding(self, signal: bool) -> float:
        """Seconds from what a method makes to 8 bits."""
        direct = signal and not self.coding.needs_field
        pixels = self.slm.width * self.slm.height
        each = _FROM_SIGNAL if direct else _FROM_FIELD
        return self.rates.seconds(OperationCounts(bytes=each * pixels, calls=_STEPS), False)

    def _by_object(self, tolerances: list[float], exact: list[Choice]) -> Iterator[Choice]:
        """The video methods that tell objects apart."""
        for name, module in COUNTED.items():
            worked: list[tuple[float, float, float]] = []
            for group in self._groups():
                end = min(self.frame.number + group - 1, self.numbers[-1])
                later = range(self.frame.number + 1, end + 1)
                first = tolerances[0]
                try:
                    found = import_module(module).cost(
                        self.scene, self.frame.objects, later, self.slm, self.wavelength,
                        self.coding, tolerance=first,
                    )  # fmt: skip
                except ValueError:
                    continue
                key = sum((o.key for o in found), OperationCounts())
                mean = sum((o.mean for o in found), OperationCounts())
                shared = method_named(OBJECT_CGH).shares_cores
                worked = [(self.rates.seconds(k, shared), 0.0, k.memory) for k in (key, mean)]
                fresh = exact[0].mean if exact else worked[1][0]
                for one, way in zip(tolerances, exact, strict=False):
                    # Other tolerances change both ways about alike.
                    more = way.mean / fresh
                    extra = self._encoding(True)
                    yield Choice(
                        OBJECT_CGH, name, {"tolerance": one}, group,
                        worked[0][0] * more + extra, worked[1][0] * more + extra,
                        PROMISED * one, True, max(worked[0][2], worked[1][2]),
                        {o.name: o.how for o in found},
                    )  # fmt: skip

    def _groups(self) -> list[int]:
        more = len(self.numbers) > GROUP
        return [GROUP, _LONGER * GROUP] if more else [GROUP]


def pick(
    choices: tuple[Choice, ...], tolerance: float | None, budget: float | None
) -> tuple[Choice, bool]:
    """The choice to take, and whether it meets what was asked for."""
    if not choices:
        raise ValueError("no method can make this scene's holograms: see chrmc inspect")
    fit = [c for c in choices if tolerance is None or c.meets(tolerance)]
    if budget is None:
        if fit:
            return _cheapest(fit), True
        return min(choices, key=lambda c: (c.within(tolerance or 1.0), c.mean)), False
    quick = [c for c in fit if c.mean <= budget]
    if quick:
        if tolerance is not None:
            return _cheapest(quick), True
        best = min(_worst(c) for c in quick)
        return _cheapest([c for c in quick if _worst(c) <= best]), True

    def off(choice: Choice) -> tuple[float, float]:
        late = max(log(choice.mean / budget), 0.0)
        if tolerance is None:
            return late, _worst(choice)
        wrong = choice.within(tolerance)
        return max(late, log(max(wrong, 1.0))) if wrong < float("inf") else 1e9, choice.mean

    return min(choices, key=off), False


def _worst(choice: Choice) -> float:
    """The error to reckon with."""
    return choice.within(1.0)


def _cheapest(choices: list[Choice]) -> Choice:
    """The quickest; the first, as the default is, where others hardly are quicker, and one that
    keeps its tolerance by itself where others save little."""
    least = min(choices, key=lambda c: c.mean)
    sure = [c for c in choices if c.sure]
    if sure and not least.sure:
        best = min(c.mean for c in sure)
        if least.mean > min(_MUCH * best, best - _LITTLE):
            choices = sure
    quickest = min(c.mean for c in choices)
    return next(choice for choice in choices if _WORTH * choice.mean <= quickest)


def sentence(
    taken: Choice,
    met: bool,
    choices: tuple[Choice, ...],
    tolerance: float | None,
    budget: float | None,
) -> str:
    """What is taken, and why."""
    asked = []
    if tolerance is not None:
        asked.append(f"an error of {tolerance:.2g}")
    if budget is not None:
        asked.append(f"{spell(budget)} a frame")
    said = f"{taken}: {spell(taken.mean)} a frame"
    if taken.key > 1.3 * taken.mean:
        said += f" ({spell(taken.key)} a key frame)"
    if taken.error is not None:
        said += f", expected error {taken.error:.1e}"
    if not met:
        return f"nothing meets {' and '.join(asked)}; nearest is {said}"
    if tolerance is None:
        return f"{said}, the most accurate within {asked[0]}"
    others = [
        c for c in choices
        if (c.cgh, c.compensation) != (taken.cgh, taken.compensation) and c.meets(tolerance)
    ]  # fmt: skip
    if not others:
        return f"{said}, the only way to {asked[0]}"
    other = min(others, key=lambda c: c.mean)
    against = f"{other} would take {spell(other.mean)}"
    return f"{said}; of all within {' and '.join(asked)} the cheapest: {against}"


def spell(seconds: float) -> str:
    """Seconds in words."""
    return f"{seconds:.3g} s" if seconds >= 1 else f"{1e3 * seconds:.3g} ms"
