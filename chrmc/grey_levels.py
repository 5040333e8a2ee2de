"""A complex field as 8-bit grey levels of an amplitude SLM.

Single sideband: the field keeps |f_y| < 1/4p, a carrier exp(+2πi·y/4p) lifts it to 0 < f_y < 1/2p,
and the real part is taken; what that mirrors to f_y < 0 is blocked in the 4-f system's Fourier
plane, together with the bias. So the signal is s = Re(U·carrier), and the amplitude wanted of the
panel is 0.5 + 0.5·clip(s/scale, −1, 1).

Other encodings of the same carrier, decoded by the same filter and the same scale:

bipolar : Re(U·R*) of a plane reference R = carrier* (Lucente 1993): as above, but without the
    filter, so that what the field has beyond its half band folds over into the image.
burch : 0.5 + 0.5·|U|/peak·cos(arg U + carrier) (Burch 1967): the same signal with the scale at
    the field's largest modulus, so that nothing is clipped and less light is diffracted.
offaxis : |U + R|² of an off-axis reference of modulus `scale`, as interference on a camera gives
    it: 0.25 + 0.5·s/scale + |U|²/4·scale²; the last term is noise around the zero order.
"""

from math import log, sqrt

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from chrmc.encoding import Coding, coding_for
from chrmc.response import GreyResponse
from chrmc.scene.scene import Scene
from chrmc.slm import SLM
from chrmc.survey import survey
from chrmc.threads import workers

SIGMAS = 3.0
"""Signal clipped at this many standard deviations: 0.3 % of pixels, 59 dB in the reconstruction."""

_BLOCK = 32  # rows at a time, so that a block stays in the cache through all its steps


def encode(
    field: NDArray[np.complexfloating],
    slm: SLM,
    method: str = "ssb",
    scale: float | None = None,
    *,
    response: GreyResponse | None = None,
    band_limited: bool = False,
) -> NDArray[np.uint8]:
    """Grey levels that show a field.

    field : (H, W) complex, on the SLM's pixels
    method : "ssb" (single sideband, what the 4-f system decodes), "real" (plain real part),
        "bipolar", "burch" or "offaxis"
    scale : signal at which the grey range ends; one for a whole video (`video_scale`), default
        three standard deviations of this field's own signal, for "burch" its largest modulus.
        A dark field is mid grey
    response : what grey levels do on the panel, default amplitude = grey/255
    band_limited : the field keeps to |f_y| < 1/4p already, so the filter can be left out

    Returns uint8 (H, W). Raises ValueError for NaN, another shape, or a scale that is not positive.
    """
    signal = signal_of(field, slm, method, band_limited)
    if scale is None and method == "burch":
        scale = float(np.abs(field).max())
    elif scale is None:
        scale = SIGMAS * sqrt(float(np.mean(np.square(signal), dtype=np.float64)))
    if method == "offaxis" and scale > 0:
        # What |U + R|² has besides the bias and the signal; −0.25 moves the bias to 0.25.
        modulus2 = np.square(field.real) + np.square(field.imag)
        signal += (modulus2 / (2 * scale) - 0.5 * scale).astype(np.float32)
    return encode_signal(signal, scale, response, in_place=True)


def signal_of(
    field: NDArray[np.complexfloating],
    slm: SLM,
    method: str = "ssb",
    band_limited: bool = False,
) -> NDArray[np.float32]:
    """The real signal of a field, Re(U·carrier), before bias and scale: float32 (H, W)."""
    coding = coding_for(method, slm)
    field = np.asarray(field)
    if field.shape != slm.shape:
        raise ValueError(
            f"field is {field.shape} but {slm.name} has (rows, columns) = {slm.shape}; compute it "
            "on the SLM's own pixels"
        )
    if not np.isfinite(field.sum()) and not np.isfinite(field).all():
        bad = np.count_nonzero(~np.isfinite(field))
        raise ValueError(f"field has {bad} NaN or infinite pixels; every one must be finite")
    if coding.carrier == 0:
        return np.array(field.real, dtype=np.float32)
    field = np.asarray(field, dtype=np.complex64)
    if method == "ssb" and not band_limited:
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
    """The field without frequencies |f_y| ≥ the coding's passband; (H, W) complex64.

    Along y only, and on the SLM's own rows: padding would cut the field off at the edges and so
    bring new frequencies in, where a field that keeps to the band already shall pass unchanged.
    """
    spectrum = scipy.fft.fft(field, axis=0, workers=workers())
    spectrum[np.abs(scipy.fft.fftfreq(slm.height, slm.pixel_pitch)) >= coding.passband.fy_max] = 0
    limited: NDArray[np.complex64] = scipy.fft.ifft(
        spectrum, axis=0, workers=workers(), overwrite_x=True
    )
    return limited


def encode_signal(
    signal: NDArray[np.float32],
    scale: float,
    response: GreyResponse | None = None,
    *,
    in_place: bool = False,
) -> NDArray[np.uint8]:
    """Grey levels of a real signal: 0.5 + 0.5·clip(signal/scale, −1, 1) as amplitude.

    signal : (H, W) float32, Re(U·carrier)
    scale : signal at which the grey range ends; 0 only where the signal is 0 everywhere
    response : default amplitude = grey/255, so grey = rint(255·amplitude)
    in_place : the signal may be used up as working memory

    Returns uint8 (H, W).
    """
    signal = np.asarray(signal)
    if signal.ndim != 2 or signal.dtype != np.float32:
        raise ValueError(
            f"signal must be float32 (rows, columns), not {signal.dtype} {signal.shape}"
        )
    if not (np.isfinite(scale) and scale >= 0):
        raise ValueError(f"scale must be positive, not {scale}")
    if scale == 0:
        if signal.any():
            raise ValueError("scale is 0 but the signal is not: take video_scale of its scene")
        scale = 1.0
    table = None if response is None or response.is_linear else response.table
    half = np.float32(127.5 if table is None else (len(table) - 1) / 2)
    factor = np.float32(half / scale)
    frame = np.empty(signal.shape, dtype=np.uint8)
    work = np.empty((_BLOCK, signal.shape[1]), dtype=np.float32)
    for row in range(0, len(signal), _BLOCK):
        source = signal[row : row + _BLOCK]
        if not np.isfinite(source.sum()) and not np.isfinite(source).all():
            raise ValueError(f"signal has NaN or infinite pixels from row {row} on")
        level = source if in_place else work[: len(source)]
        np.multiply(source, factor, out=level)
        level += half
        np.clip(level, 0, 2 * half, out=level)
        np.rint(level, out=level)
        if table is None:
            frame[row : row + _BLOCK] = level
        else:
            np.take(table, level.astype(np.int32), out=frame[row : row + _BLOCK])
    return frame


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

    sigmas : signal at which the grey range ends, in standard deviations; default 3, for "burch"
        the modulus √(ln N)·rms that fully developed speckle reaches once in the SLM's N pixels
    """
    if sigmas is None:
        peak = sqrt(2 * log(slm.width * slm.height))
        sigmas = peak if coding.name == "burch" else SIGMAS
    return sigmas * sqrt(power / 2)
