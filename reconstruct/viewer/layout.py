"""The window's contents: controls on the left, pictures on the right, what is told below."""

from typing import Any

import moderngl
import numpy as np
from imgui_bundle import imgui

from reconstruct.viewer import controls, dialogs, overlays
from reconstruct.viewer.canvas import Canvas
from reconstruct.viewer.compare import Comparison
from reconstruct.viewer.measure import Line, Region
from reconstruct.viewer.panes import Layer, Pane, colour
from reconstruct.viewer.session import FOURIER_SIDE, Session
from reconstruct.viewer.shade import Look
from reconstruct.viewer.sight import fourier_covers, sight_of
from reconstruct.viewer.sources import titles_of

ImVec2 = imgui.ImVec2
SIDE = 21.5
"""Width of the controls, in font sizes."""
_PLAIN = Look()
_LOG = Look(mode="log")


def measures(held: Comparison) -> str:
    """How like B is to A, in words."""
    alike = "" if held.ssim is None else f", SSIM {held.ssim:.4f}"
    if held.coarse and held.ssim is not None:
        alike = f", SSIM about {held.ssim:.3f}"
    return f"PSNR {held.psnr:.2f} dB{alike}"


class Layout:
    """Canvases and panes of one session; `draw` shows them.

    context : the window's moderngl context; font : of headings
    """

    def __init__(self, context: moderngl.Context, font: Any) -> None:
        self.context = context
        self.font = font
        self._model: Any = None

    def _meet(self, session: Session) -> None:
        """New canvases and panes when another video is looked at."""
        if self._model is session.model:
            return
        self._model = model = session.model
        self.pictures = [Canvas(self.context, "complex") for _ in model.videos]
        self.difference = Canvas(self.context, "signed")
        self.hologram = Canvas(self.context, "grey")
        self.fourier = Canvas(self.context, "power")
        names = ["Reconstruction"]
        if model.comparing:
            a, b = titles_of(model.sources)
            names = [f"A: {a}", f"B: {b}"]
        self.panes = [Pane(name, model.view) for name in names]
        self.hologram_pane = Pane("Hologram", session.views["hologram"])
        self.fourier_pane = Pane("Fourier plane", session.views["fourier"])
        self._fourier_white = 1.0
        self._masked: Any = None

    def every_pane(self) -> list[Pane]:
        """Those of the pictures and the two below."""
        return [*self.panes, self.hologram_pane, self.fourier_pane]

    def draw(self, session: Session, width: float, height: float, density: float) -> None:
        """Everything, in one window of the GUI each for controls and pictures."""
        self._meet(session)
        em = imgui.get_font_size()
        side = SIDE * em
        imgui.set_next_window_pos(ImVec2(0, 0))
        imgui.set_next_window_size(ImVec2(side, height))
        flags = imgui.WindowFlags_.no_decoration | imgui.WindowFlags_.no_move
        flags |= imgui.WindowFlags_.no_bring_to_front_on_focus
        bars = flags & ~imgui.WindowFlags_.no_scrollbar
        imgui.begin("controls", None, int(bars | imgui.WindowFlags_.no_nav))
        controls.files(session)
        controls.frames(session, self.font)
        controls.depth(session, self.font)
        controls.tabs(session)
        imgui.end()
        self._upload(session)
        imgui.set_next_window_pos(ImVec2(side, 0))
        imgui.set_next_window_size(ImVec2(width - side, height))
        still = imgui.WindowFlags_.no_scroll_with_mouse | imgui.WindowFlags_.no_nav
        imgui.begin("pictures", None, int(flags | still))
        free = imgui.get_content_region_avail()
        gap = 0.55 * em
        line = imgui.get_text_line_height() + gap
        tall = free.y - line - gap
        high = tall * 0.66
        self._reconstructions(session, (free.x, high), gap, density)
        self._below(session, (free.x, tall - high), gap, density)
        imgui.text_disabled(self._status(session))
        imgui.end()
        dialogs.help_overlay(session, width, height)
        dialogs.ask_to_open(session, width)

    def _upload(self, session: Session) -> None:
        """Bring the canvases up to what the model has; says nothing of what it has not."""
        model = session.model
        slm = model.video.slm
        panel = (0.0, 0.0, float(slm.width), float(slm.height))
        for i, canvas in enumerate(self.pictures):
            picture = model.picture(i)
            if picture is not None:
                canvas.upload(picture.field, picture, panel, picture.glow)
        held = model.comparison
        if held is not None and model.mode == "difference":
            self.difference.upload(held.difference, held, panel)
        decoded, quick = model.decoded(model.active), model.quick
        if decoded is None or quick is None:
            return
        levels, sight = quick.holograms[model.active], quick.request.sight
        if levels is not None:
            covers = None if sight is None else sight.covers
            self.hologram.upload(levels, (decoded.frame, sight), covers)
        spectrum = decoded.frame.spectrum
        covers = fourier_covers(spectrum.shape, FOURIER_SIDE)
        if self.fourier.upload(spectrum, decoded.frame, covers):
            # The bias is decades above the rest: white is found beside the axes.
            self._fourier_white = 30 * float(spectrum[3::7, 5::7].mean() + 1e-30)
        if self._masked is not decoded.system:
            self._masked = decoded.system
            self.fourier.upload_mask(np.fft.fftshift(decoded.system.transmission()))

    def _reconstructions(
        self, session: Session, size: tuple[float, float], gap: float, density: float
    ) -> None:
        model = session.model
        beside = model.comparing and model.mode == "side by side"
        wide = (size[0] - gap) / 2 if beside else size[0]
        if beside:
            for i, pane in enumerate(self.panes):
                if i:
                    imgui.same_line(0, gap)
                self._reconstruction(session, pane, (wide, size[1]), [i], density)
        elif model.comparing and model.mode == "wipe":
            self._wipe(session, size, density)
        elif model.comparing and model.mode == "difference":
            self._reconstruction(session, self.panes[0], size, [0, 1], density, signed=True)
        else:
            at = 1 if model.comparing and model.mode == "B" else 0
            self._reconstruction(session, self.panes[at], size, [at], density)
        shown = model.view.scale * density
        slm = model.video.slm
        model.screen = (
            min(round(slm.height * shown), slm.height),
            min(round(slm.width * shown), slm.width),
        )

    def _wipe(self, session: Session, size: tuple[float, float], density: float) -> None:
        """A left of the line, B right of it; the line follows the mouse."""
        model = session.model
        start = imgui.get_cursor_pos()
        imgui.set_next_item_allow_overlap()
        self._reconstruction(session, self.panes[0], size, [0, 1], density)
        after = imgui.get_cursor_pos()
        em = imgui.get_font_size()
        imgui.set_cursor_pos(ImVec2(start.x + model.wipe * size[0] - em / 2, start.y))
        imgui.invisible_button("wipe", ImVec2(em, size[1]))
        if imgui.is_item_hovered() or imgui.is_item_active():
            imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew)
        origin = self.panes[0].origin
        if imgui.is_item_active():
            at = imgui.get_io().mouse_pos.x - origin[0]
            model.wipe = float(np.clip(at / size[0], 0, 1))
        x = origin[0] + model.wipe * size[0]
        drawn = imgui.get_window_draw_list()
        a, b = ImVec2(x, origin[1]), ImVec2(x, origin[1] + size[1])
        drawn.add_line(a, b, colour(0, 0, 0, 0.7), 4)
        drawn.add_line(a, b, colour(0.36, 0.80, 0.52), 1.6)
        imgui.set_cursor_pos(after)

    def _reconstruction(
        self,
        session: Session,
        pane: Pane,
        size: tuple[float, float],
        which: list[int],
        density: float,
        signed: bool = False,
    ) -> None:
        """One pane with one video's picture, or two for a wipe or a difference."""
        model = session.model
        pictures = [model.picture(i) for i in which]
        first = pictures[0]
        white = first.white if first is not None else 1.0
        if signed:
            white = 1.0 if model.comparison is None else model.comparison.span
            layers = [Layer(self.difference, model.look, white)]
        elif len(which) == 2:
            ends = ((0.0, model.wipe), (model.wipe, 1.0))
            factor = 1.0 if model.comparison is None else max(model.comparison.factor, 1e-30)
            whites = (white, white / factor)
            layers = [
                Layer(self.pictures[i], model.look, whites[i], *ends[i])
                for i in which
                if pictures[i] is not None
            ]
        else:
            layers = [Layer(self.pictures[which[0]], model.look, white)]
        faults = [model.fault(i) for i in which if model.fault(i)]
        if faults and len(which) == 1:
            layers = []
        pane.grabbing = session.tool != "focus"
        title = pane.title
        if len(which) == 2:
            pane.title = ("B less A" if signed else "A left, B right") + f"##{title}"
        note = ""
        if first is not None:
            note = f"frame {first.number} at {first.depth * 1e3:.2f} mm"
            if first.coarse:
                note += "   first picture"
                if pane.view.scale * model.video.slm.width > 2 * first.field.shape[1]:
                    note += ", blurred until the sharp one comes"
                note += f", {first.lost:.0%} of the light cut" if first.lost >= 0.005 else ""
            if which[-1] == 1 and model.comparison is not None:
                note += "   " + measures(model.comparison)
        drawn = pane.show(size, layers, density, note)
        pane.title = title
        pitch = model.video.slm.pixel_pitch
        overlays.scale_bar(pane, drawn, pitch)
        if first is not None and not faults:
            ends_ = None if signed else first.extremes
            overlays.colour_bar(pane, drawn, model.look, white, ends_, signed)
        if model.found is not None:
            overlays.focus_mark(pane, drawn, model.found.pixel, pitch)
        if model.line is not None:
            overlays.ruler(pane, drawn, model.line, pitch)
        if model.region is not None:
            overlays.rectangle(pane, drawn, model.region)
        if faults:
            overlays.fault(pane, drawn, "\n".join(faults))
        if model.busy:
            share = None if model.progress is None else model.progress.share
            overlays.busy(pane, drawn, model.busy, share)
        pane.finish(drawn)
        if pane.clicked is not None:
            model.focus_at(*pane.clicked, video=which[-1] if len(which) == 1 else 0)
        if pane.drawn is not None and session.tool == "line":
            model.line = Line(*pane.drawn)
        if pane.drawn is not None and session.tool == "region":
            model.region = Region(*pane.drawn)

    def _below(
        self, session: Session, size: tuple[float, float], gap: float, density: float
    ) -> None:
        """The hologram and the Fourier plane of the active video."""
        model = session.model
        half = (size[0] - gap) / 2
        which = ""
        if model.comparing:
            which = f"of {'AB'[model.active]} (Tab)"
        decoded = model.decoded(model.active)
        if decoded is not None and decoded.lasers is not None:
            which += f"   at {decoded.system.wavelength * 1e9:g} nm"
        faulty = bool(model.fault(model.active))
        hologram = [] if faulty else [Layer(self.hologram, _PLAIN, 1.0)]
        pane = self.hologram_pane
        pane.finish(pane.show((half, size[1]), hologram, density, which))
        model.sight = sight_of(pane.view, density)
        imgui.same_line(0, gap)
        fourier = [] if faulty else [Layer(self.fourier, _LOG, self._fourier_white)]
        pane = self.fourier_pane
        pane.finish(pane.show((half, size[1]), fourier, density, which))

    def _status(self, session: Session) -> str:
        """What is told, else what is under the cursor, else what hands can do."""
        model = session.model
        if session.told:
            return session.told
        for i, pane in enumerate(self.every_pane()):
            if pane.hover is None:
                continue
            row, column = pane.hover
            zoom = f"{pane.view.scale:.2g}:1"
            decoded = model.decoded(model.active)
            if pane is self.fourier_pane:
                if decoded is None:
                    continue
                video = model.videos[model.active]
                unit = video.wavelength * decoded.system.bench.focal1 / video.slm.pixel_pitch
                y, x = ((v + 0.5) / FOURIER_SIDE - 0.5 for v in (row, column))
                return f"{x * unit * 1e3:+.3f}, {y * unit * 1e3:+.3f} mm   {zoom}"
            x_, y_ = model.position_of(row, column)
            place = f"row {row}, column {column}   x {x_ * 1e3:+.3f}, y {y_ * 1e3:+.3f} mm"
            if pane is self.hologram_pane:
                grey = "" if decoded is None else f"grey {decoded.frame.levels[row, column]}"
                return f"{place}   {grey}   {zoom}"
            picture = model.picture(min(i, len(model.videos) - 1))
            if picture is None:
                return place
            at = [v * n // m for v, n, m in zip((row, column), picture.field.shape,
                                                model.video.slm.shape, strict=True)]  # fmt: skip
            return f"{place}   intensity {picture.light[at[0], at[1]]:.4g}   {zoom}"
        return "click: focus there   wheel: zoom   drag: move   arrows: frame, depth   H: all keys"
