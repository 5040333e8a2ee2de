"""A complex field as 8-bit grey levels of a panel.

Single sideband: the field keeps |f_y| < 1/4p, a carrier exp(+2πi·y/4p) lifts it to 0 < f_y < 1/2p,
and the real part is taken; what that mirrors to f_y < 0 is blocked in the 4-f system's Fourier
plane, together with the bias. So the signal is s = Re(U·carrier), and the amplitude wanted of the
panel is 0.5 + 0.5·clip(s/scale, −1, 1). `chrmc.encodings` has this and the other encodings.
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.encoding import Coding, coding_for
from chrmc.panels import encoding_for
from chrmc.parallel import in_parallel
from chrmc.ranges import real
from chrmc.response import GreyResponse
from chrmc.scene.scene import Scene
from chrmc.slm import SLM
from chrmc.survey import survey
from chrmc.threads import workers

_LEAST, _MOST = 1e-15, 1e15  # of a field: its square must be a normal float32
_BLOCK = 32  # rows at a time, so that a block stays in the cache through all its steps


def encode(
    field: NDArray[np.complexfloating],
    slm: SLM,
    method: str | None = None,
    scale: float | None = None,
    *,
    response: GreyResponse | None = None,
    band_limited: bool = False,
) -> NDArray[np.uint8]:
    """Grey levels that show a field.

    field : (H, W) complex, on the SLM's pixels
    method : one of `chrmc.encoding.CODINGS`, such as "ssb" (single sideband); default the usual
        one of the panel's kind
    scale : signal at which the grey range ends; one for a whole video (`video_scale`), default
        the encoding's own of this field, mostly three standard deviations of its signal. A dark
        field is mid grey
    response : what grey levels do on the panel, default amplitude = grey/255
    band_limited : the field keeps to the passband already, so the filter can be left out

    The levels are those that the SLM's `bits` allow, 2^bits of them spread over 0 … 255.

    Returns uint8 (H, W). Raises ValueError for NaN, another shape, or a scale that is not positive.
    """
    coding = coding_for(method or encoding_for(slm), slm)
    field = check_field(field, slm)
    if coding.limits and not band_limited:
        field = limit_band(field.astype(np.complex64), slm, coding)
    signal = signal_of(field, slm, method, band_limited=True)
    if scale is None:
        scale = _own_scale(coding, field, signal)
    if not (np.isfinite(scale) and scale >= 0):
        raise ValueError(f"scale must be positive, not {scale}")
    if coding.levels is not None:
        return coding.levels(field, signal, scale, slm, response)
    return encode_signal(signal, scale, response, in_place=True, bits=slm.bits)


def scale_for(field: NDArray[np.complexfloating], slm: SLM, method: str | None = None) -> float:
    """The scale that `encode` takes for a single field; 0 for a dark one."""
    coding = coding_for(method or encoding_for(slm), slm)
    return _own_scale(coding, check_field(field, slm), signal_of(field, slm, method))


def _own_scale(
    coding: Coding, field: NDArray[np.complexfloating], signal: NDArray[np.float32]
) -> float:
    if coding.own_scale is not None:
        return coding.own_scale(field, signal)
    return coding.sigmas * sqrt(float(np.mean(np.square(signal), dtype=np.float64)))


def check_field(field: NDArray[np.complexfloating], slm: SLM) -> NDArray[np.complexfloating]:
    """The field as an array, or ValueError unless it has the SLM's pixels and all are finite."""
    field = np.asarray(field)
    if field.shape != slm.shape:
        raise ValueError(
            f"field is {field.shape} but {slm.name} has (rows, columns) = {slm.shape}; compute it "
            "on the SLM's own pixels"
        )
    if field.dtype.kind not in "cfiu":
        raise ValueError(f"field must be an array of numbers, not of {field.dtype}")
    peak = max(float(np.abs(part).max(initial=0)) for part in (field.real, field.imag))
    if not np.isfinite(peak):
        bad = np.count_nonzero(~np.isfinite(field))
        raise ValueError(f"field has {bad} NaN or infinite pixels; every one must be finite")
    if peak > 0 and not _LEAST <= peak <= _MOST:
        raise ValueError(
            f"the field reaches {peak:.3g}, outside {_LEAST:g} to {_MOST:g}, where single "
            "precision is safe: multiply it by a number"
        )
    return field


def signal_of(
    field: NDArray[np.complexfloating],
    slm: SLM,
    method: str | None = None,
    band_limited: bool = False,
) -> NDArray[np.float32]:
    """The real signal of a field, Re(U·carrier), before bias and scale: float32 (H, W)."""
    coding = coding_for(method or encoding_for(slm), slm)
    field = check_field(field, slm)
    if coding.carrier == 0:
        return np.array(field.real, dtype=np.float32)
    field = np.asarray(field, dtype=np.complex64)
    if coding.limits and not band_limited:
        field = limit_band(field, slm, coding)
    cycles = coding.carrier * slm.y()
    turn = 2 * np.pi * (cycles - np.rint(cycles))[:, None]
    cosine, sine = np.cos(turn).astype(np.float32), np.sin(turn).astype(np.float32)
    signal = np.empty(slm.shape, dtype=np.float32)
    work = np.empty((_BLOCK, slm.width), dtype=np.float32)
    for row in range(0, slm.height, _BLOCK):
        part = slice(row, row + _BLOCK)
        out = signal[part]
        product = work[: len(out)]
        np.multiply(field.real[part], cosine[part], out=out)
        np.multiply(field.imag[part], sine[part], out=product)
        out -= product
    return signal


def limit_band(field: NDArray[np.complex64], slm: SLM, coding: Coding) -> NDArray[np.complex64]:
    """The field without frequencies beyond the coding's passband; (H, W) complex64.

    On the SLM's own rows and columns: padding would cut the field off at the edges and so bring
    new frequencies in, where a field that keeps to the band already shall pass unchanged.
    """
    import scipy.fft  # takes a while

    limited = np.asarray(field, dtype=np.complex64)
    for axis, edge in ((0, coding.passband.fy_max), (1, coding.passband.fx_max)):
        beyond = np.abs(scipy.fft.fftfreq(slm.shape[axis], slm.pixel_pitch)) >= edge
        if edge >= slm.nyquist:
            continue
        spectrum = scipy.fft.fft(limited, axis=axis, workers=workers())
        spectrum[beyond if axis == 0 else (slice(None), beyond)] = 0
        limited = scipy.fft.ifft(spectrum, axis=axis, workers=workers(), overwrite_x=True)
    return limited


def encode_signal(
    signal: NDArray[np.float32],
    scale: float,
    response: GreyResponse | None = None,
    *,
    in_place: bool = False,
    bits: int = 8,
) -> NDArray[np.uint8]:
    """Grey levels of a real signal: 0.5 + 0.5·clip(signal/scale, −1, 1) as amplitude.

    signal : (H, W) float32, Re(U·carrier)
    scale : signal at which the grey range ends; 0 only where the signal is 0 everywhere
    response : default amplitude = grey/255, so grey = rint(255·amplitude)
    in_place : the signal may be used up as working memory
    bits : grey-level depth of the panel: 2^bits levels, spread evenly over 0 … 255

    Returns uint8 (H, W).
    """
    signal = np.asarray(signal)
    if signal.ndim != 2 or signal.dtype != np.float32:
        raise ValueError(
            f"signal must be float32 (rows, columns), not {signal.dtype} {signal.shape}"
        )
    scale = real("scale", scale)
    if not (scale == 0 or 1e-30 <= scale <= 1e30):
        raise ValueError(f"scale must be a positive number, 1e-30 to 1e30, not {scale:g}")
    if scale == 0:
        if signal.any():
            raise ValueError("scale is 0 but the signal is not: take video_scale of its scene")
        scale = 1.0
    if response is not None and response.tilt is not None:
        wanted = np.float32(0.5) + signal * np.float32(0.5 / scale)
        if not np.isfinite(wanted).all():
            raise ValueError("signal has NaN or infinite pixels")
        found = response.grey(wanted)
        if bits >= 8:
            return found
        allowed = allowed_levels(bits)
        return allowed[np.rint(found / 255 * (len(allowed) - 1)).astype(int)]
    table = None if response is None or response.is_linear else response.table
    # What the nearest step of the amplitude becomes; none is needed where it is the grey itself.
    lookup = table
    if bits < 8:
        allowed = allowed_levels(bits)
        steps = len(allowed) - 1
        lookup = allowed if table is None else allowed[np.rint(table / 255 * steps).astype(int)]
    half = np.float32(127.5 if lookup is None else (len(lookup) - 1) / 2)
    factor = np.float32(half / scale)
    frame = np.empty(signal.shape, dtype=np.uint8)

    def encode_rows(part: range) -> None:
        work = np.empty((_BLOCK, signal.shape[1]), dtype=np.float32)
        for row in part:
            source = signal[row : row + _BLOCK]
            if not np.isfinite(source.sum()) and not np.isfinite(source).all():
                raise ValueError(f"signal has NaN or infinite pixels from row {row} on")
            level = source if in_place else work[: len(source)]
            np.multiply(source, factor, out=level)
            level += half
            np.clip(level, 0, 2 * half, out=level)
            np.rint(level, out=level)
            if lookup is None:
                frame[row : row + _BLOCK] = level
            else:
                np.take(lookup, level.astype(np.int32), out=frame[row : row + _BLOCK])

    rows = range(0, len(signal), _BLOCK)
    cores = workers()
    in_parallel(encode_rows, [rows[first::cores] for first in range(cores)])
    return frame


def allowed_levels(bits: int) -> NDArray[np.uint8]:
    """The (2^bits,) grey levels of a panel of so many bits, spread evenly over 0 … 255.

    Frames hold 8 bits, so a panel of more gets 256 levels.
    """
    if bits < 1:
        raise ValueError(f"a panel has at least 1 bit of grey, not {bits}")
    count = 1 << min(bits, 8)
    return np.rint(np.arange(count) * 255 / (count - 1)).astype(np.uint8)


def video_scale(
    scene: Scene, slm: SLM, wavelength: float, coding: Coding, sigmas: float | None = None
) -> float:
    """One scale for a whole video, from its points alone; 0 for a scene without light.

    The scene's brightest frame counts, whichever frames are to be made: clips, resumed and live
    runs agree. See `chrmc.survey` for the frames looked at, `scale_of` for the rest.
    """
    return scale_of(survey(scene, slm, wavelength, coding).power, slm, coding, sigmas)


def scale_of(power: float, slm: SLM, coding: Coding, sigmas: float | None = None) -> float:
    """The scale of a video whose brightest frame has the mean intensity `power`.

    Points of random phase add in power, so that frame's signal is expected to have the variance
    power/2.

    sigmas : signal at which the grey range ends, in standard deviations; default the encoding's
    """
    return (coding.sigmas if sigmas is None else sigmas) * sqrt(power / 2)
