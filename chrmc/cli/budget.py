"""Time per frame on the command line: 16.7ms, 0.05s, 30fps."""

import re
from math import isfinite
from typing import Any

import click

_SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6}


class Budget(click.ParamType):
    """Seconds per frame from a time or a rate."""

    name = "16.7ms|30fps"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        if isinstance(value, float):
            return value
        match = re.fullmatch(
            r"([\d.]+(?:e[+-]?\d+)?)\s*(s|ms|us|fps|hz)", str(value).strip().lower()
        )
        try:
            number = float(match[1]) if match else 0.0
        except ValueError:
            number = 0.0
        if not match or not number > 0:
            self.fail(f"{value!r} is no time per frame; write 16.7ms or 30fps", param, ctx)
        seconds = 1 / number if match[2] in ("fps", "hz") else number * _SECONDS[match[2]]
        if not (isfinite(seconds) and 1e-6 <= seconds <= 1e6):
            self.fail(f"{value!r} a frame is no budget: 1 µs to 1e6 s are taken", param, ctx)
        return seconds
