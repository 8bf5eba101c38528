"""Names of the objects of a board: unique, and listed in a message without flooding it."""

from collections.abc import Sequence

from specs.finding import Finding
from specs.finding_rules import REPEATED_NAME

_LISTED = 20


def some(names: Sequence[str]) -> str:
    """List up to 20 names."""
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return ", ".join(names[:_LISTED]) + more


def cause(reason: Exception) -> str:
    """Say what a library stumbled over, on one short line: some exceptions carry the whole file."""
    text = " ".join(str(reason)[:200].split())
    return f"{type(reason).__name__}: {text[:100]}" if text else type(reason).__name__


def distinct_names(wishes: Sequence[str]) -> tuple[list[str], list[Finding]]:
    """Make names unique in file order: a second ``R1`` becomes ``R1-2``.

    Returns:
        The names, and one warning if any had to change.
    """
    taken = set(wishes) | {"board"}
    used: set[str] = {"board"}
    names: list[str] = []
    changed: list[str] = []
    for wish in wishes:
        name, count = wish, 1
        while name in used or (name in taken and name != wish):
            count += 1
            name = f"{wish}-{count}"
        if name != wish:
            changed.append(name)
        used.add(name)
        names.append(name)
    message = f"{len(changed)} components share a reference designator and were renamed: {some(changed)}."
    return names, [Finding(REPEATED_NAME, message)] if changed else []
