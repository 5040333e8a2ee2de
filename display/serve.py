"""A panel on the network: one client at a time shows frames on a `Screen`.

Nothing from the network reads or writes files, allocates more than a frame, or ends the server.
"""

import hmac
import ipaddress
import socket
import threading
import time
from collections.abc import Callable
from dataclasses import asdict
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.ranges import real
from display.screen import Screen
from display.wire import Broken, receive, send

PORT = 47808
_PATIENCE = 20.0  # seconds for the rest of a message that has begun, and for the greeting
_FORMATS = ("raw", "png", "complex64")


class Server:
    """Listens, and shows what the client sends.

    screen : opened and closed by the caller
    host, port : where to listen; port 0 takes a free one, see `address`
    token : what a client must present; needed unless host is this machine alone
    tell : is given a line for every client that comes, goes or errs
    """

    def __init__(
        self,
        screen: Screen,
        host: str = "127.0.0.1",
        port: int = PORT,
        token: str = "",
        tell: Callable[[str], None] = lambda line: None,
    ) -> None:
        if not is_loopback(host) and len(token) < 8:
            raise ValueError(
                f"anyone who reaches {host} could drive the panel: give --token, 8 characters or "
                "more"
            )
        self.screen, self.tell = screen, tell
        self._token = token
        self._busy = threading.Lock()
        self._stopped = False
        try:
            self._socket = socket.create_server((host, port))
        except (OSError, OverflowError) as error:
            raise OSError(f"cannot listen on {host}:{port}: {error}") from None
        self._socket.settimeout(0.2)
        slm = screen.slm
        self._limit = 8 * slm.width * slm.height + 4096

    @property
    def address(self) -> tuple[str, int]:
        """Host and port that it listens on."""
        host, port = self._socket.getsockname()[:2]
        return str(host), int(port)

    def run(self) -> None:
        """Serve until `stop`, or until the user closes the window."""
        with self._socket:
            while not self._stopped and not self.screen.closed:
                try:
                    connection, place = self._socket.accept()
                except TimeoutError:
                    continue
                except OSError as error:
                    self.tell(f"warning: a client could not be taken: {error}")
                    time.sleep(0.05)
                    continue
                threading.Thread(
                    target=self._client, args=(connection, f"{place[0]}:{place[1]}"), daemon=True
                ).start()

    def stop(self) -> None:
        """End `run`."""
        self._stopped = True

    def _client(self, connection: socket.socket, name: str) -> None:
        with connection:
            if not self._busy.acquire(blocking=False):
                _answer(connection, "another client has the panel: close it first")
                return
            try:
                connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self.tell(f"client {name} connected")
                self.serve(connection)
                self.tell(f"client {name} left")
            except Broken as error:
                self.tell(f"warning: client {name}: {error}")
                _answer(connection, str(error))
            except OSError as error:
                self.tell(f"warning: client {name} was lost: {error}")
            finally:
                self._busy.release()

    def serve(self, connection: socket.socket) -> None:
        """Talk to one client until it leaves; Broken where it cannot be understood."""
        connection.settimeout(_PATIENCE)
        welcome = False
        while not self._stopped:
            if welcome and not self._waits(connection):
                return
            got = receive(connection, self._limit if welcome else 0, _PATIENCE)
            if got is None:
                return
            message, payload = got
            do = message.get("do")
            if not welcome:
                token = message.get("token", "")
                if do != "hello" or not isinstance(token, str):
                    raise Broken('the first message is {"do": "hello", "token": …}')
                # JSON can hold halves of letters, which no encoding knows.
                given = token.encode("utf-8", "surrogatepass")
                if not hmac.compare_digest(given, self._token.encode()):
                    raise Broken("wrong token")
                welcome = True
            try:
                answer, sent = self._do(do, message, payload)
            except (ValueError, TypeError, OSError) as error:
                if self.screen.closed:
                    raise Broken("the panel's window was closed") from None
                answer, sent = {"ok": False, "error": str(error)[:500]}, b""
            send(connection, answer, sent)
            if do == "bye":
                return

    def _waits(self, connection: socket.socket) -> bool:
        """Wait, however long, for the next message to begin; False when the server stops."""
        connection.settimeout(0.2)
        while not self._stopped:
            try:
                connection.recv(1, socket.MSG_PEEK)
            except TimeoutError:
                continue
            connection.settimeout(_PATIENCE)
            return True
        return False

    def _do(self, do: Any, message: dict[str, Any], payload: bytes) -> tuple[dict[str, Any], bytes]:
        screen = self.screen
        if do in ("hello", "info"):
            return {
                "ok": True,
                "name": screen.name,
                "width": screen.slm.width,
                "height": screen.slm.height,
                "pixel_pitch": screen.slm.pixel_pitch,
                "bits": screen.slm.bits,
                "kind": screen.slm.kind,
                "refresh": screen.refresh,
                "clock": time.perf_counter(),
            }, b""
        if do == "show":
            frame = frame_of(message, payload, screen.slm.shape)
            moment = message.get("at")
            if moment is not None:
                moment = real("at", moment)
                if not moment < time.perf_counter() + 60:
                    raise ValueError("at is a time of the server's clock, within a minute")
                time.sleep(max(0.0, moment - time.perf_counter()))
            flip = screen.show(frame, str(message.get("name", ""))[:200])
            return {"ok": True, "flip": asdict(flip)}, b""
        if do == "read":
            picture = np.ascontiguousarray(screen.read())
            return {"ok": True, "shape": list(picture.shape)}, picture.tobytes()
        if do == "bye":
            return {"ok": True}, b""
        raise ValueError(f"do: hello, info, show, read or bye, not {str(do)[:40]!r}")


def frame_of(message: dict[str, Any], payload: bytes, shape: tuple[int, int]) -> NDArray[Any]:
    """The frame that a message carries, of the panel's shape; ValueError for any other."""
    rows, columns = shape
    kind = message.get("format", "raw")
    if kind == "png":
        return _unpacked(payload, shape)
    if kind not in _FORMATS:
        raise ValueError(f"format: {', '.join(_FORMATS)}, not {str(kind)[:40]!r}")
    wide = 1 if kind == "raw" else 8
    if len(payload) != wide * rows * columns:
        raise ValueError(
            f"{len(payload)} bytes are no frame: {columns} × {rows} pixels of {wide} bytes each "
            f"have {wide * rows * columns}"
        )
    values = np.frombuffer(payload, dtype=np.uint8 if kind == "raw" else "<c8")
    return values.reshape(shape)


def _unpacked(payload: bytes, shape: tuple[int, int]) -> NDArray[np.uint8]:
    from PIL.PngImagePlugin import PngImageFile

    try:
        # Not by Image.open, which warns of a size that is refused here anyway.
        with PngImageFile(BytesIO(payload)) as picture:
            if picture.mode != "L" or picture.size != (shape[1], shape[0]):
                raise ValueError(
                    f"the PNG is {picture.size[0]} × {picture.size[1]}, mode {picture.mode}: 8-bit "
                    f"grey of {shape[1]} × {shape[0]} pixels is needed"
                )
            return np.array(picture, dtype=np.uint8)
    except ValueError:
        raise
    except Exception as error:  # whatever a decoder makes of a stranger's bytes
        raise ValueError(f"the PNG cannot be read: {str(error)[:100]}") from None


def is_loopback(host: str) -> bool:
    """Whether an address is this machine's own alone."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _answer(connection: socket.socket, error: str) -> None:
    """Say what was wrong, if the client still listens."""
    try:
        connection.settimeout(2.0)
        send(connection, {"ok": False, "error": error})
        connection.shutdown(socket.SHUT_WR)
        # What is still under way would make the answer vanish with the connection.
        end = time.monotonic() + 1.0
        while time.monotonic() < end and connection.recv(1 << 16):
            pass
    except OSError:
        pass
