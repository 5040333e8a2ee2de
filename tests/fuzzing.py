"""Inputs that nobody would write, each tried in a process of its own.

A case is a command line over a folder of files, or a call with arrays. It is good when it ends in
time and memory with a status of 0 or 1, or with status 2 and one line; a call, when it returns
finite numbers or raises ValueError or OSError. A case is plain data, so that what fails can be kept
as a file. Run by scripts/fuzz.sh; kept cases are tried again by test_fuzzed.py.
"""

import argparse
import base64
import hashlib
import importlib
import json
import multiprocessing
import os
import pkgutil
import random
import re
import resource
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

import click
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

import chrmc
import display
import reconstruct
from chrmc.cli.main import COMMANDS as COMMAND_MODULES
from chrmc.cli.main import group

SECONDS, MEGABYTES = 40, 3000
"""Of processor time, which other programs do not change, and beyond what is loaded already."""
WALL = 6 * SECONDS
KEPT = Path(__file__).parent / "fuzzed"
FORK = multiprocessing.get_context("fork")
"""Its processes start with all modules loaded, and end as a program does: with what was left for
the end (semaphores, threads) seen to."""
Case = dict[str, Any]

NASTY: list[Any] = [
    None, True, False, 0, -1, 1, 2, 3.5, -0.0, 1e-320, 1e-45, 1e38, 1e200, 1e308, -1e308, "nan",
    "inf", "-inf", 2**31, 2**63, 2**64, 10**40, "", " ", "none", "x", "1", "é\u0000ü", "../../x",
    "/etc/passwd", "9" * 40, [], [1], [[1]], ["x"], {}, {"a": 1}, [None], "a" * 5000,
]  # fmt: skip
NUMBERS: list[Any] = [
    0, -1, 1, 1e-320, 1e-45, 1e-9, 532e-9, 8e-6, 0.25, 3.5, 532, 1e38, 1e200, 1e308, -1e308, "nan",
    "inf", "-inf", 2**64, 10**40,
]  # fmt: skip
WORDS = [
    "", "0", "-1", "1", "3", "0.25", "252mm", "8um", "532nm", "532", "1e308", "1e-320", "nan",
    "inf", "-inf", "9" * 40, "none", "x", "../..", "/", "/dev/null", "ü\u2028é", "1:2", "2:1",
    "1,2", "0:0", "all", "a=b", "=", "tolerance=", "tolerance=none", "tolerance=" + "9" * 40,
    "radius=1e308", "guard=-1", "planes=0", "planes=1e9", "-", "--", "%s", "{0}", "a" * 300,
]  # fmt: skip
PANEL = ["--slm", "192x120:81um"]
FRESH = ["--cgh", "fresnel", "--compensation", "none"]
COLOURS = [*PANEL, *FRESH, "--wavelength", "638nm,532nm,450nm", "--frames", "1:1"]
TRADEOFF = ["tradeoff", "scene", *PANEL, "--points", "5", "--rounds", "1", "--frames", "1",
            "--no-images", "--limit", "0.1", "--out", "tradeoff"]  # fmt: skip
MODELS = ["cloud.csv", "cloud.npz", "box.obj", "box.glb", "box.ply", "box.stl", "seen.png"]
WAITING = {"--help", "--loop", "--start-on", "--countdown", "--workers", "--scheduler", "--serial",
           "--udp", "--camera", "--monitor", "--windowed", "--verify-screen", "--identify",
           "--follow", "--minutes", "--limit", "--endure"}  # fmt: skip
"""Options that wait, that need a device, or that ask for hours of work."""
USUAL: dict[str, list[str]] = {
    "generate": ["scene", "--out", "v", "--frames", "1:1", *PANEL, "--compensation", "none"],
    "scene": ["car-house", "--out", "s", "--frames", "1:1"],
    "inspect": ["world.toml", *PANEL],
    "plan": ["world.toml", *PANEL],
    "check": ["video"],
    "reconstruct": ["video", "--frame", "1", "--depth", "252mm", "--out", "o.png"],
    "montage": ["video", "--out", "m.png"],
    "panorama": ["video", "--out", "p.png"],
    "play": ["video", "--headless", "--fps", "1000"],
    "pattern": ["point", "--out", "p.png", *PANEL],
    "bench-sheet": ["car-house"],
    "live": ["scene", "--headless", "--frames", "1:1", *PANEL, "--compensation", "none"],
    "sweep": ["r.toml"],
    "calibrate-response": ["--csv", "readings.csv", "--out", "fit.csv"],
    "bench propagation": ["video", "--frame", "1", "--depth", "252mm", "--pixels", "3"],
    "bench encodings": ["scene", *PANEL],
    "bench tradeoff": [*TRADEOFF],
    "bench rmc": ["car-house", *PANEL, "--frames", "1:2"],
}
ON_FILES = [
    ["generate", "scene", "--out", "v", *PANEL],
    ["scene", "scene", "--out", "copy"],
    ["check", "video"],
    ["reconstruct", "video", "--frame", "1", "--depth", "252mm", "--out", "o.png"],
    ["panorama", "video", "--out", "p.png"],
    ["montage", "video", "--out", "m.png"],
    ["play", "video", "--headless"],
    ["play", "video/frame_0001.tif", "--headless", *PANEL],
    ["generate", "scene", "--out", "video", *PANEL, *FRESH],
    ["generate", "scene", "--out", "v", "--frames", "1:1", *PANEL, "--response", "grey.csv"],
    ["sweep", "r.toml"],
    ["sweep", "r.toml", "--plot", "seconds,error", "--out", "plot.png"],
    ["check", "colours"],
    ["play", "colours", "--headless"],
    ["reconstruct", "colours", "--frame", "1", "--depth", "252mm", "--out", "o.png"],
    ["montage", "colours", "--out", "m.png"],
    ["generate", "scene", "--out", "colours", *COLOURS],
    ["inspect", "world.toml", *PANEL],
    ["generate", "world.toml", "--out", "v", "--frames", "1:1", *PANEL],
    ["scene", "world.toml", "--out", "copy.toml", *PANEL],
    *(["inspect", name, *PANEL] for name in MODELS),
    ["generate", "recording", "--out", "v", "--frames", "1:1", *PANEL],
    ["pattern", "point", "--out", "p.png", "--slm", "panel.toml"],
    ["calibrate-response", "--csv", "readings.csv", "--out", "fit.csv", "--plot", "fit.png"],
    ["bench", *TRADEOFF],
    ["bench", *TRADEOFF, "--draw-only"],
]  # fmt: skip


def options_of(words: str) -> list[click.Option]:
    """The options of a command, as it declares them."""
    found: click.Command = group
    for word in words.split():
        assert isinstance(found, click.Group)
        inner = found.get_command(click.Context(found), word)
        assert inner is not None
        found = inner
    options = [p for p in found.params if isinstance(p, click.Option)]
    return [p for p in options if not WAITING & set(p.opts)]


def prepared(folder: Path) -> None:
    """Scenes of all kinds, videos, tables and records that are as they should be."""
    os.chdir(folder)
    run_quietly(["scene", "car-house", "--out", "scene", "--frames", "1:2"])
    run_quietly(["generate", "scene", "--out", "video", *PANEL, *FRESH])
    run_quietly(["generate", "scene", "--out", "colours", *COLOURS])
    Path("r.toml").write_text(
        'scenes = ["scene"]\nmethods = ["fresnel", { cgh = "wrp", set = { planes = 1 } }]\n'
        'tolerances = [1e-2]\nencodings = "ssb"\nslms = ["192x120:81um"]\nframes = "1:1"\n'
        "check = [1]\nwavelength = 532e-9\ncheck_pixels = 16\n"
    )
    run_quietly(["sweep", "r.toml"])
    Path("grey.csv").write_text("grey,intensity\n0,0.01\n64,0.1\n128,0.4\n255,1\n")
    grey = np.arange(0, 256, 5)
    Path("readings.csv").write_text(
        "grey,intensity\n" + "".join(f"{g},{g**2 / 255 + 3:.3f}\n" for g in grey)
    )
    Path("panel.toml").write_text('name = "own"\nwidth = 192\nheight = 120\npixel_pitch = "81um"\n')
    models()
    run_quietly(["bench", *TRADEOFF])


def models() -> None:
    """Files of other programs, and a scene.toml of some of them."""
    import trimesh
    from PIL import Image

    rng = np.random.default_rng(1)
    places, seen = rng.normal(0, 1, (30, 3)), rng.integers(1, 255, (24, 32, 3), dtype=np.uint8)
    np.savetxt("cloud.csv", places, delimiter=",", header="x,y,z", comments="")
    np.savez("cloud.npz", positions=places, intensity=np.ones(30))
    Image.fromarray(seen).save("seen.png")
    corners = trimesh.creation.box()
    for kind in ("glb", "ply", "stl"):
        corners.export(f"box.{kind}")
    Path("box.mtl").write_text("newmtl a\nmap_Kd seen.png\n")
    Path("box.obj").write_text(
        "mtllib box.mtl\nusemtl a\nvt 0 0\nvt 1 0\nvt 0 1\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"
        "v 0 0 1\nf 1/1 2/2 3/3\nf 1/1 2/2 4/3\nf 2/1 3/2 4/3\nf 3/1 1/2 4/3\n"
    )
    Path("track.csv").write_text(
        "time,x,y,z,qx,qy,qz,qw\n0,0,0,1,0,0,0,1\n0.1,0.1,0,1,0,0.1,0,0.99\n"
    )
    Path("world.toml").write_text(
        "frames = 3\nrate = 30\npoints = 200\nlamp = [0, -1, -1]\nambient = 0.2\n"
        '[[object]]\nfile = "box.obj"\nsize = 1e-3\nplace = [0, 0, 0.25]\nturn = [0, 20, 0]\n'
        'motion = { kind = "poses", file = "track.csv", scale = 1e-4 }\n'
        '[[object]]\ntext = "A"\nplace = [1e-3, 0, 0.26]\n'
        'motion = { kind = "turntable", degrees = 6, axis = [0, 1, 0] }\n'
    )
    for name in ("rgb", "depth"):
        Path("recording", name).mkdir(parents=True)
    Image.fromarray(seen).save("recording/rgb/1.png")
    Image.fromarray(seen[:, :, 0].astype(np.uint16) + 1000).save("recording/depth/1.png")
    Path("recording/camera.json").write_text(
        '{"fx": 30, "fy": 30, "cx": 16, "cy": 12, "depth_scale": 1000}'
    )


def prepared_apart(folder: Path) -> None:
    """`prepared` in a process of its own: a process that forks must have no threads."""
    warm()
    child = FORK.Process(target=_silently_prepared, args=(folder,))
    child.start()
    child.join()
    if child.exitcode:
        raise SystemExit("fuzz.sh: the good files could not be made")


def _silently_prepared(folder: Path) -> None:
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    prepared(folder)


def warm() -> None:
    """Load what the commands load when they run, so that no case has to."""
    for module, _ in COMMAND_MODULES.values():
        importlib.import_module(module)
    for package in (chrmc, display, reconstruct):
        for found in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
            if not re.search(r"__main__|viewer|cluster", found.name):
                importlib.import_module(found.name)
    for name in ("OpenImageIO", "PIL.Image", "matplotlib.figure", "matplotlib.backends.backend_agg",
                 "tqdm.auto", "scipy.signal", "scipy.ndimage", "scipy.optimize", "skimage.metrics",
                 "moderngl", "trimesh"):  # fmt: skip
        importlib.import_module(name)


def run_quietly(arguments: list[str]) -> None:
    group.main(arguments, standalone_mode=False)


def cli_case(rng: random.Random) -> Case:
    """A command with one to three options at odds."""
    command = rng.choice(list(USUAL))
    arguments = [*command.split(), *USUAL[command]]
    for _ in range(rng.choice([1, 1, 1, 2, 3])):
        option = rng.choice(options_of(command))
        arguments.append(option.opts[0])
        if not option.is_flag:
            right = list(option.type.choices) if isinstance(option.type, click.Choice) else []
            arguments.append(rng.choice(right if right and rng.random() < 0.5 else WORDS))
    if rng.random() < 0.1:
        arguments[rng.randrange(len(arguments))] = rng.choice(WORDS)
    return {"kind": "cli", "arguments": arguments, "files": {}}


def file_case(rng: random.Random, folder: Path) -> Case:
    """A good file spoiled, and a command that reads it."""
    names = [p for p in sorted(folder.rglob("*")) if p.is_file() and p.name != "preview.png"]
    path = rng.choice(names)
    name = str(path.relative_to(folder))
    content = path.read_bytes()
    spoil = spoiled_json if path.suffix == ".json" and rng.random() < 0.8 else spoiled_bytes
    fitting = [a for a in ON_FILES if name.split("/")[0] in {word.split("/")[0] for word in a}]
    if not fitting:  # what a scene.toml names
        fitting = [a for a in ON_FILES if "world.toml" in a]
    spoilt = spoil(rng, content)
    files = {name: base64.b64encode(spoilt).decode()}
    return {"kind": "cli", "arguments": rng.choice(fitting), "files": files}


def spoiled_bytes(rng: random.Random, content: bytes) -> bytes:
    data = bytearray(content)
    for _ in range(rng.choice([1, 1, 2, 4, 16])):
        # Headers say sizes: they are hit more often than pixels.
        at = rng.randrange(min(len(data), rng.choice([64, 400, len(data)])) or 1)
        how = rng.randrange(6)
        if how == 0 and data:
            data[at : at + 1] = bytes([rng.randrange(256)])
        elif how == 1:
            data[at : at + 4] = rng.choice([0, 1, 2**31 - 1, 2**32 - 1, 200_000]).to_bytes(
                4, "little"
            )
        elif how == 2:
            del data[at:]
        elif how == 3:
            del data[at : at + rng.randrange(1, 50)]
        elif how == 4:
            data[at:at] = data[at : at + rng.randrange(1, 50)]
        else:
            data[at:at] = rng.choice(
                [b"\0", b"nan", b"1e999", b",", b";", b"\xff\xfe", b"-", b"\n"]
            )
    return bytes(data)


def spoiled_json(rng: random.Random, content: bytes) -> bytes:
    whole = json.loads(content)
    for _ in range(rng.choice([1, 1, 2, 3])):
        place: Any = whole
        while True:
            keys = list(place) if isinstance(place, dict) else list(range(len(place)))
            if not keys:
                break
            key = rng.choice(keys)
            if isinstance(place[key], dict | list) and place[key] and rng.random() < 0.6:
                place = place[key]
                continue
            how = rng.random()
            if how < 0.15:
                del place[key]
            else:
                place[key] = rng.choice(NASTY)
            break
    text = json.dumps(whole)
    for name in ("nan", "inf", "-inf"):
        text = text.replace(
            f'"{name}"', {"nan": "NaN", "inf": "Infinity", "-inf": "-Infinity"}[name]
        )
    return text.encode()


def array(rng: random.Random, *shape: int) -> dict[str, Any]:
    """An array as plain data: mostly good, sometimes with a value, a type or a shape at odds."""
    values: Any = np.round(np.random.default_rng(rng.randrange(2**32)).normal(0, 1e-3, shape), 9)
    values = values.tolist()
    if rng.random() < 0.4:
        place = values
        while place and isinstance(place[0], list):
            place = place[rng.randrange(len(place))]
        if place:
            place[rng.randrange(len(place))] = rng.choice(NUMBERS)
    if rng.random() < 0.08:
        return {"plain": rng.choice(NASTY)}
    return {
        "array": values,
        "type": rng.choice(["float64"] * 4 + ["float32", "int64", "object", ""]),
    }


def number(rng: random.Random, usual: float) -> Any:
    return usual if rng.random() < 0.7 else rng.choice([*NUMBERS, *NASTY[:4], "x", [1]])


def array_case(rng: random.Random) -> Case:
    """A call of the library with arrays and numbers at odds."""
    n = rng.choice([0, 1, 1, 5, 40])
    call = rng.choice(["field", "reference", "encode", "four_f", "pose", "response", "video"])
    places = array(rng, n, rng.choice([3, 3, 3, 3, 2]))
    if "array" in places and rng.random() < 0.9:
        for row in places["array"]:
            if len(row) == 3 and isinstance(row[2], float) and abs(row[2]) < 1:
                row[2] = 0.25 + row[2]
    return {
        "kind": "call",
        "call": call,
        "method": rng.choice(["curved", "rt", "fresnel", "wrp", "nlut", "nlut-1d"]),
        "encoding": rng.choice(["ssb", "real", "bipolar", "burch", "offaxis"]),
        "positions": places,
        "amplitude": array(rng, n if rng.random() < 0.9 else n + 1),
        "phase": array(rng, n),
        "picture": array(rng, 24, 40),
        "matrix": array(rng, 3, 3),
        "vector": array(rng, 3),
        "wavelength": number(rng, 532e-9),
        "pitch": number(rng, 40e-6),
        "depth": number(rng, 0.25),
        "tolerance": number(rng, 1e-3),
        "scale": number(rng, 1.0),
    }


def real(value: Any) -> Any:
    """Written numbers that JSON has no word for."""
    return float(value) if value in ("nan", "inf", "-inf") else value


def unpacked(value: dict[str, Any]) -> Any:
    if "plain" in value:
        return real(value["plain"])

    def deep(v: Any) -> Any:
        return [deep(e) for e in v] if isinstance(v, list) else real(v)

    values = deep(value["array"])
    with np.errstate(all="ignore"):
        try:
            return np.array(values, dtype=value["type"]) if value["type"] else values
        except (OverflowError, ValueError, TypeError):
            return values


def call(case: Case) -> None:
    """Do what the case asks; AssertionError where a result is not finite."""
    from chrmc.response import GreyResponse

    wavelength, pitch, depth = (real(case[k]) for k in ("wavelength", "pitch", "depth"))
    slm = chrmc.SLM("fuzz", 40, 24, pitch)
    name = case["call"]
    if name in ("field", "reference", "video"):
        cloud = chrmc.PointCloud(*(unpacked(case[k]) for k in ("positions", "amplitude", "phase")))
        if name == "field":
            made = chrmc.compute_field(cloud, slm, wavelength, method=case["method"])
        elif name == "reference":
            made = chrmc.reference_field(cloud, slm, wavelength)
        else:
            pose = chrmc.Pose(np.eye(3), np.zeros(3))
            scene = chrmc.PointScene("fuzz", {"a": cloud}, {"a": [pose, pose]})
            tolerance = real(case["tolerance"])
            frames = chrmc.video(
                scene, slm, wavelength, coding=case["encoding"], tolerance=tolerance
            )
            made = np.stack([frame.field for frame in frames])
    elif name == "encode":
        field, scale = np.asarray(unpacked(case["picture"])), real(case["scale"])
        if field.dtype.kind in "fi" and isinstance(scale, float):
            with np.errstate(all="ignore"):
                field = field * scale
        made = display.encode(field, slm, case["encoding"])
    elif name == "four_f":
        levels = np.zeros(slm.shape, np.uint8)
        made = reconstruct.four_f(levels, slm, wavelength, depth, case["encoding"])
    elif name == "pose":
        pose = chrmc.Pose(unpacked(case["matrix"]), unpacked(case["vector"]))
        made = pose.apply(np.ones((2, 3)))
    else:
        amplitude = unpacked(case["phase"])
        made = GreyResponse.from_table(np.linspace(0, 255, np.size(amplitude)), amplitude).levels
    assert np.isfinite(made).all(), "a result is not finite"


def tried(case: Case, folder: Path) -> str:
    """Run the case in a process of its own; what was wrong, or nothing."""
    said = folder / ".said"
    child = FORK.Process(target=_inside, args=(case, folder, said))
    child.start()
    child.join(WALL)
    code = child.exitcode
    if code is None:
        child.kill()
        child.join()
        return f"not done after {WALL} s"
    text = said.read_text(errors="replace") if said.exists() else ""
    if code < 0:
        return f"ended by signal {-code}"
    tail = (text.strip().splitlines() or [""])[-1][-300:]
    if "Traceback" in text or "Warning" in text:
        return f"a traceback or warning: {tail}"
    if code not in (0, 1, 2):
        return f"status {code}: {tail}"
    lines = [line for line in text.splitlines() if not line.startswith("warning")]
    if code == 2 and case["kind"] == "cli" and len(lines) != 1:
        return f"status 2 with {len(lines)} lines: {tail}"
    return ""


def _inside(case: Case, folder: Path, said: Path) -> None:
    """The case under its limits; ends with its status, 99 where it raised what it must not."""
    out = os.open(os.devnull, os.O_RDWR)
    told = os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for number_, where in ((0, out), (1, out), (2, told)):
        os.dup2(where, number_)
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    limit = used + (MEGABYTES << 20)
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
    warnings.simplefilter("always")
    os.chdir(folder)
    try:
        status = _status(case)
    except BaseException:
        traceback.print_exc()
        status = 99
    sys.exit(status)


def _status(case: Case) -> int:
    if case["kind"] == "call":
        try:
            call(case)
        except (ValueError, OSError):
            return 2
        return 0
    from chrmc.cli.main import main

    for name, content in case["files"].items():
        Path(name).write_bytes(base64.b64decode(content))
    try:
        main([str(a) for a in case["arguments"]])
    except SystemExit as ended:
        return int(ended.code or 0)
    return 98


def in_copy(case: Case, good: Path) -> str:
    """`tried` in a copy of the good files."""
    import shutil

    with tempfile.TemporaryDirectory(prefix="fuzz") as place:
        work = Path(place) / "work"
        if case["kind"] == "cli":
            shutil.copytree(good, work)
        else:
            work.mkdir()
        return tried(case, work)


def keep(case: Case, why: str) -> Path:
    text = json.dumps(case | {"was": why})
    path = KEPT / f"{case['kind']}_{hashlib.sha256(text.encode()).hexdigest()[:10]}.json"
    KEPT.mkdir(exist_ok=True)
    path.write_text(text + "\n")
    return path


def replay() -> int:
    """Try all kept cases again; 1 when one fails."""
    cases = {path.name: json.loads(path.read_text()) for path in sorted(KEPT.glob("*.json"))}
    bad = 0
    with tempfile.TemporaryDirectory(prefix="fuzz") as place:
        if any(case["kind"] == "cli" for case in cases.values()):
            prepared_apart(Path(place))
        for name, case in cases.items():
            why = in_copy(case, Path(place))
            if why:
                bad += 1
                print(f"{name}: {why}")
    print(f"{len(cases)} kept cases, {bad} fail")
    return int(bad > 0)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=5)
    parser.add_argument("--cases", type=int, default=10**9)
    parser.add_argument("--seed", type=int, default=time.time_ns() % 2**32)
    parser.add_argument("--kinds", default="cli,files,arrays")
    parser.add_argument("--no-keep", action="store_true", help="only say what failed")
    parser.add_argument("--replay", action="store_true", help="try the kept cases again")
    asked = parser.parse_args()
    if asked.replay:
        return replay()
    kinds = asked.kinds.split(",")
    rng = random.Random(asked.seed)
    counts: Counter[str] = Counter()
    found: Counter[str] = Counter()
    print(f"seed {asked.seed}")
    with tempfile.TemporaryDirectory(prefix="fuzz") as place:
        good = Path(place)
        prepared_apart(good)
        end = time.monotonic() + 60 * asked.minutes
        while time.monotonic() < end and sum(counts.values()) < asked.cases:
            kind = rng.choice(kinds)
            case = {
                "cli": lambda: cli_case(rng),
                "files": lambda: file_case(rng, good),
                "arrays": lambda: array_case(rng),
            }[kind]()
            counts[kind] += 1
            why = in_copy(case, good)
            if why:
                # One case of a fault is enough.
                found[why[:60]] += 1
                if found[why[:60]] == 1:
                    where = "" if asked.no_keep else f" → {keep(case, why)}"
                    words = case.get("arguments") or [case["call"], case["method"]]
                    print(
                        f"{' '.join(words)[:150]} {list(case.get('files', []))}: {why}{where}",
                        flush=True,
                    )
    for kind, count in counts.items():
        print(f"{kind}: {count} cases")
    print(f"{sum(found.values())} failed, {len(found)} in different ways")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
