"""The CH-RMC paper's own numbers, recomputed from what it prints (Optics Express 26, 2018).

Each claim compares a printed value with what the paper's other values and equations give. It is
consistent where the two agree to the digits printed.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import asin, atan2, cos, degrees, hypot, pi, radians, sin, tan

from chrmc.compensation.ch_rmc_paper.conversion import RADIUS, one_pixel_distance, sagitta
from chrmc.scene.circles import paper_angle, paper_circle, turn_angle
from chrmc.scene.motion import local_offsets
from chrmc.slm import LC_R_1080, WAVELENGTH

PITCH = LC_R_1080.pixel_pitch
WIDTH = LC_R_1080.width * PITCH

# Section 3.3, centimetres: centre (x, z), radius, three positions of the car.
ARCS = {
    "C1": ((20.52, 46.38), 31.36, ((46.42, 28.69), (46.29, 28.51), (46.14, 28.44))),
    "C2": ((14.36, 85.74), 73.48, ((31.35, 25.23), (31.14, 25.09), (30.92, 25.01))),
    "C3": ((1.31, 64.89), 35.06, ((1.02, 24.89), (0.81, 24.95), (0.62, 25.02))),
}
# Section 3.3: printed d in centimetres (the second for the arcs printed twice), two angles.
DISTANCES = {"C1": (31.89, 31.90), "C2": (71.26,), "C3": (50.41,)}
ANGLES = {"C1": (0.301, 0.304), "C2": (0.301, 0.302), "C3": (0.302, 0.305)}
# Section 4.1: seconds per stage PE, PA, CON, RMC, HC, EC, their printed percentages, and totals.
STAGES = ("PE", "PA", "CON", "RMC", "HC", "EC")
SECONDS = {
    "RT": (0.03361, 0.26921, 0.02113, 0.01192, 22.12, 110.24),
    "WRP": (0.03454, 0.27017, 0.02079, 0.01147, 1.45, 2.12),
    "NLUT": (0.03372, 0.26958, 0.02136, 0.01136, 1.42, 7.13),
}
SHARES = {
    "RT": (0.03, 0.2, 0.016, 0.01, 16.67, 83.07),
    "WRP": (0.89, 6.93, 0.53, 0.29, 37.18, 54.36),
    "NLUT": (0.38, 3.03, 0.24, 0.13, 15.97, 80.20),
}
# Original and CH-RMC seconds per frame, printed reduction in per cent; the same for points.
TIMES = {"RT": (424.83, 132.70, 68.75), "WRP": (7.72, 3.90, 50.82), "NLUT": (26.61, 8.89, 66.59)}
POINTS = {"RT": (1208, 325, 73.10), "WRP": (1208, 316, 73.84), "NLUT": (1208, 322, 73.34)}
# Table 2: printed growth in per cent of the points of the linear methods over the NLUT's 1208.
GROWTH = {"MC-NLUT": 27.65, "MPEG-NLUT": 63.66, "3DMC-NLUT": 76.24}
# Section 3.4: depth in metres and the conversion table's value there.
TABLE = ((2.19e-7, 0.45 + 0.89j), (4.37e-7, -0.60 + 0.80j), (6.54e-7, -0.98 - 0.17j))


@dataclass(frozen=True)
class Claim:
    """One printed value. text : what it is; printed, recomputed : with units; note : why not."""

    text: str
    printed: str
    recomputed: str
    consistent: bool
    note: str = ""

    def __str__(self) -> str:
        verdict = "consistent    " if self.consistent else "NOT consistent"
        line = f"{verdict}  {self.text}: printed {self.printed}, recomputed {self.recomputed}"
        return f"{line} ({self.note})" if self.note else line


def claims() -> list[Claim]:
    """Every claim, in the paper's order."""
    return [
        *_conversion(),
        *_arcs(),
        *_scene(),
        *_table_values(),
        *_rotation(),
        *_table_1(),
        *_table_2(),
    ]


def _near(printed: float, value: float, digit: float) -> bool:
    """Equal to within one unit of the last printed digit."""
    return abs(printed - value) <= digit * (1 + 1e-9)


def _conversion() -> Iterator[Claim]:
    z = one_pixel_distance(PITCH, WAVELENGTH)
    yield Claim(
        "z at which W(z) = p (Eq. 6)", "246 µm", f"{z * 1e6:.1f} µm", _near(246, z * 1e6, 1)
    )
    z0 = sagitta(RADIUS, WIDTH)
    yield Claim(
        "z0 (Eq. 9) at R = 14.5 cm", "209 µm", f"{z0 * 1e6:.2f} µm", _near(209, z0 * 1e6, 1)
    )
    radius = (209e-6**2 + (WIDTH / 2) ** 2) / (2 * 209e-6)
    yield Claim(
        "R from z0 = 209 µm", "14.5 cm", f"{radius * 100:.2f} cm", _near(14.5, radius * 100, 0.1)
    )


def _arcs() -> Iterator[Claim]:
    for name, (centre, radius, points) in ARCS.items():
        fitted = paper_circle(*points).radius
        yield Claim(
            f"{name}: radius of the circle through the three printed points",
            f"{radius} cm",
            f"{fitted:.3g} cm",
            _near(radius, fitted, 0.01),
            "a step of 2 mm has a sagitta of µm, its points are printed to 0.1 mm",
        )
        distance = hypot(points[0][0] - centre[0], points[0][1] - centre[1])
        yield Claim(
            f"{name}: from the printed centre to the first point",
            f"{radius} cm",
            f"{distance:.2f} cm",
            _near(radius, distance, 0.01),
        )
        for k, printed in enumerate(ANGLES[name]):
            pair = points[k], points[k + 1]
            angle = degrees(abs(float(turn_angle(centre, *pair))))
            by_heights = degrees(paper_angle(centre, *pair))
            yield Claim(
                f"{name}: angle of step {k + 1} about the printed centre",
                f"{printed}°",
                f"{angle:.3f}°, by Eqs 2–4 {by_heights:.3f}°",
                _near(printed, angle, 0.001),
            )
        d, offset = (100 * v for v in local_offsets([c / 100 for c in centre], RADIUS, WIDTH))
        for printed in DISTANCES[name]:
            yield Claim(
                f"{name}: d = z_O − R + z0",
                f"{printed} cm",
                f"{d:.2f} cm",
                _near(printed, d, 0.005),
            )
        yield Claim(
            f"{name}: l = x_O",
            f"{centre[0]} cm",
            f"{offset:.2f} cm",
            _near(centre[0], offset, 0.005),
        )


def _scene() -> Iterator[Claim]:
    limit = degrees(asin(WAVELENGTH / (2 * PITCH)))
    (x, z) = ARCS["C1"][2][0]
    off = degrees(atan2(x, z))
    yield Claim(
        "direction of the car at frame 1 within what the SLM diffracts to",
        f"x = {x} cm, z = {z} cm",
        f"{off:.0f}° off axis, the SLM reaches {limit:.2f}°",
        off <= limit,
    )
    l1, d1 = ARCS["C1"][0][0], DISTANCES["C1"][0]
    ratio = sin(atan2(l1, d1)) / sin(radians(limit))
    yield Claim(
        "lateral position adjustment within the SLM's band",
        f"l1 = {l1} cm over d1 = {d1} cm",
        f"{ratio:.1f} times the band",
        ratio <= 1,
    )
    every = [p for _, _, points in ARCS.values() for p in points]
    for axis, unit, room, what in ((0, "x", 32.0, "320 × 1 mm"), (1, "z", 2.55, "256 × 0.1 mm")):
        used = max(p[axis] for p in every) - min(p[axis] for p in every)
        yield Claim(
            f"the car's path in {unit} fits the image's range",
            what,
            f"path spans {used:.2f} cm of {room:.4g} cm",
            used <= room,
        )
    yield Claim(
        "house reconstructed within its depth range",
        "264 mm, range 264.8–272.1 mm",
        "0.8 mm in front of it",
        264.8 <= 264 <= 272.1,
    )
    for frame, printed, name in ((21, 252, "C2"), (51, 249, "C3")):
        depth = ARCS[name][2][0][1] * 10
        yield Claim(
            f"car reconstructed at frame {frame}",
            f"{printed} mm",
            f"{depth:.1f} mm",
            _near(printed, depth, 1),
        )
    pixels = (2240 - LC_R_1080.width) / 320
    yield Claim(
        "PFP of (1920 + 320) × (1200 + 240) pixels for object pixels of 1 mm",
        "1 mm",
        f"{pixels:.0f} hologram pixel = {pixels * PITCH * 1e6:.1f} µm per object pixel",
        _near(1e-3, pixels * PITCH, 1e-4),
    )


def _table_values() -> Iterator[Claim]:
    k = 2 * pi / WAVELENGTH
    for z, printed in TABLE:
        value = complex(cos(k * z), sin(k * z))
        yield Claim(
            f"T_conv = exp(ikz) at z = {z:.3g} m",
            f"{printed.real:.2f}{printed.imag:+.2f}i",
            f"{value.real:.2f}{value.imag:+.2f}i",
            abs(printed - value) < 0.02,
        )
    z0 = sagitta(RADIUS, WIDTH)
    edge = WIDTH / 2
    depths = [z0 - RADIUS + (RADIUS**2 - (edge - (i + 0.5) * PITCH) ** 2) ** 0.5 for i in range(3)]
    yield Claim(
        "z(x, y) of the first three columns (Eq. 8)",
        ", ".join(f"{z * 1e6:.3f}" for z, _ in TABLE) + " µm",
        ", ".join(f"{z * 1e6:.3f}" for z in depths) + " µm",
        all(_near(z * 1e6, d * 1e6, 0.01) for (z, _), d in zip(TABLE, depths, strict=True)),
        "printed values step by half a pixel",
    )


def _rotation() -> Iterator[Claim]:
    shift = RADIUS * radians(0.3)
    yield Claim(
        "0.3° in radians", "0.0052", f"{radians(0.3):.4f}", _near(0.0052, radians(0.3), 1e-4)
    )
    yield Claim("R·θ at 0.3°", "759 µm", f"{shift * 1e6:.1f} µm", _near(759, shift * 1e6, 1))
    yield Claim("R·θ in pixels", "93", f"{shift / PITCH:.1f}", _near(93, shift / PITCH, 1))
    share = 100 * 1827 / 1920
    yield Claim(
        "overlap of 1827 of 1920 columns", "95.16 %", f"{share:.2f} %", _near(95.16, share, 0.01)
    )
    blank = 100 * 93 / 1920
    yield Claim("blank of 93 columns", "4.84 %", f"{blank:.2f} %", _near(4.84, blank, 0.01))
    yield Claim("width of the blank in section 3.7", "97 columns", "93 columns", False)
    ratio = 100 * 93 / 1827
    yield Claim("blank over overlap, average", "6 %", f"{ratio:.1f} %", _near(6, ratio, 0.5))
    true = tan(radians(0.3)) * ARCS["C1"][0][1] / 100 / PITCH
    yield Claim(
        "blank at the hologram plane itself on C1",
        "93 columns",
        f"{true:.0f} columns",
        _near(93, true, 1),
        "light sweeps the OPH by z_O·θ, not R·θ",
    )


def _table_1() -> Iterator[Claim]:
    for name, seconds in SECONDS.items():
        total, printed_total = sum(seconds), TIMES[name][1]
        yield Claim(
            f"{name}: stages add up to the frame's time",
            f"{printed_total:.2f} s",
            f"{total:.3f} s",
            _near(printed_total, total, 0.01),
        )
        for stage, part, printed in zip(STAGES, seconds, SHARES[name], strict=True):
            value = 100 * part / printed_total
            yield Claim(
                f"{name}: share of {stage}",
                f"{printed:g} %",
                f"{value:.3g} %",
                _near(printed, value, 0.01),
            )
    for text, table in (("points", POINTS), ("time", TIMES)):
        values = []
        for name, (before, after, printed) in table.items():
            values.append(100 * (1 - after / before))
            yield Claim(
                f"{name}: {text} per frame reduced",
                f"{printed:.2f} %",
                f"{values[-1]:.2f} %",
                _near(printed, values[-1], 0.015),
            )
        mean, printed = sum(values) / 3, 73.43 if text == "points" else 62.05
        yield Claim(
            f"average reduction of {text}",
            f"{printed:.2f} %",
            f"{mean:.2f} %",
            _near(printed, mean, 0.01),
        )
    fold = SHARES["WRP"][4] / ((SHARES["RT"][4] + SHARES["NLUT"][4]) / 2)
    yield Claim(
        "WRP: share of HC over the other methods'",
        "2.35-fold",
        f"{fold:.2f}-fold",
        _near(2.35, fold, 0.01),
    )


def _table_2() -> Iterator[Claim]:
    for name, printed in GROWTH.items():
        points = round(1208 * (1 + printed / 100))
        value = 100 * (points / 1208 - 1)
        yield Claim(
            f"{name}: growth of points is that of a whole number over 1208",
            f"{printed:.2f} %",
            f"{points} points, {value:.2f} %",
            _near(printed, value, 0.01),
        )
