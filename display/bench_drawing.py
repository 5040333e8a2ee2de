"""The bench sheet as a drawing: the filter plane, and the bench from the side."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from display.bench_sheet import Sheet, Target, mm

_BEAM, _IMAGE, _MASK = "#2f8f46", "#a33ea1", "#444444"


def draw(sheet: Sheet, targets: Sequence[Target], path: Path) -> None:
    """Write the drawing; .png, .pdf or .svg by the suffix."""
    from matplotlib.figure import Figure

    from chrmc.figures import check_figure, save

    check_figure(path)
    figure = Figure(figsize=(13, 9), layout="constrained")
    grid = figure.add_gridspec(2, 2, height_ratios=(1.15, 1), width_ratios=(1, 1.15))
    _filter_plane(figure.add_subplot(grid[0, 0]), sheet)
    _words(figure.add_subplot(grid[0, 1]), sheet, targets)
    _side_view(figure.add_subplot(grid[1, :]), sheet, targets)
    figure.suptitle(f"Bench for {sheet.slm.name} at {1e9 * sheet.wavelength:.5g} nm")
    save(figure, path, dpi=110)


def _filter_plane(axes: Any, sheet: Sheet) -> None:
    from matplotlib.patches import Circle, Rectangle

    unit = 1e3 * sheet.order_spacing
    edge = 1.25 * unit
    axes.add_patch(Rectangle((-edge, -edge), 2 * edge, 2 * edge, color=_MASK, alpha=0.5, lw=0))
    half, zero = sheet.coding.half_plane, sheet.coding.zero_order
    width, height = (1e3 * side for side in sheet.opening)
    centre = 1e3 * sheet.carrier
    for colour, alpha in (("white", 1.0), (_BEAM, 0.35)):
        corner = (-width / 2, centre - height / 2)
        axes.add_patch(Rectangle(corner, width, height, color=colour, alpha=alpha, lw=0))
    if half:
        axes.add_patch(
            Rectangle((-width / 2, -height), width, height, fill=False, ec="#eeeeee", ls="--")
        )
        axes.text(
            0, -unit / 4, f"conjugate: blocked\n{mm(-sheet.carrier)}", ha="center", va="center",
            color="white",
        )  # fmt: skip
        axes.plot([0], [centre], "+", color=_BEAM, ms=14)
    passed = "passed\n"
    passed += f"carrier {mm(sheet.carrier)}" if half else "zero order too" if zero else ""
    axes.text(0, centre + 0.04 * unit, passed, ha="center", va="top")
    for i in (-1, 0, 1):
        for j in (-1, 0, 1):
            axes.add_patch(Circle((i * unit, j * unit), 0.025 * unit, color="#c0392b"))
            if (i, j) != (0, 0):
                axes.text(i * unit, (j + 0.05) * unit, f"{i:+d}, {j:+d}", ha="center", va="top")
    # Centred over its dot: to one side it would cross the border of the half plane.
    if not zero:
        axes.text(0, -0.03 * unit, "zero order: blocked", ha="center", va="bottom", color="white")
    axes.annotate(
        "", (-unit, -1.06 * unit), (0, -1.06 * unit), arrowprops={"arrowstyle": "<->", "color": "w"}
    )
    axes.text(-unit / 2, -1.07 * unit, mm(sheet.order_spacing), ha="center", va="bottom", color="w")
    axes.set(
        xlim=(-edge, edge), ylim=(edge, -edge), aspect="equal", xlabel="x / mm",
        ylabel="y / mm (down)",
        title=f"Filter plane: opening {mm(sheet.opening[0])} × {mm(sheet.opening[1])}",
    )  # fmt: skip


def _words(axes: Any, sheet: Sheet, targets: Sequence[Target]) -> None:
    axes.axis("off")
    half = sheet.coding.half_plane
    text = [
        f"panel {mm(sheet.size[0])} × {mm(sheet.size[1])}, pitch "
        f"{1e6 * sheet.slm.pixel_pitch:.4g} µm",
        f"lens 1: f {mm(sheet.focal1)}, clear {mm(sheet.lens1)} or more",
        f"lens 2: f {mm(sheet.focal2)}, clear {mm(sheet.lens2)} or more",
        f"magnification {sheet.magnification:.4g}, upside down",
        f"encoding {sheet.coding.name}; orders every {mm(sheet.order_spacing)}"
        + (f"; carrier {mm(sheet.carrier)} below the axis" if half else ""),
        "block the half above the axis and the zero order"
        if half
        else f"pass {mm(sheet.opening[0])} × {mm(sheet.opening[1])} about the axis, zero order "
        + ("and all" if sheet.coding.zero_order else "blocked"),
        "",
    ]
    for place in map(sheet.place, targets):
        text += [
            f"{place.target.name} at {mm(place.target.depth)}",
            f"   camera focused through lens 2, {mm(-place.camera)} before it"
            if place.camera < 0
            else f"   camera focused {mm(place.camera)} behind lens 2",
            *[f"   or conjugate: bare sensor {mm(place.sensor)} behind lens 2"] * half,
            f"   image centre ({mm(place.x)}, {mm(place.y)})",
            f"   resolution {1e6 * place.resolution[0]:.1f} × {1e6 * place.resolution[1]:.1f} µm, "
            f"field ±{mm(place.field_any[0])} × ±{mm(place.field_any[1])}",
        ]
    axes.text(0, 1, "\n".join(text), va="top", family="monospace", fontsize=9.5)


def _side_view(axes: Any, sheet: Sheet, targets: Sequence[Target]) -> None:
    from matplotlib.patches import Ellipse

    f1, f2 = 1e3 * sheet.focal1, 1e3 * sheet.focal2
    half = 1e3 * sheet.size[1] / 2
    lens1, mask, lens2, image = f1, 2 * f1, 2 * f1 + f2, 2 * f1 + 2 * f2
    places = [sheet.place(t) for t in targets]
    left = min([0.0, lens2, *(1e3 * -t.depth for t in targets)])
    left = min([left, *(lens2 + 1e3 * p.camera for p in places)])
    conjugate = sheet.coding.half_plane
    right = max([image, *(lens2 + 1e3 * p.sensor for p in places if conjugate)])
    carrier, top = 1e3 * sheet.carrier, 1e3 * (sheet.carrier + sheet.opening[1] / 2)
    low_edge = 1e3 * (sheet.carrier - sheet.opening[1] / 2)
    m = sheet.magnification
    for start in (-half, 0.0, half):
        # Rays of the carrier: they leave the panel downwards, cross the filter at the carrier and
        # come to the upside-down image.
        axes.plot(
            [0, lens1, mask, lens2, image],
            [start, start + carrier, carrier, carrier - m * start, -m * start],
            color=_BEAM, lw=0.9,
        )  # fmt: skip
    axes.plot([0, 0], [-half, half], color="black", lw=4)
    axes.plot([image, image], [-half * m, half * m], color="black", lw=2, ls=":")
    axes.plot([mask, mask], [-2.2 * top, low_edge + 0.02 * top], color=_MASK, lw=4)
    axes.plot([mask, mask], [top, 2.2 * top], color=_MASK, lw=4)
    for at, clear in ((lens1, sheet.lens1), (lens2, sheet.lens2)):
        height = 1e3 * clear
        thin = 0.012 * (right - left)
        axes.add_patch(Ellipse((at, 0), thin, height, color="#7fb2e5", alpha=0.7))
    low = 1.25 * max(1e3 * sheet.lens1, 1e3 * sheet.lens2) / 2
    for at, name in (
        (0, "panel"), (lens1, "lens 1"), (mask, "filter"), (lens2, "lens 2"),
        (image, "image of panel"),
    ):  # fmt: skip
        axes.text(at, -low, name, ha="center", va="bottom")
    for row, place in enumerate(places):
        y = low * (0.62 + 0.22 * (row % 2))
        for at, words in (
            (-1e3 * place.target.depth, place.target.name),
            (lens2 + 1e3 * place.camera, f"{place.target.name}: focus here"),
            *[(lens2 + 1e3 * place.sensor, f"{place.target.name}, conjugate")] * conjugate,
        ):
            axes.plot([at, at], [-half, half], color=_IMAGE, lw=1.5, ls="--")
            axes.plot([at, at], [half, y], color=_IMAGE, lw=0.5)
            axes.text(at, y, words, ha="center", va="top", color=_IMAGE, fontsize=8.5)
    for start, end in ((0, lens1), (lens1, mask), (mask, lens2), (lens2, image)):
        axes.annotate(
            "", (start, -0.82 * low), (end, -0.82 * low), arrowprops={"arrowstyle": "<->"}
        )
        axes.text((start + end) / 2, -0.84 * low, f"{end - start:.4g} mm", ha="center", va="bottom")
    axes.set(
        xlim=(left - 70, right + 70), ylim=(1.15 * low, -1.25 * low), xlabel="along the axis / mm",
        ylabel="y / mm (down)", title="From the side (heights enlarged)",
    )  # fmt: skip
