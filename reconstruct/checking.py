"""The verdict on a stored video: what `chrmc check` does, for Python."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from os import PathLike, fspath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.progress import progress
from chrmc.response import GreyResponse
from chrmc.scene.drawn import drawn
from chrmc.scene.light import scenes_in_light
from chrmc.scene.load import BUILT_IN, load_scene
from chrmc.scene.origin import MADE_OF, scene_made_of
from chrmc.scene.scene import Scene
from chrmc.store.colour import ColourVideo, open_video, read_plan
from chrmc.store.video import Video
from reconstruct.four_f_system import FourF
from reconstruct.looks import looks_of
from reconstruct.verdict import FrameVerdict, Target, judge_frame

PAPER_FRAMES = (1, 21, 51, 80)
"""The frames of the paper's Fig. 14, and the first."""


def check(
    video: Video | ColourVideo | str | PathLike[str],
    frames: Sequence[int] | None = None,
    *,
    scene: Scene | str | None = None,
    metrics: bool = False,
    **tolerances: Any,
) -> list[FrameVerdict]:
    """Is every object of a stored video in focus where the scene says, and does it look like it?

    video : a stored video or its folder
    frames : numbers; default 1, 21, 51, 80 where all are there, else four spread evenly
    scene : for PSNR and SSIM too, against the reconstruction of the scene's own field: a `Scene`
        or what `chrmc.load_scene` takes
    metrics : also where published focus metrics of each region peak
    tolerances : `depth_tolerance` and `lateral_tolerance` in metres, see `judge_frame`

    Returns one verdict per frame, of a video in colours per frame and colour; `.passed` says
    whether all is as it should be.
    """
    stored = video if isinstance(video, Video | ColourVideo) else open_video(fspath(video))
    if isinstance(stored, ColourVideo):
        asked = chosen_frames(frames, stored)
        lit: list[Any] = [None] * len(stored.channels)
        if scene is not None:
            whole = scene_of(stored, scene) if isinstance(scene, str) else scene
            lit = list(scenes_in_light(whole, stored.wavelengths))
        return [
            replace(verdict, wavelength=channel.wavelength)
            for channel, one in zip(stored.channels, lit, strict=True)
            for verdict in check(channel, asked, scene=one, metrics=metrics, **tolerances)
        ]
    numbers = chosen_frames(frames, stored)
    system = FourF(
        stored.slm,
        stored.wavelength,
        stored.encoding,
        response=GreyResponse.from_dict(stored.response),
        scale=stored.scale,
    )
    true_field = None if scene is None else truth_maker(stored, scene)
    known = _built_in(stored)
    verdicts = []
    for number in progress(numbers, "check"):
        targets = _targets(stored, number, system, known)
        verdicts.append(
            judge_frame(
                stored.read(number),
                system,
                targets,
                stored.pixel_pitch,
                number,
                None if true_field is None else true_field(number),
                with_metrics=metrics,
                **tolerances,
            )
        )
    return verdicts


def _built_in(video: Video) -> Scene | None:
    """The scene that a video names, where it comes with the package: nothing else that a manifest
    names is opened or run."""
    name = video.scene.get("name")
    if name not in BUILT_IN or video.scene.get("source") is not None:
        return None
    if all(o.get("light") for f in video.frames for o in f["objects"] if o.get("position")):
        return None  # the manifest has all that is needed
    return load_scene(str(name), form=str(video.scene["form"]), slm=video.slm)


def _targets(video: Video, number: int, system: FourF, scene: Scene | None) -> list[Target]:
    """A frame's visible objects; those whose map of light the manifest lacks get it from the scene,
    where that has them at the same place."""
    found = [Target.of_record(o) for o in video.entry(number)["objects"]]
    targets = [t for t in found if t is not None]
    if scene is None or not 1 <= number <= scene.frame_count:
        return targets
    known = {o.name: Target.of_cloud(o.name, o.cloud, system) for o in scene.frame(number).objects}
    out = []
    for target in targets:
        same = known.get(target.name) if target.light is None else None
        near = same is not None and np.allclose(same.position, target.position, atol=1e-7)
        out.append(same if near and same is not None else target)
    return out


def chosen_frames(asked: Sequence[int] | None, video: Video | ColourVideo) -> list[int]:
    """Frame numbers to judge; ValueError where one is not in the video."""
    if not video.numbers:
        raise ValueError(f"{video.folder} has no frames yet: run `chrmc generate` first")
    if asked is None:
        if set(PAPER_FRAMES) <= set(video.numbers):
            return list(PAPER_FRAMES)
        last = len(video.numbers) - 1
        return sorted({video.numbers[round(last * share / 3)] for share in range(4)})
    for n in asked:
        video.entry(n)
    return list(asked)


def truth_maker(video: Video, scene: Scene | str) -> Callable[[int], NDArray[np.complex64]]:
    """A function from frame number to the scene's field within the video's passband.

    The low-rank method at 1e-6 stands for the float64 sum: 120 dB, and a thousand times faster;
    where its single precision cannot promise that, at 1e-5.
    """
    from chrmc.cgh import DEFAULT_METHOD, compute_field
    from chrmc.encoding import coding_for

    if isinstance(scene, str):
        scene = scene_of(video, scene)
    scene = _as_shown(video, scene)
    band = coding_for(video.encoding, video.slm).passband

    def field(number: int) -> NDArray[np.complex64]:
        cloud = scene.frame(number).cloud
        exact = partial(
            compute_field, cloud, video.slm, video.wavelength, DEFAULT_METHOD, passband=band
        )
        try:
            return exact(tolerance=1e-6)
        except ValueError:
            return exact(tolerance=1e-5)

    return field


def scene_of(video: Video | ColourVideo, named: str | None = None) -> Scene:
    """The scene that a video was made of, sized as it was then; in all its colours, or, of one
    laser of a video in colours, in that laser's light.

    named : what `load_scene` takes, default what the manifest says: a built-in scene, or files
        that have not changed since; ValueError where it was a Python file
    """
    if isinstance(video, ColourVideo):  # sized for the shortest wavelength
        return _loaded(min(video.channels, key=lambda channel: channel.wavelength), named)
    plan = read_plan(video.folder.parent)
    if plan is not None and video.folder.name in plan.folders:
        whole = open_video(video.folder.parent)
        lit = scenes_in_light(scene_of(whole, named), plan.wavelengths)
        return lit[plan.folders.index(video.folder.name)]
    return _loaded(video, named)


def _as_shown(video: Video, scene: Scene) -> Scene:
    """The scene, each frame with as many draws of its phases as the video shows."""
    looks = looks_of(video)
    once = video.scene.get("frame_count") == looks * scene.frame_count
    return drawn(scene, looks) if once else scene


def _loaded(video: Video, named: str | None) -> Scene:
    return _as_shown(video, _named(video, named))


def _named(video: Video, named: str | None) -> Scene:
    record = video.scene.get(MADE_OF)
    if record is not None:
        words = [] if named is None else [named]
        return scene_made_of(record, video.slm, video.wavelength, words)
    name = named or _name_of(video)
    form = str(video.scene["form"])
    return load_scene(name, form=form, slm=video.slm, wavelength=video.wavelength)


def _name_of(video: Video) -> str:
    """The name of the scene that a video was made of; ValueError where that was a Python file."""
    source = video.scene.get("source")
    if source is not None:
        raise ValueError(
            f"the scene came from {source['file']}: name it again, --scene FILE.py:"
            f"{source['function']} (a manifest's code is never run by itself)"
        )
    return str(video.scene["name"])
