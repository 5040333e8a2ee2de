"""A byte to other instruments at every new frame: UDP or a serial line."""

import re
import socket
from collections.abc import Callable
from typing import Any

from display.log import Flip

Message = bytes | Callable[[Flip], bytes]


class UDPMark:
    """Sends a datagram whenever a new frame is on: pass it as `on_flip`.

    address : "host:port"
    message : what to send, or a function of the flip that says it; None sends the number of the
        flip as text
    """

    def __init__(self, address: str, message: Message | None = None) -> None:
        host, _, port = address.rpartition(":")
        if not host or not port.isdecimal() or not 0 < int(port) < 65536:
            raise ValueError(f"{address!r} is no address: write host:port, such as 10.0.0.5:9000")
        try:
            family, kind, _, _, place = socket.getaddrinfo(
                host.strip("[]"), int(port), type=socket.SOCK_DGRAM
            )[0]
        except OSError as error:
            raise OSError(f"{address}: {error.strerror or error}") from error
        self._socket, self._place = socket.socket(family, kind), place
        self._socket.setblocking(False)
        self._message = message

    def __call__(self, flip: Flip) -> None:
        if flip.shown == "new":
            message = str(flip.flip).encode() if self._message is None else self._message
            self._socket.sendto(
                message if isinstance(message, bytes) else message(flip), self._place
            )

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


class SerialMark:
    """Writes a byte to a serial line whenever a new frame is on: pass it as `on_flip`.

    port : such as "/dev/ttyUSB0" or "COM3"; needs the package pyserial
    message : what to write, or a function of the flip that says it (`display.colours.laser_bytes`)
    baud : bits per second; at 115200 a byte takes 87 µs
    """

    def __init__(self, port: str, message: Message = b"\x01", baud: int = 115200) -> None:
        try:
            import serial
        except ImportError:
            raise OSError("a serial mark needs pyserial: pip install 'chrmc[serial]'") from None
        try:
            self._line: Any = serial.Serial(port, baud, write_timeout=0.1)
        except (serial.SerialException, ValueError) as error:
            said = re.sub(r"\[Errno -?\d+\] ", "", str(error))
            raise OSError(f"serial line {port}: {said}") from error
        self._message = message

    def __call__(self, flip: Flip) -> None:
        if flip.shown == "new":
            message = self._message
            self._line.write(message if isinstance(message, bytes) else message(flip))
            self._line.flush()

    def close(self) -> None:
        """Close the line."""
        self._line.close()
