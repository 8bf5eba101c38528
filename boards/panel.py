"""Panels: several instances of one board, turned and turned over, with rails and tabs, as one workpiece."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal, cast

import numpy as np
import shapely
from pydantic import Field, model_validator
from shapely import Polygon
from shapely.affinity import rotate

from boards.board import Board, Body, Instance, Pad, Side
from boards.bounds import FARTHEST_MM, MOST_TURN_DEG
from boards.errors import BoardError
from boards.formats.names import some
from boards.formats.placed import StepPanel
from boards.formats.prism import prism
from boards.understand import understand
from geometry.arrays import Directions
from geometry.polygons import polygons_of
from specs.finding import Finding
from specs.finding_rules import PANEL_BOARDS
from specs.spec import Bounds, Spec
from specs.yaml.file_kind import FileKind
from specs.yaml.load import parse_spec, read_text, resolve_text

MOST_INSTANCES = 1000
_JOIN_MM = 0.001
"""Pieces of the panel that touch within this are one."""

Length = Annotated[float, Bounds(0.0, FARTHEST_MM, "mm", "sizes on a panel")]
Place = Annotated[float, Bounds(-FARTHEST_MM, FARTHEST_MM, "mm", "places on a panel")]


class InstanceSpec(Spec):
    """One board of a panel; what is left out is that of the grid."""

    at: tuple[Place, Place] | None = Field(
        default=None,
        description="Front left corner, on the panel, of the rectangle around the board as it lies there; left out, "
        "its place in the grid.",
    )
    turn_deg: Annotated[float, Bounds(-MOST_TURN_DEG, MOST_TURN_DEG, "degrees", "turns of a board")] = Field(
        default=0.0, description="Anticlockwise, as seen from the panel's top."
    )
    side: Literal["top", "bottom"] = Field(
        default="top", description="Side of the panel on which the board's own top lies: bottom for one turned over."
    )
    skip: bool = Field(default=False, description="True for a board with a skip mark: it is there and is not cleaned.")


class TabSpec(Spec):
    """A rectangle of material between boards and rails."""

    at: tuple[Place, Place] = Field(description="Its front left corner on the panel.")
    size_mm: tuple[Length, Length] = Field(description="Along x and along y.")


class PanelLayout(Spec):
    """What a panel is made of."""

    board: str = Field(min_length=1, description="A sample board, or a board file beside this one.")
    parts: str | None = Field(default=None, description="Parts table of the board, beside this file.")
    nx: Annotated[int, Bounds(1, MOST_INSTANCES, "", "boards in a row")] = Field(
        default=1, description="Boards along x."
    )
    ny: Annotated[int, Bounds(1, MOST_INSTANCES, "", "boards in a row")] = Field(
        default=1, description="Boards along y."
    )
    pitch_mm: tuple[Length, Length] | None = Field(
        default=None, description="From one board to the next along x and y; needed with more than one."
    )
    instances: list[InstanceSpec] = Field(
        default=[], description="The boards, row by row from the front left; more than the grid has must have a place."
    )
    rails_mm: dict[Literal["front", "back", "left", "right"], Length] = Field(
        default={}, description="Widths of rails along the rectangle around all boards."
    )
    tabs: list[TabSpec] = Field(default=[], description="Material between boards and rails.")

    @property
    def is_left_to_the_file(self) -> bool:
        """Whether neither a grid nor places are stated: the board's file may repeat its board itself."""
        return self.nx * self.ny == 1 and not self.instances

    @model_validator(mode="after")
    def _check(self) -> "PanelLayout":
        count = self.nx * self.ny
        if count > MOST_INSTANCES or len(self.instances) > MOST_INSTANCES:
            raise ValueError(f"a panel has at most {MOST_INSTANCES} boards")
        if count > 1 and self.pitch_mm is None:
            raise ValueError("give pitch_mm with more than one board in the grid")
        if any(each.at is None for each in self.instances[count:]):
            raise ValueError(f"instances beyond the {count} of the grid need a place: at")
        return self


class PanelFile(Spec):
    """A panel file."""

    panel: PanelLayout = Field(description="The panel.")


PANEL = FileKind("panel", "panel: {board: FILE}", "washboard board", BoardError, PanelFile, dict[str, Path])


def read_panel(file: Path) -> PanelLayout:
    """Read a panel file.

    Raises:
        BoardError: It cannot be read, or a value does not fit; the line is named.
    """
    return parse_spec(resolve_text(read_text(file, PANEL), file, PANEL), PANEL).panel


def compose_panel(layout: PanelLayout, board: Board, name: str, found: StepPanel | None = None) -> Board:
    """Put the instances of a board, rails and tabs together to one workpiece.

    The frame is the panel's, with the z of the board. Components are named ``U1@2`` for U1 of the second instance, and
    instances are numbered row by row from the front left, whatever their order in the file.

    Args:
        layout: Of the panel.
        board: The single board.
        name: Of the panel.
        found: How the board's file repeats it; taken where the layout states no grid and no places.

    Raises:
        BoardError: Two boards overlap, all are skipped, or the board is a panel itself.
    """
    if board.instances:
        raise BoardError(f"{board.name} is a panel itself; name a single board.")
    faces: dict[Side, Board] = {"top": board}
    places = found.places if found is not None else ()
    if any(each.side == "bottom" for each in layout.instances) or any(place.is_turned_over for place in places):
        faces["bottom"] = turned_over(board)
    placed = [
        (Instance("", faces["bottom" if at.is_turned_over else "top"], at.turn_rad, at.x_mm, at.y_mm), False)
        for at in places
    ] or list(_placed(layout, faces))
    placed.sort(key=lambda each: place_order(each[0]))
    outlines = [instance.move(instance.board.outline) for instance, _ in placed]
    shrunk = shapely.buffer(np.array(outlines, dtype=object), -_JOIN_MM)
    for a, b in shapely.STRtree(shrunk).query(shrunk, predicate="intersects").T.tolist():
        if a < b:
            raise BoardError(f"boards {a + 1} and {b + 1} of the panel overlap. Correct their places or the pitch.")
    cleaned = tuple(replace(each, name=f"{number}") for number, (each, skip) in enumerate(placed, start=1) if not skip)
    if not cleaned:
        raise BoardError("every board of the panel has a skip mark: nothing is left to clean.")
    stated = found.outline if found is not None else None
    material = _material(layout, [*outlines, *(polygons_of(stated) if stated is not None else ())])
    slab = Body("panel", "board", *prism(material, board.bottom_z_mm, board.top_z_mm))
    noticed = [each for each in board.findings if each.rule is not PANEL_BOARDS]  # that is settled here
    if others := found.others if found is not None else ():
        text = f"The panel holds other steps as well, which are not read and are bare material: {some(others)}."
        noticed.append(Finding(PANEL_BOARDS, text, override="warning"))
    panel = assemble(cleaned, [slab], name, noticed)
    return replace(panel, sources=board.sources, contradictions=board.contradictions)


def place_order(instance: Instance) -> list[float]:
    """Key of the order in which boards are numbered: row by row from the front left."""
    return np.round(instance.move(instance.board.outline).bounds, 3)[[1, 0]].tolist()


def assemble(instances: Sequence[Instance], others: Iterable[Body], name: str, findings: Iterable[Finding]) -> Board:
    """Understand a panel as one workpiece.

    Args:
        instances: In their order, numbered.
        others: The material as one board, and what else stands on the panel.
        name: Of the panel.
        findings: What was noticed before.
    """
    moved = (body for instance in instances for body in moved_bodies(instance))
    return replace(understand([*others, *moved], name, findings, is_panel=True), instances=tuple(instances))


def _placed(layout: PanelLayout, faces: Mapping[Side, Board]) -> Iterator[tuple[Instance, bool]]:
    """Lay the rectangle around each turned board at its place; and whether the board has a skip mark."""
    pitch = layout.pitch_mm or (0.0, 0.0)
    unstated = layout.nx * layout.ny - len(layout.instances)
    for number, each in enumerate([*layout.instances, *[InstanceSpec()] * unstated]):
        at = each.at or (number % layout.nx * pitch[0], number // layout.nx * pitch[1])
        board, turn = faces[each.side], math.radians(each.turn_deg)
        x0, y0, _, _ = rotate(board.outline, turn, origin=(0.0, 0.0), use_radians=True).bounds
        yield Instance("", board, turn, at[0] - x0, at[1] - y0), each.skip


def _material(layout: PanelLayout, outlines: Sequence[Polygon]) -> Polygon | shapely.MultiPolygon:
    """Boards, rails and tabs as one outline."""
    x0, y0, x1, y1 = shapely.total_bounds(np.array(outlines, dtype=object)).tolist()
    widths = {side: layout.rails_mm.get(side, 0.0) for side in ("front", "back", "left", "right")}
    left, right, low, high = x0 - widths["left"], x1 + widths["right"], y0 - widths["front"], y1 + widths["back"]
    rails = [
        shapely.box(left, low, right, y0),
        shapely.box(left, y1, right, high),
        shapely.box(left, low, x0, high),
        shapely.box(x1, low, right, high),
    ]
    tabs = [shapely.box(*tab.at, tab.at[0] + tab.size_mm[0], tab.at[1] + tab.size_mm[1]) for tab in layout.tabs]
    extra = [piece for piece in (*rails, *tabs) if piece.area > 0.0]
    whole = shapely.union_all(shapely.buffer(np.array([*outlines, *extra], dtype=object), _JOIN_MM, join_style="mitre"))
    pieces = polygons_of(shapely.buffer(whole, -_JOIN_MM, join_style="mitre"))
    return pieces[0] if len(pieces) == 1 else shapely.MultiPolygon(pieces)


def turned_over(board: Board) -> Board:
    """Return a board as it lies when turned over about y: x and z change their signs, and its sides their names."""
    signs, sides = np.array([-1.0, 1.0, -1.0]), {"top": "bottom", "bottom": "top"}
    bodies = [
        replace(
            body,
            patches=body.patches * signs + [0.0, 0.0, board.top_z_mm + board.bottom_z_mm],
            normals=body.normals * signs,
            side=cast("Side | None", sides.get(body.side or "")),
            pads=tuple(_moved_pad(pad, -pad.x_mm, pad.y_mm, -pad.turn_rad) for pad in body.pads),
        )
        for body in board.bodies
    ]
    return replace(understand(bodies, board.name), findings=board.findings)


def moved_bodies(instance: Instance) -> Iterator[Body]:
    """Bodies of an instance besides its slab, on the panel."""
    for body in instance.board.bodies:
        if body.role == "board":
            continue
        patches = body.patches.copy()
        patches[:, :, :2] = instance.points(patches[:, :, :2].reshape(-1, 2)).reshape(-1, 3, 2)
        normals: Directions = body.normals.copy()
        normals[:, :2] = instance.directions(normals[:, :2])
        spots = instance.points(np.array([[pad.x_mm, pad.y_mm] for pad in body.pads]).reshape(-1, 2)).tolist()
        pads = tuple(
            _moved_pad(pad, x, y, pad.turn_rad + instance.turn_rad)
            for pad, (x, y) in zip(body.pads, spots, strict=True)
        )
        yield replace(body, name=instance.rename(body.name), patches=patches, normals=normals, pads=pads)


def _moved_pad(pad: Pad, x_mm: float, y_mm: float, turn_rad: float) -> Pad:
    return replace(pad, x_mm=x_mm, y_mm=y_mm, turn_rad=math.remainder(turn_rad, 2.0 * math.pi))
