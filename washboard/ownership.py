"""Whose the packages are that would be imported: other distributions, and folders, may bear the same names."""

from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path

PACKAGES = (
    "specs", "geometry", "boards", "programs", "recipes", "cleaning", "robotcell", "rulesengine", "reports", "studies",
    "webui", "commandline",
)  # fmt: skip
MARKER = b'DISTRIBUTION = "washboard"'
"""A line in the ``__init__`` of each of them."""
_ADVICE = "Install washboard in an environment of its own, with `pipx install` or `uv tool install`."


def find_foreign() -> str | None:
    """Look for a package of ours that is somebody else's, without importing any.

    Returns:
        One sentence: which, where, and what to do; ``None`` where all are ours.
    """
    home = Path(__file__).parents[1]
    for name in PACKAGES:
        spec = PathFinder.find_spec(name)
        origin = None if spec is None else spec.origin
        if spec is None or origin is None:
            return _missing(name, home, spec)
        folder = Path(origin).parent
        if folder.parent.resolve() != home.resolve():
            return (
                f"the package {name!r} in {folder} is not washboard's and would be read in place of that in {home}. "
                f"Start washboard in another folder and without PYTHONPATH. {_ADVICE}"
            )
        if not _is_ours(spec, origin):
            return (
                f"the package {name!r} in {folder} is not washboard's: {_owner(name)} has put its own in that place. "
                f"{_ADVICE}"
            )
    return None


def _missing(name: str, home: Path, spec: ModuleSpec | None) -> str:
    """Sentence about a package of which nothing, or no more than a folder, is there."""
    there = "is missing" if spec is None else "has no __init__.py"
    return f"the package {name!r} of washboard {there} in {home}: something else has removed it. {_ADVICE}"


def _is_ours(spec: ModuleSpec, origin: str) -> bool:
    read = getattr(spec.loader, "get_data", None)  # a folder's loader has it, and that of an archive
    try:
        return read is not None and MARKER in read(origin)
    except OSError:
        return False


def _owner(name: str) -> str:
    """Name the distributions that have installed a package of this name, besides ours."""
    from importlib.metadata import packages_distributions

    others = sorted(set(packages_distributions().get(name, ())) - {"washboard"})
    return f"the distribution {', '.join(others)}" if others else "something else"
