"""Compare the compensated object with the actual one, and name the points that differ (Eq. 14).

Rules, stated wherever a number depends on them:
    strict    same pixel, same depth plane, intensity within 2/255 of full scale
    tolerant  same pixel, depth within one plane, intensity within 5 % of full scale
Points of known identity are compared with themselves, within half a pixel and half a plane (one
and a half under "tolerant"); others by the pixel and plane that they fall into.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chrmc.scene.points import PointCloud

SNR_THRESHOLD = 30.0
"""The paper's limit in dB above which no correction is made."""


@dataclass(frozen=True)
class Rule:
    """planes : depth planes that may lie between; intensity : share of full scale"""

    planes: int
    intensity: float


RULES = {"strict": Rule(0, 2 / 255), "tolerant": Rule(1, 0.05)}


@dataclass(frozen=True, eq=False)
class Matching:
    """Compensated points against actual ones.

    wrong : (P,) compensated points that the actual image does not have
    missing : (A,) actual points that the compensated image does not have
    pairs : (K, 2) compensated and actual points in one place, whatever their intensity
    """

    wrong: NDArray[np.bool_]
    missing: NDArray[np.bool_]
    pairs: NDArray[np.intp]


def rule_named(name: str) -> Rule:
    """The matching rule of a name."""
    if name not in RULES:
        raise ValueError(f"unknown matching rule {name!r}: choose one of {', '.join(RULES)}")
    return RULES[name]


def match(
    compensated: PointCloud,
    actual: PointCloud,
    rule: Rule,
    pixel_pitch: float,
    plane_spacing: float,
    ids: tuple[NDArray[np.intp], NDArray[np.intp]] | None = None,
) -> Matching:
    """Pair the points of two clouds under a rule.

    pixel_pitch, plane_spacing : of the scene's images, metres
    ids : the identities of the compensated and the actual points where they are known
    """
    if ids is not None:
        pairs = _by_identity(compensated, actual, rule, pixel_pitch, plane_spacing, *ids)
    else:
        pairs = _by_pixel(compensated, actual, rule, pixel_pitch, plane_spacing)
    full = max(
        compensated.intensity.max(initial=0.0),
        actual.intensity.max(initial=0.0),
        np.finfo(float).tiny,
    )
    contrast = compensated.intensity[pairs[:, 0]] - actual.intensity[pairs[:, 1]]
    same = pairs[np.abs(contrast) <= rule.intensity * full * (1 + 1e-9)]
    wrong, missing = np.ones(len(compensated), bool), np.ones(len(actual), bool)
    wrong[same[:, 0]] = False
    missing[same[:, 1]] = False
    return Matching(wrong, missing, pairs)


def _by_identity(
    compensated: PointCloud,
    actual: PointCloud,
    rule: Rule,
    pixel_pitch: float,
    plane_spacing: float,
    compensated_ids: NDArray[np.intp],
    actual_ids: NDArray[np.intp],
) -> NDArray[np.intp]:
    _, i, j = np.intersect1d(compensated_ids, actual_ids, return_indices=True)
    apart = np.abs(compensated.positions[i] - actual.positions[j])
    near = (apart[:, :2] <= pixel_pitch / 2).all(axis=1)
    near &= apart[:, 2] <= (0.5 + rule.planes) * plane_spacing
    return np.stack([i[near], j[near]], axis=1)


def _by_pixel(
    compensated: PointCloud,
    actual: PointCloud,
    rule: Rule,
    pixel_pitch: float,
    plane_spacing: float,
) -> NDArray[np.intp]:
    if len(compensated) == 0 or len(actual) == 0:
        return np.zeros((0, 2), dtype=np.intp)
    # The actual points lie on the image's grid: any of them tells where it is.
    step = np.array([pixel_pitch, pixel_pitch, plane_spacing])
    origin = actual.positions[0]
    c = np.rint((compensated.positions - origin) / step).astype(np.int64)
    a = np.rint((actual.positions - origin) / step).astype(np.int64)
    low = min(c[:, 0].min(), a[:, 0].min())
    width = max(c[:, 0].max(), a[:, 0].max()) - low + 1
    c_key, a_key = c[:, 1] * width + c[:, 0] - low, a[:, 1] * width + a[:, 0] - low
    keys, first = np.unique(a_key, return_index=True)
    slot = np.minimum(np.searchsorted(keys, c_key), len(keys) - 1)
    j = first[slot]
    planes = np.abs(c[:, 2] - a[j, 2])
    i = np.flatnonzero((keys[slot] == c_key) & (planes <= rule.planes))
    # One partner each: the nearest plane, then the nearest intensity.
    contrast = np.abs(compensated.intensity[i] - actual.intensity[j[i]])
    i = i[np.lexsort((contrast, planes[i]))]
    _, best = np.unique(j[i], return_index=True)
    i = i[best]
    return np.stack([i, j[i]], axis=1).astype(np.intp)


def snr(compensated: PointCloud, actual: PointCloud, matching: Matching) -> float:
    """Eq. 14 in dB: 10·log10(ΣN² / Σ(N − M)²), N the compensated image, M the actual one.

    N and M are intensities. Light in one pixel but on planes that don't match counts as two
    lights, N² + M²: an image of intensity alone would not see a wrong depth. +inf for no
    difference, −inf where nothing was compensated.
    """
    n, m = compensated.intensity, actual.intensity
    i, j = matching.pairs.T
    signal = float(np.sum(n**2))
    alone = float(np.sum(np.delete(n, i) ** 2) + np.sum(np.delete(m, j) ** 2))
    noise = alone + float(np.sum((n[i] - m[j]) ** 2))
    if noise == 0:
        return np.inf
    return float(10 * np.log10(signal / noise)) if signal > 0 else -np.inf
