"""Which program computes: its version, and a hash of the code and data that results depend on."""

import hashlib
from collections.abc import Iterator
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from specs.input_file import own_text

_PACKAGES = (
    "boards", "cleaning", "geometry", "programs", "recipes", "reports", "robotcell", "rulesengine", "specs", "studies",
)  # fmt: skip
"""Of ours, below ``studies``."""
_LIBRARIES = (
    "EAIK", "coal", "contourpy", "embreex", "manifold3d", "numba", "numpy", "potpourri3d", "scipy", "shapely", "ssik",
    "toppra", "trimesh",
)  # fmt: skip
"""Whose numbers go into results."""
_KINDS = (".py", ".yaml")
_LETTERS = 16


@cache
def program_version() -> str:
    """Give the version and a fingerprint, as ``0.1.0+1f2e3d4c5b6a7980``: equal where the same code computes.

    It holds every module and table of the packages that compute, and the versions of the numerical libraries.
    """
    digest = hashlib.sha256()
    for name, content in (*_own(), *((each, _version(each)) for each in _LIBRARIES)):
        digest.update(f"{name}\0{hashlib.sha256(content.encode()).hexdigest()}\n".encode())
    return f"{_version('washboard')}+{digest.hexdigest()[:_LETTERS]}"


def _own() -> Iterator[tuple[str, str]]:
    """Give name and text of our files, in alphabetical order."""
    root = Path(__file__).parents[1]
    for package in _PACKAGES:
        files = sorted(each.relative_to(root / package) for each in (root / package).rglob("*"))
        for file in files:
            if file.suffix in _KINDS:
                yield f"{package}/{file.as_posix()}", own_text(package, str(file))


def _version(library: str) -> str:
    try:
        return version(library)
    except PackageNotFoundError:
        return ""
