"""Scene to stored hologram video in one call: `chrmc.generate`."""

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import Any

from chrmc.cgh import Method
from chrmc.compensation import VideoMethod
from chrmc.generation.checking import SHARE
from chrmc.generation.colour import Responses, make_in_light
from chrmc.scene.origin import opened
from chrmc.scene.scene import Scene
from chrmc.slm import LC_R_1080, SLM
from chrmc.store.colour import ColourVideo, lasers_of, open_video
from chrmc.store.video import Video


def generate(
    scene: Scene | str | PathLike[str],
    folder: str | PathLike[str],
    *,
    slm: SLM = LC_R_1080,
    wavelength: float | Sequence[float] | None = None,
    cgh: str | Method | None = "auto",
    compensation: str | VideoMethod | None = "auto",
    surface: str | None = None,
    tolerance: float | None = None,
    frames: tuple[int, int] | None = None,
    encoding: str | None = None,
    response: Responses = None,
    check_pixels: int | None = None,
    check_share: float = SHARE,
    group: int | None = None,
    looks: int = 1,
    png: bool = False,
    force: bool = False,
    workers: int | None = None,
    scheduler: str | None = None,
    **options: Any,
) -> Video | ColourVideo:
    """Make a hologram video of a scene and store it; the same call goes on with a stopped one.

    scene : a `Scene`, or what `load_scene` takes
    folder : made when absent; one that holds another video is refused
    slm : the panel
    wavelength : metres; default the scene's, else 532 nm. Several make a video in colours: a
        hologram per frame and laser, of the points' colours
    cgh : CGH method, compensation : video method, each a name or a function; default "auto": what
        `chrmc.plan` finds cheapest, or what a stopped video was begun with. Beside a named method,
        or options, "auto" is "curved", and "ch-rmc" with it, "none" with another
    surface : of ch-rmc, "object" or "paper"
    tolerance : largest relative field error against the float64 truth; default 1e-3 where the
        method promises one
    frames : (first, last), inclusive, from 1; default all
    encoding : see `display.encode`; default the usual one of the panel's kind, "ssb" of amplitude
    response : the panel's grey response, or the CSV file of one, or several, one for each
        wavelength in their order; default linear
    check_pixels : pixels per frame on which the error is measured, 0 for none; default as many, of
        as many frames, as `check_share` of the time allows, the scene's first and last frame and
        the first of each group always
    group : frames after which a new key frame begins, whatever is made of them and in which order
    looks : draws of the points' phases that each frame is shown with, one after the other: frames
        of their own, for panels so fast that the eye averages them
    png : write PNG, smaller and slower than TIFF
    force : replace another video in the folder, once the new one stands
    workers : processes that make the groups; scheduler : address of a running Dask cluster that
        does, tcp://HOST:PORT; default this process, with all cores
    options : of the methods

    Returns the stored video. Raises ValueError or OSError in one line; what was finished is kept.
    """
    lasers = lasers_of(wavelength)
    # The shortest wavelength resolves most and reaches least.
    finest: Any = min(lasers) if lasers else wavelength
    loaded, source = opened(scene, slm, finest)
    choices = dict(
        cgh=cgh,
        compensation=compensation,
        surface=surface,
        tolerance=tolerance,
        encoding=encoding,
        response=response,
        settings=options,
        check_pixels=check_pixels,
        check_share=check_share,
        group=group,
        looks=looks,
        source=source,
    )
    make_in_light(
        loaded,
        slm,
        wavelength,
        choices,
        Path(folder),
        frames,
        ".png" if png else ".tif",
        force=force,
        workers=workers,
        scheduler=scheduler,
    )
    return open_video(Path(folder))
