"""Scene to stored hologram video: the work behind `chrmc generate` and `chrmc demo`."""

import hashlib
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.compensation import video
from chrmc.compensation.frame import VideoFrame
from chrmc.encoding import Coding, coding_for
from chrmc.optics.footprint import coverage
from chrmc.progress import progress
from chrmc.reference import reference_samples, relative_error
from chrmc.response import GreyResponse
from chrmc.scene.scene import Scene, frame_range
from chrmc.slm import LC_R_1080, SLM, WAVELENGTH
from chrmc.store import FORMAT, VideoWriter

CHECK_SEED = 20180101
"""Seed of the pixels that `error_reference` is measured on, recorded in the manifest."""


@dataclass(frozen=True)
class Recipe:
    """Everything that decides what a video's frames look like."""

    scene: Scene
    slm: SLM = LC_R_1080
    wavelength: float = WAVELENGTH
    cgh: str = "rt"
    compensation: str = "none"
    options: dict[str, Any] = field(default_factory=dict)
    encoding: str = "ssb"
    check_pixels: int = 256
    response: GreyResponse | None = None

    @property
    def coding(self) -> Coding:
        """Passband and carrier of the encoding."""
        return coding_for(self.encoding, self.slm)

    def video(self, first: int, last: int) -> Iterator[VideoFrame]:
        """Frames first … last, made one by one."""
        return video(
            self.scene,
            self.slm,
            self.wavelength,
            cgh=self.cgh,
            compensation=self.compensation,
            frames=(first, last),
            coding=self.coding,
            **self.options,
        )


def scene_wavelength(scene: Scene, asked: float | None) -> float:
    """The user's wavelength, else the scene's, else the default; metres."""
    wavelength = asked or scene.wavelength or WAVELENGTH
    if not 1e-8 <= wavelength <= 1e-3:
        raise ValueError(f"wavelength {wavelength:g} m is not light; 532 nm is 532e-9")
    return wavelength


def fingerprint(scene: Scene) -> str:
    """Hash of all points of all frames: two scenes of one fingerprint give one video."""
    digest = hashlib.sha256()
    for number in range(1, scene.frame_count + 1):
        cloud = scene.frame(number).cloud
        for values in (cloud.positions, cloud.amplitude, cloud.phase):
            digest.update(np.ascontiguousarray(values).tobytes())
    return digest.hexdigest()


def describe(recipe: Recipe, scale: float) -> dict[str, Any]:
    """The manifest without its frames."""
    scene, coding = recipe.scene, recipe.coding
    description = {
        "format": FORMAT,
        "slm": asdict(recipe.slm),
        "wavelength": recipe.wavelength,
        "scene": {
            "name": scene.name,
            "form": scene.form,
            "frame_count": scene.frame_count,
            "pixel_pitch": scene.pixel_pitch,
            "objects": list(scene.object_names),
            "fingerprint": fingerprint(scene),
        },
        "methods": {
            "cgh": recipe.cgh,
            "compensation": recipe.compensation,
            "options": recipe.options,
        },
        "encoding": coding.name,
        "carrier": coding.carrier,
        "passband": asdict(coding.passband),
        "scale": scale,
        "error_check": {"pixels": recipe.check_pixels, "seed": CHECK_SEED},
    }
    if recipe.response is not None:
        description["response"] = recipe.response.as_dict()
    return description


def generate(
    recipe: Recipe, folder: Path, frames: tuple[int, int] | None = None, suffix: str = ".tif"
) -> int:
    """Make the frames that `folder` does not hold yet; the number made.

    A stopped run is continued: frames whose file and hash agree with the manifest are kept. Motion
    compensation then starts anew with a key frame at the first missing frame.
    """
    from chrmc.grey_levels import video_scale

    scene, slm = recipe.scene, recipe.slm
    numbers = frame_range(scene, frames)
    # A video without any light is legal, and any scale shows it.
    scale = video_scale(scene, slm, recipe.wavelength, recipe.coding) or 1.0
    writer = VideoWriter(folder, describe(recipe, scale), suffix)
    missing = [n for n in numbers if n not in writer.entries]
    if not missing:
        return 0
    made = recipe.video(missing[0], numbers[-1])
    try:
        count = 0
        for frame in progress(made, "generate", total=numbers[-1] - missing[0] + 1):
            levels = grey_levels(frame, recipe, scale)
            if frame.number in writer.entries:
                continue  # kept from before; made again only to carry the compensation on
            frame.record.error_reference = measured_error(frame, recipe)
            with_boxes(frame, recipe)
            writer.add(frame.record, levels)
            count += 1
    finally:
        if writer.entries:
            writer.save()
    return count


def grey_levels(frame: VideoFrame, recipe: Recipe, scale: float) -> NDArray[np.uint8]:
    """The frame's 8-bit picture; its time is booked under "encode"."""
    from chrmc.grey_levels import encode, encode_signal

    signal = None if recipe.coding.needs_field else frame.signal
    if signal is not None:
        with frame.record.stage("encode"):
            return encode_signal(signal, scale, recipe.response)
    complex_field = frame.field
    with frame.record.stage("encode"):
        # The generator kept to the encoding's passband, so nothing is left to filter.
        return encode(
            complex_field,
            recipe.slm,
            recipe.encoding,
            scale,
            response=recipe.response,
            band_limited=True,
        )


def measured_error(frame: VideoFrame, recipe: Recipe) -> float | None:
    """Relative L2 error against the float64 truth on sampled pixels.

    Of the complex field; of the coded real signal where the method made only that.
    """
    if recipe.check_pixels < 1:
        return None
    slm, coding = recipe.slm, recipe.coding
    rng = np.random.default_rng([CHECK_SEED, frame.number])
    rows = rng.integers(0, slm.height, recipe.check_pixels)
    columns = rng.integers(0, slm.width, recipe.check_pixels)
    truth = reference_samples(
        frame.shown, slm, recipe.wavelength, rows, columns, passband=coding.passband
    )
    if frame.signal is None:
        error = relative_error(frame.field[rows, columns], truth)
    else:
        real = (truth * np.exp(2j * np.pi * coding.carrier * slm.y(rows))).real
        error = relative_error(frame.signal[rows, columns].astype(np.complex128), real + 0j)
    return error if np.isfinite(error) else None


def with_boxes(frame: VideoFrame, recipe: Recipe) -> None:
    """Add to each object's entry its visible points' bounding box, metres, their number, and the
    mean share of the panel that their footprints cover."""
    for entry, thing in zip(frame.record.objects, frame.scene_frame.objects, strict=True):
        cloud = thing.cloud
        if len(cloud):
            entry["box"] = [
                cloud.positions.min(axis=0).tolist(),
                cloud.positions.max(axis=0).tolist(),
            ]
            entry["points"] = len(cloud)
            share = coverage(cloud, recipe.slm, recipe.wavelength, recipe.coding.passband)
            entry["coverage"] = float(share.mean())


def summary(entries: list[dict[str, Any]]) -> Iterator[str]:
    """A small table of stage times, points and errors over a video's frames."""
    stages: dict[str, float] = {}
    for entry in entries:
        for name, seconds in entry["stage_seconds"].items():
            stages[name] = stages.get(name, 0.0) + seconds
    n = max(len(entries), 1)
    total = sum(stages.values())
    yield f"{len(entries)} frames, {sum(e['key'] for e in entries)} of them key frames"
    yield f"{'stage':<12}{'ms per frame':>14}{'share':>9}"
    for name, seconds in stages.items():
        yield f"{name:<12}{1e3 * seconds / n:>14.2f}{seconds / max(total, 1e-12):>9.1%}"
    yield f"{'total':<12}{1e3 * total / n:>14.2f}"
    points = [e["points_computed"] for e in entries]
    yield f"points computed per frame: {np.mean(points) if points else 0:.0f}"
    shares: dict[str, list[float]] = {}
    for thing in (o for e in entries for o in e["objects"]):
        if "coverage" in thing:
            shares.setdefault(thing["name"], []).append(thing["coverage"])
    for name, found in shares.items():
        yield f"{name}: its fringes cover {min(found):.0%} to {max(found):.0%} of the panel"
    errors = [e["error_reference"] for e in entries if e["error_reference"] is not None]
    if errors:
        yield (
            f"field error against the float64 truth: median {np.median(errors):.1e}, "
            f"worst {max(errors):.1e}"
        )
