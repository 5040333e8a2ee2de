"""What a generator must know of an amplitude encoding: the passband it leaves and its carrier."""

from dataclasses import dataclass

from chrmc.optics.passband import Passband, full_band
from chrmc.slm import SLM


@dataclass(frozen=True)
class Coding:
    """An encoding as the generator sees it.

    name : one of CODINGS
    passband : what the complex field may occupy before the carrier is put on
    carrier : frequency of exp(+2πi·carrier·y), cycles per metre; 0 for none
    needs_field : the grey levels follow from the complex field, not from Re(field·carrier) alone
    """

    name: str
    passband: Passband
    carrier: float
    needs_field: bool = False


CODINGS = ("ssb", "real", "bipolar", "burch", "offaxis")


def coding_for(name: str, slm: SLM) -> Coding:
    """The coding called `name` on `slm`.

    "ssb": single sideband across the motion: |f_y| < 1/4p, carrier 1/4p in y.
    "real": the plain in-line real part, full band, no carrier.
    "bipolar", "burch", "offaxis": of the same passband and carrier as "ssb", so that the same
    Fourier filter decodes them; `display.encode` says what sets them apart.
    """
    if name == "real":
        return Coding("real", full_band(slm), 0.0)
    if name in CODINGS:
        half = Passband(slm.nyquist, slm.nyquist / 2)
        return Coding(name, half, slm.nyquist / 2, needs_field=name == "offaxis")
    raise ValueError(f"unknown encoding {name!r}: choose one of {', '.join(CODINGS)}")
