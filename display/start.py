"""When the first frame comes: at once, at a key, at a time of day, after a countdown."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date, datetime
from math import ceil, isfinite


@dataclass(frozen=True)
class Start:
    """The panel stays dark until then.

    on : "key", a time of day as `parse_time` takes it, or None
    countdown : seconds told one by one, after the key or up to the time of day
    """

    on: str | float | datetime | None = None
    countdown: float = 0.0

    def __post_init__(self) -> None:
        if not (isfinite(self.countdown) and 0 <= self.countdown <= 3600):
            raise ValueError(f"a countdown lasts 0 to 3600 seconds, not {self.countdown:g}")
        if self.on not in (None, "key"):
            parse_time(self.on)

    def wait(
        self,
        keys: Callable[[], list[str]],
        closed: Callable[[], bool],
        poll: Callable[[], None],
        tell: Callable[[str], None],
    ) -> bool:
        """Wait; False when Esc or a closed window calls it off."""
        moment = None
        if self.on == "key":
            tell("a key starts it; Esc ends")
            pressed: list[str] = []
            while not pressed:
                poll()
                pressed = keys()
                if closed() or "escape" in pressed:
                    return False
                time.sleep(0.002)
        elif self.on is not None:
            moment = parse_time(self.on)
            tell(f"starts at {datetime.fromtimestamp(moment).isoformat(' ')}; Esc ends")
        end = time.time() + self.countdown if moment is None else moment
        told = ceil(self.countdown) + 1
        while (left := end - time.time()) > 0:
            if ceil(left) < told and self.countdown:
                told = ceil(left)
                tell(f"{told}")
            poll()
            if closed() or "escape" in keys():
                return False
            time.sleep(min(0.005, left))
        return True


def parse_time(value: str | float | datetime | None, now: float | None = None) -> float:
    """Seconds since 1970 of a time to come.

    value : "20:15", "20:15:30.5" (today, local), "2026-11-21T20:15:30" (local, or with its own
        offset), a datetime, or seconds since 1970

    ValueError for anything else, and for what is past.
    """
    now = time.time() if now is None else now
    try:
        if isinstance(value, str):
            text = value.strip()
            day = f"{date.fromtimestamp(now).isoformat()}T" if text[2:3] == ":" else ""
            value = datetime.fromisoformat(day + text)
        moment = value.timestamp() if isinstance(value, datetime) else float(value)  # type: ignore[arg-type]
    except (ValueError, TypeError, OverflowError, OSError):
        raise ValueError(
            f"start on {value!r}: write key, a time such as 20:15:30, or a date and time such as "
            "2026-11-21T20:15:30"
        ) from None
    if not now - 1e-3 <= moment < now + 400 * 86400:
        raise ValueError(f"start on {value}: that is past or more than a year away")
    return moment
