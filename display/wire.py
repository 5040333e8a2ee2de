"""Messages between a program and `chrmc serve`: a length, JSON, and what the JSON announces.

    4 bytes    length n of the JSON, most significant byte first; at most 65,536
    n bytes    one JSON object, UTF-8
    b bytes    payload, b the object's "bytes"; none without it

Both directions are the same. A request says what to "do"; an answer says "ok": true with what was
asked for, or false with an "error" in words. docs/remote.md lists them.
"""

import json
import socket
import struct
import time
from typing import Any

HEADER_LIMIT = 65_536
_LENGTH = struct.Struct(">I")


class Broken(Exception):
    """What came is no message, so nothing after it can be understood."""


def send(connection: socket.socket, message: dict[str, Any], payload: bytes = b"") -> None:
    """Send one message."""
    if payload:
        message = message | {"bytes": len(payload)}
    text = json.dumps(message).encode()
    connection.sendall(_LENGTH.pack(len(text)) + text)
    if payload:
        connection.sendall(payload)


def receive(
    connection: socket.socket, limit: int, seconds: float = float("inf")
) -> tuple[dict[str, Any], bytes] | None:
    """The next message and its payload; None where the other side has closed.

    limit : bytes of payload that are taken; a longer one raises Broken before anything of it is
        read
    seconds : for the JSON, and again for the payload and each megabyte of it: one byte now and
        then would keep others out for hours
    """
    end = time.monotonic() + seconds
    start = _read(connection, _LENGTH.size, end, may_end=True)
    if start is None:
        return None
    (length,) = _LENGTH.unpack(start)
    if not 2 <= length <= HEADER_LIMIT:
        raise Broken(f"a message of {length} bytes: the first 4 bytes are the length of its JSON")
    try:
        message = json.loads(_read(connection, length, end) or b"")
    except (ValueError, RecursionError) as error:
        raise Broken(f"what should be JSON is not: {str(error)[:100]}") from None
    if not isinstance(message, dict):
        raise Broken("the JSON of a message is an object")
    count = message.get("bytes", 0)
    if type(count) is not int or count < 0:
        raise Broken(f"bytes is a count, not {str(count)[:40]!r}")
    if count > limit:
        raise Broken(f"{count} bytes announced; this panel's frames have {limit} at most")
    end = time.monotonic() + seconds * (1 + count / 1e6)
    return message, (_read(connection, count, end) or b"") if count else b""


def _read(connection: socket.socket, count: int, end: float, may_end: bool = False) -> bytes | None:
    held = bytearray()
    while len(held) < count:
        if time.monotonic() > end:
            raise Broken(f"{len(held)} of {count} bytes came in time: send a message at once")
        part = connection.recv(min(count - len(held), 1 << 20))
        if not part:
            if may_end and not held:
                return None
            raise Broken(f"the connection ended after {len(held)} of {count} bytes")
        held += part
    return bytes(held)
