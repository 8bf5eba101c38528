"""Packages of a library and their placements on both sides, as IPC-2581, ODB++ and placement tables state them."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon
from shapely.affinity import affine_transform

from boards.board import Pad, Side
from boards.errors import BoardError, Line
from boards.formats.layout import LayoutNotes, LayoutPart, evidence_of
from boards.formats.loops import Point2, box_around
from boards.packages.families import is_bare
from geometry.arrays import Points2
from specs.errors import printable
from specs.finding import Finding
from specs.finding_rules import PANEL_BOARDS

LEAST_PAD_MM = 1e-3
_MOST_PLACES = 1000
_LEAST_RIM_MM = 0.65
"""Across the copper around the smallest hole for a lead: 0.4 mm of drill and the annular ring."""

_MOST_HEEL_MM = 0.6
"""Between a body and the inner end of its pads: shorter than a lead, whose foot the pad is for."""

_LEAST_BODY = 0.1
"""Part of the box around the pads that the drawing of a body covers at least; a smaller one is a mark."""


@dataclass(frozen=True, slots=True)
class Pose:
    """Where something lies in the plane, and how it is turned. mm, as seen from the top."""

    x_mm: float
    y_mm: float
    turn_rad: float
    """Anticlockwise, after x was mirrored if it is."""
    is_mirrored: bool = False
    """Whether x changes its sign before the turn."""

    def matrix(self) -> Points2:
        """Matrix (2, 2) that columns of the own frame are multiplied with from the left."""
        cos, sin = math.cos(self.turn_rad), math.sin(self.turn_rad)
        mirror = -1.0 if self.is_mirrored else 1.0
        return np.array([[mirror * cos, -sin], [mirror * sin, cos]])

    def place(self, points: Points2) -> Points2:
        """Bring points ``(n, 2)``, or one, out of the own frame."""
        return points @ self.matrix().T + [self.x_mm, self.y_mm]

    def place_outline(self, outline: Polygon | MultiPolygon) -> Polygon | MultiPolygon:
        """Bring an outline out of the own frame; every vertex keeps its place in its ring."""
        return affine_transform(outline, [*self.matrix().ravel().tolist(), self.x_mm, self.y_mm])

    def turn(self, inner_rad: float) -> float:
        """Angle of what has this one in the own frame."""
        return math.remainder(self.turn_rad + (-inner_rad if self.is_mirrored else inner_rad), 2.0 * math.pi)

    def rectangle(self, length_mm: float, width_mm: float) -> Points2:
        """Corners ``(4, 2)`` of a rectangle about the own origin."""
        return self.place(np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]) * [length_mm, width_mm] / 2.0)


@dataclass(frozen=True, slots=True)
class Land:
    """The copper of one pin in the frame of its package, as seen from the package's own side; mm."""

    number: str
    pad: Pad
    flat: bool
    """Whether the pin is soldered to the surface, not through the board."""


def has_leads(holes: Sequence[Pad], flat: Sequence[Pad]) -> bool:
    """Whether plated holes of a part take leads.

    Where pads are soldered flat as well, holes whose rim is too small for a lead, or that lie in such a pad, are vias.
    """
    areas = shapely.union_all(
        [Polygon(Pose(p.x_mm, p.y_mm, p.turn_rad).rectangle(p.length_mm, p.width_mm)) for p in flat]
    )
    return any(
        not flat
        or (
            min(hole.length_mm, hole.width_mm) >= _LEAST_RIM_MM and not shapely.contains_xy(areas, hole.x_mm, hole.y_mm)
        )
        for hole in holes
    )


def is_between(outline: Polygon | MultiPolygon, pads: Sequence[Pad]) -> bool:
    """Whether a drawing ends so far from the pads on both of its sides that it is print between them, not the body."""
    x0, y0, x1, y1 = outline.bounds
    boxes = np.array(
        [shapely.LineString(Pose(p.x_mm, p.y_mm, p.turn_rad).rectangle(p.length_mm, p.width_mm)).bounds for p in pads]
    )
    inside = (boxes[:, 0] >= x0) & (boxes[:, 1] >= y0) & (boxes[:, 2] <= x1) & (boxes[:, 3] <= y1)
    left, front, right, back = boxes[~inside].T
    beyond = [left - x1, x0 - right, front - y1, y0 - back]  # how far each pad lies beyond each side
    off = np.array(beyond).reshape(4, -1) > _MOST_HEEL_MM
    return bool(
        off.size and off.any(axis=0).all() and ((off[0].any() and off[1].any()) or (off[2].any() and off[3].any()))
    )


@dataclass(frozen=True, slots=True, eq=False)
class PackageShape:
    """One package of the library, in its own frame as seen from its own side; mm."""

    name: str
    outline: Polygon | MultiPolygon | None
    """Of the body; ``None`` where none is drawn."""
    lands: tuple[Land, ...]
    pins: int | None
    height_mm: float | None = None
    description: str = ""

    @property
    def through_hole(self) -> bool:
        """Whether a lead goes through the board."""
        flat = [land.pad for land in self.lands if land.flat]
        return has_leads([land.pad for land in self.lands if not land.flat], flat)

    def body(self) -> tuple[Polygon | MultiPolygon | None, bool]:
        """Outline of the body, ``None`` if nothing has an area, and whether it is only the box around the pads."""
        pads = [land.pad for land in self.lands]
        box = box_around([Pose(p.x_mm, p.y_mm, p.turn_rad).rectangle(p.length_mm, p.width_mm) for p in pads])
        if self.outline is None or box is None:
            return (box, True) if self.outline is None else (self.outline, False)
        if is_between(self.outline, pads) and all(land.flat for land in self.lands):
            return shapely.box(*shapely.union_all([box, self.outline]).bounds), True
        return (self.outline, False) if self.outline.area >= _LEAST_BODY * box.area else (box, True)


@dataclass(frozen=True, slots=True)
class PlacedPart:
    """Where a package stands. Board frame, mm, as seen from the top."""

    name: str
    pose: Pose
    side: Side
    part: str = ""
    value: str = ""
    height_mm: float | None = None
    standoff_mm: float | None = None


@dataclass(frozen=True, slots=True)
class TurnConvention:
    """How the stated rotation of a side's parts leads from the frame of their packages onto the board.

    Programs differ: clockwise or not, mirrored before or after the turn, packages drawn as seen from their own side or
    through the board.
    """

    is_mirrored: bool
    sign: float
    """1 where stated angles are anticlockwise as seen from the top, after mirroring; else -1."""
    quarters: int = 0
    """Quarter turns that are added."""

    def pose(self, place: Point2, stated_rad: float) -> Pose:
        """Pose of a part at a place with a stated rotation."""
        turn = math.remainder(self.sign * stated_rad + self.quarters * math.pi / 2.0, 2.0 * math.pi)
        return Pose(float(place[0]), float(place[1]), turn, self.is_mirrored)


def fit_convention(found: Iterable[tuple[Pad, Point2, float]], usual: TurnConvention) -> TurnConvention:
    """Find the convention under which pins come to lie where the file places their copper.

    Args:
        found: Of many parts each pin in the frame of its package, where the file places it less the place of its part,
            and the rotation stated for the part; mm.
        usual: Taken where others fit no better.
    """
    rows = np.array([(pad.x_mm, pad.y_mm, *place, stated_rad) for pad, place, stated_rad in found])
    if not len(rows):
        return usual
    stated_x, y, *places, stated = rows.T

    def misfit(convention: TurnConvention) -> float:
        """Mean distance of pins from their places, mm."""
        turn = convention.sign * stated + convention.quarters * math.pi / 2.0
        x = -stated_x if convention.is_mirrored else stated_x
        placed = x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)
        return round(float(np.hypot(placed[0] - places[0], placed[1] - places[1]).mean()), 3)

    known = [TurnConvention(mirrored, sign, n) for mirrored in (False, True) for sign in (1.0, -1.0) for n in range(4)]
    return min((usual, *known), key=misfit)


@dataclass(frozen=True, slots=True, eq=False)
class _Form:
    """What all parts of one package have in common."""

    outline: Polygon | MultiPolygon | None
    from_pads: bool
    through_hole: bool


def _layout_part(placed: PlacedPart, package: PackageShape, form: _Form) -> LayoutPart | None:
    """Stand a package on the board; ``None`` where it has no body, no pad with an area."""
    outline = form.outline
    if outline is None:
        return None
    return LayoutPart(
        placed.name,
        placed.pose.place_outline(outline),
        placed.side,
        evidence_of(outline, package.name, placed.name, form.through_hole, package.description),
        form.from_pads,
        part=placed.part,
        value=placed.value,
        pins=package.pins,
        pads=tuple(
            replace(pad, x_mm=x, y_mm=y, turn_rad=placed.pose.turn(pad.turn_rad))
            for pad in (land.pad for land in package.lands if land.flat)
            if min(pad.length_mm, pad.width_mm) >= LEAST_PAD_MM
            for x, y in [placed.pose.place(np.array([pad.x_mm, pad.y_mm])).tolist()]
        ),
        stated_height_mm=package.height_mm if placed.height_mm is None else placed.height_mm,
        gap_height_mm=placed.standoff_mm,
    )


def stand_parts(placed: Iterable[tuple[PlacedPart, PackageShape, bool]], notes: LayoutNotes) -> Iterator[LayoutPart]:
    """Stand packages on the board, each with whether it is mounted; what is not, or has no body, is noted.

    Copper, print and holes have none: by their family, or because at most one pad and no outline is there.
    """
    forms: dict[PackageShape, _Form] = {}
    for part, package, is_mounted in placed:
        height_mm = package.height_mm if part.height_mm is None else part.height_mm
        bare = is_bare([package.name], part.name, len(package.lands), height_mm)
        has_body = not bare and (len(package.lands) > 1 or package.outline is not None)
        if package not in forms and has_body and is_mounted:
            forms[package] = _Form(*package.body(), package.through_hole)
        found = _layout_part(part, package, forms[package]) if has_body and is_mounted else None
        notes.not_fitted += [part.name] * (not is_mounted)
        if found is None:
            notes.left_out.append(part.name)
        else:
            yield found


@dataclass(frozen=True, slots=True)
class StepPlace:
    """One repetition of a board's step on a panel, as the file states it. Millimetres and radians."""

    x_mm: float
    y_mm: float
    """Of the origin of the board's frame, on the panel."""
    turn_rad: float
    """Anticlockwise as seen from the panel's top, after x was mirrored if the board is turned over."""
    is_turned_over: bool


@dataclass(frozen=True, slots=True, eq=False)
class StepPanel:
    """How a file repeats its board."""

    places: tuple[StepPlace, ...]
    outline: Polygon | MultiPolygon | None
    """Profile of the panel; ``None`` where it has none."""
    others: tuple[str, ...] = ()
    """Other steps that it repeats, which may be other boards."""

    @staticmethod
    def grid(counts: tuple[int, int], first: StepPlace, apart_mm: tuple[float, float], where: Line) -> list[StepPlace]:
        """Repeat a place in columns and rows, row by row.

        Raises:
            BoardError: They are too many.
        """
        columns, rows = counts
        if columns * rows > _MOST_PLACES:
            raise where.error(f"a panel of more than {_MOST_PLACES} boards is not read.")
        return [
            replace(first, x_mm=first.x_mm + column * apart_mm[0], y_mm=first.y_mm + row * apart_mm[1])
            for row in range(rows)
            for column in range(columns)
        ]


@dataclass(frozen=True)
class StepRepeats:
    """Which steps of a file repeat which, and where."""

    board: str
    """Step of the board."""
    repeats: Mapping[str, Sequence[tuple[str, Callable[[], Iterable[StepPlace]]]]]
    """By step the steps that it repeats with their places, in file order."""

    @cached_property
    def _holding(self) -> set[str]:
        """Steps on which the board is, through others as well."""
        found = {self.board}
        for _ in self.repeats:
            found |= {step for step, own in self.repeats.items() if any(name in found for name, _ in own)}
        return found

    @cached_property
    def panel(self) -> str | None:
        """Step that repeats the board, itself or through others, and is repeated by none; ``None`` without one."""
        inner = {name for own in self.repeats.values() for name, _ in own}
        holding = [step for step in self.repeats if step in self._holding and step != self.board]
        return next((each for each in holding if each not in inner), next(iter(holding), None))

    def places(self) -> tuple[StepPlace, ...]:
        """Every place of the board on the panel.

        Raises:
            BoardError: They cannot be read, or are too many.
        """
        found = tuple(islice(self._places(self.panel or "", ()), _MOST_PLACES + 1))
        if len(found) > _MOST_PLACES:
            raise BoardError(f"a panel of more than {_MOST_PLACES} boards is not read.")
        return found

    def others(self) -> tuple[str, ...]:
        """Steps on the panel that do not hold the board."""
        names = dict.fromkeys(name for name, _ in self.repeats.get(self.panel or "", ()))
        return tuple(name for name in names if name not in self._holding)

    def findings(self) -> list[Finding]:
        """What is open where the board is repeated: whether it is read alone."""
        if self.panel is None:
            return []
        text = (
            f"The file repeats this board on a panel, its step {printable(self.panel)[:60]}. It is read alone. State "
            "`panel: apart` in columns.yaml beside it to have the panel read, or `panel: whole`."
        )
        return [Finding(PANEL_BOARDS, text, override="warning")]

    def _places(self, step: str, around: tuple[str, ...]) -> Iterator[StepPlace]:
        for name, own in self.repeats.get(step, ()):
            if name not in self._holding or name in (step, *around):
                continue
            for at in own():
                if name == self.board:
                    yield at
                    continue
                outer = Pose(at.x_mm, at.y_mm, at.turn_rad, at.is_turned_over)
                for each in self._places(name, (*around, step)):
                    x, y = outer.place(np.array([each.x_mm, each.y_mm])).tolist()
                    yield StepPlace(x, y, outer.turn(each.turn_rad), at.is_turned_over != each.is_turned_over)
