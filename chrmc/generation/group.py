"""A group of a video's frames made and stored: the unit of work, wherever it is done."""

from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.compensation.frame import VideoFrame
from chrmc.generation.checking import Check
from chrmc.generation.recipe import CHECK_SEED, Recipe
from chrmc.light_map import LightMap
from chrmc.optics.footprint import coverage, expected_power
from chrmc.reference import reference_samples, relative_error
from chrmc.store.group import GroupWriter
from chrmc.threads import ONE_BLAS_THREAD


def groups_of(recipe: Recipe, missing: list[int]) -> list[tuple[range, set[int]]]:
    """The groups that missing frames belong to, each with those of its frames."""
    found: dict[int, tuple[range, set[int]]] = {}
    for number in missing:
        group = recipe.group_of(number)
        found.setdefault(group.start, (group, set()))[1].add(number)
    return list(found.values())


def make_group(
    recipe: Recipe,
    folder: Path,
    scale: float,
    group: range,
    wanted: Collection[int],
    suffix: str,
    options: dict[str, Any],
) -> Iterator[int]:
    """Make and store the wanted frames of a group; yields their numbers, each once it is stored.

    The video method is asked for the whole group, so that it looks ahead and carries on as if all
    of it were wanted, and is left after the last one.
    """
    writer = GroupWriter(folder, group.start, suffix)
    last = max(wanted)
    try:
        # How BLAS cuts a product into threads changes the last bits of its sums. Methods spread
        # their work over the cores themselves, in pieces that do not depend on how many.
        with ONE_BLAS_THREAD:
            for frame in recipe.video(group[0], group[-1], **options):
                if frame.number in wanted:
                    levels = grey_levels(frame, recipe, scale)
                    frame.record.error_reference = measured_error(frame, recipe)
                    if frame.record.error_reference is not None:
                        frame.record.error_pixels = recipe.check_pixels
                    with_boxes(frame, recipe)
                    writer.add(frame.record, levels)
                    yield frame.number
                if frame.number >= last:
                    return
    finally:
        writer.save()


def grey_levels(frame: VideoFrame, recipe: Recipe, scale: float) -> NDArray[np.uint8]:
    """The frame's 8-bit picture; its time is booked under "encode"."""
    from chrmc.grey_levels import encode, encode_signal

    signal = None if recipe.coding.needs_field else frame.signal
    if signal is not None:
        with frame.record.stage("encode"):
            return encode_signal(signal, scale, recipe.response, bits=recipe.slm.bits)
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
    check = Check(recipe.check_pixels, recipe.check_every)
    if not check.includes(frame.number, recipe.scene.frame_count, recipe.group):
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
    """Add to each object's entry its visible points' bounding box, metres, their number, the mean
    share of the panel that their footprints cover, and the light and its map that checks use."""
    for entry, obj in zip(frame.record.objects, frame.scene_frame.objects, strict=True):
        cloud = obj.cloud
        if len(cloud):
            entry["box"] = [
                cloud.positions.min(axis=0).tolist(),
                cloud.positions.max(axis=0).tolist(),
            ]
            entry["points"] = len(cloud)
            share = coverage(cloud, recipe.slm, recipe.wavelength, recipe.coding.passband)
            entry["coverage"] = float(share.mean())
            optics = recipe.slm, recipe.wavelength, recipe.coding.passband
            entry["power"] = float(expected_power(cloud, *optics).sum())
            light = LightMap.of_cloud(cloud, *optics)
            if light is not None:
                entry["light"] = light.as_record()
