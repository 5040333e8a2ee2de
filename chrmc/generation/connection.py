"""A client of a Dask cluster: of one that runs, or of one on this machine that ends with it."""

import logging
import socket
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

from chrmc.interrupts import interrupts_wait
from chrmc.ranges import Count
from chrmc.threads import THREADS
from chrmc.threads import workers as cores

WORKERS = Count("workers", 1, 1024)
_CONNECT = 10  # seconds
_START = 120  # seconds, for processes of this machine: it may be busy
_PATIENCE = {f"distributed.comm.timeouts.{name}": f"{_START}s" for name in ("connect", "tcp")}
_TRIMMING = "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_"
"""Dask sets this, and then every large array costs its worker new pages: see docs/scale.md."""


@contextmanager
def connected(workers: int | None, scheduler: str | None) -> Iterator[Any]:
    """A client of the running cluster, or of one on this machine that ends with it."""
    try:
        import dask
        from distributed import Client, LocalCluster
    except ImportError:
        raise OSError("--workers and --scheduler need: pip install 'chrmc[cluster]'") from None
    names = [n for n in logging.root.manager.loggerDict if n.split(".")[0] == "distributed"]
    levels = {name: logging.getLogger(name).level for name in names}
    for name in names:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)  # what matters is told in one line
    try:
        with dask.config.set({_TRIMMING: None} | (_PATIENCE if scheduler is None else {})):
            yield from _clients(Client, LocalCluster, workers, scheduler)
    finally:
        for name, level in levels.items():
            logging.getLogger(name).setLevel(level)


@contextmanager
def local_cluster(workers: int) -> Iterator[str]:
    """Address of a cluster of so many processes on this machine, which ends with the block."""
    with connected(workers, None) as client:
        yield client.scheduler.address


def _clients(
    Client: Any, LocalCluster: Any, workers: int | None, scheduler: str | None
) -> Iterator[Any]:
    if workers is not None and scheduler is not None:
        raise ValueError("--workers starts a cluster, --scheduler uses a running one: give one")
    if scheduler is not None:
        _answers(scheduler)
        client = Client(scheduler, timeout=_CONNECT, set_as_default=False)
        try:
            if not client.scheduler_info()["workers"]:
                raise OSError(f"{scheduler} has no workers: start some with `dask worker`")
            for worker, found in client.run(version, on_error="return").items():
                if found != version():
                    told = found if isinstance(found, str) else "another version"
                    raise OSError(f"{worker} has chrmc {told}, not {version()}: install the same")
            yield client
        finally:
            client.close(timeout=_CONNECT)
        return
    count = WORKERS.of(workers)
    # Each worker uses its share of the cores.
    share = {THREADS: str(max(1, cores() // count))}
    with ExitStack() as started:
        try:
            # Of a cluster that has not quite started dask cannot be rid without a traceback.
            with interrupts_wait():
                cluster = started.enter_context(
                    LocalCluster(
                        n_workers=count,
                        threads_per_worker=1,
                        processes=True,
                        dashboard_address="127.0.0.1:0",
                        silence_logs=logging.CRITICAL,
                        env=share,
                        memory_limit=0,
                    )
                )
            client = started.enter_context(Client(cluster, timeout=_START, set_as_default=False))
        except TimeoutError:
            raise OSError(
                f"{count} processes did not start in {_START} s: the machine is too busy; the same "
                "command goes on"
            ) from None
        yield client


def _answers(scheduler: str) -> None:
    """OSError where nothing listens: dask itself goes on trying."""
    from distributed.comm import get_address_host_port

    try:
        socket.create_connection(get_address_host_port(scheduler), _CONNECT).close()
    except (OSError, ValueError, OverflowError) as error:
        why = " ".join(str(getattr(error, "strerror", None) or error).split())
        raise OSError(
            f"no scheduler answers at {scheduler} ({why}): give tcp://HOST:PORT"
        ) from None


def version() -> str:
    """Of chrmc, as client and workers compare it."""
    from chrmc import __version__

    return __version__
