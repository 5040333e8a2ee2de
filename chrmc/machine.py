"""What decides the last bits of a sum besides the recipe: the arithmetic of a machine."""

import platform
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version

from threadpoolctl import threadpool_info


@lru_cache(maxsize=1)
def arithmetic() -> dict[str, str]:
    """Versions, and the BLAS with the CPU kernels that it chose here, for manifests."""
    facts = {"python": platform.python_version(), "machine": platform.machine()}
    for package in ("chrmc", "numpy", "scipy"):
        try:
            facts[package] = version(package)
        except PackageNotFoundError:  # run from its source
            facts[package] = "unknown"
    blas = {
        f"{library['internal_api']} {library.get('version')} {library.get('architecture', '')}"
        for library in threadpool_info()
        if library["user_api"] == "blas"
    }
    facts["blas"] = ", ".join(sorted(name.strip() for name in blas))
    return facts
