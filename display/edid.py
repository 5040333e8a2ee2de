"""The name on a monitor's label, from its EDID: the 128 bytes that it tells the computer."""

import sys
from pathlib import Path

_DESCRIPTORS = (54, 72, 90, 108)  # where the four descriptors of 18 bytes begin
_NAME = b"\x00\x00\x00\xfc\x00"
_MAGIC = b"\x00\xff\xff\xff\xff\xff\xff\x00"


def label_of(edid: bytes) -> str:
    """The monitor's name, else maker and product code such as "HOL 1A2B"; "" for no EDID.

    Source: VESA E-EDID 1.4, sections 3.4 and 3.10.3.4.
    """
    if len(edid) < 128 or edid[:8] != _MAGIC:
        return ""
    for start in _DESCRIPTORS:
        part = edid[start : start + 18]
        if part[:5] == _NAME:
            text = part[5:].split(b"\n")[0].decode("cp437").strip()
            if text and text.isprintable():
                return text
    code = int.from_bytes(edid[8:10], "big")
    letters = [(code >> shift) & 31 for shift in (10, 5, 0)]
    if not all(1 <= letter <= 26 for letter in letters):
        return ""
    maker = "".join(chr(64 + letter) for letter in letters)
    return f"{maker} {int.from_bytes(edid[10:12], 'little'):04X}"


def drm_labels(folder: Path = Path("/sys/class/drm")) -> dict[str, str]:
    """Labels by output name (such as "DP-1"), as Linux's graphics drivers list them."""
    labels = {}
    for path in sorted(folder.glob("card*-*/edid")):
        try:
            label = label_of(path.read_bytes())
        except OSError:
            continue
        if label:
            labels[path.parent.name.split("-", 1)[1]] = label
    return labels


def windows_label(adapter: str) -> str:
    """Label of the monitor on a Windows adapter such as "\\\\.\\DISPLAY1"; "" where unknown."""
    if sys.platform != "win32":
        return ""
    import ctypes
    import winreg
    from ctypes import wintypes

    class Device(ctypes.Structure):
        _fields_ = (
            ("size", wintypes.DWORD),
            ("name", wintypes.WCHAR * 32),
            ("text", wintypes.WCHAR * 128),
            ("flags", wintypes.DWORD),
            ("id", wintypes.WCHAR * 128),
            ("key", wintypes.WCHAR * 128),
        )

    device = Device(size=ctypes.sizeof(Device))
    # The last argument asks for the interface's name, which holds the place in the registry.
    if not ctypes.windll.user32.EnumDisplayDevicesW(adapter, 0, ctypes.byref(device), 1):
        return ""
    parts = device.id.split("#")
    if len(parts) < 3:
        return ""
    path = rf"SYSTEM\CurrentControlSet\Enum\DISPLAY\{parts[1]}\{parts[2]}\Device Parameters"
    try:
        with winreg.OpenKey(winreg.HKEY_LOCAL_MACHINE, path) as key:
            return label_of(bytes(winreg.QueryValueEx(key, "EDID")[0]))
    except OSError:
        return ""
