"""Names of the objects of a board: in natural order, unique, and listed in a message without flooding it."""

import re
import tarfile
import zipfile
import zlib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TypeAlias

from boards.board import Body
from specs.errors import printable
from specs.finding import Finding, FindingRule
from specs.finding_rules import REPEATED_NAME

_LISTED = 20
_DIGITS = re.compile(r"([0-9]+)")
_ROLES = ("board", "part", "component", "fixture")

_NO_TEXT = re.compile(
    r"\.(?:zip|tgz|tar|gz|7z|rar|z|pdf|png|jpe?g|gif|bmp|tiff?|svg|ico|webp|docx?|xlsx?|pptx?|od[stp]|dxf|dwg|stl|obj|ply"
    r"|wrl|3mf|step|stp|stpz|ige?s|x_t|sldprt|sldasm|glb|gltf|bin|exe|dll|html?|xml|cvg|json|ya?ml|md|log|drl|drd|xln|exc"
    r"|ncd|drr|nc|kicad_\w+|brd|sch|lbr|pcbdoc|schdoc|prjpcb|tri|emn|emp|idf|cad|py|js|css|mp4|mov)$",
    re.IGNORECASE,
)
"""Of files that are read elsewhere, or by nobody."""

_AFFIXES = (re.compile(r"(?<=.)[-_.:@]\d+$"), re.compile(r"^[A-Za-z_]*\d+[-_.:](?=[A-Za-z])"))
"""What tools add to the designators of a board's copies: R1_2, Board_2-R1."""

NaturalKey: TypeAlias = tuple[tuple[str | tuple[int, str], ...], str]


def natural_key(name: str) -> NaturalKey:
    """Key of the natural order of names: U2 before U10."""
    words = enumerate(
        _DIGITS.split(name)
    )  # texts and numbers in turn; a number of any length is compared by its digits
    return tuple((len(plain := word.lstrip("0")), plain) if place % 2 else word for place, word in words), name


def canonical_order(bodies: Iterable[Body]) -> tuple[Body, ...]:
    """Sort bodies by role and then by the natural order of their names: their order in the file has no effect."""
    return tuple(sorted(bodies, key=lambda body: (_ROLES.index(body.role), natural_key(body.name))))


def stem_of(file: Path) -> str:
    """Return a file's name without the suffixes of its format."""
    return file.name.removesuffix(".gz").rpartition(".")[0] or file.name


def may_be_text(name: str) -> bool:
    """Whether a file whose suffix states nothing may be a layer or a table: by its content, which is looked at."""
    return _NO_TEXT.search(name) is None


def some(names: Sequence[str]) -> str:
    """List up to 20 names."""
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return ", ".join(names[:_LISTED]) + more


def listed(rule: FindingRule, names: Sequence[str], text: str) -> list[Finding]:
    """One finding about all of the names, none if there is no name.

    Args:
        rule: Of the finding.
        names: What it is about, in any order.
        text: What follows the number of names; the last ``{}`` stands for the names.
    """
    if not names:
        return []
    before, _, after = text.rpartition("{}")  # a file's name in the text may have braces, too
    return [Finding(rule, f"{len(names)} {before}{some(sorted(names, key=natural_key))}{after}")]


def cause(reason: Exception) -> str:
    """Cause of an exception that a damaged file led to, on one short line and without Python's words for it."""
    match reason:
        case KeyError():
            return f"{str(reason)[:60]} is missing"
        case IndexError():
            return "an index leads beyond the end"
        case RecursionError():
            return "nested too deep"
        case MemoryError():
            return "more than the memory holds"
        case NotImplementedError():
            return "it is packed by a method that is not read here"
        case zipfile.BadZipFile() | tarfile.TarError() | zlib.error() | EOFError():
            return "it is no archive of its kind, or cut short"
        case OSError(strerror=str(words)):
            return words
        case ValueError():
            return printable(" ".join(str(reason)[:200].split())[:100])
        case _:
            return "a value of another kind than expected"


def copy_marks(name: str) -> list[tuple[str, str]]:
    """What may number the copy of a board in the name of a component, with the name without it."""
    hits = ((each.search(name), each) for each in _AFFIXES)
    return [(hit[0], each.sub("", name)) for hit, each in hits if hit is not None]


def distinct_names(names: Sequence[str], places: Sequence[tuple[float | str, ...]]) -> tuple[list[str], list[Finding]]:
    """Make names unique in the order of their places: a second ``R1`` becomes ``R1-2``.

    Returns:
        The names, and one warning if any had to change.
    """
    stated = set(names) | {"board"}
    used: set[str] = {"board"}
    result = list(names)
    changed: list[str] = []
    counts: dict[str, int] = {}
    for number in sorted(range(len(names)), key=places.__getitem__):
        base = names[number]
        name, count = base, counts.get(base, 1)
        while name in used or (name in stated and name != base):
            count += 1
            name = f"{base}-{count}"
        counts[base] = count
        if name != base:
            changed.append(name)
        used.add(name)
        result[number] = name
    return result, listed(REPEATED_NAME, changed, "components share a reference designator and were renamed: {}.")
