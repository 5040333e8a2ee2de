"""Tables 1 and 2 of the CH-RMC paper, made again here, with the paper's figures beside.

ANCOP is the average number of calculated object points of a frame, ACT the average calculation
time. The paper seems to count error-correction points only, so both countings are given, and
point·pixels, which hold the blank region's work too.
"""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from chrmc.bench.paper import GROWTH, POINTS, SECONDS, STAGES, TIMES
from chrmc.bench.systems import Measured, System, count_points
from chrmc.cgh import METHODS
from chrmc.compensation import COMPENSATIONS, ch_rmc_for
from chrmc.encoding import Coding
from chrmc.scene.scene import Scene, frame_range
from chrmc.slm import SLM

RULES = ("strict", "tolerant")
# Table 2's printed ACT growth over the NLUT's, per cent.
TIME_GROWTH = {"MC-NLUT": 29.35, "MPEG-NLUT": 67.43, "3DMC-NLUT": 75.02}


@dataclass(frozen=True)
class Pair:
    """A compensated system beside its original.

    paper : the paper's name of it, or None
    """

    original: System
    compensated: System
    paper: str | None = None


def table1_pairs() -> list[Pair]:
    """Every CGH method here, plain and with CH-RMC: on the paper's surface, or the exact one."""
    pairs = []
    for cgh in METHODS:
        compensation = ch_rmc_for(cgh)
        pairs.append(
            Pair(
                System(cgh, cgh),
                System(f"{cgh} + {compensation}", cgh, compensation),
                cgh.upper() if cgh.upper() in TIMES else None,
            )
        )
    return pairs


def table2_pairs(cgh: str = "nlut") -> list[Pair]:
    """Every video method here over one CGH method."""
    original = System(cgh, cgh)
    pairs = []
    for name in COMPENSATIONS:
        if name == "none" or (name.startswith("ch-rmc") and name != ch_rmc_for(cgh)):
            continue
        ours = name == ch_rmc_for(cgh)
        label = f"{cgh} + {name}" if ours else name
        pairs.append(Pair(original, System(label, cgh, name), "NLUT" if ours else name.upper()))
    return pairs


def systems_of(pairs: Sequence[Pair]) -> list[System]:
    """Each system of the pairs once, originals first."""
    return list(dict.fromkeys([*(p.original for p in pairs), *(p.compensated for p in pairs)]))


def tolerant_points(
    systems: Sequence[System],
    scene: Scene,
    slm: SLM,
    wavelength: float,
    coding: Coding,
    frames: tuple[int, int] | None,
) -> dict[System, float]:
    """Mean points per frame under the tolerant matching rule, for the methods that have rules."""
    found = {}
    numbers = frame_range(scene, frames)
    for system in systems:
        if system.compensation in ("none", "ch-rmc-object"):
            continue
        loose = replace(system, options=(*system.options, ("matching", "tolerant")))
        try:
            records = count_points(loose, scene, slm, wavelength, numbers, coding)
        except ValueError:
            continue  # its row in the table says why
        found[system] = float(np.mean([record.points_computed for record in records]))
    return found


def rows(
    form: str, pairs: Sequence[Pair], measured: Sequence[Measured], tolerant: dict[System, float]
) -> list[dict[str, Any]]:
    """One dict per system, for CSV and text: SI units, percentages against the original."""
    by_system = {m.system: m for m in measured}
    out: list[dict[str, Any]] = []
    done: set[System] = set()
    for pair in pairs:
        original = by_system[pair.original]
        for system in (pair.original, pair.compensated):
            if system in done:
                continue
            done.add(system)
            paper = _printed(pair, system)
            out.append(_row(form, by_system[system], original, tolerant.get(system), paper))
    return out


def _printed(pair: Pair, system: System) -> tuple[float | None, float | None]:
    """The paper's points and seconds of a system."""
    original = system.cgh.upper()
    if original not in TIMES:
        return None, None
    points, seconds = POINTS[original], TIMES[original]
    if system == pair.original:
        return points[0], seconds[0]
    if pair.paper in TIMES:
        return points[1], seconds[1]
    if pair.paper in GROWTH:
        growth = GROWTH[pair.paper], TIME_GROWTH[pair.paper]
        return points[0] * (1 + growth[0] / 100), seconds[0] * (1 + growth[1] / 100)
    return None, None


def _row(
    form: str,
    measured: Measured,
    original: Measured,
    tolerant: float | None,
    paper: tuple[float | None, float | None],
) -> dict[str, Any]:
    system = measured.system
    points, seconds = measured.mean("points_computed"), measured.mean("seconds")
    row: dict[str, Any] = {
        "form": form,
        "system": system.label,
        "cgh": system.cgh,
        "compensation": system.compensation,
        "frames": len(measured.records),
        "points": points,
        "points_corrected": measured.corrections,
        "points_moving": measured.mean("points_moving"),
        "points_tolerant": float("nan") if tolerant is None else tolerant,
        "points_change_%": _change(points, original.mean("points_computed")),
        "point_pixels": measured.mean("point_pixels"),
        "point_pixels_change_%": _change(
            measured.mean("point_pixels"), original.mean("point_pixels")
        ),
        "seconds": seconds,
        "seconds_median": measured.median_seconds,
        "seconds_change_%": _change(seconds, original.mean("seconds")),
        **{f"{stage}_s": measured.stage(stage) for stage in STAGES},
        "error_shown": measured.rms("error_shown"),
        "error_scene": measured.rms("error_scene"),
        "psnr_shown_dB": measured.worst("psnr_shown"),
        "psnr_scene_dB": measured.worst("psnr_scene"),
        "snr_images_dB": measured.worst("snr_images"),
        "paper_points": paper[0],
        "paper_seconds": paper[1],
        "cache": "" if measured.cache is None else str(measured.cache),
        "refused": measured.refused,
    }
    return row


def _change(value: float, original: float) -> float:
    return 100 * (value / original - 1) if original else float("nan")


def to_csv(table: Sequence[dict[str, Any]]) -> str:
    """The rows as CSV text."""
    out = io.StringIO()
    writer = csv.DictWriter(out, fieldnames=list(table[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(table)
    return out.getvalue()


_COLUMNS = (
    ("system", "system", "{:<24}"),
    ("points", "points", "{:>7.0f}"),
    ("points_corrected", "corrected", "{:>9.0f}"),
    ("points_moving", "moving", "{:>7.0f}"),
    ("points_tolerant", "tolerant", "{:>8.0f}"),
    ("points_change_%", "points %", "{:>+8.1f}"),
    ("point_pixels", "pt·px/1e9", "{:>9.2f}"),
    ("point_pixels_change_%", "pt·px %", "{:>+7.1f}"),
    ("seconds", "ACT s", "{:>8.3f}"),
    ("seconds_median", "median", "{:>8.3f}"),
    ("seconds_change_%", "ACT %", "{:>+7.1f}"),
    ("error_shown", "err shown", "{:>9.1e}"),
    ("error_scene", "err scene", "{:>9.1e}"),
    ("psnr_shown_dB", "PSNR shown", "{:>10.1f}"),
    ("psnr_scene_dB", "scene", "{:>7.1f}"),
    ("snr_images_dB", "Eq. 14", "{:>7.1f}"),
    ("paper_points", "paper pts", "{:>9.0f}"),
    ("paper_seconds", "paper s", "{:>8.2f}"),
)


def to_text(table: Sequence[dict[str, Any]]) -> str:
    """The rows as a table for reading; a dash for what a system does not have."""
    widths = [len(form.format(_example(form))) for _, _, form in _COLUMNS]
    heads = [title.rjust(w) for (_, title, _), w in zip(_COLUMNS, widths, strict=True)]
    heads[0] = _COLUMNS[0][1].ljust(widths[0])
    lines = ["  ".join(heads)]
    for row in table:
        cells = []
        for (key, _, form), width in zip(_COLUMNS, widths, strict=True):
            value = row[key]
            if key == "point_pixels":
                value = value / 1e9
            missing = value is None or (isinstance(value, float) and np.isnan(value))
            cells.append("–".rjust(width) if missing else form.format(value))
        lines.append("  ".join(cells))
        if row["refused"]:
            lines.append(f"    refused: {row['refused']}")
    lines += [f"{row['system']} keeps {row['cache']}" for row in table if row["cache"]]
    return "\n".join(lines)


def _example(form: str) -> Any:
    return "" if "<" in form else 0


def stages_text(table: Sequence[dict[str, Any]]) -> str:
    """Seconds per stage of the compensated systems, the paper's below its own."""
    lines = ["system".ljust(24) + "".join(f"{stage + ' ms':>11}" for stage in STAGES)]
    for row in table:
        if row["compensation"] == "none" or row["refused"]:
            continue
        lines.append(
            row["system"].ljust(24) + "".join(f"{1e3 * row[f'{s}_s']:>11.2f}" for s in STAGES)
        )
        name = row["cgh"].upper()
        if row["compensation"] == "ch-rmc-paper" and name in SECONDS:
            lines.append(
                f"  paper, CH-RMC {name}".ljust(24)
                + "".join(f"{1e3 * value:>11.2f}" for value in SECONDS[name])
            )
    return "\n".join(lines)


def claims_text(table: Sequence[dict[str, Any]]) -> str:
    """What holds of the paper's claims on these rows, one line each."""
    lines = []
    for row in table:
        if row["compensation"] == "none" or row["paper_points"] is None or row["refused"]:
            continue
        base_points = POINTS["NLUT"][0]
        name = row["cgh"].upper()
        base_seconds = TIMES[name][0]
        lines.append(
            f"{row['system']}: points {row['points_change_%']:+.1f} % "
            f"(paper {_change(row['paper_points'], base_points):+.1f} %), time "
            f"{row['seconds_change_%']:+.1f} % "
            f"(paper {_change(row['paper_seconds'], base_seconds):+.1f} %)"
        )
    return "\n".join(lines)


def plot(tables: dict[str, Sequence[dict[str, Any]]], path: Path, title: str) -> None:
    """Points and times relative to each original, with the paper's; a PNG, PDF or SVG.

    tables : scene form to rows
    """
    from chrmc.figures import COLOURS, new_figure, save

    forms = {"rgbd": "intensity and depth pictures", "points": "body-fixed points"}
    heights = [
        1.2 + 0.55 * sum(r["compensation"] != "none" and not r["refused"] for r in table)
        for table in tables.values()
    ]
    figure, axes = new_figure(
        (11, sum(heights) + 0.9), len(tables), 2, squeeze=False, height_ratios=heights
    )
    for line, (form, table) in zip(axes, tables.items(), strict=True):
        shown = [r for r in table if r["compensation"] != "none" and not r["refused"]]
        at = np.arange(len(shown))
        for axis, key, printed, name in (
            (line[0], "points_change_%", "paper_points", "points computed per frame"),
            (line[1], "seconds_change_%", "paper_seconds", "time per frame"),
        ):
            here = [100 + r[key] for r in shown]
            paper = [
                np.nan
                if r[printed] is None
                else 100
                * r[printed]
                / (POINTS["NLUT"][0] if printed == "paper_points" else TIMES[r["cgh"].upper()][0])
                for r in shown
            ]
            for values, side, label, look in (
                (here, -0.2, "measured here", {"color": COLOURS[0]}),
                (paper, 0.2, "printed in the paper",
                 {"color": "white", "edgecolor": COLOURS[1], "hatch": "///"}),
            ):  # fmt: skip
                bars = axis.barh(at + side, values, 0.36, label=label, **look)
                words = ["" if np.isnan(v) else f"{v:.0f} %" for v in values]
                axis.bar_label(bars, words, padding=3, fontsize=8)
            axis.axvline(100, color="0.4", linewidth=1, linestyle="--", label="no compensation")
            axis.set_yticks(at, [r["system"] for r in shown])
            axis.invert_yaxis()
            axis.margins(x=0.15)
            axis.set_xlabel("% of the same method without compensation")
            axis.set_title(f"{name}, {forms.get(form, form)}", fontsize=10)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False, fontsize=9)
    figure.suptitle(title, fontsize=11)
    save(figure, path)
