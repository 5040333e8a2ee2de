"""A panel that another program or machine serves, with the methods of a `Screen`."""

import socket
import threading
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.ranges import SIDE, real
from display.log import Flip
from display.timing import check_rate
from display.wire import Broken, receive, send

_ANSWER = 1 << 28  # bytes: the largest picture that `read` brings


class Remote:
    """The panel behind `chrmc serve`.

    address : "host:port"
    token : as the server was given it
    timeout : seconds to wait for an answer

    Raises OSError where nothing answers, the server refuses, or the connection is lost. Times of
    flips are those of the server's clock.
    """

    def __init__(self, address: str, token: str = "", timeout: float = 30.0) -> None:
        host, _, port = address.rpartition(":")
        if not host or not port.isdecimal():
            raise ValueError(f"{address!r} is no address: write host:port, such as 127.0.0.1:47808")
        self.address = address
        self._turn = threading.Lock()
        try:
            self._socket: socket.socket | None = socket.create_connection(
                (host.strip("[]"), int(port)), timeout
            )
        except (OSError, OverflowError) as error:
            raise OSError(f"no panel at {address}: {error}") from None
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        about, _ = self._ask({"do": "hello", "token": token})
        with self._understood():
            self.name, self.refresh = str(about["name"]), about["refresh"]
            self.shape = (SIDE.of(about["height"]), SIDE.of(about["width"]))
            self._ahead = real("clock", about["clock"]) - time.perf_counter()

    @property
    def closed(self) -> bool:
        """Whether the connection is closed."""
        return self._socket is None

    def __repr__(self) -> str:
        rows, columns = self.shape
        state = ", closed" if self.closed else ""
        return f"<Remote {self.name!r} at {self.address}, {columns} × {rows}{state}>"

    def show(self, frame: Any, name: str = "") -> Flip:
        """Show one frame, uint8 grey levels or a complex field; returns when it is on."""
        return self._show(frame, name, None)

    def _show(self, frame: Any, name: str, at: float | None) -> Flip:
        frame = np.asarray(frame)
        if frame.shape != self.shape:
            raise ValueError(f"the frame is {frame.shape}, but {self.name} shows {self.shape}")
        if np.iscomplexobj(frame):
            kind, data = "complex64", frame.astype("<c8").tobytes()
        elif frame.dtype == np.uint8:
            kind, data = "raw", frame.tobytes()
        else:
            raise ValueError(f"a frame is uint8 grey levels or a complex field, not {frame.dtype}")
        message: dict[str, Any] = {"do": "show", "format": kind, "name": name}
        if at is not None:
            message["at"] = at + self._ahead
        answer, _ = self._ask(message, data)
        with self._understood():
            return Flip(**answer["flip"])

    def play(
        self,
        frames: Iterable[Any],
        fps: float | None = None,
        *,
        durations: Sequence[float] | None = None,
        loop: bool = False,
        seconds: float | None = None,
    ) -> Iterator[Flip]:
        """Show frame after frame; yields the flip of each.

        frames : any iterable; fps : frames per second, default as fast as they arrive; durations :
        seconds of each frame instead. A frame that the network brings too late is shown at once.
        """
        check_rate(fps, "fps")
        if fps is not None and durations is not None:
            raise ValueError("durations give each frame's time: leave fps out")
        start, due = time.perf_counter(), None
        while True:
            shown = 0
            for index, frame in enumerate(frames):
                if seconds is not None and time.perf_counter() - start >= seconds:
                    return
                flip = self._show(frame, f"frame {index + 1}", due)
                if fps is not None or durations is not None:
                    stay = 1 / fps if fps is not None else (durations or ())[index]
                    now = time.perf_counter()
                    due = now + stay if due is None else max(due + stay, now)
                yield flip
                shown += 1
            if not loop or not shown:
                return

    def read(self) -> NDArray[np.uint8]:
        """(rows, columns, 3) bytes that the panel's part of the server's desktop shows."""
        answer, data = self._ask({"do": "read"})
        with self._understood():
            rows, columns, channels = answer["shape"]
            return np.frombuffer(data, dtype=np.uint8).reshape(rows, columns, channels)

    @contextmanager
    def _understood(self) -> Iterator[None]:
        """OSError where the other side answers what no server of a panel does."""
        try:
            yield
        except (KeyError, TypeError, ValueError) as error:
            self.close()
            raise OSError(f"{self.address} does not answer as a panel does: {error}") from None

    def close(self) -> None:
        """Leave the panel to others."""
        with self._turn:
            if self._socket is not None:
                self._socket.close()
                self._socket = None

    def __enter__(self) -> "Remote":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _ask(self, message: dict[str, Any], payload: bytes = b"") -> tuple[dict[str, Any], bytes]:
        with self._turn:
            if self._socket is None:
                raise ValueError("this connection is closed: open a new one")
            try:
                send(self._socket, message, payload)
                got = receive(self._socket, _ANSWER)
            except (OSError, Broken) as error:
                self._socket.close()
                self._socket = None
                raise OSError(f"{self.address} was lost: {error}") from None
            if got is None:
                self._socket.close()
                self._socket = None
                raise OSError(f"{self.address} closed the connection")
        answer, data = got
        if answer.get("ok") is not True:
            words = str(answer.get("error", "the server refused without a word"))
            if message["do"] == "hello":
                self.close()
                raise OSError(f"{self.address}: {words}")
            raise ValueError(words)
        return answer, data
