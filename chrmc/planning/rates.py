"""How fast this machine is at each kind of operation, measured once and kept.

A kernel of each kind, as the CGH methods do it, is timed on one core by the processor's clock, so
that other programs matter little; and on all cores at once, which slows each down where they share
memory. Time is then Σ counts/rates, work that is shared divided by the cores.
"""

import hashlib
import json
import os
import platform
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_info

from chrmc.cgh.counts import KINDS, Rates, product
from chrmc.files import read_json, replacing
from chrmc.threads import ONE_BLAS_THREAD, workers

SECONDS, BRIEF = 8.0, 0.8
"""Time that `calibrate` takes, about, and that the first plan on a machine takes for it."""
FORMAT = 2

Kernel = tuple[Callable[[], object], float]
"""Some work, and how many operations it is."""


def fingerprint() -> str:
    """Hash of what rates depend on: the machine, its BLAS, the threads in use."""
    blas = sorted(
        (str(entry.get("internal_api")), str(entry.get("version")), str(entry.get("architecture")))
        for entry in threadpool_info()
        if entry.get("user_api") == "blas"
    )
    said = [FORMAT, platform.node(), platform.machine(), _processor(), os.cpu_count(), workers()]
    text = json.dumps([*said, np.__version__, blas])
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line for line in lines if line.startswith("model name")), "")


def rates_file() -> Path:
    """Where this machine's rates are kept."""
    from platformdirs import user_cache_path

    return user_cache_path("chrmc") / f"rates-{fingerprint()}.json"


@lru_cache(maxsize=1)
def machine_rates() -> Rates:
    """This machine's rates: those kept, else measured briefly and kept."""
    return kept_rates() or calibrate(BRIEF)


def kept_rates() -> Rates | None:
    """The rates on disk, if they are there and whole."""
    try:
        rates = Rates(**read_json(rates_file(), "record of rates"))
        values = [*rates.alone.values(), *rates.together.values(), rates.threads]
        whole = set(rates.alone) == set(rates.together) == set(KINDS)
        return rates if whole and all(0 < v < 1e18 for v in values) else None
    except (OSError, ValueError, TypeError, AttributeError):
        return None


def calibrate(seconds: float = SECONDS) -> Rates:
    """Measure this machine's rates within so many seconds of work, and keep them where the disk
    takes them: else they are measured again next time."""
    rates = measured(seconds)
    with suppress(OSError):
        keep(rates)
    return rates


def keep(rates: Rates) -> None:
    """Write them where the next plan finds them; OSError where that cannot be."""
    with replacing(rates_file()) as part:
        part.write_text(json.dumps(asdict(rates), indent=1), encoding="utf-8")


def measured(seconds: float = SECONDS) -> Rates:
    """This machine's rates, measured within so many seconds of work."""
    threads = workers()
    share = seconds / (2 * len(KERNELS))
    alone, together = {}, {}
    with ONE_BLAS_THREAD, ThreadPoolExecutor(threads) as pool:
        for kind, make in KERNELS.items():
            jobs = [make() for _ in range(threads)]
            alone[kind] = _rate(jobs[0], share)
            if threads == 1 or kind == "calls":
                together[kind] = alone[kind]
                continue
            found = list(pool.map(_rate, jobs, [share] * threads))
            together[kind] = min(alone[kind], float(np.median(found)))
    return Rates(alone, together, threads, seconds < SECONDS)


def _rate(kernel: Kernel, seconds: float) -> float:
    """Operations per second of this thread's processor time, the best of several."""
    work, count = kernel
    work()
    best, spent, began = np.inf, 0.0, time.perf_counter()
    # Another program may hold the core: the clock on the wall ends it too.
    while spent < seconds and time.perf_counter() - began < 4 * seconds:
        start = time.thread_time()
        work()
        took = time.thread_time() - start
        best, spent = min(best, took), spent + took
    return count / max(best, 1e-9)


def _products() -> Kernel:
    # Half of it in the shape of sums over points, half in that of pixels from nodes.
    random = np.random.default_rng(0)
    shapes = ((100, 600, 220), (96, 40, 1920))
    pairs = [
        (random.random((m, k), dtype=np.float32), random.random((k, n), dtype=np.float32))
        for m, k, n in shapes
    ]
    outs = [np.empty((m, n), np.float32) for m, _, n in shapes]

    def work() -> None:
        for _ in range(4):
            for (left, right), out in zip(pairs, outs, strict=True):
                np.matmul(left, right, out=out)

    return work, 4.0 * sum(product(*shape) for shape in shapes)


def _phasors() -> Kernel:
    offsets = np.linspace(-8e-3, 8e-3, 256) - np.linspace(0, 1e-3, 40)[:, None]
    cos, sin, both = (np.empty(offsets.shape, np.float32) for _ in range(3))

    def work() -> None:
        cycles = offsets * offsets
        cycles /= (np.sqrt(cycles + 0.0625) + 0.25) * 532e-9
        turn = (cycles - np.rint(cycles)).astype(np.float32)
        turn *= np.float32(2 * np.pi)
        np.cos(turn, out=cos)
        np.sin(turn, out=sin)
        np.add(cos, sin, out=both)

    return work, float(offsets.size)


def _lookups() -> Kernel:
    shape = (32, 1920)
    pattern = np.full((40, 2000), 1 + 1j, np.complex64)
    across, down = np.ones(1920, np.complex64), np.ones((32, 1), np.complex64)
    scratch, out = np.empty(shape, np.complex64), np.zeros(shape, np.complex64)

    def work() -> None:
        np.multiply(pattern[32:0:-1, 1920:0:-1], across, out=scratch)
        np.multiply(scratch, down, out=scratch)
        np.add(out, scratch, out=out)

    return work, float(np.prod(shape))


def _transforms() -> Kernel:
    import scipy.fft  # takes a while

    samples = np.ones((1024, 1024), np.complex64)
    return lambda: scipy.fft.fft2(samples, workers=1), samples.size * 20.0


def _bytes() -> Kernel:
    a, b = np.ones(1 << 22, np.float32), np.ones(1 << 22, np.float32)
    return lambda: np.add(a, b, out=a), 12.0 * a.size


def _calls() -> Kernel:
    small = np.ones(32)

    def work() -> None:
        for _ in range(100):
            np.multiply(small, 2.0)[1:].sum()

    return work, 300.0


KERNELS: Mapping[str, Callable[[], Kernel]] = {
    "products": _products,
    "phasors": _phasors,
    "lookups": _lookups,
    "transforms": _transforms,
    "bytes": _bytes,
    "calls": _calls,
}
