"""A pytest plugin: which test runs which lines, and its processor time (see mutation.py).

Loaded by `-p mutation_map`; the files to look at come in MUTATION_FILES, the map goes to
MUTATION_MAP.
"""

import functools
import gc
import json
import os
import time
from collections.abc import Iterator
from pathlib import Path

import coverage
import pytest

FILES = os.environ["MUTATION_FILES"].split(os.pathsep)
recorder = coverage.Coverage(data_file=None, include=FILES, config_file=False, messages=False)
seconds: dict[str, float] = {}
recorder.start()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """One test. What an earlier one left in caches would hide lines from it."""
    for obj in gc.get_objects():
        if isinstance(obj, functools._lru_cache_wrapper):
            obj.cache_clear()
    recorder.switch_context(item.nodeid)
    start = time.process_time()
    try:
        return (yield)
    finally:
        seconds[item.nodeid] = time.process_time() - start
        recorder.switch_context("")


def pytest_sessionfinish() -> None:
    recorder.stop()
    data = recorder.get_data()
    lines: dict[str, dict[int, list[str]]] = {}
    for path in FILES:
        by_line = data.contexts_by_lineno(path)
        lines[path] = {line: sorted(set(tests) - {""}) for line, tests in by_line.items()}
    written = json.dumps({"seconds": seconds, "lines": lines})
    Path(os.environ["MUTATION_MAP"]).write_text(written)
