"""A process that works on cases one after the other, and is ended where one takes too long."""

import multiprocessing
from multiprocessing.connection import Connection

from chrmc.bench.extremes import Case, Outcome, judged, limit, measured

_SHARED = 4.0  # times a case's limit that may pass by the clock, on a machine that others use too


class Worker:
    """Holds the process; use it in a `with`."""

    def __init__(self) -> None:
        self._process: multiprocessing.process.BaseProcess | None = None
        self._pipe: Connection | None = None

    def __enter__(self) -> "Worker":
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def run(self, case: Case, patience: float = _SHARED) -> Outcome:
        """The outcome of a case, or of having ended it.

        patience : times the case's limit
        """
        if self._pipe is None:
            context = multiprocessing.get_context("spawn")
            self._pipe, theirs = context.Pipe()
            self._process = context.Process(target=_serve, args=(theirs,), daemon=True)
            self._process.start()
            theirs.close()
            self._pipe.recv()  # it has imported what it needs
        assert self._process is not None
        seconds = patience * limit(case)
        out = Outcome(case, seconds=seconds, cpu=seconds)
        self._pipe.send(case)
        try:
            if self._pipe.poll(seconds):
                return judged(self._pipe.recv())
            out.fault = f"ended after {seconds:.0f} s"
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


def _serve(pipe: Connection) -> None:
    pipe.send("ready")
    while True:
        try:
            case = pipe.recv()
        except (EOFError, KeyboardInterrupt):
            return
        pipe.send(measured(case))
