"""Small files that claim to be, or unpack to, far more than memory holds: one line, at once."""

import json
import resource
import shutil
import struct
import time
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import pytest

from chrmc.cli.main import group, main
from chrmc.files import sha256
from chrmc.pictures import read_grey, write_pixels

SIDE = 60_000
CLAIMED = 200_000


def png_bomb(path: Path) -> None:
    """(60,000, 60,000) black pixels of 8 bits: 3.6 GB from 4 MB."""
    packer = zlib.compressobj(9)
    row = bytes(SIDE + 1)
    few = packer.compress(row * 20) + packer.flush(zlib.Z_FULL_FLUSH)
    # After a full flush the packer starts afresh, so the same bytes stand for the next rows too.
    again = zlib.compressobj(9, zlib.DEFLATED, -15)
    more = again.compress(row * 20) + again.flush(zlib.Z_FULL_FLUSH)
    data = few + more * (SIDE // 20 - 1) + b"\x03\x00" + struct.pack(">I", 1)

    def chunk(kind: bytes, content: bytes) -> bytes:
        code = zlib.crc32(kind + content)
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", code)

    head = struct.pack(">IIBBBBB", SIDE, SIDE, 8, 0, 0, 0, 0)
    parts = chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + parts)


def tiff_bomb(path: Path) -> None:
    """The same as TIFF, of strips of one packed row."""
    strip = zlib.compress(bytes(SIDE), 9)
    entries = 9
    strips = 8 + 2 + 12 * entries + 4
    offsets, counts = strips + len(strip), strips + len(strip) + 4 * SIDE
    tags = [
        (256, 4, 1, SIDE), (257, 4, 1, SIDE), (258, 3, 1, 8), (259, 3, 1, 8), (262, 3, 1, 1),
        (273, 4, SIDE, offsets), (277, 3, 1, 1), (278, 4, 1, 1), (279, 4, SIDE, counts),
    ]  # fmt: skip
    head = b"II*\0" + struct.pack("<I", 8) + struct.pack("<H", entries)
    head += b"".join(struct.pack("<HHII", *tag) for tag in tags) + struct.pack("<I", 0)
    places = np.full(SIDE, strips, "<u4").tobytes() + np.full(SIDE, len(strip), "<u4").tobytes()
    path.write_bytes(head + strip + places)


def exr_bomb(path: Path) -> None:
    """A good file whose header says 200,000 × 200,000."""
    content = path.read_bytes()
    for name in (b"dataWindow\0box2i\0", b"displayWindow\0box2i\0"):
        at = content.index(name) + len(name) + 4
        window = struct.pack("<4i", 0, 0, CLAIMED - 1, CLAIMED - 1)
        content = content[:at] + window + content[at + 16 :]
    path.write_bytes(content)


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory, stored_video: Path) -> Path:
    folder = tmp_path_factory.mktemp("good")
    shutil.copytree(stored_video, folder / "video")
    scene = ["scene", "car-house", "--out", str(folder / "scene"), "--frames", "1:1"]
    group.main(scene, standalone_mode=False)
    return folder


@pytest.mark.parametrize(
    "arguments",
    [
        ["check", "video"],
        ["reconstruct", "video", "--frame", "1", "--depth", "252mm", "--out", "o.png"],
        ["panorama", "video", "--out", "p.png"],
        ["play", "video", "--headless", "--on-bad-frame", "stop"],
        ["play", "video/frame_0001.png", "--headless"],
        ["generate", "video/frame_0001.png", "--out", "v", "--slm", "192x120:81um"],
        ["generate", "scene", "--out", "v", "--slm", "192x120:81um"],
    ],
    ids=lambda arguments: " ".join(arguments[:2]),
)
@pytest.mark.parametrize("kind", ["png", "tif"])
def test_a_bomb_is_one_line_in_a_second(
    arguments: list[str],
    kind: str,
    good: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    if "scene" in arguments and kind == "tif":
        return  # scenes have OpenEXR frames
    monkeypatch.chdir(tmp_path)
    shutil.copytree(good, tmp_path, dirs_exist_ok=True)
    frame = tmp_path / "video" / f"frame_0001.{kind}"
    (png_bomb if kind == "png" else tiff_bomb)(frame)
    assert frame.stat().st_size < 5e6
    manifest = tmp_path / "video" / "manifest.json"
    content = json.loads(manifest.read_text())
    content["frames"][0] |= {"file": frame.name, "sha256": sha256(frame)}
    manifest.write_text(json.dumps(content))
    exr_bomb(tmp_path / "scene" / "frame_0001.exr")
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    begun = time.process_time()
    with pytest.raises(SystemExit) as ended:
        main([word.replace("frame_0001.png", frame.name) for word in arguments])
    assert time.process_time() - begun < 2  # what is loaded first of all takes a part
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 300_000  # kilobytes
    told = capfd.readouterr().err
    assert ended.value.code in (1, 2), told
    assert "frame_0001" in told
    if ended.value.code == 2:
        assert told.count("\n") == 1
    assert not (tmp_path / "v").exists()
    assert not (tmp_path / "o.png").exists()


def test_the_bombs_are_what_they_say(tmp_path: Path) -> None:
    """Another reader finds the same sizes, and rows that unpack."""
    from PIL import Image

    Image.MAX_IMAGE_PIXELS = None
    for name, make in (("b.png", png_bomb), ("b.tif", tiff_bomb)):
        make(tmp_path / name)
        with Image.open(tmp_path / name) as picture:
            assert picture.size == (SIDE, SIDE)
    write_pixels(tmp_path / "c.exr", np.zeros((4, 4, 1)), "float", names=["Y"])
    exr_bomb(tmp_path / "c.exr")
    assert (tmp_path / "c.exr").stat().st_size < 10_000


@pytest.mark.parametrize("how", ["cut short", "a bit turned"])
@pytest.mark.parametrize(
    "arguments",
    [
        ["play", "video/frame_0001.png", "--headless"],
        ["generate", "video/frame_0001.png", "--out", "v", "--slm", "192x120:81um"],
    ],
    ids=lambda arguments: arguments[0],
)
def test_a_damaged_png_is_one_line(
    arguments: list[str],
    how: str,
    good: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    """Also of what libpng says on its own."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "video").mkdir()
    path = tmp_path / "video" / "frame_0001.png"
    write_pixels(path, np.full((120, 192, 1), 9, np.uint8), "uint8")
    content = bytearray(path.read_bytes())
    content[-20] ^= how == "a bit turned"
    path.write_bytes(content[: -15 if how == "cut short" else None])
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    told = capfd.readouterr().err
    assert ended.value.code == 2 and told.count("\n") == 1, told
    assert "is damaged or cut short" in told


def test_a_png_whose_part_claims_more_than_the_file_has(tmp_path: Path) -> None:
    claim = struct.pack(">I", 0xFFFFFFF0) + b"IDAT" + bytes(9)
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n" + claim)
    tracemalloc.start()
    try:
        with pytest.raises(OSError, match="damaged or cut short"):
            read_grey(tmp_path / "a.png")
        assert tracemalloc.get_traced_memory()[1] < 100e6
    finally:
        tracemalloc.stop()
