"""The viewer's model: what is looked at, and the pictures that follow. No GUI, nothing waits.

The state (frame, depth, filter, look, zoom) is changed at will; `update` hands what is to be
computed to worker threads and takes what they have finished:

quick   the picture at the screen's resolution, for every change; the newest request wins
slow    the sharp picture and its figures once the state rests, or an autofocus; left on a change
errands focus curves of all objects, files to save: not disturbed by looking around
"""

import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from reconstruct.viewer.compare import Comparison, compare
from reconstruct.viewer.focusing import Curve, Found, curves_of_objects, focus_around
from reconstruct.viewer.lasers import Source
from reconstruct.viewer.pipeline import (
    Decoded,
    Figures,
    Picture,
    Quick,
    Request,
    Sharp,
    pipeline_of,
    quick,
    sharpen,
)
from reconstruct.viewer.state import ViewerState
from reconstruct.viewer.worker import Failed, Progress, Said, Steps, Worker

REST = 0.15
"""Seconds without a change after which the sharp picture is made."""


class ViewerModel(ViewerState):
    """A viewer's state, and what is computed for it.

    wake : called from worker threads when `update` has something to take

    found : the last focus that was asked for in this frame; curves : of this frame's objects
    comparison : the newest; alike : the newest that has an SSIM, which takes longer
    progress : of an autofocus or an errand, while there is one
    """

    def __init__(
        self, videos: Source | Sequence[Source], wake: Callable[[], None] = lambda: None
    ) -> None:
        super().__init__(videos)
        self.found: Found | None = None
        self.curves: dict[str, Curve] = {}
        self.progress: Progress | None = None
        self.quick: Quick | None = None
        self.sharp: Sharp | None = None
        self.figures: Figures | None = None
        self.comparison: Comparison | None = None
        self.alike: Comparison | None = None
        self._messages: deque[str] = deque()
        self._errands: deque[Steps] = deque()
        self._pipelines = [pipeline_of(s, self.depth_range[1]) for s in self.sources]
        self._workers = {n: Worker(n, wake) for n in ("quick", "slow", "errands")}
        self._asked: Request | None = None
        self._sharpened: Request | None = None
        self._focusing = False
        self._changed_at = time.monotonic()
        self._next_flip = 0.0
        self._flips: deque[float] = deque(maxlen=12)

    def close(self) -> None:
        """End the workers; a file that is being written becomes whole."""
        for worker in self._workers.values():
            worker.leave()
        for name, worker in self._workers.items():
            worker.close(60.0 if name == "errands" else 0.5)

    # --- the work, done elsewhere ---

    @property
    def request(self) -> Request:
        """What is to be seen now."""
        return Request(self.number, self._depth, self._filter, self.screen, self.sight)

    def update(self) -> bool:
        """Ask for what is missing, take what is there; whether anything new came."""
        self._flip()
        fresh = self._take()
        self._next_errand()
        wanted = self.request
        if wanted != self._asked:
            if self.found is not None and self.found.number != wanted.number:
                self.found = None  # what was focused on belongs to its frame
            if any(c.number != wanted.number for c in self.curves.values()):
                self.curves = {}
            if self._asked is None or wanted.subject != self._asked.subject:
                self._changed_at = time.monotonic()
                if self._focusing:
                    self._focusing, self.progress = False, None
                self._workers["slow"].leave()
                self._sharpened = None
            self._asked = wanted
            for pipeline in self._pipelines:
                pipeline.farthest = self.depth_range[1]
            self._workers["quick"].ask(lambda: self._first(wanted))
        rested = time.monotonic() - self._changed_at >= REST
        if rested and not self.playing:
            self._history.note(self.snapshot())
        if rested and not self._focusing and self._sharpened is None:
            decoded = self._decoded()
            if decoded is not None:
                self._sharpened = wanted
                self._workers["slow"].ask(lambda: self._then(decoded, wanted))
        if self.comparing and rested and not self._focusing:
            self._compare_anew()
        return fresh

    def _first(self, wanted: Request) -> Iterator[Any]:
        for answer in quick(self._pipelines, wanted):
            yield answer
            if self.comparing:
                yield self._compare(wanted, answer.pictures, False)

    def _compare(
        self, wanted: Request, pictures: Sequence[Picture | None], with_ssim: bool
    ) -> Comparison | None:
        shape = self.video.slm.shape
        return compare(wanted, pictures, with_ssim, shape, self.region)

    def _compare_anew(self) -> None:
        """The sharp pictures compared again when another region is marked."""
        held, sharp = self.comparison, self.sharp
        if held is None or held.region == self.region or self._workers["slow"].busy:
            return
        if sharp is not None and sharp.request.subject == self.request.subject:
            again = sharp
            self._workers["slow"].ask(
                lambda: iter([self._compare(again.request, again.pictures, True)])
            )

    def _then(self, decoded: Sequence[Decoded | None], wanted: Request) -> Iterator[Any]:
        for answer in sharpen(decoded, wanted):
            yield answer
            if isinstance(answer, Sharp) and self.comparing:
                yield self._compare(wanted, answer.pictures, False)
                yield self._compare(wanted, answer.pictures, True)

    def _decoded(self) -> tuple[Decoded | None, ...] | None:
        """The wanted frame's fields, once the quick worker has them."""
        ready = self.quick is not None and self.quick.request.subject == self.request.subject
        return self.quick.decoded if ready and self.quick is not None else None

    def _take(self) -> bool:
        fresh = False
        for name, worker in self._workers.items():
            for result in worker.take():
                fresh = True
                self._accept(name, result)
        return fresh

    def _accept(self, worker: str, result: Any) -> None:
        if isinstance(result, Quick):
            if self.quick is None or result.request.number != self.quick.request.number:
                self._flips.append(time.monotonic())
            self.quick = result
            if self.comparing and self._sharpened is None and not self._focusing:
                seen = result  # beside the pictures to come, which do not wait for it
                self._workers["slow"].ask(
                    lambda: iter([self._compare(seen.request, seen.pictures, True)])
                )
        elif isinstance(result, Sharp):
            self.sharp = result
        elif isinstance(result, Figures):
            self.figures = result
        elif isinstance(result, Comparison):
            current = result.request.subject == self.request.subject
            if result.ssim is not None:
                self.alike = result
            if current or result.ssim is None:
                self.comparison = result
        elif isinstance(result, Progress):
            if worker == "errands" or self._focusing:
                self.progress = result
        elif isinstance(result, Curve):
            if result.number == self.number:
                self.curves[result.name] = result
        elif isinstance(result, Found):
            self._accept_focus(result)
        elif isinstance(result, Said):
            self._messages.append(result.text)
        elif isinstance(result, Failed):
            self._messages.append(result.message)
            self._focusing = False
        busy = self._focusing or self._workers["errands"].busy
        if self.progress is not None and not busy:
            self.progress = None

    def _accept_focus(self, result: Found) -> None:
        if not self._focusing or result.number != self.number:
            return
        self._focusing, self.progress = False, None
        self.found = result
        if result.focus.focused:
            self.follow = None
            self.depth = result.focus.depth
            self._messages.append(f"focused at {self.depth * 1e3:.2f} mm")
        else:
            self._messages.append("nothing comes into focus there")

    def focus_at(self, row: int, column: int, video: int = 0) -> None:
        """Find the focus around a pixel; `found` and the depth follow when it is done."""
        decoded = self._decoded()
        one = decoded[video] if decoded is not None else None
        if one is None:
            return
        depths = self.depth_range
        self._focusing, self._sharpened = True, None
        self._workers["slow"].ask(lambda: focus_around(one, (row, column), depths))

    def find_curves(self) -> None:
        """Find the focus curves of the frame's objects; `curves` fills when they are done."""
        decoded = self._decoded()
        one = decoded[self.active] if decoded is not None else None
        if one is not None:
            depths = self.depth_range
            self.run_errand(lambda: curves_of_objects(one, depths))

    def run_errand(self, job: Steps) -> None:
        """Do a long job beside all else, after those that were asked for before."""
        self._errands.append(job)
        self._next_errand()

    def _next_errand(self) -> None:
        if self._errands and not self._workers["errands"].busy:
            self._workers["errands"].ask(self._errands.popleft())

    def stop(self) -> None:
        """Stop an autofocus and all errands."""
        self._errands.clear()
        self._workers["errands"].leave()
        if self._focusing:
            self._workers["slow"].leave()
        self._focusing, self.progress = False, None

    # --- playing ---

    def _flip(self) -> None:
        """The next frame when it is time and the last one was seen."""
        if not self.playing:
            self._flips.clear()
        now = time.monotonic()
        seen = self.quick is not None and self.quick.request.number == self.number
        if not (self.playing and seen and now >= self._next_flip):
            return
        self._next_flip = max(self._next_flip, now - 1 / self.rate) + 1 / self.rate
        self.step(1)

    @property
    def seconds_to_flip(self) -> float:
        """Until the next frame is due."""
        return max(self._next_flip - time.monotonic(), 0.0)

    @property
    def shown_rate(self) -> float:
        """Frames a second over the last dozen."""
        if len(self._flips) < 2 or time.monotonic() - self._flips[-1] > 3:
            return 0.0
        return (len(self._flips) - 1) / max(self._flips[-1] - self._flips[0], 1e-9)

    # --- what is there to see ---

    def picture(self, video: int = 0) -> Picture | None:
        """The best picture there is: the sharp one where it answers the request."""
        if self.sharp is not None and self.sharp.request.subject == self.request.subject:
            return self.sharp.pictures[video]
        return self.quick.pictures[video] if self.quick is not None else None

    def fault(self, video: int = 0) -> str:
        """What is wrong with the frame, one line, or nothing."""
        return self.quick.faults[video] if self.quick is not None else ""

    def decoded(self, video: int = 0) -> Decoded | None:
        """The decoded frame that was seen last."""
        return self.quick.decoded[video] if self.quick is not None else None

    @property
    def busy(self) -> str:
        """What is under way, in words, or nothing."""
        if self.progress is not None:
            return self.progress.what
        if self._workers["errands"].busy:
            return "working"
        if self._workers["slow"].busy:
            return "autofocus" if self._focusing else "sharp picture"
        return "picture" if self._workers["quick"].busy else ""

    @property
    def resting(self) -> bool:
        """Whether everything that was asked for is there."""
        wanted = self.request.subject
        return (
            not self.busy
            and self.figures is not None
            and self.figures.request.subject == wanted
            and self._asked == self.request
        )

    @property
    def seconds_to_rest(self) -> float:
        """Until the sharp picture may be asked for; 0 when it was."""
        if self._sharpened is not None or self._focusing:
            return 0.0
        return max(self._changed_at + REST - time.monotonic(), 0.001)

    def settle(self, seconds: float = 60.0) -> None:
        """Update until `resting`: for scripts and tests."""
        end = time.monotonic() + seconds
        self.update()
        while not self.resting:
            if time.monotonic() > end:
                raise TimeoutError(f"still busy after {seconds} s: {self.busy or 'nothing'}")
            time.sleep(0.002)
            self.update()

    def messages(self) -> list[str]:
        """What is to be told, once."""
        told = list(self._messages)
        self._messages.clear()
        return told
