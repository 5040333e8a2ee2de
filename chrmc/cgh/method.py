"""What a CGH method is, and where each is found: one file for a method, one line here."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.counts import OperationCounts
from chrmc.options import check_options, meant, option_names
from chrmc.python_file import from_python_file, is_python_name
from chrmc.ranges import short

FieldFunction = Callable[..., NDArray[np.complex64]]
"""(cloud, slm, wavelength, window, passband, **options) → complex64 (H, W) on the window."""


@dataclass(frozen=True, eq=False)
class CGHMethod:
    """What a CGH method offers; only `field` is asked for.

    field : (cloud, slm, wavelength, window, passband, **options) → complex64 (H, W), the sum
        Σ w·a/r·exp(i(kr + φ)), absolutely scaled
    signal : the same with a coding in place of the passband → float32 (H, W), the coded
        Re(field·exp(+2πi·carrier·y)) for less work than the field takes
    field_and_error, signal_and_error : the same, and the relative L2 error that the method
        expects of it, None where it knows of none
    one_by_one : `field` where that judges waves by what is left of them: each computed by itself,
        as for points that a hologram is changed by
    cost : (cloud, slm, wavelength, window, passband, **options) → what a frame takes, an
        `OperationCounts`, its cache being warm
    waves : (cloud, slm, wavelength, rows, columns, passband, **options) → complex128 (N, K), each
        point's wave at K pixels of its own, as the method forms it: what errors are expected from
    rounding : relative error that single precision adds
    shares_cores : whether all cores work on a frame, BLAS being at one thread
    new_cache : makes what the option `cache` takes, to be held for a whole video
    settings : its options from coarse to fine, as benches compare them
    """

    field: FieldFunction
    signal: Callable[..., NDArray[np.float32]] | None = None
    field_and_error: Callable[..., tuple[NDArray[np.complex64], float | None]] | None = None
    signal_and_error: Callable[..., tuple[NDArray[np.float32], float | None]] | None = None
    one_by_one: FieldFunction | None = None
    cost: Callable[..., OperationCounts] | None = None
    waves: Callable[..., NDArray[np.complex128]] | None = None
    rounding: float = 0.0
    shares_cores: bool = True
    new_cache: Callable[[], Any] | None = None
    settings: tuple[Mapping[str, Any], ...] = ({},)

    @property
    def name(self) -> str:
        """What it is registered as, else what its function is called."""
        for name, module in METHODS.items():
            if module == self.field.__module__:
                return name
        return getattr(self.field, "__name__", "a function")

    def takes(self, option: str) -> bool:
        """Whether `field` has an option of that name, or passes all on."""
        names, others = option_names(self.field)
        return others or option in names

    def check(self, options: Mapping[str, Any]) -> None:
        """ValueError for an option that it does not take, which says what methods do."""
        check_options(
            f"CGH method {self.name}",
            self.field,
            options,
            lambda option: [name for name in METHODS if method_named(name).takes(option)],
        )

    def with_cache(self, options: dict[str, Any]) -> dict[str, Any]:
        """The options, with a cache to hold for a whole video where the method takes one."""
        if self.new_cache is None or "cache" in options:
            return options
        return {**options, "cache": self.new_cache()}


Method = CGHMethod | FieldFunction
"""What stands for a method wherever a name does: a plain function has no more than its field."""

# name: the module that says what it is in `METHOD`
METHODS = {
    "curved": "chrmc.cgh.curved",
    "rt": "chrmc.cgh.rt",
    "fresnel": "chrmc.cgh.fresnel",
    "wrp": "chrmc.cgh.wrp",
    "nlut": "chrmc.cgh.nlut",
    "nlut-1d": "chrmc.cgh.nlut_1d",
}

DEFAULT_METHOD = "curved"
"""Taken where none is named, and as the exact one where methods are compared."""


def method_named(method: str | Method) -> CGHMethod:
    """The method of a name, of FILE.py:NAME, or of a function."""
    if is_python_name(method):
        method = from_python_file(method)
        if not (isinstance(method, CGHMethod) or callable(method)):
            raise ValueError(f"a CGH method is a function or a CGHMethod, not {short(method)}")
    if isinstance(method, CGHMethod):
        return method
    if callable(method):
        return CGHMethod(method)
    if method not in METHODS:
        raise ValueError(
            f"unknown CGH method {method!r}{meant(method, METHODS)}: "
            f"choose one of {', '.join(METHODS)}"
        )
    found: CGHMethod = import_module(METHODS[method]).METHOD
    return found
