"""What can be looked at: a stored video, or any picture of grey levels as a video of one frame."""

from collections.abc import Sequence
from pathlib import Path

from chrmc.encoding import coding_for
from chrmc.pictures import read_grey
from chrmc.slm import LC_R_1080, SLM, WAVELENGTH
from chrmc.store.colour import ColourVideo, open_video
from chrmc.store.video import MANIFEST, Video
from reconstruct.viewer.lasers import Source


def open_source(
    path: str | Path,
    slm: SLM | None = None,
    wavelength: float | None = None,
    encoding: str | None = None,
) -> Source:
    """A video's folder or its manifest, of one laser or several, or a picture.

    slm, wavelength (metres), encoding : of a picture, default the LC-R 1080 where its size fits,
        532 nm, "ssb"; a video knows its own, and they are refused

    Raises ValueError or OSError in one line.
    """
    path = Path(path)
    if path.is_dir() or path.name == MANIFEST:
        folder = path if path.is_dir() else path.parent
        given = {"--slm": slm, "--wavelength": wavelength, "--encoding": encoding}
        for name, value in given.items():
            if value is not None:
                raise ValueError(f"{folder} is a video and knows its own: leave out {name}")
        video = open_video(folder)
        if not video.numbers:
            raise ValueError(f"{folder} has no frames yet: run `chrmc generate` first")
        return video
    levels = read_grey(path)
    panel = LC_R_1080 if slm is None else slm
    if levels.shape != panel.shape:
        raise ValueError(
            f"{path} is {levels.shape[1]} × {levels.shape[0]} pixels, {panel.name} has "
            f"{panel.width} × {panel.height}: say which with "
            f"--slm {levels.shape[1]}x{levels.shape[0]}:PITCH"
        )
    coding = coding_for("ssb" if encoding is None else encoding, panel)
    return Video(
        path.parent,
        panel,
        WAVELENGTH if wavelength is None else wavelength,
        {"name": path.name, "pixel_pitch": 5 * panel.pixel_pitch},
        {},
        coding.name,
        1.0,
        {},
        [{"number": 1, "file": path.name, "objects": []}],
    )


def title_of(video: Source) -> str:
    """What a source is called in the window."""
    if isinstance(video, ColourVideo):
        return video.folder.resolve().name
    single = len(video.frames) == 1 and not video.methods
    return str(video.scene.get("name")) if single else video.folder.resolve().name


def titles_of(videos: Sequence[Source]) -> list[str]:
    """What sources are called side by side: those of one name by their folder's folder, too."""
    titles = [title_of(video) for video in videos]
    if len(set(titles)) == len(titles):
        return titles
    return [
        f"{video.folder.resolve().parent.name}/{title}"
        for video, title in zip(videos, titles, strict=True)
    ]


def check_pair(a: Source, b: Source) -> list[int]:
    """Frame numbers that two videos share, or ValueError where they cannot be compared."""
    if (a.slm.shape, a.slm.pixel_pitch) != (b.slm.shape, b.slm.pixel_pitch):
        raise ValueError(
            f"{a.folder} is for {_panel(a.slm)}, {b.folder} for {_panel(b.slm)}: "
            "only videos of one panel are compared"
        )
    common = sorted(set(a.numbers) & set(b.numbers))
    if not common:
        raise ValueError(f"{a.folder} and {b.folder} have no frame in common")
    return common


def _panel(slm: SLM) -> str:
    return f"{slm.width} × {slm.height} pixels of {slm.pixel_pitch * 1e6:g} µm"
