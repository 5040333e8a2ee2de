"""Random right and wrong pictures, judged: `python tests/reconstruct/confusion.py [SEED [COUNT]]`.

Scenes, places and phases follow from the seed; none was used to set a limit of the verdict. Prints
for every kind how many pass, and what the verdict says of those that it should not have judged so.
"""

import sys
from collections import defaultdict

import numpy as np

from chrmc import SLM, PointCloud, compute_field
from chrmc.encoding import coding_for
from chrmc.optics.resolution import depth_of_focus, resolution
from display import encode
from reconstruct import FourF
from reconstruct.verdict import Target, judge_frame

SLM_, LAMBDA, PITCH = SLM("half", 960, 600, 8.1e-6), 532e-9, 40.5e-6
BAND = coding_for("ssb", SLM_).passband
SYSTEM = FourF(SLM_, LAMBDA)
GOOD = (
    "sparse", "dense", "deep", "far", "surface", "helix", "turntable", "recording", "one", "ten",
)  # fmt: skip
WRONG = (
    "mirrored", "half size", "flattened", "a point", "pseudoscopic", "random points", "noise",
    "shifted", "frame mirrored", "conjugate", "wavelength", "pitch", "next frame",
)  # fmt: skip


def lopsided(random, count, size, z):
    """A slanted letter L with a bump: no symmetry, relief throughout."""
    u = random.uniform(-1, 1, (6 * count, 2))
    corner = random.uniform(-0.4, 0.2, 2)
    u = u[(u[:, 0] < corner[0]) | (u[:, 1] > corner[1] + 0.3)][:count]
    relief = u @ random.uniform(0.4, 1, 2) + 0.4 * np.exp(-8 * ((u - corner) ** 2).sum(axis=1))
    return np.column_stack([size[0] * u[:, 0], size[1] * u[:, 1], z + size[2] * relief])


def bodies(kind, random):
    """The bodies of a good scene, as places (N, 3) and whether their phases are constant."""
    z = random.uniform(0.08, 0.3)
    size = np.array([0.7e-3, 0.5e-3, 0.6e-3]) * random.uniform(0.7, 1.4, 3) * max(1, z / 0.15)
    at = np.append(random.uniform(-1, 1, 2) * 0.4e-3, 0)
    if kind == "sparse":
        return [
            (
                random.uniform(-1, 1, (int(random.integers(12, 60)), 3)) * size + at + (0, 0, z),
                False,
            )
        ]
    if kind == "dense":
        return [(lopsided(random, 8000, size, z) + at, False)]
    if kind == "deep":
        return [(lopsided(random, 1500, size * (1, 1, random.uniform(4, 12)), z) + at, False)]
    if kind == "far":
        z = random.uniform(4, 6)
        return [(lopsided(random, 700, np.array([25e-3, 18e-3, 0.1]), z), False)]
    if kind == "surface":
        return [(lopsided(random, 6000, size, z) + at, True)]
    if kind == "helix":
        t = np.linspace(0, 2 * np.pi * random.uniform(1, 2.5), int(random.integers(80, 400)))
        ring = np.column_stack([np.cos(t), np.sin(t), np.linspace(-2, 2, len(t))])
        return [(ring * size + at + (0, 0, z), True)]
    if kind == "turntable":
        u = random.standard_normal((5000, 3))
        u /= np.linalg.norm(u, axis=1)[:, None]
        turn, _ = np.linalg.qr(random.standard_normal((3, 3)))
        u = (u * (1, 0.5, 0.3)) @ turn.T
        return [(u[u[:, 2] < 0] * 0.7e-3 * max(1, z / 0.15) + at + (0, 0, z), False)]
    if kind == "recording":
        places = lopsided(random, 1500, size, z) + at
        places[:, :2] = np.rint(places[:, :2] / PITCH) * PITCH
        places[:, 2] = np.rint(places[:, 2] / 1e-4) * 1e-4
        return [(np.unique(places, axis=0), False)]
    if kind == "one":
        return [(np.array([[*random.uniform(-1e-3, 1e-3, 2), z]]), False)]
    places = []
    for k in range(10):
        where = ((k % 5 - 2) * 0.7e-3, (k // 5 - 0.5) * 1.2e-3, z + random.uniform(-5e-3, 5e-3))
        places.append((lopsided(random, 200, np.array([0.2e-3, 0.2e-3, 0.4e-3]), 0) + where, False))
    return places


def cloud_of(places, constant, random):
    phase = np.zeros(len(places)) if constant else random.uniform(0, 2 * np.pi, len(places))
    return PointCloud(places, np.ones(len(places)), phase)


def spoiled(kind, clouds, random):
    """(clouds, wavelength, pitch) that a wrong picture is made with."""
    wavelength, pitch, out = LAMBDA, SLM_.pixel_pitch, []
    for cloud in clouds:
        p, c = cloud.positions.copy(), cloud.centroid
        if kind == "next frame":
            a = 0.35
            turn = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
            p = c + (p - c) @ turn.T + (0.15e-3, 0, 0)
        elif kind == "random points":
            p = random.uniform(p.min(axis=0), p.max(axis=0), (100, 3))
            p += c - p.mean(axis=0)
        else:
            factors = {
                "mirrored": (-1, 1, 1), "half size": (0.5,) * 3, "flattened": (1, 1, 0),
                "a point": (0, 0, 0), "pseudoscopic": (1, 1, -1),
            }.get(kind, (1, 1, 1))  # fmt: skip
            p = c + (p - c) * factors
        if kind == "shifted":
            p = p + random.choice([-1, 1], 3) * np.array([0, 0, 0.6e-3 + deepness(c[2])])
        out.append(cloud_of(p, False, random))
    if kind == "wavelength":
        wavelength *= random.choice([0.85, 1.2])
    if kind == "pitch":
        pitch *= random.choice([0.9, 1.1])
    return out, wavelength, pitch


def deepness(z):
    """A depth of focus: shifts smaller than half of it are passed on purpose."""
    return max(depth_of_focus(SLM_, LAMBDA, z, BAND))


def frame_of(clouds, wavelength=LAMBDA, pitch=SLM_.pixel_pitch, kind="", random=None):
    slm = SLM("s", SLM_.width, SLM_.height, pitch)
    band = coding_for("ssb", slm).passband
    field = compute_field(
        PointCloud.concatenate(clouds), slm, wavelength, "curved", passband=band, tolerance=1e-2
    )
    if kind == "noise":
        more = (
            random.standard_normal((2, *field.shape)) * 3 * np.sqrt(np.mean(np.abs(field) ** 2) / 2)
        )
        field = (field + more[0] + 1j * more[1]).astype(np.complex64)
    if kind == "conjugate":
        field = field.conj()
    frame = encode(field, slm)
    return np.ascontiguousarray(frame[:, ::-1]) if kind == "frame mirrored" else frame


def judged(clouds, frame):
    targets = [Target.of_cloud(f"body {k}", cloud, SYSTEM) for k, cloud in enumerate(clouds)]
    found = judge_frame(frame, SYSTEM, targets, PITCH)
    return found.passed, found.faults + [f for o in found.objects for f in o.faults]


def told(cloud, kind):
    """Whether a wrong kind differs from the right one by more than what can be resolved."""
    z = cloud.centroid[2]
    size = np.ptp(cloud.positions, axis=0)
    fine = max(resolution(SLM_, LAMBDA, z, BAND))
    if kind in ("flattened", "pseudoscopic"):
        return size[2] > 3 * deepness(z)
    return min(size[:2]) > 16 * fine


def trial(seed, count, good=GOOD, wrong=WRONG):
    """{kind: [(passed, what is said)]} of right and of wrong pictures."""
    right, bad = defaultdict(list), defaultdict(list)
    for number in range(count):
        random = np.random.default_rng([seed, number])
        for kind in good:
            clouds = [cloud_of(places, same, random) for places, same in bodies(kind, random)]
            right[kind].append(judged(clouds, frame_of(clouds)))
        kinds = ("dense", "deep", "turntable", "recording")
        clouds = [cloud_of(p, c, random) for p, c in bodies(kinds[number % len(kinds)], random)]
        for kind in wrong:
            if told(clouds[0], kind):
                other, wavelength, pitch = spoiled(kind, clouds, random)
                frame = frame_of(other, wavelength, pitch, kind, random)
                bad[kind].append(judged(clouds, frame))
    return right, bad


def main(seed=1, count=4):
    right, bad = trial(seed, count)
    misjudged = 0
    for name, found, wanted in (("right", right, True), ("wrong", bad, False)):
        print(f"{name:16} {'passed':>7} {'failed':>7}")
        for kind, outcomes in found.items():
            passed = sum(ok for ok, _ in outcomes)
            print(f"  {kind:14} {passed:7d} {len(outcomes) - passed:7d}")
            for ok, said in outcomes:
                if ok is not wanted:
                    misjudged += 1
                    print(f"    {'passed' if ok else '; '.join(said)}")

    return misjudged > 0


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
