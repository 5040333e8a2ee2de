"""Names of a package whose modules are read when they are first asked for."""

from collections.abc import Callable, Mapping
from typing import Any


def lazily(package: str, modules: Mapping[str, str]) -> Callable[[str], Any]:
    """A package's `__getattr__`.

    modules : name → the module that has it
    """

    def get(name: str) -> Any:
        if name in modules:
            from importlib import import_module

            return getattr(import_module(modules[name]), name)
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    return get
