"""The viewer's controls: they read and set the session, and compute nothing."""

from typing import Any

import numpy as np
from imgui_bundle import imgui

from reconstruct.viewer import plots
from reconstruct.viewer.compare import MODES as COMPARISONS
from reconstruct.viewer.session import SAVES, Session
from reconstruct.viewer.shade import COLOURS, MODES
from reconstruct.viewer.state import RATES
from reconstruct.viewer.widgets import button, em, fits, heading, label, rows, slider, tip

ImVec2 = imgui.ImVec2
FILTER_EDGE = 12e-3
"""Largest aperture that the slider offers, metres."""


def files(session: Session) -> None:
    """Open, save, help: always in the same place."""
    if button("Open", 4.6):
        session.ask_to_open()
    tip("Ctrl+O, or drop a folder or picture on the window")
    imgui.same_line()
    if button("Save", 4.6):
        imgui.open_popup("save")
    tip("S saves the picture, E intensities, G a figure")
    if imgui.begin_popup("save"):
        for words, ending, kind in SAVES:
            if imgui.selectable(words, False)[0]:
                session.save(ending, kind)
        imgui.end_popup()
    imgui.same_line()
    if button("Undo", 4.6):
        session.undo()
    tip("Ctrl+Z; Ctrl+Y goes forward")
    imgui.same_line()
    if button("Help", 4.6):
        session.toggle_help()
    tip("H")


def frames(session: Session, font: Any) -> None:
    """Scrubber, play, rate, follow."""
    model = session.model
    heading("Frame", font)
    if button("Pause##play" if model.playing else "Play##play", 4.6):
        session.play()
    tip("Space")
    imgui.same_line()
    if button("<", 1.8):
        model.step(-1)
    tip("Left arrow")
    imgui.same_line()
    if button(">", 1.8):
        model.step(1)
    tip("Right arrow")
    imgui.same_line()
    imgui.align_text_to_frame_padding()
    imgui.text(f"{model.number}")
    imgui.same_line()
    rate = f", {model.shown_rate:.1f} a second" if model.playing else ""
    imgui.text_disabled(f"of {model.numbers[0]} to {model.numbers[-1]}{rate}")
    imgui.set_next_item_width(-1.0)
    last = max(len(model.numbers) - 1, 1)
    imgui.begin_disabled(len(model.numbers) == 1)
    changed, index = imgui.slider_int("##frame", model.index, 0, last, "")
    imgui.end_disabled()
    if changed:
        model.index = index
    changed, rate_ = slider("rate", model.rate, *RATES, "%.1f /s", logarithmic=True)
    if changed:
        model.rate = float(np.clip(rate_, *RATES))
    names = ["no object", *dict.fromkeys(t.name for t in model.objects())]
    label("follow")
    current = model.follow or names[0]
    if imgui.begin_combo("##follow", current):
        for name in names:
            if imgui.selectable(name, name == current)[0]:
                model.follow = None if name == names[0] else name
                model.index = model.index  # takes its depth at once
        imgui.end_combo()


def depth(session: Session, font: Any) -> None:
    """Depth slider, steps, objects, focus curves."""
    model = session.model
    heading("Depth", font)
    low, high = model.depth_range
    changed, value = slider(
        "depth", model.depth * 1e3, low * 1e3, high * 1e3, "%.2f mm", labelled=False
    )
    if changed:
        model.depth = value * 1e-3
        model.follow = None
    for step in (-1.0, -0.1, 0.1, 1.0):
        if button(f"{step:+.1f}", 3.2):
            session.go_deeper(step * 1e-3)
        tip("mm")
        imgui.same_line()
    if button("curves"):
        session.find_curves()
    tip("Focus curves of all objects: C")
    for i, target in enumerate(model.objects()[:6]):
        at = float(target.position[2])
        words = f"{target.name}  {at * 1e3:.2f}"
        if i and fits(words):
            imgui.same_line()
        if button(words):
            model.follow = None
            model.depth = at
        tip("Where the scene says it is")
    plots.focus_curves(session)


def compared(session: Session) -> None:
    """How two videos are shown, and what sets them apart."""
    model = session.model
    label("show")
    changed, at = imgui.combo("##compare", COMPARISONS.index(model.mode), list(COMPARISONS))
    if changed:
        model.mode = COMPARISONS[at]
    held = model.comparison
    if held is None or held.request.number != model.number:
        fault = model.fault(0) or model.fault(1)
        imgui.text_disabled(f"PSNR, SSIM: {'a frame cannot be read' if fault else 'not yet'}")
        return
    imgui.text_disabled("of the region" if held.region else "of all; R marks a region")
    ssim = "being measured" if model.alike is None else f"about {model.alike.ssim:.3f}"
    if held.ssim is not None and not held.coarse:
        ssim = f"{held.ssim:.4f}"
    rows("compared", [("PSNR", f"{held.psnr:.2f} dB"), ("SSIM", ssim),
                      ("B is shown times", f"{held.factor:.3g}")])  # fmt: skip


def fourier_filter(session: Session) -> None:
    """Half plane, zero order, aperture."""
    model = session.model
    chosen = model.filter
    automatic = model.carries
    half = automatic if chosen.half_plane is None else chosen.half_plane
    changed, half = imgui.checkbox("single sideband, f_y > 0 only", half)
    if changed:
        model.change_filter(half_plane=half)
    block = chosen.dc_block
    changed, on = imgui.checkbox("block zero order", block is not None)
    if changed:
        model.change_filter(dc_block=10e-6 if on else None)
    if block is not None:
        changed, value = slider("radius", block * 1e6, 0.0, 500.0, "%.0f µm", logarithmic=True)
        if changed:
            model.change_filter(dc_block=max(value, 0.0) * 1e-6)
    shapes = ("none", "round", "square")
    opening = chosen.aperture
    current = 0 if opening is None else 1 if np.ndim(opening) == 0 else 2
    label("aperture")
    changed, picked = imgui.combo("##aperture", current, list(shapes))
    size = 6e-3 if opening is None else float(np.max(np.asarray(opening)))
    if changed:
        model.change_filter(aperture=(None, size, (size, size))[picked])
    if opening is not None:
        changed, value = slider("opening", size * 1e3, 0.2, FILTER_EDGE * 1e3, "%.2f mm")
        if changed and value > 0:
            side = value * 1e-3
            model.change_filter(aperture=side if current == 1 else (side, side))


def look(session: Session) -> None:
    """Mode, colours, gamma, exposure."""
    shown = session.model.look
    for mode in MODES:
        if imgui.radio_button(mode, shown.mode == mode):
            shown.mode = mode
        imgui.same_line()
    imgui.new_line()
    label("colours")
    _, at = imgui.combo("##colours", COLOURS.index(shown.colours), list(COLOURS))
    shown.colours = COLOURS[at]
    _, stops = slider("exposure", shown.stops, -5, 7, "%+.1f EV")
    shown.stops = float(np.clip(stops, -20, 20))
    tip("in powers of two against the automatic one")
    _, gamma = slider("gamma", shown.gamma, 0.5, 4, "%.2f")
    shown.gamma = float(np.clip(gamma, 0.1, 10))


def figures(session: Session) -> None:
    """What was measured of the sharp picture."""
    model = session.model
    held = model.figures
    words = {
        "sharpness": ("sharpness", "{:.1f}"),
        "contrast": ("contrast", "{:.3f}"),
        "speckle": ("speckle contrast", "{:.2f}"),
        "efficiency": ("light in the image", "{:.2%}"),
        "blocked": ("light on the filter", "{:.1%}"),
    }
    fresh = held is not None and held.request.subject == model.request.subject
    values = held.values[min(model.active, len(held.values) - 1)] if held and fresh else {}
    told = [(n, f.format(values[k]) if k in values else "…") for k, (n, f) in words.items()]
    if model.quick is not None:
        told.append(("first picture", f"{1e3 * model.quick.seconds:.0f} ms"))
    if model.sharp is not None:
        told.append(("sharp picture", f"{1e3 * model.sharp.seconds:.0f} ms"))
    rows("figures", told)


def tabs(session: Session) -> None:
    """Picture, filter, values and marks, one at a time: all fits without scrolling."""
    imgui.dummy(ImVec2(0, 0.2 * em()))
    if not imgui.begin_tab_bar("tabs"):
        return
    pages = [
        ("Picture", look),
        ("Filter", fourier_filter),
        ("Values", figures),
        ("Marks", plots.marks),
    ]
    if session.model.comparing:
        pages.insert(0, ("Compare", compared))
    for name, show in pages:
        chosen = name == "Marks" and session.show_marks
        flags = imgui.TabItemFlags_.set_selected if chosen else imgui.TabItemFlags_.none
        if imgui.begin_tab_item(name, None, int(flags))[0]:
            show(session)
            imgui.end_tab_item()
    session.show_marks = False
    imgui.end_tab_bar()
