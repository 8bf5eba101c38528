"""The triangulated board file ``.tri``: read with its numbers in bulk, written the same way every time."""

import math
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import cast, get_args

import numpy as np
from numpy.typing import NDArray

from boards.board import Body, Pad, Role, Side, Surface
from boards.bounds import MOST_TURN_DEG
from boards.errors import BoardError, Line
from boards.formats.tri.layout import MILLIMETRES, Item, Layout, read_count, read_layout, read_legacy_layout
from boards.formats.tri.text import cut, is_number, read_text
from geometry.arrays import Directions, Triangles
from geometry.mesh import areas_and_normals, cross_products
from specs.finding import Finding
from specs.finding_rules import TRI_DEGENERATE, TRI_LEGACY, TRI_NORMAL, TRI_ZERO_NORMAL

SMALLEST_AREA_MM2 = 2.5e-9
"""A smaller triangle is degenerate: on a grid of 0.0001 mm the smallest has twice this area."""

_FARTHEST_MM = 1e6
"""Where a number is read; what lies within, but farther than a board reaches, is refused with a guess of its units."""

_PATCH = "%.4f " * 9 + "%.5f %.5f %.5f\n"
_ROWS = 4096
_PAD_SHAPES = ("rect", "round")


def read_tri(path: Path) -> tuple[tuple[Body, ...], tuple[Finding, ...]]:
    """Read a board file of either layout, packed or not; lengths become millimetres.

    Returns:
        The bodies in file order, and what was noticed while reading.

    Raises:
        BoardError: The file does not follow the format; the message names the line.
    """
    content = cut(read_text(path), path)
    layout = read_layout(content, path) if content.records else read_legacy_layout(content, path)
    values = content.numbers.values
    may_be_far = values.size and max(values.max(), -values.min()) * MILLIMETRES[layout.units] > _FARTHEST_MM
    stated = layout.widths == 12
    if stated.all() and len(stated) * 12 == len(values):
        table = values.reshape(-1, 12)
        patches, normals = table[:, :9].reshape(-1, 3, 3), table[:, 9:].copy()
    else:
        patches, normals = values[layout.offsets[:, None] + np.arange(9)].reshape(-1, 3, 3), np.zeros((len(stated), 3))
        normals[stated] = values[layout.offsets[stated, None] + np.arange(9, 12)]
    if layout.units != "mm":
        patches *= MILLIMETRES[layout.units]
    if may_be_far:
        for far in np.flatnonzero((np.abs(patches) > _FARTHEST_MM).any(axis=(1, 2)))[:1].tolist():
            raise Line(path, int(layout.lines[far])).error("a vertex lies more than 1 km away. Check the units.")
    keep, notes = _check_patches(patches, normals, layout)
    roles: list[Role] = []
    if not layout.legacy:
        roles = _read_roles(layout.items, path)
    else:
        ends = np.cumsum([sum(count for _, count in item.surfaces) for item in layout.items])
        plans = (part.reshape(-1, 3)[:, :2] for part in np.split(patches, ends[:-1]))
        areas = [float(np.prod(np.ptp(plan, axis=0))) if len(plan) else 0.0 for plan in plans]
        board = int(np.argmax(np.round(areas, 4)))
        roles = ["board" if place == board else "component" for place in range(len(areas))]
        taken = "mm taken, the board is the object of largest plan area"
        notes.append(Finding(TRI_LEGACY, f"The file holds numbers only and states no units: {taken}."))
    return tuple(_build(layout, roles, patches, normals, keep)), tuple(notes)


def _check_patches(patches: Triangles, normals: Directions, layout: Layout) -> tuple[NDArray[np.bool_], list[Finding]]:
    """Complete the normals in place; return which patches have an area, and what was noticed."""
    windings = cross_products(patches)
    keep = np.einsum("ij,ij->i", windings, windings) > (2.0 * SMALLEST_AREA_MM2) ** 2
    square = np.einsum("ij,ij->i", normals, normals)
    stated = layout.widths == 12
    lost = stated & (square < 1e-12) & keep
    odd = np.abs(square - 1.0) > 2e-4  # five decimals of a unit vector stay as they are, to be written the same again
    scaled = odd & (square >= 1e-12)
    normals[scaled] /= np.sqrt(square[scaled, None])
    taken = square < 1e-12
    normals[taken] = areas_and_normals(patches[taken])[1]
    against = keep & (np.einsum("ij,ij->i", normals, windings) < 0.0)
    notes: list[Finding] = []
    for mask, rule, text in (
        (~keep, TRI_DEGENERATE, "without an area were left out"),
        (lost, TRI_ZERO_NORMAL, "have a normal of zero length: the winding's was taken"),
        (against, TRI_NORMAL, "have a normal more than 90° away from their winding: the stated normal was taken"),
    ):
        count = int(np.count_nonzero(mask))
        if count:
            line = int(layout.lines[np.flatnonzero(mask)[0]])
            notes.append(Finding(rule, f"{count} patches {text} (first in line {line})."))
    return keep, notes


def _read_roles(items: Sequence[Item], path: Path) -> list[Role]:
    roles: list[Role] = []
    board: Item | None = None
    for item in items:
        role = cast(Role | None, _choice(item, "role", get_args(Role)))
        if role is None:
            raise item.error(f"object {item.name} has no role=board, component, fixture or part.")
        if role == "board":
            if board is not None:
                already = f"a second board, {item.name}; line {board.line} has one already"
                raise item.error(f"{already}. Give one another role.")
            board = item
        roles.append(role)
    if board is None and "part" not in roles:
        raise BoardError("no object has role=board. Give it to the bare board.", file=path)
    if board is not None and "part" in roles:
        other = next(item for item, role in zip(items, roles, strict=True) if role == "part")
        raise other.error(f"role=part of {other.name} beside the board {board.name}: write component or fixture.")
    return roles


def _choice(item: Item, key: str, words: tuple[str, ...]) -> str | None:
    value = item.attributes.get(key)
    if value is not None and value not in words:
        raise item.error(f"{key}={value[:40]!r} of {item.name}: write {' or '.join(words)}.")
    return value


def _build(
    layout: Layout, roles: list[Role], patches: Triangles, normals: Directions, keep: NDArray[np.bool_]
) -> Iterator[Body]:
    patches, normals = (patches, normals) if keep.all() else (patches[keep], normals[keep])
    counts = [count for item in layout.items for _, count in item.surfaces]
    left = iter(np.diff(np.concatenate(([0], np.cumsum(keep)))[np.cumsum([0, *counts])]).tolist())
    scale_mm = MILLIMETRES[layout.units]
    last = 0
    for item, role in zip(layout.items, roles, strict=True):
        first = last
        kept = [Surface(name, next(left)) for name, _ in item.surfaces]
        surfaces = tuple(surface for surface in kept if surface.patches)
        last = first + sum(surface.patches for surface in surfaces)
        if first == last:
            raise item.error(f"object {item.name} has no patch with an area.")
        stated = item.attributes
        word = stated.get("standoff", "")
        gap_mm = float(word) * scale_mm + 0.0 if is_number(word) else None
        if "standoff" in stated and (gap_mm is None or not 0.0 <= gap_mm <= _FARTHEST_MM):
            raise item.error(f"standoff={word[:40]!r} of {item.name}: write a length ≥ 0.")
        yield Body(
            name=item.name,
            role=role,
            patches=patches[first:last],
            normals=normals[first:last],
            surfaces=surfaces,
            package=stated.get("package"),
            part=stated.get("part"),
            value=stated.get("value"),
            pins=read_count(stated["pins"], f"pins of {item.name}", item) if "pins" in stated else None,
            side=cast(Side | None, _choice(item, "side", get_args(Side))),
            gap_height_mm=gap_mm,
            extra=tuple((key, value) for key, value in stated.items() if key.startswith("x-")),
            pads=tuple(_read_pad(word, item, scale_mm) for word in stated["pads"].split(";"))
            if stated.get("pads")
            else (),
        )


def _read_pad(word: str, item: Item, scale_mm: float) -> Pad:
    """Read one of an object's ``pads``: ``x,y,length,width,degrees,rect`` or ``round``, ``;`` between pads."""
    fields = [field.strip() for field in word.split(",")]
    if len(fields) == 6 and fields[5] in _PAD_SHAPES and all(map(is_number, fields[:5])):
        x, y, length, width = (float(field) * scale_mm + 0.0 for field in fields[:4])
        within = max(abs(x), abs(y), length, width) <= _FARTHEST_MM and abs(float(fields[4])) <= MOST_TURN_DEG
        if within and round(min(length, width), 4) > 0.0:
            return Pad(x, y, length, width, math.radians(float(fields[4])), fields[5] == "round")
    form = "write x,y,length,width,degrees,rect (or round), pads with ';' between"
    raise item.error(f"pad {word[:60]!r} of {item.name}: {form}.")


def write_tri(bodies: Iterable[Body]) -> str:
    """Write bodies as the text of a board file: the same bodies give the same text, and so does reading it back.

    Lengths are rounded to 0.0001 mm, normals to five decimals; patches that lose their area by that are left out.

    Raises:
        BoardError: A body has no patch with an area.
    """
    parts: list[str] = []
    count = 0
    for body in bodies:
        count += 1
        parts.extend(_write_body(body))
    return f"board-tri 1\nunits mm\nobjects {count}\n" + "".join(parts)


def _write_body(body: Body) -> Iterator[str]:
    table = np.hstack([np.round(body.patches.reshape(-1, 9), 4), np.round(body.normals, 5)]) + 0.0
    keep = areas_and_normals(table[:, :9].reshape(-1, 3, 3))[0] > SMALLEST_AREA_MM2
    owner = np.repeat(np.arange(len(body.surfaces)), [surface.patches for surface in body.surfaces])
    counts = np.bincount(owner[keep], minlength=len(body.surfaces)).tolist()
    surfaces = [(surface.name, count) for surface, count in zip(body.surfaces, counts, strict=True) if count]
    if not surfaces:
        raise BoardError(f"{body.name} has no patch with an area: it cannot be written to a board file.")
    pads: list[str] = []
    for pad in body.pads:
        numbers = (pad.x_mm, pad.y_mm, pad.length_mm, pad.width_mm, math.degrees(pad.turn_rad))
        pads.append(",".join([*(f"{round(number, 4) + 0.0:.4f}" for number in numbers), _PAD_SHAPES[pad.round]]))
    stated: list[tuple[str, object]] = [
        ("role", body.role),
        ("package", body.package),
        ("part", body.part),
        ("value", body.value),
        ("pins", body.pins),
        ("side", body.side),
        ("standoff", None if body.gap_height_mm is None else f"{body.gap_height_mm:.4f}"),
        ("pads", ";".join(pads) or None),
        *body.extra,
    ]
    attributes = " ".join(f"{key}={_word(str(value))}" for key, value in stated if value is not None)
    yield f"object {_word(body.name)} surfaces {len(surfaces)} {attributes}\n"
    table = table[keep]
    begin = 0
    for name, count in surfaces:
        yield f"surface {_word(name)} patches {count}\n"
        for first in range(begin, begin + count, _ROWS):
            rows = table[first : min(first + _ROWS, begin + count)]
            yield _PATCH * len(rows) % tuple(rows.ravel().tolist())
        begin += count


def _word(text: str) -> str:
    """Quote a text where it must be; the format knows no escapes, so a double quote becomes two single ones."""
    plain = " ".join(text.replace('"', "''").split())
    return f'"{plain}"' if not plain or " " in plain or "#" in plain else plain
