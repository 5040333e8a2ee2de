"""A process that works on cases one after the other, and is ended where one takes too long."""

import multiprocessing
import time
from multiprocessing.connection import Connection

from chrmc.bench.extremes import Case, Outcome, judged, limit, measured

_PATIENCE = 3.0  # times a case's limit, in processor time: the truth takes some of it too
_SHARED = 3.0  # times as much by the clock, on a machine that others use too


class Worker:
    """Holds the process; use it in a `with`."""

    def __init__(self) -> None:
        self._process: multiprocessing.process.BaseProcess | None = None
        self._pipe: Connection | None = None

    def __enter__(self) -> "Worker":
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def run(self, case: Case, patience: float = _PATIENCE) -> Outcome:
        """The outcome of a case, or of having ended it.

        patience : times the case's limit, in processor time; three times as long by the clock
        """
        if self._pipe is None:
            context = multiprocessing.get_context("spawn")
            self._pipe, theirs = context.Pipe()
            self._process = context.Process(target=_serve, args=(theirs,), daemon=True)
            self._process.start()
            theirs.close()
            self._pipe.recv()  # it has imported what it needs
        assert self._process is not None and self._process.pid is not None
        seconds, start = patience * limit(case), time.monotonic()
        before = _processor_time(self._process.pid)
        out = Outcome(case)
        self._pipe.send(case)
        try:
            while out.cpu < seconds and out.seconds < _SHARED * seconds:
                if self._pipe.poll(min(0.5, seconds)):
                    return judged(self._pipe.recv())
                out.seconds = time.monotonic() - start
                out.cpu = _processor_time(self._process.pid) - before
            out.fault = f"ended after {out.seconds:.0f} s, {out.cpu:.0f} of the processors"
        except EOFError:
            self._process.join(10)
            out.fault = f"its process died, status {self._process.exitcode}: out of memory?"
        self._end()
        return out

    def _end(self) -> None:
        if self._process is not None and self._pipe is not None:
            self._process.kill()
            self._process.join()
            self._pipe.close()
        self._process = self._pipe = None


def _processor_time(pid: int) -> float:
    """Seconds that a process has had of all processors; 0 where the system does not tell."""
    try:
        return time.clock_gettime((~pid << 3) | 2)  # its clock, as clock_getcpuclockid names it
    except (OSError, AttributeError):
        return 0.0


def _serve(pipe: Connection) -> None:
    pipe.send("ready")
    while True:
        try:
            case = pipe.recv()
        except (EOFError, KeyboardInterrupt):
            return
        pipe.send(measured(case))
