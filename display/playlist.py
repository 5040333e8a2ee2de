"""What is to be shown: frames of a stored video, or one picture, read and checked one by one."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from chrmc.files import sha256
from chrmc.panels import encoding_for
from chrmc.pictures import read_grey
from chrmc.slm import LC_R_1080, SLM
from chrmc.store.colour import ColourVideo, open_video


@dataclass(frozen=True, eq=False)
class Picture:
    """One frame ready to be shown.

    number : scene frame, from 1
    file : name for the log
    sha256 : of that file; of the grey levels where there is no file
    levels : (H, W) uint8, or (H, W, 3) for the three channels
    """

    number: int
    file: str
    sha256: str
    levels: NDArray[np.uint8] = field(repr=False)


@dataclass(frozen=True)
class Entry:
    """A frame to be read: its number, file, the hash that a manifest promises, if any, and what
    the log calls it, the file's name by default."""

    number: int
    path: Path
    sha256: str | None = None
    name: str = ""


@dataclass(frozen=True)
class Playlist:
    """Frames in playing order, all of one SLM's size.

    slm : whose pixels the frames have
    entries : what to read
    name : of the video or picture, for messages
    load : reads the grey levels of a file
    lasers : names of those whose entries make one frame of a video in colours, in turn
    """

    slm: SLM
    entries: Sequence[Entry]
    name: str
    load: Callable[[Path], NDArray[np.uint8]] = read_grey
    lasers: Sequence[str] = ()

    def __len__(self) -> int:
        return len(self.entries)

    def read(self, index: int) -> Picture:
        """The frame at a place in the list.

        Raises OSError or ValueError, naming the frame, when it is missing, damaged, not what the
        manifest promises, or of another size than the SLM.
        """
        entry = self.entries[index]
        try:
            if not entry.path.is_file():
                raise FileNotFoundError(f"{entry.path} is missing")
            digest = sha256(entry.path)
            if entry.sha256 is not None and digest != entry.sha256:
                raise OSError(
                    f"{entry.path} is not the file that the manifest lists (SHA-256 differs): "
                    "generate it again"
                )
            levels = self.load(entry.path)
            check_levels(levels, self.slm, str(entry.path))
        except (OSError, ValueError) as error:
            raise type(error)(f"frame {entry.number}: {error}") from error
        return Picture(entry.number, entry.name or entry.path.name, digest, levels)


def check_levels(levels: NDArray[np.uint8], slm: SLM, what: str) -> None:
    """ValueError unless the picture has the SLM's pixels, and only levels that it shows.

    On a binary panel these are 0 and 255; a picture of three channels holds bit planes there.
    """
    if levels.shape[:2] != slm.shape:
        raise ValueError(
            f"{what} is {levels.shape[1]} × {levels.shape[0]} pixels, but {slm.name} shows "
            f"{slm.width} × {slm.height}: make it at that size, pixels are never resampled"
        )
    # 255 wraps around to 0, 0 becomes 1: one pass over the picture.
    if slm.kind == "binary" and levels.ndim == 2 and (levels + np.uint8(1)).max() > 1:
        raise ValueError(
            f"{what} has grey levels, but {slm.name} is either dark or bright: take 0 and 255 "
            "only, or encode a field for it (error-diffusion, lee)"
        )


def open_playlist(
    target: str | Path,
    slm: SLM | None = None,
    frames: tuple[int, int] | None = None,
    order: Sequence[float] | None = None,
) -> Playlist:
    """The playlist of a generated video's folder, or of a single picture.

    slm : for a picture, default LC_R_1080; a video's manifest says its own
    frames : (first, last) frame numbers of a video, inclusive; default all
    order : of the lasers of a video in colours, wavelengths in metres; default its own
    """
    path = Path(target)
    if not path.exists():
        raise FileNotFoundError(f"{path} does not exist: give a video's folder or a picture")
    if not path.is_dir():
        if frames is not None:
            raise ValueError(f"{path} is one picture: a range of frames needs a video's folder")
        playlist = Playlist(slm or LC_R_1080, [Entry(1, path)], path.name)
        playlist.read(0)
        return playlist
    video = open_video(path)
    if slm is not None and (slm.width, slm.height) != (video.slm.width, video.slm.height):
        raise ValueError(
            f"{path} was made for {video.slm.width} × {video.slm.height} pixels, not for the "
            f"{slm.width} × {slm.height} of {slm.name}: generate it for that SLM"
        )
    if slm is not None:
        encoding_for(slm, video.channels[0].encoding)
    if isinstance(video, ColourVideo):
        from display.colours import colour_playlist

        return colour_playlist(video, order, frames)
    if order is not None:
        raise ValueError(f"{path} is a video in one colour: an order of lasers means nothing there")
    first, last = frames or (0, max(video.numbers, default=0))
    entries = [
        Entry(int(f["number"]), video.path(int(f["number"])), str(f["sha256"]))
        for f in video.frames
        if first <= int(f["number"]) <= last
    ]
    if not entries:
        there = f"frames {video.numbers[0]} to {video.numbers[-1]}" if video.numbers else "no frame"
        raise ValueError(f"{path} has {there}: nothing to play")
    return Playlist(slm or video.slm, entries, path.name)
