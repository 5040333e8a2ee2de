"""A panel on the network: the same methods, and nothing that a stranger sends can hurt it."""

import contextlib
import gc
import json
import os
import random
import re
import socket
import struct
import subprocess
import sys
import threading
import time
import warnings
import zlib
from io import BytesIO

import numpy as np
import pytest

import display
from chrmc.grey_levels import encode
from chrmc.slm import SLM
from display.serve import Server, is_loopback

PANEL = SLM("small", 16, 12, 8e-6)


@pytest.fixture
def served():
    """(server, "host:port", what it told) of a headless panel."""
    told = []
    with display.Screen(headless=True, slm=PANEL) as screen:
        server = Server(screen, port=0, tell=told.append)
        thread = threading.Thread(target=server.run, daemon=True)
        thread.start()
        host, port = server.address
        yield server, f"{host}:{port}", told
        server.stop()
        thread.join(240)
        assert not thread.is_alive()


def noise(seed=0, shape=PANEL.shape):
    return np.random.default_rng(seed).integers(0, 256, shape, dtype=np.uint8)


def connect(address, patience=240.0):
    """A Remote, once the panel is free again."""
    end = time.monotonic() + patience
    while True:
        try:
            return display.Remote(address)
        except OSError as error:
            if "another client" not in str(error) or time.monotonic() > end:
                raise
            time.sleep(0.01)


def raw_message(message, payload=b""):
    text = json.dumps(message).encode()
    return struct.pack(">I", len(text)) + text + payload


def raw_answer(connection):
    """What a client in another language would do."""
    with connection.makefile("rb") as stream:
        (length,) = struct.unpack(">I", stream.read(4))
        return json.loads(stream.read(length))


def dial(address):
    host, port = address.split(":")
    return socket.create_connection((host, int(port)), 240)


def greeted(address):
    """A connection that was welcomed, once the panel is free."""
    for _ in range(10000):
        connection = dial(address)
        connection.sendall(raw_message({"do": "hello"}))
        if raw_answer(connection)["ok"]:
            return connection
        connection.close()
        time.sleep(0.02)
    raise AssertionError("the panel is never free")


def test_the_same_methods_from_afar(served):
    _, address, _ = served
    with display.Remote(address) as panel:
        assert panel.shape == PANEL.shape and "16 × 12" in repr(panel)
        first, second = panel.show(noise(1)), panel.show(noise(2), name="two")
        assert second.flip == first.flip + 1 and second.file == "two" and not second.late
        assert np.array_equal(panel.read()[..., 1], noise(2))
        field = (noise(3) + 1j * noise(4)).astype(np.complex64)
        panel.show(field)
        assert np.array_equal(panel.read()[..., 0], encode(field, PANEL))
    assert panel.closed
    with pytest.raises(ValueError, match="closed"):
        panel.show(noise())


def test_playing_keeps_the_rate(served):
    _, address, _ = served
    with display.Remote(address) as panel:
        flips = list(panel.play([noise(n) for n in range(8)], fps=20))
        gaps = np.diff([f.time for f in flips])
        assert 0.03 < np.median(gaps) < 1  # late on a busy machine, but not early
        assert [f.file for f in flips[:2]] == ["frame 1", "frame 2"]
        uneven = list(panel.play([noise(n) for n in range(3)], durations=[0.15, 0.05, 0.05]))
        assert uneven[1].time - uneven[0].time > 0.12


def test_bad_frames_are_refused_and_the_client_stays(served):
    _, address, _ = served
    with display.Remote(address) as panel:
        for frame, complaint in ((noise(shape=(3, 4)), r"\(3, 4\)"), (noise() / 255, "float64")):
            with pytest.raises(ValueError, match=complaint):
                panel.show(frame)
        with pytest.raises(ValueError, match="NaN"):
            panel.show(np.full(PANEL.shape, np.nan, np.complex64))
        panel.show(noise(5))
        assert np.array_equal(panel.read()[..., 0], noise(5))


def test_the_documented_bytes(served):
    """Spoken by hand, as docs/remote.md tells it."""
    from PIL import Image

    _, address, _ = served
    png = BytesIO()
    Image.fromarray(noise(6)).save(png, "PNG")
    with dial(address) as connection:
        connection.sendall(raw_message({"do": "hello"}))
        about = raw_answer(connection)
        assert about["ok"] and (about["width"], about["height"]) == (16, 12)
        data = noise(6).tobytes()
        for kind, payload in (("raw", data), ("png", png.getvalue())):
            request = {"do": "show", "format": kind, "bytes": len(payload)}
            connection.sendall(raw_message(request, payload))
            answer = raw_answer(connection)
            assert answer["ok"] and answer["flip"]["shown"] == "new"
        for request, complaint in (
            ({"do": "jump"}, "hello, info, show"),
            ({"do": "show"}, "0 bytes are no frame"),
            ({"do": "show", "format": "gif"}, "raw, png, complex64"),
            ({"do": "show", "format": "png"}, "PNG cannot be read"),
        ):
            connection.sendall(raw_message(request))
            answer = raw_answer(connection)
            assert not answer["ok"] and complaint in answer["error"]
        small = BytesIO()
        Image.fromarray(noise(shape=(5, 5))).save(small, "PNG")
        connection.sendall(
            raw_message({"do": "show", "format": "png", "bytes": len(small.getvalue())})
            + small.getvalue()
        )
        assert "5 × 5" in raw_answer(connection)["error"]
        connection.sendall(raw_message({"do": "bye"}))
        assert raw_answer(connection)["ok"]
        assert connection.recv(1) == b""


def test_a_second_client_is_told_and_the_next_is_taken(served):
    _, address, _ = served
    with display.Remote(address) as panel:
        with pytest.raises(OSError, match="another client has the panel"):
            display.Remote(address)
        panel.show(noise())
    connect(address).close()


def test_a_lost_client_frees_the_panel(served):
    _, address, told = served
    connection = dial(address)
    connection.sendall(raw_message({"do": "hello"}))
    assert raw_answer(connection)["ok"]
    connection.sendall(raw_message({"do": "show", "bytes": 192}, bytes(50)))  # and no more
    connection.close()
    with connect(address) as panel:
        panel.show(noise())
    assert any("50 of 192 bytes" in line for line in told)


def test_a_slow_client_is_waited_for(served):
    _, address, _ = served
    whole = raw_message({"do": "hello"}) + raw_message(
        {"do": "show", "bytes": 192}, noise(7).tobytes()
    )
    with dial(address) as connection:
        for byte in whole:
            connection.sendall(bytes([byte]))
            if byte % 8 == 0:
                time.sleep(0.001)
        assert raw_answer(connection)["ok"] and raw_answer(connection)["ok"]


def test_nothing_is_allocated_for_a_frame_that_is_too_long(served):
    _, address, told = served
    for announced in (10**6, 10**15, -5, True, "many", 1.5):
        with greeted(address) as connection:
            connection.sendall(raw_message({"do": "show", "bytes": announced}))
            assert not raw_answer(connection)["ok"]
    assert any("1000000 bytes announced" in line for line in told)


def test_a_token_is_asked_for_beyond_this_machine():
    assert all(is_loopback(host) for host in ("127.0.0.1", "::1", "localhost", "127.3.2.1"))
    assert not any(is_loopback(host) for host in ("0.0.0.0", "::", "10.0.0.5", "lab", ""))
    with display.Screen(headless=True, slm=PANEL) as screen:
        for token in ("", "short"):
            with pytest.raises(ValueError, match="--token"):
                Server(screen, "0.0.0.0", 0, token)
        server = Server(screen, port=0, token="a long secret")
        thread = threading.Thread(target=server.run, daemon=True)
        thread.start()
        address = f"127.0.0.1:{server.address[1]}"
        for wrong in ("", "a long secreT", "é"):
            with pytest.raises(OSError, match=r"wrong token|another client"):
                display.Remote(address, wrong)
            time.sleep(0.05)
        end = time.monotonic() + 240
        while time.monotonic() < end:
            try:
                with display.Remote(address, "a long secret") as panel:
                    panel.show(noise())
                break
            except OSError:
                time.sleep(0.02)
        else:
            pytest.fail("the right token is not taken")
        server.stop()
        thread.join(240)


def mutated(rng):
    """Bytes as a confused or hostile client may send them."""
    request = {
        "do": rng.choice(["hello", "show", "info", "read", "bye", "open", None, 7, [], {}]),
        "format": rng.choice(["raw", "png", "complex64", "gif", 5, None]),
        "bytes": rng.choice([0, 1, 192, 1536, 193, -1, 2**70, "x", None, 1e300, True]),
        "at": rng.choice([None, 0, "now", 1e300, -1e300, float("nan"), True]),
        "name": rng.choice(["a", "../../etc/passwd", 5, "é" * 500, None]),
        "token": rng.choice(["", "x", 5, None]),
    }
    for key in list(request):
        if rng.random() < 0.4:
            del request[key]
    count = request.get("bytes", 0)
    payload = b""
    if isinstance(count, int) and 0 < count < 5000 and rng.random() < 0.8:
        payload = rng.randbytes(count)
    whole = bytearray(raw_message(request, payload))
    kind = rng.random()
    if kind < 0.25:
        for _ in range(rng.randint(1, 8)):
            whole[rng.randrange(len(whole))] = rng.randrange(256)
    elif kind < 0.4:
        whole = whole[: rng.randrange(len(whole))]
    elif kind < 0.5:
        whole = bytearray(rng.randbytes(rng.randrange(1, 200)))
    elif kind < 0.55:
        text = b"[" * 60_000
        whole = bytearray(struct.pack(">I", len(text)) + text)
    return bytes(whole)


def test_ten_thousand_mutated_messages(served):
    """The server lives, answers a good client, and neither memory nor handles grow."""
    server, address, told = served
    rng = random.Random(20)

    def state():
        gc.collect()
        pages = int(open("/proc/self/statm").read().split()[1])  # noqa: PTH123, SIM115
        return len(os.listdir("/proc/self/fd")), pages * 4096  # noqa: PTH208

    def talk(count):
        """One client that says hello, then anything, without waiting for answers."""
        ours, theirs = socket.socketpair()
        sent = b"".join(mutated(rng) for _ in range(count))
        hello = raw_message({"do": "hello"}) if rng.random() < 0.9 else b""

        def drain():
            try:
                while ours.recv(65536):
                    pass
            except OSError:
                pass

        reader = threading.Thread(target=drain)
        reader.start()
        serving = threading.Thread(target=server._client, args=(theirs, "fuzz"))
        serving.start()
        try:
            ours.sendall(hello + sent)
            ours.shutdown(socket.SHUT_WR)
        except OSError:
            pass
        serving.join(60)
        assert not serving.is_alive()
        reader.join(60)
        ours.close()

    for _ in range(100):
        talk(4)
    before = state()
    for _ in range(2400):
        talk(4)
    after = state()
    assert after[0] <= before[0] + 2
    assert after[1] - before[1] < 30e6
    assert told and all(isinstance(line, str) for line in told)
    with connect(address) as panel:
        panel.show(noise(9))
        assert np.array_equal(panel.read()[..., 0], noise(9))


def test_the_command(tmp_path):
    environment = {k: v for k, v in os.environ.items() if "DISPLAY" not in k}
    log = tmp_path / "flips.csv"
    server = subprocess.Popen(
        [
            *(sys.executable, "-c", "from chrmc.cli.main import main; main()", "serve"),
            *("--headless", "--slm", "16x12:8um", "--port", "0", "--log", str(log)),
        ],
        env=environment | {"PYTHONUNBUFFERED": "1"},
        text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    try:
        line = ""
        while "Ctrl-C ends" not in line:
            line = server.stdout.readline()
            assert line, server.stderr.read()
        address = re.search(r"on (127\.0\.0\.1:\d+);", line)[1]
        with display.Remote(address) as panel:
            panel.show(noise())
            panel.show(noise(1), name="../etc/passwd")
    finally:
        server.terminate()
        server.communicate(timeout=240)
    assert server.returncode == 130
    assert len(log.read_text().splitlines()) == 3


def test_no_server_and_no_address_are_one_line():
    with pytest.raises(OSError, match="no panel at"):
        display.Remote("127.0.0.1:9")
    for wrong in ("nowhere", ":5", "host:x"):
        with pytest.raises(ValueError, match="host:port"):
            display.Remote(wrong)


def test_words_that_no_encoding_knows_and_times_beyond_numbers(served):
    _, address, _ = served
    with dial(address) as connection:
        connection.sendall(raw_message({"do": "hello", "token": "\ud800"}))
        assert not raw_answer(connection)["ok"]
    connect(address).close()
    for moment in (-(10**400), float("-inf"), float("nan"), True):
        with connect(address) as panel:
            message = {"do": "show", "at": moment}
            with pytest.raises(ValueError, match="at must be"):
                panel._ask(message, noise().tobytes())


HELLO = {"ok": True, "name": "x", "refresh": 60, "width": 4, "height": 3, "clock": 1}


@pytest.mark.parametrize(
    "answers",
    [
        [{"ok": True}],
        [HELLO | {"height": []}],
        [HELLO | {"width": 10**400}],
        [HELLO | {"clock": None}],
        [HELLO, {"ok": True, "flip": 5}],
        [HELLO, {"ok": True, "flip": {"a": 1}}],
        [HELLO, {"ok": True}],
    ],
)
def test_what_answers_is_no_panel(answers):
    def answer():
        connection, _ = listener.accept()
        with connection:
            for each in answers:
                connection.recv(1 << 16)
                connection.sendall(raw_message(each))

    with socket.create_server(("127.0.0.1", 0)) as listener:
        thread = threading.Thread(target=answer, daemon=True)
        thread.start()
        with pytest.raises(OSError, match="as a panel does"):
            display.Remote(f"127.0.0.1:{listener.getsockname()[1]}").show(
                np.zeros((3, 4), np.uint8)
            )
        thread.join(240)


@pytest.mark.parametrize("name", ["\ud800", "a\nb", "\x00", "\u2028"])
def test_a_name_from_anybody_is_part_of_one_line_of_the_log(name, tmp_path):
    with display.Screen(headless=True, slm=PANEL, log=tmp_path / "f.csv") as screen:
        screen.show(noise(), "good")
        screen.show(noise(), f"<{name}>")
    lines = (tmp_path / "f.csv").read_text().split("\n")
    assert len(lines) == 4
    assert lines[2].split(",")[:2] == ["2", "2"] and "<" in lines[2]


def test_a_picture_that_is_too_large_is_refused_without_a_warning(served):
    _, address, _ = served
    head = struct.pack(">IIBBBBB", 12_000, 12_000, 8, 0, 0, 0, 0)
    part = b"IHDR" + head
    png = b"\x89PNG\r\n\x1a\n" + struct.pack(">I", len(head)) + part
    png += struct.pack(">I", zlib.crc32(part)) + struct.pack(">I", 0) + b"IDAT"
    png += struct.pack(">I", zlib.crc32(b"IDAT"))
    with dial(address) as connection, warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        connection.sendall(raw_message({"do": "hello"}))
        assert raw_answer(connection)["ok"]
        request = {"do": "show", "format": "png", "bytes": len(png)}
        connection.sendall(raw_message(request, png))
        assert "12000 × 12000" in raw_answer(connection)["error"]
    assert not told


@pytest.mark.parametrize("inside", ["the JSON", "the payload"])
def test_who_sends_a_byte_now_and_then_does_not_keep_the_panel(inside, served, monkeypatch):
    _, address, told = served
    monkeypatch.setattr("display.serve._PATIENCE", 0.5)
    with dial(address) as slow:
        if inside == "the JSON":
            slow.sendall(struct.pack(">I", 60_000))
        else:
            slow.sendall(raw_message({"do": "hello"}))
            assert raw_answer(slow)["ok"]
            slow.sendall(raw_message({"do": "show", "bytes": 5000}))
        end = time.monotonic() + 240
        with contextlib.suppress(OSError):  # it hung up
            while time.monotonic() < end and not any("in time" in line for line in told):
                slow.sendall(b" ")
                time.sleep(0.02)
    assert any("in time" in line for line in told)
