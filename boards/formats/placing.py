"""What each part of a CAD file is to the board: a component on it, a layer of it, or something around it."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

from boards.board import Role
from boards.formats.loose import height_range, plan_hull, touching_groups
from boards.formats.tree import Part
from geometry.arrays import Triangles
from specs.finding import Finding, FindingRule
from specs.finding_rules import BOARD_LAYERS, COMPONENT_WITHOUT_HEIGHT, MODELS_JOINED, NOT_ON_THE_BOARD, REPEATED_NAME

_LAYER_MM = 0.15  # copper, mask and print are thinner than this; no component is
_NO_HEIGHT_MM = 0.01
_STANDS_MM = 5.0
_SAME_PART_MM = 0.5


def drop_layers(board: Triangles, parts: Sequence[Part]) -> tuple[list[Part], list[Finding]]:
    """Leave out what lies within the board: copper, mask, print, plugs of holes."""
    bottom, top = height_range(board)
    plan = plan_hull(board)
    kept: list[Part] = []
    layers: list[str] = []
    flat: list[str] = []
    for part in parts:
        margin = _NO_HEIGHT_MM if part.is_named else _LAYER_MM
        low, high = height_range(part.patches()) if part.geometry else (bottom, top)
        # A second board of a panel is as thin, but beside the first.
        beside = bool(part.geometry) and not plan_hull(part.patches()).centroid.within(plan)
        if beside or low < bottom - margin or high > top + margin:
            kept.append(part)
        else:
            (flat if part.is_named else layers).append(part.name or "unnamed")
    findings = _listed(BOARD_LAYERS, "lie within the board's thickness and are left out", layers)
    hint = "have no height above the board and are left out; check their models"
    return kept, findings + _listed(COMPONENT_WITHOUT_HEIGHT, hint, flat)


def split_roles(board: Triangles, parts: Sequence[Part]) -> tuple[list[tuple[Role, Part]], list[Finding]]:
    """Tell components from what only surrounds the board: an enclosure, a carrier, a part elsewhere.

    A part with a reference designator is a component wherever it is.
    """
    bottom, top = height_range(board)
    plan = plan_hull(board)
    placed: list[tuple[Role, Part]] = []
    around: list[str] = []
    for part in parts:
        low, high = height_range(part.patches())
        hull = plan_hull(part.patches())
        stands = max(low - top, bottom - high) < _STANDS_MM and hull.distance(plan) < _SAME_PART_MM
        if part.is_named or (stands and hull.area < plan.area):
            placed.append(("component", part))
        else:
            placed.append(("fixture", part))
            around.append(part.name or "unnamed")
    return placed, _listed(NOT_ON_THE_BOARD, "do not stand on the board and are kept as obstacles", around)


def join_repeated(parts: Sequence[Part]) -> tuple[list[Part], list[Finding]]:
    """Join parts of one name that touch: a footprint with several 3-D models comes as several parts."""
    rows: dict[str, list[int]] = {}
    for row, part in enumerate(parts):
        if part.is_named:
            rows.setdefault(part.name, []).append(row)
    merged = dict(enumerate(parts))
    names: list[str] = []
    for same in (same for same in rows.values() if len(same) > 1):
        for group in touching_groups([parts[row].patches() for row in same], _SAME_PART_MM):
            first, *others = (same[member] for member in group)
            geometry = parts[first].geometry + tuple(own for row in others for own in merged.pop(row).geometry)
            merged[first] = replace(parts[first], geometry=geometry)
            names += [parts[first].name] * bool(others)
    return list(merged.values()), _listed(MODELS_JOINED, "come in several touching bodies, joined", names)


def name_parts(placed: Iterable[tuple[Role, Part]]) -> tuple[list[tuple[Role, Part]], list[Finding]]:
    """Give every part a name that the board file can hold and that no other has."""
    taken = {"board"}
    named: list[tuple[Role, Part]] = []
    renamed: list[str] = []
    for role, part in placed:
        base = re.sub(r"[\s\"'#=\x00-\x1f]+", "_", part.name).strip("_")
        name, number = base or "part-1", 1
        while name in taken:
            number += 1
            name = f"{base or 'part'}-{number}"
        if base and number > 1:
            renamed.append(f"{base} -> {name}")
        taken.add(name)
        named.append((role, replace(part, name=name)))
    hint = "names occur more than once; the later ones were renamed"
    return named, _listed(REPEATED_NAME, hint, renamed)


def _listed(rule: FindingRule, what: str, names: Sequence[str]) -> list[Finding]:
    if not names:
        return []
    some = ", ".join(names[:20]) + (" …" if len(names) > 20 else "")
    return [Finding(rule, f"{len(names)} {what}: {some}.")]
