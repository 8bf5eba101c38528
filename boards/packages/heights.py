"""Height of a body from what a layout file states of it: the one precedence of its sources.

A name such as ``CP_Axial_L18.0mm_D6.5mm_P25.00mm_Horizontal`` states sizes, and what it states comes first. Then come a
3-D model of the same family whose name states them, the family of the package, that of the model, and the sizes in a
description. What nothing knows is taken for tall, so that the nozzle stays clear of it.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, TypeAlias

from boards.packages.families import (
    LONGEST_TEXT,
    PackageFamily,
    normalise,
    other_chip,
    package_families,
    package_family,
)

HeightSource: TypeAlias = Literal["stated", "name", "model", "family", "description", "assumed"]

TALL_LEADED_MM = 25.0
"""Assumed of a part that nothing is known about, if its leads go through the board or may do so."""

TALL_FLAT_MM = 12.0
"""The most that is assumed of a part that is soldered flat: SMD cans and transformers."""

_LEAST_FLAT_MM = 2.0
_FLAT_SLENDERNESS = 2.0
"""Cans, the most slender parts that are soldered flat, are less than twice as high as they are long."""

_FAR = 3.0
"""Times the height that name or family give: no maker's part is that much higher."""

_DEFAULTS_MM = (25.4, 50.8, 76.2, 100.0, 127.0, 254.0)
"""Heights that layout tools write for what was never measured: 1000, 2000, 3000, 5000 and 10000 mil, and 100 mm."""

_SAME_MM = 0.01
_RANGE_MM = (0.1, 100.0)
"""No body is lower; 0 and 1 mil are what layout tools write for what was never measured, too."""

_ACCESSORY = re.compile(
    r"heat-?_?sink|cooler|(?<![a-z])(?:screw|nut|washer|stand-?off|spacer|bracket|clip|fan)(?![a-z])", re.IGNORECASE
)
"""Names of models of what is mounted on or beside a part: they do not show the body that is soldered."""

_LONGEST_CODE = 24
_SEATED_MM = 0.25
"""Sizes of a body lack the gap beneath it: a family's seated height that is larger by no more than this is taken."""


@dataclass(frozen=True, slots=True)
class BodyHeight:
    """Height of a body above the board's surface."""

    height_mm: float
    source: HeightSource
    reason: str
    """Such as ``name states D6.5mm`` or ``family SOIC (JEDEC MS-012)``."""


@dataclass(frozen=True, slots=True)
class HeightEvidence:
    """What a layout file states of a part without its height."""

    package: str
    reference: str = ""
    """Reference designator: a capacitor may stand on the lands of a chip resistor."""
    models: tuple[str, ...] = ()
    """File names of its 3-D models at their own scale."""
    description: str = ""
    through_hole: bool = True
    """Whether it has, or may have, leads through the board."""
    length_mm: float = 0.0
    """Longer side of its outline; 0 if unknown."""


@dataclass(frozen=True, slots=True)
class CheckedHeight:
    """The height that counts where a file states one, compared with what its names state."""

    height: BodyHeight
    doubt: str = ""
    """Why the stated height is not believed, or cannot have been measured; empty where it is believed."""


@dataclass(frozen=True, slots=True)
class _Rule:
    """One way in which names state a height."""

    pattern: re.Pattern[str]
    height_mm: Callable[[Sequence[float]], float]
    """Of the numbers that the pattern caught."""
    is_body: bool = False
    """Whether the height is the body's alone, without the gap beneath it."""


_N = r"(\d{1,3}(?:\.\d{1,4})?|\.\d{1,4})"
_LEAD_BEND_MM = 3.5
"""A part on one end: 1 mm under it, 1 mm of straight lead above, the bend and the lead (IPC-2222, IEC 61188)."""

_COATING_MM = 5.0
"""A disc on its leads: the coating runs down them, and the maker's tolerance of the diameter."""


def _rule(pattern: str, height_mm: Callable[[Sequence[float]], float] = lambda n: n[0], *, body: bool = False) -> _Rule:
    return _Rule(re.compile(pattern.replace("N", _N)), height_mm, body)


def _hundredths(numbers: Sequence[float]) -> float:
    return numbers[0] / 100.0


def _on_end(numbers: Sequence[float]) -> float:
    return numbers[0] + _LEAD_BEND_MM


_RULES = (
    # IPC-7351: pitch P span X [span X] height in hundredths of a millimetre, then the pins.
    _rule(r"^[a-z]{3,7}\d+p\d+x(?:\d+x)?(\d{2,4})(?:-\d+)?[abclmn]*$", _hundredths),
    _rule(r"^[a-z]{3,7}\d+c\d+p\d+x\d+-\d+x\d+x(\d{2,4})[abclmn]*$", _hundredths),
    _rule(r"^(?:cap|res|ind|led|dio|fus|bead|thrm|var)[a-z]*\d{3,4}x(\d{2,4})[abclmn]*$", _hundredths),
    # Height after H: `CP_Radial_D10.0mm_H20.0mm`, `L_12x12mm_H4.5mm`, of inductors without a unit too, `L_6.3x6.3_H3`;
    # the H of a LED is seen from its front, that of a resonator from the top, that of an encoder is its shaft's.
    _rule(r"^(?!led|resonator|rotary).*?(?<![a-z])h-?N-?mm(?![a-z])"),
    _rule(r"^(?:l|ind[a-z]*|inductor)-.*?-hN(?![\w.])"),
    # `CP_EIA-3216-18` in tenths; `CP_Elec_8x10.5`: diameter by height; other cans: the larger of the two.
    _rule(r"\beia-?\d{4}-(\d\d)\b", lambda n: n[0] / 10.0),
    _rule(r"\beia-?\d{4}-(\d{3})\b", _hundredths),
    _rule(r"\b(?:cp?|smd)-elec-[\d.]+xN(?!\d)"),
    _rule(r"^(?:e-?cap|elko|alu|cp|c-?pol|cap-?pol|cap-?alu)(?!-axial).*?(?<![\d.])NxNmm(?![a-z]|x)", max),
    _rule(r"^(?:buzzer|speaker)[a-z-]*-[\d.]+xN(?!\d)"),
    # Length, width and height of a body in millimetres: `3.95x5.21x3.27mm`, `5.0 x 3.2 x 1.1 mm`, `7x7x1.4`.
    _rule(rf"(?<![a-z0-9.]){_N}(?:-?mm)?-?x-?{_N}(?:-?mm)?-?x-?N-?mm(?![a-z])", lambda n: n[2], body=True),
    _rule(r"(?<![a-z0-9.])\d{1,2}(?:\.\d+)?x\d{1,2}(?:\.\d+)?x(\d{1,2}\.\d{1,2})(?![\d.a-z]|-\d*mil)", body=True),
    # Lying on the board: as high as it is thick. Standing on one end: its length and the bend of a lead.
    _rule(r"-lN(?:mm)?(?=-).*vert", _on_end),
    _rule(r"(?<![a-z0-9])0[2-9](\d\d)/\d+v", _on_end),
    _rule(r"^(?!led).*-d-?N(?:mm)?-l[\d.].*horiz"),
    _rule(r"-l[\d.]+(?:mm)?-dN(?:mm)?(?=-).*horiz"),
    _rule(r"axial-(?:power|shunt).*-l[\d.]+(?:mm)?-wN(?:mm)?(?=-)", lambda n: n[0] + 1.5),
    _rule(r"^(?:r-)?0([2-9])\d\d/\d+$", lambda n: n[0] + 0.7),
    _rule(r"axial-din0([2-9])\d\d(?!.*-[ld]\d)(?!.*vert)", lambda n: n[0] + 0.7),
    # Discs and toroids on edge; light-emitting diodes on their leads.
    _rule(r"(?:^|-)disc-dN(?:mm)?", lambda n: n[0] + _COATING_MM),
    _rule(r"toroid-vert[a-z]*-lN(?:mm)?", lambda n: n[0] + 2.0),
    _rule(r"^led-dN(?:mm)?(?=-).*horiz.*-zN", lambda n: n[0] + n[1] + 1.0),
    _rule(r"^led-dN(?:mm)?(?=-|$)", lambda n: n[0] + 4.5),
    # Inductors by length and height in tenths: NR8040, SRN6028, MAPI-4020, XAL5030.
    _rule(
        r"(?:^|-)(?:nr[sv]?|srn|srp|sru|srr|mapi|xal|xfl|xel|lps|mss|vlf|nlv)-?\d\d(\d\d)(?!\d)",
        lambda n: n[0] / 10.0 + 0.3,
    ),
)

_IN_WORDS = (
    _rule(r"height(?:-of)?-?[=:]?-?N-?mm"),
    _rule(rf"(?<![a-z0-9.]){_N}(?:-?mm)?-?[x*]-?{_N}(?:-?mm)?-?[x*]-?N-?mm(?![a-z^])", lambda n: n[2], body=True),
)


def body_height(evidence: HeightEvidence) -> BodyHeight:
    """Height of a part's body from the first source that has one: name, model, family, description; else tall.

    A model's name that states a height comes before the family of the package if the model is of the same family.
    """
    family = _family_of(evidence, evidence.package)
    found = _stated(evidence.package, family, "name")
    if found is not None:
        return found
    files = (re.split(r"[\\/]", model)[-1] for model in evidence.models)
    stems = (re.sub(r"\.(?:wrl|wrz|step|stp|igs|iges|glb)(?:\.gz)?$", "", file, flags=re.I) for file in files)
    own_kind = _ACCESSORY.search(evidence.package) is not None
    models = [(name, _family_of(evidence, name)) for name in stems if own_kind or not _ACCESSORY.search(name)]
    for name, own in models:
        same = family is None or (own is not None and own.name == family.name)
        found = _stated(name, own, "model") if same else None
        if found is not None:
            return found
    if family is not None:
        return _of_family(family, evidence, "family")
    own = next((own for _, own in models if own is not None and own.has_body), None)
    if own is not None:
        return _of_family(own, evidence, "model")
    text = normalise(re.sub(r"<[^>]*>", " ", evidence.description[:LONGEST_TEXT]).replace(":", " "))
    hit = next(_hits(_IN_WORDS, re.sub(r"(?<=\d),(?=\d)", ".", text)), None)
    if hit is not None:  # in words, or as three sizes
        return BodyHeight(hit[0] + _SEATED_MM * hit[2], "description", f"description, {hit[1]}")
    return BodyHeight(_tall(evidence), "assumed", "assumed tall")


def checked_height(stated_mm: float | None, evidence: HeightEvidence) -> CheckedHeight:
    """Height of a body that the file may state: believed unless it contradicts what its names give.

    A stated height is not believed that is more than three times that of the names, less than a third of one in the
    name, below 0.1 mm, or a layout tool's default above that of the names. Where nothing is known, a default is kept.
    """
    found = body_height(evidence)
    if stated_mm is None:
        return CheckedHeight(found)
    is_default = any(abs(stated_mm - mm) < _SAME_MM for mm in _DEFAULTS_MM)
    known = found.source != "assumed"
    low_mm = found.height_mm / _FAR if found.source == "name" else min(_RANGE_MM[0], found.height_mm / _FAR)
    high = known and (stated_mm > _FAR * found.height_mm or (is_default and stated_mm > found.height_mm))
    if high or stated_mm < low_mm:
        return CheckedHeight(found, f"{stated_mm:g} mm stated, {found.height_mm:g} mm taken: {found.reason}")
    stated = BodyHeight(stated_mm, "stated", "stated")
    default = f"{stated_mm:g} mm stated, a layout tool's default, kept"
    return CheckedHeight(stated, default if is_default and not known else "")


def length_in(text: str) -> float | None:
    """Read a length such as ``4.5``, ``4,5 mm`` or ``177 mil``, in mm; ``None`` where it is none above zero."""
    found = re.fullmatch(r"(\d{1,4}(?:[.,]\d{1,6})?|[.,]\d{1,6})\s*(mm|mils?|thou|in|inch|\")?", text.strip().lower())
    if found is None:
        return None
    scale = {"mm": 1.0, "": 1.0, "in": 25.4, "inch": 25.4, '"': 25.4}.get(found[2] or "", 0.0254)
    return float(found[1].replace(",", ".")) * scale or None


def _family_of(evidence: HeightEvidence, name: str) -> PackageFamily | None:
    """Family of a name as far as the part itself agrees with it."""
    family = package_family(name)
    if family is None:
        return None
    if family.name == "PLCC" and evidence.through_hole and evidence.length_mm > 0.0:
        return next(row for row in package_families() if row.name == "PLCC socket")
    letters = re.match(r"[A-Za-z]*", evidence.reference)
    # R and what begins with it: RN and RP are networks of resistors.
    return family if letters is None or letters[0][:1].upper() in ("", "R") else other_chip(family)


@lru_cache(maxsize=4096)
def _stated(name: str, family: PackageFamily | None, source: HeightSource) -> BodyHeight | None:
    if family is not None and not family.has_body:
        return None
    text = re.sub(r"(?<=\d),(?=\d)", ".", normalise(name))
    hit = next(_hits(_RULES, text), None)
    if hit is None:
        return None
    height_mm, words, is_body = hit
    if is_body and family is not None and height_mm <= family.height_mm <= height_mm + _SEATED_MM:
        return BodyHeight(family.height_mm, source, f"{source} states {words}, seated as family {family.name}")
    return BodyHeight(height_mm, source, f"{source} states {words}")


def _hits(rules: Sequence[_Rule], text: str) -> Iterator[tuple[float, str, bool]]:
    """Yield height, wording and kind of every rule that holds."""
    for rule in rules:
        found = rule.pattern.search(text)
        if found is None:
            continue
        height_mm = round(rule.height_mm([float(number) for number in found.groups()]), 3)
        if _RANGE_MM[0] <= height_mm <= _RANGE_MM[1]:
            yield height_mm, _wording(text, found), rule.is_body


def _wording(text: str, found: re.Match[str]) -> str:
    """Cut the sizes out of a name: ``D6.5mm``, ``8x10.5``, ``EIA-3216-18``, ``SRN6028``."""
    start = text.rfind("-", 0, found.start(1)) + 1
    words = text[start:].split("-", 1)[0][:_LONGEST_CODE]
    if words.isdigit():
        words = found[0].strip("-")
    return words[:1].upper() + words[1:] if re.match(r"[a-z]?[\d.]", words) else words.upper()


def _of_family(family: PackageFamily, evidence: HeightEvidence, source: HeightSource) -> BodyHeight:
    """Seated height of a family; a mere word such as ``L`` is tall with leads, else bounded by the part's size."""
    height_mm = family.height_mm
    if family.loose and evidence.length_mm > 0.0:
        height_mm = (max if evidence.through_hole else min)(height_mm, _tall(evidence))
    words = f"family {family.name} ({family.source})"
    return BodyHeight(height_mm, source, words if source == "family" else f"{source}, {words}")


def _tall(evidence: HeightEvidence) -> float:
    """Height that hardly any part of this kind exceeds, mm."""
    if evidence.through_hole:
        return TALL_LEADED_MM
    slender = max(_LEAST_FLAT_MM, _FLAT_SLENDERNESS * evidence.length_mm) if evidence.length_mm > 0.0 else TALL_FLAT_MM
    return round(min(TALL_FLAT_MM, slender), 1)
