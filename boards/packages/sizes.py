"""The sizes that the name of a package states: its body, its pitch, its balls, its exposed pad."""

import re
from dataclasses import dataclass
from functools import lru_cache


@dataclass(frozen=True, slots=True)
class PackageSizes:
    """What a name such as ``QFN-32-1EP_5x5mm_P0.5mm_EP3.45x3.45mm`` states. mm; ``None`` where it does not."""

    body_mm: tuple[float, float] | None
    """Across the rows of leads and along them, as KiCad orders them; not stated by IPC-7351, which gives the span."""
    pitch_mm: float | None
    ball_mm: float | None
    layout: tuple[int, int] | None
    """Columns and rows of a grid."""
    pad_mm: tuple[float, float] | None
    """The exposed pad, in the order of the body."""
    has_pad: bool | None
    """Whether there is an exposed pad; ``None`` where the name is too short."""


FINEST_MM = 0.2
"""No pitch of what is soldered to boards is finer."""

_WIDEST_MM = 2.6
"""No pitch of what is soldered flat is wider; ``P8MM`` means 0.8 mm to some and is ignored."""

LONGEST_TEXT = 2000
"""Characters of a name or a description that are read: patterns are searched for at each of them."""

_NUMBER = r"(\d{1,2}(?:\.\d{1,4})?)"
_BODY = re.compile(rf"(?:^|[-_ ]){_NUMBER}x{_NUMBER}(?:x[\d.]+)?mm")
_BARE_BODY = re.compile(
    r"(?:q[fn]|so[nip]|sop|dfn|bga|lga).*?[-_ ](\d{1,2}(?:[.p]\d{1,3})?)x(\d{1,2}(?:[.p]\d{1,3})?)(?![\dp.x])"
)
_PITCH = re.compile(rf"(?:^|[-_ ])p{_NUMBER}mm")
_IPC = re.compile(r"^[a-z]{3,7}(\d{2,3})p(\d{2,4})x(\d{2,4})x\d{2,4}-")
_IPC_LEADLESS = re.compile(r"^[a-z]*(?:qfn|son|bga|lga|dfn)")
_BALL = re.compile(rf"ball{_NUMBER}mm")
_LAYOUT = re.compile(r"layout(\d{1,2})x(\d{1,2})(?![\dy])")
_PAD = re.compile(rf"[-_ ]ep{_NUMBER}x{_NUMBER}(?:mm)?")
_HAS_PAD = re.compile(
    r"\dep(?![a-z])|[-_ ]ep[\d_-]|power-?pad|^(?:h[tvlms]?s{1,2}op|hsoic|hso[p-]|h[tlv]qf?p|hmsop|htqfp)"
)


@lru_cache(maxsize=4096)
def package_sizes(package: str) -> PackageSizes:
    """Read the sizes out of a package's name: KiCad's and those of IPC-7351."""
    name = without_library(package).lower()
    ipc = _IPC.search(name)
    pitch = _first(_PITCH, name) or (int(ipc[1]) / 100.0 if ipc else None)
    body = _pair(_BODY, name) or _pair(_BARE_BODY, name)
    if body is None and ipc and _IPC_LEADLESS.search(name):
        body = (int(ipc[2]) / 100.0, int(ipc[3]) / 100.0)
    layout = _LAYOUT.search(name)
    pad = _pair(_PAD, name)
    stated = pad is not None or _HAS_PAD.search(name) is not None
    return PackageSizes(
        body_mm=body,
        pitch_mm=pitch if pitch and FINEST_MM <= pitch <= _WIDEST_MM else None,
        ball_mm=_first(_BALL, name) or None,
        layout=(int(layout[1]), int(layout[2])) if layout else None,
        pad_mm=pad,
        has_pad=True if stated else False if _PITCH.search(name) else None,
    )


def without_library(package: str) -> str:
    """Name of a package without the library before its colon; ``MICROSD_1:1`` states a scale and stays as it is."""
    library, _, name = package[:LONGEST_TEXT].rpartition(":")
    is_scale = bool(library) and len(name) <= 3 and not any(map(str.isalpha, name))
    return (f"{library}:{name}" if is_scale else name).strip()


def _first(pattern: re.Pattern[str], name: str) -> float | None:
    found = pattern.search(name)
    return float(found[1]) if found else None


def _pair(pattern: re.Pattern[str], name: str) -> tuple[float, float] | None:
    found = pattern.search(name)
    if found is None or not (_number(found[1]) and _number(found[2])):
        return None
    return _number(found[1]), _number(found[2])


def _number(text: str) -> float:
    """Read a number that may have ``P`` for its point, as in ``8X12P5``."""
    return float(text.replace("p", "."))
