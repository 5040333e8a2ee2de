"""Groups of frames that are all compensated from the group's first, block by block.

What MPEG-NLUT and 3DMC-NLUT share. The reference frame is computed whole. Its objects' images are
cut into square blocks; each block's points have a hologram of their own if the block moves in
any frame of the group, or else go into one hologram with all that stand still. A general frame
shifts each block's hologram by the block's vector, computes the strips that come in from
outside, and takes out and puts in the points that then differ. Where far more light would be taken
out than the frame shows, it is computed whole: what is gone leaves its rounding.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh import Method
from chrmc.compensation.frame import VideoFrame
from chrmc.compensation.held import (
    WORN,
    Computer,
    Correction,
    Held,
    Matcher,
    correct,
    objects_of,
)
from chrmc.compensation.nlut.blocks import (
    Image,
    crop,
    depth_vector,
    grid_index,
    grid_offset,
    image_of,
    lateral_vector,
)
from chrmc.compensation.shift import Move, lens, lens_axis, moved, shift_into, strips, to_pixels
from chrmc.encoding import Coding
from chrmc.record import FrameRecord
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import ObjectFrame, Scene, SceneFrame
from chrmc.slm import SLM


@dataclass(frozen=True)
class Search:
    """How blocks and their vectors are found.

    size : frames in a group, the reference included
    block : side of a block, scene pixels
    lateral : longest vector per axis, scene pixels
    planes : longest vector in depth, planes; 0 for none
    measure : "sad" or "mse"
    """

    size: int
    block: int
    lateral: int
    planes: int
    measure: str

    def __post_init__(self) -> None:
        for name, value, least in (
            ("group", self.size, 1),
            ("block", self.block, 1),
            ("search", self.lateral, 0),
            ("search_planes", self.planes, 0),
        ):
            if value < least:
                raise ValueError(f"{name} must be at least {least}, not {value}")


@dataclass(frozen=True, eq=False)
class Block:
    """Points of the reference frame that move together.

    name : of their object; at : (row, column) of the block's first pixel on the scene's grid
    """

    name: str
    at: tuple[int, int]
    points: Held


@dataclass(frozen=True, eq=False)
class Moving:
    """One frame of a group: where the blocks go and what is corrected then.

    whole : it is computed afresh, and nothing goes anywhere
    """

    scene_frame: SceneFrame
    moves: list[Move]
    carried: list[PointCloud]
    corrections: list[Correction]
    shown: PointCloud
    whole: bool


@dataclass(frozen=True, eq=False)
class Group:
    """A reference frame's blocks and, made when first needed, their holograms."""

    frame: SceneFrame
    blocks: list[Block]
    alone: list[bool]  # which blocks need a hologram of their own
    computer: Computer
    record: FrameRecord

    @cached_property
    def fields(self) -> tuple[NDArray[np.complex64], dict[int, NDArray[np.complex64]]]:
        """The hologram of all blocks that stand still, and those of the others."""
        still = PointCloud.concatenate(
            b.points.cloud for b, alone in zip(self.blocks, self.alone, strict=True) if not alone
        )
        return self.computer.change(still, self.record, "HC"), {
            i: self.computer.change(block.points.cloud, self.record, "HC")
            for i, (block, alone) in enumerate(zip(self.blocks, self.alone, strict=True))
            if alone
        }

    def reference(self) -> NDArray[np.complex64]:
        """The field of the group's first frame."""
        still, moving = self.fields
        total = still.copy()
        for field in moving.values():
            total += field
        return self.computer.settled(total, self.frame.cloud, self.record)

    def general(self, frame: Moving, record: FrameRecord) -> NDArray[np.complex64]:
        """The field of another frame."""
        computer = self.computer
        if frame.whole:
            return computer.compute(frame.shown, record, "HC")
        still, moving = self.fields
        slm = computer.slm
        total = still.copy()
        for i, field in moving.items():
            block, move, carried = self.blocks[i].points.cloud, frame.moves[i], frame.carried[i]
            with record.stage("RMC"):
                if not move.depth:
                    shift_into(total, field, move)
                else:
                    shifted = np.zeros_like(field)
                    shift_into(shifted, field, move)
                    x, y, z = lens_axis(block, move, slm)
                    in_y, in_x = lens(slm, computer.wavelength, (x, y), z, move.depth)
                    shifted *= in_y[:, None]
                    shifted *= in_x
                    total += shifted
            for window in strips(move, slm):
                total[window.slices] += computer.change(carried, record, "HC", window)
        change = PointCloud.concatenate(c.signed for c in frame.corrections)
        if len(change):
            total += computer.change(change, record, "EC")
        return computer.settled(total, frame.shown, record)


def group_frames(
    scene: Scene,
    slm: SLM,
    wavelength: float,
    cgh: str | Method,
    numbers: range,
    coding: Coding,
    search: Search,
    matching: str | None,
    options: dict[str, Any],
) -> Iterator[VideoFrame]:
    """The frames of all groups, one after the other."""
    matcher = Matcher.of(scene, matching)
    computer = Computer(slm, wavelength, cgh, coding.passband, options)
    for start in range(0, len(numbers), search.size):
        group, general = next_group(scene, numbers[start:], matcher, computer, search)
        yield VideoFrame(group.frame, group.record, group.reference)
        for frame, own in general:
            make = partial(group.general, frame, own)
            yield VideoFrame(frame.scene_frame, own, make, shown=frame.shown)


def next_group(
    scene: Scene, numbers: range, matcher: Matcher, computer: Computer, search: Search
) -> tuple[Group, list[tuple[Moving, FrameRecord]]]:
    """The first group of some frames, none of whose fields is made yet."""
    first, *others = numbers[: search.size]
    record = FrameRecord(first)
    with record.stage("PE"):
        reference = scene.frame(first)
        blocks = [b for obj in reference.objects for b in _cut(obj, matcher, search)]
    general = []
    for number in others:
        own = FrameRecord(number, key=False)
        with own.stage("PE"):
            frame = _compensate(scene.frame(number), blocks, matcher, computer, search)
        own.key = frame.whole
        _book(own, frame, computer)
        general.append((frame, own))
    alone = [any(frame.moves[i] for frame, _ in general) for i in range(len(blocks))]
    everything = Correction(PointCloud.empty(), reference.cloud)
    computer.book(record, everything)
    return Group(reference, blocks, alone, computer, record), general


def _cut(obj: ObjectFrame, matcher: Matcher, search: Search) -> list[Block]:
    """An object's points by the square blocks of the scene's grid that they lie in."""
    held = Held.of(obj)
    if len(held) == 0:
        return []
    row, column = grid_index(
        held.cloud, matcher.pixel_pitch, grid_offset(obj.cloud, matcher.pixel_pitch)
    )
    corner = np.stack([row, column], axis=1) // search.block
    corners, which = np.unique(corner, axis=0, return_inverse=True)
    which = which.reshape(-1)
    return [
        Block(
            obj.name,
            (int(at[0]) * search.block, int(at[1]) * search.block),
            held.select(np.flatnonzero(which == i)),
        )
        for i, at in enumerate(corners)
    ]


def _compensate(
    scene_frame: SceneFrame,
    blocks: list[Block],
    matcher: Matcher,
    computer: Computer,
    search: Search,
) -> Moving:
    """Where each block went, and what is wrong then."""
    moves = [Move()] * len(blocks)
    carried = [block.points.cloud for block in blocks]
    corrections, shown = [], []
    reference = {block.name: block.points for block in blocks}
    for obj in objects_of(scene_frame, reference):
        own = [i for i, block in enumerate(blocks) if block.name == obj.name]
        vector = _vectors(obj, matcher, computer.slm, search)
        parts = []
        for i in own:
            moves[i] = vector(blocks[i])
            part = Held(
                moved(carried[i], moves[i], computer.slm, computer.wavelength),
                blocks[i].points.ids,
            )
            part = computer.visible(part)
            carried[i] = part.cloud
            parts.append(part)
        held = _join(parts, obj)
        after, correction = correct(held, obj, matcher)
        corrections.append(correction)
        shown.append(after.cloud)
    everything = PointCloud.concatenate(shown)
    taken = sum(computer.light(correction.removed) for correction in corrections)
    whole = taken > WORN * computer.light(everything)
    if whole:
        moves, carried = [Move()] * len(blocks), [PointCloud.empty()] * len(blocks)
        corrections = [Correction(PointCloud.empty(), everything)]
    return Moving(scene_frame, moves, carried, corrections, everything, whole)


def _join(parts: list[Held], obj: ObjectFrame) -> Held:
    if not parts:
        return Held.empty(obj)
    known = [part.ids for part in parts if part.ids is not None]
    ids = np.concatenate(known) if len(known) == len(parts) else None
    return Held(PointCloud.concatenate(part.cloud for part in parts), ids)


def _vectors(
    obj: ObjectFrame, matcher: Matcher, slm: SLM, search: Search
) -> Callable[[Block], Move]:
    """The function that finds a block's move into the object's present image."""
    if len(obj.cloud) == 0:
        return lambda block: Move()
    if obj.ids is not None:
        return partial(_known, obj=obj, slm=slm, search=search)
    offset = grid_offset(obj.cloud, matcher.pixel_pitch)
    image = image_of(obj.cloud, matcher.pixel_pitch, matcher.plane_spacing, offset)
    return partial(_searched, image=image, offset=offset, matcher=matcher, slm=slm, search=search)


def _known(block: Block, obj: ObjectFrame, slm: SLM, search: Search) -> Move:
    """The median displacement of points of known identity."""
    if block.points.ids is None or obj.ids is None:
        return Move()
    _, i, j = np.intersect1d(block.points.ids, obj.ids, return_indices=True)
    if len(i) == 0:
        return Move()
    apart = obj.cloud.positions[j] - block.points.cloud.positions[i]
    dx, dy, dz = np.median(apart, axis=0)
    return to_pixels(dx, dy, slm, dz if search.planes else 0.0)


def _searched(
    block: Block,
    image: Image,
    offset: tuple[float, float],
    matcher: Matcher,
    slm: SLM,
    search: Search,
) -> Move:
    """The move under which a block's intensities, then its depth slices, meet the image."""
    pitch, spacing = matcher.pixel_pitch, matcher.plane_spacing
    own = image_of(block.points.cloud, pitch, spacing, offset)
    shape = (search.block, search.block)
    intensity, plane = crop(own, *block.at, shape)
    rows, columns = lateral_vector(intensity, block.at, image, search.lateral, search.measure)
    planes = 0
    if search.planes:
        there = crop(image, block.at[0] + rows, block.at[1] + columns, shape)
        planes = depth_vector(intensity, plane, *there, search.planes)
    return to_pixels(columns * pitch, rows * pitch, slm, planes * spacing)


def _book(record: FrameRecord, frame: Moving, computer: Computer) -> None:
    size = computer.slm.width * computer.slm.height
    for correction in frame.corrections:
        computer.book(record, correction)
    blanks = [sum(w.size for w in strips(move, computer.slm)) for move in frame.moves]
    for blank, cloud in zip(blanks, frame.carried, strict=True):
        record.point_pixels += blank * len(cloud)
    record.blank_share = float(np.mean(blanks)) / size if blanks else 0.0
