"""Exports of the sample boards: as KiCad's board, as bare Gerber layers with a centroid, and as IPC-D-356.

And how alike two readings of one board are. Turns and places are as seen from the top.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import shapely
from ecad_writers import UNITS, gerber_head, gerber_xy
from sample_boards.assemble import Place, Sample
from sample_boards.catalogue import shape_of
from sample_boards.lands import lands_of

from boards.board import Board, Component

_ANNULAR_MM = 0.6


@dataclass(frozen=True)
class Land:
    """A pad in the frame of its part; one with a drill goes through the board."""

    pin: int
    x: float
    y: float
    length: float
    width: float
    is_round: bool
    drill_mm: float = 0.0


def lands(place: Place) -> list[Land]:
    shape = shape_of(place.package)
    flat = [(pad.x_mm, pad.y_mm, pad.length_mm, pad.width_mm, pad.round, 0.0) for pad in lands_of(shape)]
    if not flat and not shape.drills:  # caps that touch along a line
        boxes = [(solid.reshape(-1, 3).min(axis=0), solid.reshape(-1, 3).max(axis=0)) for solid in
                 dict(shape.solids)["terminals"]]  # fmt: skip
        flat = [(*((low + high) / 2).tolist()[:2], *(high - low).tolist()[:2], False, 0.0) for low, high in boxes]
    through = [(x, y, drill + _ANNULAR_MM, drill + _ANNULAR_MM, True, drill) for x, y, drill in shape.drills]
    return [Land(pin, *each) for pin, each in enumerate([*flat, *through], start=1)]


def body_of(place: Place) -> tuple[float, float, float, float]:
    """Box around a part without its leads, in its frame."""
    groups = dict(shape_of(place.package).solids)
    solids = groups.get("body", next(iter(groups.values())))
    corners = np.concatenate([solid.reshape(-1, 3) for solid in solids])[:, :2]
    return *corners.min(axis=0).tolist(), *corners.max(axis=0).tolist()


def on_board(place: Place, x: float, y: float) -> tuple[float, float]:
    cos, sin = math.cos(math.radians(place.turn_deg)), math.sin(math.radians(place.turn_deg))
    x = -x if place.side == "bottom" else x
    return place.x + cos * x - sin * y, place.y + sin * x + cos * y


def kicad_board(sample: Sample) -> str:
    lines = [f"(kicad_pcb (version 20221018) (generator pcbnew) (general (thickness {sample.top - sample.bottom}))"]
    for ring in (sample.outline, *sample.holes):
        for (x, y), (u, v) in pairwise([*ring, ring[0]]):
            lines.append(f'(gr_line (start {x} {-y}) (end {u} {-v}) (layer "Edge.Cuts"))')
    for place in sample.places:
        side, mirror = ("B", -1.0) if place.side == "bottom" else ("F", 1.0)
        lines += [
            f'(footprint "own:{place.package}" (layer "{side}.Cu") (at {place.x} {-place.y} {place.turn_deg})',
            f'(property "Reference" "{place.name}") (property "Value" "{place.value or ""}")',
        ]
        x0, y0, x1, y1 = body_of(place)
        corners = [(mirror * x, -y) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0))]
        lines += [
            f'(fp_line (start {x} {y}) (end {u} {v}) (layer "{side}.Fab"))' for (x, y), (u, v) in pairwise(corners)
        ]
        for land in lands(place):
            kind = f"smd {'circle' if land.is_round else 'rect'}" if not land.drill_mm else "thru_hole circle"
            drill = f"(drill {land.drill_mm})" if land.drill_mm else ""
            layers = '"*.Cu" "*.Mask"' if land.drill_mm else f'"{side}.Cu" "{side}.Mask"'
            lines.append(
                f'(pad "{land.pin}" {kind} (at {mirror * land.x} {-land.y} {place.turn_deg}) '
                f"(size {land.length} {land.width}) {drill} (layers {layers}))"
            )
        lines.append(")")
    return "\n".join([*lines, ")"])


def gerber_layers(sample: Sample, unit: str = "MM") -> dict[str, str]:
    """Edge, copper and mask without attributes of parts and pins."""
    edge = [*gerber_head(unit, "Profile,NP"), "%ADD10C,0.05*%", "D10*"]
    for ring in (sample.outline, *sample.holes):
        (x, y), *rest = [*ring, ring[0]]
        edge += [f"{gerber_xy(x, y, unit)}D02*", *(f"{gerber_xy(u, v, unit)}D01*" for u, v in rest)]
    files = {"card.gm1": "\n".join([*edge, "M02*", ""])}
    for side, copper, mask in (("top", "gtl", "gts"), ("bottom", "gbl", "gbs")):
        files[f"card.{copper}"] = files[f"card.{mask}"] = "\n".join(_flashes(sample, side, unit))
    return files


def _flashes(sample: Sample, side: str, unit: str) -> Iterator[str]:
    yield from gerber_head(unit, "")[1:]
    yield "%AMTurned*21,1,$1,$2,0,0,$3*%"
    codes: dict[str, int] = {}
    for place in sample.places:
        for land in (each for each in lands(place) if each.drill_mm or place.side == side):
            length, width = land.length / UNITS[unit], land.width / UNITS[unit]
            quarter, rest = divmod(place.turn_deg, 90.0)
            aperture = f"C,{length:.6f}"
            if not land.is_round:
                sizes = (width, length) if quarter % 2 else (length, width)
                aperture = (f"Turned,{length:.6f}X{width:.6f}X{place.turn_deg}" if rest else
                            "R,{:.6f}X{:.6f}".format(*sizes))  # fmt: skip
            if aperture not in codes:
                codes[aperture] = len(codes) + 10
                yield f"%ADD{codes[aperture]}{aperture}*%"
            yield f"D{codes[aperture]}*"
            yield f"{gerber_xy(*on_board(place, land.x, land.y), unit)}D03*"
    yield "M02*\n"


def centroid_table(sample: Sample, unit: str = "MM", *, from_below: bool = False) -> str:
    """Places and turns; those of the bottom as seen from below, if wanted."""
    rows = [f"Designator,Val,Package,Mid X({unit.lower()}),Mid Y({unit.lower()}),Rotation,Layer"]
    for place in sample.places:
        turn = (180.0 - place.turn_deg) % 360.0 if from_below and place.side == "bottom" else place.turn_deg
        x, y = place.x / UNITS[unit], place.y / UNITS[unit]
        rows.append(f"{place.name},{place.value or ''},{place.package},{x:.5f},{y:.5f},{turn},{place.side}")
    return "\n".join([*rows, ""])


def netlist(sample: Sample) -> str:
    lines = ["P  CODE 00", "P  UNITS CUST 0"]
    for place in sample.places:
        for land in lands(place):
            x, y = (round(mm / 25.4 * 10_000) for mm in on_board(place, land.x, land.y))
            head, access = ("317", "A00") if land.drill_mm else ("327", "A01" if place.side == "top" else "A02")
            drill = f"D{round(land.drill_mm / 25.4 * 10_000):04d}PA00" if land.drill_mm else f"     {access}"
            lines.append(
                f"{head}{'NET':<14}   {place.name[:6]:<6}-{land.pin:<4} {drill}X{x:+07d}Y{y:+07d}X0236Y0236R000S2"
            )
    return "\n".join([*lines, "999", ""])


def write_order(
    sample: Sample, folder: Path, unit: str = "MM", *, is_named: bool = True, from_below: bool = False
) -> Path:
    folder.mkdir(parents=True)
    files = gerber_layers(sample, unit) | {"cpl.csv": centroid_table(sample, unit, from_below=from_below)}
    for name, text in (files | ({"card.ipc": netlist(sample)} if is_named else {})).items():
        (folder / name).write_text(text)
    return folder


def agreement(sample: Sample, right: Board, found: Board) -> dict[str, float]:
    """Share of the components of a board that another reading has alike, by what is compared.

    Places are the middles of the outlines, turns those of their sides up to a quarter. A plan is right if it holds the
    body and reaches no farther than the box around the body and its pads, within 0.1 mm.
    """
    parts = {each.name: each for each in found.components}
    places = {each.name: each for each in sample.places}
    hits: dict[str, list[bool]] = {key: [] for key in ("found", "side", "place", "turn", "plan", "height")}
    for each in right.components:
        other = parts.get(each.name)
        hits["found"].append(other is not None)
        if other is None:
            continue
        hits["side"].append(other.side == each.side)
        hits["place"].append(other.outline.envelope.centroid.distance(each.outline.envelope.centroid) <= 0.1)
        hits["turn"].append(abs(math.remainder(_angle(other) - _angle(each), 90.0)) <= 1.0)
        hits["plan"].append(
            other.outline.buffer(0.1).contains(each.outline)
            and _around(places[each.name]).buffer(0.1).contains(other.outline)
        )
        hits["height"].append(abs(other.height_mm - each.height_mm) <= 0.05)
    return {key: sum(each) / len(right.components) for key, each in hits.items()}


def _angle(component: Component) -> float:
    (x, y), (u, v), *_ = component.outline.minimum_rotated_rectangle.exterior.coords
    return math.degrees(math.atan2(v - y, u - x))


def _around(place: Place) -> shapely.Polygon:
    boxes = [body_of(place)]
    boxes += [
        (each.x - each.length / 2, each.y - each.width / 2, each.x + each.length / 2, each.y + each.width / 2)
        for each in lands(place)
    ]
    low, high = np.min(boxes, axis=0)[:2].tolist(), np.max(boxes, axis=0)[2:].tolist()
    return shapely.Polygon([on_board(place, x, y) for x, y in
                            (low, (high[0], low[1]), high, (low[0], high[1]))])  # fmt: skip
