"""Verdicts as text, JSON and a plot of focus curves."""

from collections.abc import Iterator, Sequence
from math import hypot, isfinite
from pathlib import Path
from typing import Any

from chrmc.figures import MARKERS, new_figure, save
from reconstruct.verdict import FrameVerdict, ObjectVerdict

Verdicts = Sequence[FrameVerdict]


def _mm(value: float, digits: int = 3) -> str:
    return f"{value * 1e3:.{digits}f}" if isfinite(value) else "none"


def _figure(value: float | None, form: str) -> str:
    return "" if value is None else format(value, form) if isfinite(value) else str(value)


def table(verdicts: Verdicts) -> Iterator[str]:
    """Lines of a table: an object of a frame in each, then the verdict; a table per colour."""
    lasers = list(dict.fromkeys(v.wavelength for v in verdicts))
    if len(lasers) > 1:
        for wavelength in lasers:
            yield f"{(wavelength or 0) * 1e9:g} nm"
            yield from table([v for v in verdicts if v.wavelength == wavelength])
        return
    shown = [o for v in verdicts for o in v.objects]
    shapes = any(o.shape is not None for o in shown)
    truth = any(o.psnr is not None for o in shown)
    head = (
        f"{'frame':>5}  {'object':<10} {'expected':>9} {'found':>9} {'error':>8} "
        f"{'lateral':>8} {'front':>9} {'rear':>9} {'contrast':>8} {'SNR':>6} {'speckle':>7}"
    )
    shape_head = f" {'alike':>6} {'relief':>6}" if shapes else ""
    yield head + (f" {'PSNR':>6} {'SSIM':>6}" if truth else "") + shape_head
    unit = f"{'':>5}  {'':<10} {'mm':>9} {'mm':>9} {'µm':>8} {'µm':>8} {'mm':>9} {'mm':>9} {'':>8} "
    yield unit + f"{'dB':>6} {'':>7}" + (f" {'dB':>6} {'':>6}" if truth else "")
    for verdict in verdicts:
        if not verdict.objects:
            yield f"{verdict.number:>5}  (empty)"
        for o in verdict.objects:
            lateral = hypot(*o.lateral_error) * 1e6
            error = o.depth_error * 1e6
            line = (
                f"{verdict.number:>5}  {o.name:<10.10} {_mm(float(o.target.position[2])):>9} "
                f"{_mm(o.focus.depth):>9} {_figure(error, '+.0f'):>8} {_figure(lateral, '.1f'):>8} "
                f"{_mm(o.focus.front):>9} {_mm(o.focus.rear):>9} {o.contrast:>8.3f} "
                f"{_figure(o.snr, '.1f'):>6} {o.speckle_contrast:>7.2f}"
            )
            if truth:
                line += f" {_figure(o.psnr, '.1f'):>6} {_figure(o.ssim, '.4f'):>6}"
            if shapes:
                line += " " + _shape(o)
            if not o.judged:
                line += f"  cannot be judged: {o.shares.too_little}"
            elif o.shape is not None and o.shape.doubt:
                line += f"  {o.shape.doubt}"
            yield line + ("" if o.passed else f"  FAILS: {', '.join(o.faults)}")
        for fault in verdict.faults:
            yield f"{verdict.number:>5}  FAILS: {fault}"
    bad = sum(not o.passed for o in shown)
    noisy = sum(bool(v.faults) for v in verdicts)
    if noisy:
        yield f"{noisy} of {len(verdicts)} frames are noise for the most part, or cannot be judged"
    if bad:
        yield f"{bad} of {len(shown)} objects are not in focus where the scene says, or not alike"
    elif not noisy:
        judged = [o for o in shown if o.judged]
        alike = " and look like it" if all(o.shape and o.shape.told for o in judged) else ""
        those = f"all {len(judged)} objects"
        if len(judged) < len(shown):
            those += f" that can be judged, of {len(shown)},"
        doubted = sum(bool(o.shape and o.shape.doubt) for o in judged)
        but = f"; the relief of {doubted} cannot be judged" if doubted else ""
        yield f"{those} are in focus where the scene says{alike}{but}"


def _called(verdict: FrameVerdict) -> str:
    laser = "" if verdict.wavelength is None else f" at {verdict.wavelength * 1e9:g} nm"
    return f"frame {verdict.number}{laser}"


def _shape(judged: ObjectVerdict) -> str:
    """Likeness and relief, blank where they cannot be judged."""
    shape = judged.shape
    if shape is None or not shape.told:
        return f"{'':>6} {'':>6}"
    return f"{shape.picture:>6.2f} {format(shape.relief, '.1f') if shape.relief_known else '':>6}"


def metric_table(verdicts: Verdicts) -> Iterator[str]:
    """Where published metrics of each object's region peak, against the expected depth."""
    names = list(dict.fromkeys(n for v in verdicts for o in v.objects for n in o.metric_depths))
    yield f"{'frame':>5}  {'object':<10} " + " ".join(f"{n:>10}" for n in names) + "   (µm off)"
    for verdict in verdicts:
        for o in verdict.objects:
            off = [(o.metric_depths[n] - float(o.target.position[2])) * 1e6 for n in names]
            yield f"{verdict.number:>5}  {o.name:<10.10} " + " ".join(f"{v:>+10.0f}" for v in off)


def as_dict(verdicts: Verdicts) -> dict[str, Any]:
    """Everything for JSON."""
    return {
        "passed": all(v.passed for v in verdicts),
        "frames": [
            {
                "number": v.number,
                "passed": v.passed,
                "light": v.light,
                **({} if v.wavelength is None else {"wavelength": v.wavelength}),
                "objects": [o.as_dict() for o in v.objects],
            }
            for v in verdicts
        ],
    }


def plot_curves(verdicts: Verdicts, path: str | Path) -> None:
    """PNG, PDF or SVG: a panel per object, a focus curve per frame against the distance from the
    expected depth, the found depths marked."""
    from matplotlib import colormaps

    names = list(dict.fromkeys(o.name for v in verdicts for o in v.objects)) or ["no objects"]
    figure, axes = new_figure((6.6 * len(names), 3.8), columns=len(names), squeeze=False)
    colours, count = colormaps["cividis"], max(len(verdicts) - 1, 1)
    for axis, name in zip(axes[0], names, strict=True):
        allowed = [o.depth_tolerance for v in verdicts for o in v.objects if o.name == name]
        for index, verdict in enumerate(verdicts):
            for o in (o for o in verdict.objects if o.name == name):
                expected = float(o.target.position[2])
                style = {
                    "color": colours(0.85 * index / count),
                    "marker": MARKERS[index % len(MARKERS)],
                }
                top = float(o.focus.curve.max()) or 1.0
                axis.plot(
                    (o.focus.depths - expected) * 1e3,
                    o.focus.curve / top,
                    **style,
                    markevery=(index % 5, 5),
                    ms=4,
                    label=f"{_called(verdict)}: {_mm(o.focus.depth, 2)} mm",
                )
                if isfinite(o.depth_error):
                    axis.plot(o.depth_error * 1e3, 1.04, **style, ms=7, clip_on=False)
        if allowed:
            axis.axvspan(-max(allowed) * 1e3, max(allowed) * 1e3, color="0.92", zorder=0)
        axis.axvline(0, color="0.6", lw=0.8, zorder=1)
        axis.set(title=name, xlabel="depth − expected depth (mm)", ylabel="sharpness, largest = 1")
        # Beside the curves: over them it would hide some.
        axis.legend(
            frameon=False, fontsize=8, title="found", title_fontsize=8, loc="upper left",
            bbox_to_anchor=(1.0, 1.0),
        )  # fmt: skip
        axis.spines[["top", "right"]].set_visible(False)
    save(figure, path)
