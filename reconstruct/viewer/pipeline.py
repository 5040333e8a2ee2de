"""From a request to pictures: frame → Fourier plane → filter → coarse picture, then the sharp one.

One `Pipeline` per video, used by one thread; what its stages made is kept until what it depends on
changes. `Decoded` is never changed and may be handed to other threads.
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.store.colour import ColourVideo
from chrmc.store.video import Video
from reconstruct import metrics
from reconstruct.bench import Bench, Filter
from reconstruct.focus_metrics import normalised_variance
from reconstruct.four_f_system import Energy, FourF, intensity
from reconstruct.images import exposure
from reconstruct.sequence import system_of, targets_of
from reconstruct.verdict import Target
from reconstruct.viewer.coarse import Coarse, coarse_field
from reconstruct.viewer.lasers import Lasers, Source, leading
from reconstruct.viewer.sight import Sight, shrunk


@dataclass(frozen=True)
class Request:
    """What is to be seen.

    number : of the frame; depth : metres; filter : in the Fourier plane
    screen : (rows, columns) screen pixels that the panel's picture covers
    sight : what of the hologram is shown, and how large; None shows it pixel by pixel
    """

    number: int
    depth: float
    filter: Filter
    screen: tuple[int, int] = (1 << 20, 1 << 20)
    sight: Sight | None = None

    @property
    def subject(self) -> tuple[Any, ...]:
        """All but the screen's part: what a sharp picture depends on."""
        return self.number, self.depth, id(self.filter)


@dataclass(frozen=True, eq=False)
class Frame:
    """A hologram: (H, W) grey levels, and the same in the Fourier plane before the filter."""

    number: int
    levels: NDArray[np.uint8]
    plane: NDArray[np.complex64]

    @cached_property
    def spectrum(self) -> NDArray[np.float32]:
        """(H, W) intensity in the Fourier plane, zero frequency in the middle."""
        return np.fft.fftshift(intensity(self.plane))


@dataclass(frozen=True, eq=False)
class Decoded:
    """A frame behind a filter.

    lasers, of_each : of a video in colours, and the frame of every laser; else None and nothing
    """

    frame: Frame
    system: FourF
    targets: list[Target]
    scene_pitch: float
    lasers: Lasers | None = None
    of_each: tuple["Decoded", ...] = ()

    @cached_property
    def field(self) -> NDArray[np.complex64]:
        """(H, W) complex field at depth 0."""
        return self.system.decode(self.frame.plane)

    @cached_property
    def energy(self) -> Energy:
        """Where the light went."""
        return self.system.energy(self.frame.levels)

    def picture(self, depth: float) -> "Picture":
        """The full picture."""
        *_, picture = self.steps(depth)
        assert picture is not None
        return picture

    def steps(self, depth: float) -> Iterator["Picture | None"]:
        """The full picture at last, None after every step on the way."""
        number, fields = self.frame.number, []
        for one in self.of_each or (self,):
            field = one.field
            yield None
            fields.append(one.system.at(field, depth))
            yield None
        if self.lasers is None:
            yield Picture(number, depth, fields[0], exposure(intensity(fields[0])), False)
        else:
            field, glow, white = self.lasers.mix(fields)
            yield Picture(number, depth, field, white, False, glow=glow)


@dataclass(frozen=True, eq=False)
class Picture:
    """A reconstruction.

    field : (h, w) complex64, over the whole panel
    white : intensity to show as white
    coarse : made at the screen's resolution, of a band that holds all but `lost` of the light
    glow : (h, w, 3) linear sRGB of a video in colours, whose field holds the luminance
    """

    number: int
    depth: float
    field: NDArray[np.complex64]
    white: float
    coarse: bool
    lost: float = 0.0
    glow: NDArray[np.float32] | None = None

    @cached_property
    def light(self) -> NDArray[np.float32]:
        """(h, w) intensity."""
        return intensity(self.field)

    @cached_property
    def extremes(self) -> tuple[float, float]:
        """Least and most intensity."""
        return float(self.light.min()), float(self.light.max())


@dataclass(frozen=True, eq=False)
class Quick:
    """The first answer to a request, per video: what was decoded, its coarse picture, the hologram
    as the sight shows it; or in their place None and a fault, one line."""

    request: Request
    decoded: tuple[Decoded | None, ...]
    pictures: tuple[Picture | None, ...]
    holograms: tuple[NDArray[np.uint8] | None, ...]
    faults: tuple[str, ...]
    seconds: float


@dataclass(frozen=True, eq=False)
class Sharp:
    """The full pictures of a request, per video."""

    request: Request
    pictures: tuple[Picture | None, ...]
    seconds: float


@dataclass(frozen=True, eq=False)
class Figures:
    """What was measured of a request's sharp pictures, per video."""

    request: Request
    values: tuple[dict[str, float], ...]


class Pipeline:
    """The stages of one video, each kept until its input changes.

    farthest : largest depth that coarse pictures are padded for, metres
    """

    def __init__(self, video: Video, farthest: float) -> None:
        self.video = video
        self.farthest = farthest
        self._system: tuple[Filter, FourF] | None = None
        self._frame: Frame | None = None
        self._decoded: Decoded | None = None
        self._coarse: tuple[Any, Coarse] | None = None
        self._picture: tuple[Any, Picture] | None = None
        self._hologram: tuple[Any, NDArray[np.uint8]] | None = None

    def system(self, chosen: Filter) -> FourF:
        """The 4-f system with this filter."""
        if self._system is None or self._system[0] is not chosen:
            self._system = chosen, system_of(self.video, Bench(filter=chosen))
        return self._system[1]

    def decoded(self, number: int, chosen: Filter) -> Decoded:
        """A frame behind a filter; OSError or ValueError when it cannot be read."""
        system = self.system(chosen)
        if self._frame is None or self._frame.number != number:
            levels = self.video.read(number)
            self._frame = Frame(number, levels, system.fourier_plane(levels))
        held = self._decoded
        if held is None or held.frame is not self._frame or held.system is not system:
            targets = targets_of(self.video, number)
            held = Decoded(self._frame, system, targets, self.video.pixel_pitch)
            self._decoded = held
        return held

    def picture(self, request: Request) -> Picture:
        """The coarse picture."""
        decoded = self.decoded(request.number, request.filter)
        key = (decoded, request.screen, self.farthest)
        if self._coarse is None or self._coarse[0] != key:
            fresh = coarse_field(decoded.system, decoded.frame.plane, request.screen, self.farthest)
            self._coarse = key, fresh
        coarse = self._coarse[1]
        place = (key, request.depth)
        if self._picture is None or self._picture[0] != place:
            field = coarse.at(request.depth)
            white = exposure(intensity(field[::2, ::2]))
            self._picture = (
                place,
                Picture(request.number, request.depth, field, white, True, coarse.lost),
            )
        return self._picture[1]

    def hologram(self, request: Request) -> NDArray[np.uint8]:
        """The hologram as the request's sight shows it."""
        frame = self.decoded(request.number, request.filter).frame
        key = (frame, request.sight)
        if self._hologram is None or self._hologram[0] != key:
            small = frame.levels if request.sight is None else shrunk(frame.levels, request.sight)
            self._hologram = key, small
        return self._hologram[1]


class ColourPipeline(Pipeline):
    """The stages of a video in colours: those of every laser, and their mixture."""

    def __init__(self, video: ColourVideo, farthest: float) -> None:
        super().__init__(leading(video), farthest)
        self._lasers = Lasers.of(video)
        self._each = [Pipeline(channel, farthest) for channel in video.channels]
        self._mixed: tuple[Any, Picture] | None = None

    def decoded(self, number: int, chosen: Filter) -> Decoded:
        """A frame behind a filter, of every laser."""
        of_each = tuple(pipeline.decoded(number, chosen) for pipeline in self._each)
        held = self._decoded
        if held is None or held.of_each != of_each:
            held = replace(of_each[self._lasers.lead], lasers=self._lasers, of_each=of_each)
            self._decoded = held
        return held

    def picture(self, request: Request) -> Picture:
        """The coarse picture."""
        for pipeline in self._each:
            pipeline.farthest = self.farthest
        parts = [pipeline.picture(request) for pipeline in self._each]
        if self._mixed is None or self._mixed[0] != parts:
            field, glow, white = self._lasers.mix([part.field for part in parts])
            lost = max(part.lost for part in parts)
            picture = Picture(request.number, request.depth, field, white, True, lost, glow)
            self._mixed = parts, picture
        return self._mixed[1]


def pipeline_of(source: Source, farthest: float) -> Pipeline:
    """The stages of a source; farthest : as of `Pipeline`."""
    if isinstance(source, ColourVideo):
        return ColourPipeline(source, farthest)
    return Pipeline(source, farthest)


def quick(pipelines: Sequence[Pipeline], request: Request) -> Iterator[Quick]:
    """One step: the coarse pictures."""
    start = time.perf_counter()
    answers = [_answer(pipeline, request) for pipeline in pipelines]
    decoded, pictures, holograms, faults = zip(*answers, strict=True)
    yield Quick(request, decoded, pictures, holograms, faults, time.perf_counter() - start)


def _answer(
    pipeline: Pipeline, request: Request
) -> tuple[Decoded | None, Picture | None, NDArray[np.uint8] | None, str]:
    """What `Quick` holds of one video."""
    try:
        decoded = pipeline.decoded(request.number, request.filter)
        picture, hologram = pipeline.picture(request), pipeline.hologram(request)
    except (OSError, ValueError) as error:
        return None, None, None, " ".join(str(error).split())
    # Made here, not in the window's thread.
    decoded.frame.spectrum, picture.extremes  # noqa: B018
    return decoded, picture, hologram, ""


def sharpen(
    decoded: Sequence[Decoded | None], request: Request
) -> Iterator[Sharp | Figures | None]:
    """The full pictures, then what they measure."""
    start = time.perf_counter()
    pictures: list[Picture | None] = []
    for one in decoded:
        if one is None:
            pictures.append(None)
            continue
        for picture in one.steps(request.depth):
            if picture is None:
                yield None
            else:
                picture.extremes  # noqa: B018
                pictures.append(picture)
    yield Sharp(request, tuple(pictures), time.perf_counter() - start)
    values = []
    for one, picture in zip(decoded, pictures, strict=True):
        values.append({} if one is None or picture is None else measured(one, picture))
        yield None
    yield Figures(request, tuple(values))


def measured(decoded: Decoded, picture: Picture) -> dict[str, float]:
    """What a sharp picture measures, per name.

    sharpness : normalised variance of the whole picture
    contrast, speckle : of the object nearest in depth, against the rest of its surroundings
    efficiency, blocked : shares of the laser's light in the image and on the filter
    """
    light = picture.light
    values = {"sharpness": normalised_variance(light)}
    if decoded.targets:
        target = min(decoded.targets, key=lambda t: abs(float(t.position[2]) - picture.depth))
        p, shape = decoded.system.slm.pixel_pitch, np.array(light.shape)
        low, high = (
            np.rint(c[1::-1] / p + (shape - 1) / 2).astype(int) for c in (target.low, target.high)
        )
        edge = max(4, round(4 * decoded.scene_pitch / p))
        first = np.clip(low - edge, 0, shape - 1)
        last = np.clip(high + edge + 1, 1, shape)
        part = light[first[0] : last[0], first[1] : last[1]]
        lit = np.zeros(part.shape, dtype=bool)
        inner = np.maximum(low - first, 0)
        outer = np.maximum(high + 1 - first, 0)
        lit[inner[0] : outer[0], inner[1] : outer[1]] = True
        if lit.any() and not lit.all():
            values["contrast"] = metrics.contrast(part, lit, ~lit)
            values["speckle"] = metrics.speckle_contrast(part, lit)
    energy = decoded.energy
    values["efficiency"] = energy.efficiency
    values["blocked"] = energy.blocked_filter / energy.incident
    return values
