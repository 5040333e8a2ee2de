"""How long work on many points takes, reckoned from runs on fewer of them."""

from collections.abc import Callable, Sequence

_FEW = 16  # points that are simply computed
_FAR = 16  # times as many points as were run: as far as a straight line is trusted


def reckon(
    seconds_of: Callable[[int], float],
    count: int,
    limit: float,
    known: Sequence[tuple[int, float]] = (),
) -> float:
    """Seconds that `count` points take, on a straight line through the last two runs.

    seconds_of : runs so many of the points, fewer than `count`, and gives the seconds it took
    limit : what the result will be compared with, seconds
    known : (points, seconds) of runs there have been, of fewer points

    Few points tell little: tables, planes and transforms cost the same for 10 points as for
    10,000. So larger parts are run until one takes a good share of the limit, or is near enough
    to the whole. All parts together take about the limit at most; up to 16 points nothing is
    run, and the result is 0 unless something is known.
    """
    runs = sorted((n, s) for n, s in known if n < count)[-2:]
    if count <= _FEW:
        return runs[-1][1] if runs else 0.0
    if len(runs) < 2:
        runs = [(n, seconds_of(n)) for n in (_FEW // 4, _FEW - 1)]
    while True:
        (few, before), (more, last) = runs[-2:]
        each = max(last - before, 0.0) / (more - few)
        total = last + each * (count - more)
        near = count <= _FAR * more or last * count <= limit * more
        long = last > limit / 4 and total > 3 * limit
        if long or last > limit / 2 or (near and total <= limit):
            return total
        wanted = more + (limit / 3 - last) / each if each > 0 else 8.0 * more
        following = int(min(max(wanted, 2 * more), 8 * more))
        if following >= count:
            return total
        runs.append((following, seconds_of(following)))
