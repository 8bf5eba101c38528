"""The XML of an IPC-2581 file: units, primitives, and what polygons and lines draw."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from boards.bounds import FARTHEST_MM, MOST_TURN_DEG
from boards.formats.loops import Point2, arc_about
from boards.formats.placed import Pose
from boards.formats.xml_tree import XmlElement, XmlWords
from geometry.arrays import Points2

Element = XmlElement

WORDS = XmlWords(
    "IPC-2581 file",
    "Export the board again as IPC-2581, revision B or C.",
    frozenset({
        *("LogisticHeader", "HistoryRecord", "Avl", "Spec", "PadStackDef", "PadStack", "Features", "LandPattern"),
        *("SilkScreen", "LogicalNet", "PhyNetGroup", "DfxMeasurementList", "ColorRef", "LineDesc", "LineDescRef"),
        *("FillDesc", "FillDescRef", "DictionaryColor", "DictionaryLineDesc", "DictionaryFillDesc", "DictionaryFont"),
        *("DictionaryFirmware", "Color", "SpecRef"),
    }),
    deepest=40,
    most_elements=100_000_000,
    most_kept=2_000_000,
    hollow=frozenset({"Set", "LayerFeature"}),
)  # fmt: skip
"""Left out are copper, nets and print: most of a usual file."""

_SCORING = frozenset({"V_CUT", "SCORE", "DOCUMENT", "BOARD_OUTLINE"})
"""Functions of layers whose lines may score a panel; KiCad writes `Cmts.User` as DOCUMENT."""

_MOST_POINTS = 5_000_000
_UNITS_MM = {"MILLIMETER": 1.0, "MICRON": 0.001, "INCH": 25.4}


def unit_mm(element: Element) -> float:
    """Length of the unit in the attribute ``units``, mm.

    Raises:
        BoardError: It is not known.
    """
    name = element.word("units").upper()
    if name not in _UNITS_MM:
        raise element.error(f"units of <{element.tag}> is {name[:40]!r}, not MILLIMETER, MICRON or INCH.")
    return _UNITS_MM[name]


@dataclass(slots=True)
class Drawing:
    """Points of a file that were drawn so far, arcs as chords; there is a bound to their number."""

    scale_mm: float
    count: int = field(default=0)

    def point(self, element: Element, x: str = "x", y: str = "y") -> Point2:
        """Return a point of two attributes, mm."""
        return np.array([element.number(x, scale=self.scale_mm), element.number(y, scale=self.scale_mm)])

    def ring(self, polygon: Element) -> Points2:
        """Corners ``(n, 2)`` of a ``Polygon``, ``Cutout`` or ``Polyline``, without a repeated first one; mm.

        Raises:
            BoardError: It does not begin with ``PolyBegin``, has no number, or arcs of another radius at its end.
        """
        line = self.line(polygon)
        closed = len(line) > 1 and float(np.hypot(*(line[-1] - line[0]))) < 1e-6
        return line[:-1] if closed else line

    def line(self, polygon: Element) -> Points2:
        """Points ``(n, 2)`` of a ``Polygon`` or ``Polyline`` as drawn, mm."""
        steps = [child for child in polygon.children if child.tag.startswith("Poly")]
        if not steps or steps[0].tag != "PolyBegin":
            raise polygon.error(f"<{polygon.tag}> does not begin with <PolyBegin>. {WORDS.again}")
        here = self.point(steps[0])
        pieces: list[Points2] = [here[None, :]]
        for step in steps[1:]:
            end = self.point(step)
            piece = self._curve(step, here, end)[1:] if step.tag == "PolyStepCurve" else end[None, :]
            pieces.append(piece)
            self._spend(len(piece), step)
            here = end
        return np.concatenate(pieces)

    def stroke(self, element: Element) -> Points2 | None:
        """Polyline of a drawn ``Line``, ``Arc``, ``Polyline`` or ``Polygon``; ``None`` of anything else."""
        match element.tag:
            case "Line":
                return np.array([self.point(element, "startX", "startY"), self.point(element, "endX", "endY")])
            case "Arc":
                start, end = self.point(element, "startX", "startY"), self.point(element, "endX", "endY")
                curve = self._curve(element, start, end)
                self._spend(len(curve), element)
                return curve
            case "Polyline" | "Polygon":
                return self.line(element)
            case _:
                return None

    def _curve(self, element: Element, start: Point2, end: Point2) -> Points2:
        centre, clockwise = self.point(element, "centerX", "centerY"), element.word("clockwise").lower() == "true"
        points = arc_about(start, end, centre, clockwise=clockwise)
        if points is None:
            raise element.error(f"the ends of <{element.tag}> are not equally far from its centre. {WORDS.again}")
        return points

    def _spend(self, count: int, element: Element) -> None:
        self.count += count
        if self.count > _MOST_POINTS:
            raise element.error(f"more than {_MOST_POINTS:,} corners, arcs as chords. That is no {WORDS.noun}.")


def turn_rad(element: Element) -> tuple[float, bool]:
    """Rotation of an element's ``Xform`` in radians, and whether it mirrors."""
    xform = element.first("Xform")
    if xform is None:
        return 0.0, False
    stated = "rotation" in xform.attributes
    angle = math.radians(xform.number("rotation", MOST_TURN_DEG)) if stated else 0.0
    return angle, xform.word("mirror").lower() == "true"


def location(element: Element, drawing: Drawing) -> Point2:
    """Point of an element's ``Location``, mm.

    Raises:
        BoardError: It has none.
    """
    place = element.first("Location")
    if place is None:
        raise element.error(f"<{element.tag}> has no <Location>. {WORDS.again}")
    return drawing.point(place)


@dataclass(frozen=True, slots=True)
class ScoreLayers:
    """Layers whose features are kept."""

    known: dict[str, bool] = field(default_factory=dict[str, bool])
    """By name."""

    def is_kept(self, tag: str, around: Sequence[Element]) -> bool:
        """Whether features are of such a layer; layers are stated before the steps."""
        if tag != "Features" or len(around) < 4 or around[-2].tag != "LayerFeature":
            return False
        name = around[-2].word("layerRef")
        if name not in self.known:
            layers = (each for each in around[-4].all("Layer") if each.word("name") == name)
            self.known[name] = any(each.word("layerFunction").upper() in _SCORING for each in layers)
        return self.known[name]


def drawn_lines(step: Element, drawing: Drawing) -> Iterator[Points2]:
    """Yield the lines (n, 2) of a step's features that were kept, mm."""
    features = (
        each for layer in step.all("LayerFeature") for owner in layer.all("Set") for each in owner.all("Features")
    )
    for each in features:
        x, y = location(each, drawing).tolist() if each.first("Location") is not None else (0.0, 0.0)
        angle, is_mirrored = turn_rad(each)
        pose = Pose(x, y, -angle if is_mirrored else angle, is_mirrored)
        yield from (pose.place(line) for line in strokes(each.children, drawing))


@dataclass(frozen=True, slots=True)
class Primitive:
    """Size of the shape of a pad, mm; of what is no rectangle, the one around it."""

    length_mm: float
    width_mm: float
    is_round: bool
    middle: tuple[float, float] = (0.0, 0.0)


def read_primitive(shape: Element, drawing: Drawing) -> Primitive | None:
    """Size of a standard or a user primitive; ``None`` of what has none."""
    sizes = [name for name in ("diameter", "width", "height") if name in shape.attributes]
    stated = {name: shape.number(name, FARTHEST_MM, drawing.scale_mm) for name in sizes}
    if negative := [name for name, size in stated.items() if size < 0.0]:
        raise shape.error(f"{negative[0]} of <{shape.tag}> is negative. {shape.known_as.again}")
    if "diameter" in stated:
        diameter = stated["diameter"]
        return Primitive(diameter, diameter, shape.tag == "Circle")
    if {"width", "height"} <= stated.keys():
        width, height = stated["width"], stated["height"]
        return Primitive(width, height, shape.tag in ("Oval", "Ellipse") and abs(width - height) < 1e-6)
    drawn = [line for each in (shape, *shape.below()) if (line := drawing.stroke(each)) is not None]
    if not drawn:
        inner = (read_primitive(each, drawing) for each in shape.children)
        return next((each for each in inner if each is not None), None)
    points = np.concatenate(drawn)
    low, high = points.min(axis=0), points.max(axis=0)
    (length, width), (x, y) = (high - low).tolist(), ((low + high) / 2.0).tolist()
    return Primitive(length, width, False, (x, y))


def read_dictionaries(content: Element | None) -> dict[str, Primitive]:
    """Primitives of the file by their names.

    Raises:
        BoardError: One cannot be read.
    """
    found: dict[str, Primitive] = {}
    for dictionary in content.all("DictionaryStandard", "DictionaryUser") if content is not None else ():
        drawing = Drawing(unit_mm(dictionary))
        for entry in dictionary.all("EntryStandard", "EntryUser"):
            shapes = (read_primitive(child, drawing) for child in entry.children)
            shape = next((each for each in shapes if each is not None), None)
            if shape is not None:
                found[entry.word("id")] = shape
    return found


def strokes(elements: Iterable[Element], drawing: Drawing) -> Iterator[Points2]:
    """Yield what is drawn by elements and inside them."""
    for element in elements:
        line = drawing.stroke(element)
        if line is not None:
            yield line
        else:
            yield from strokes(element.children, drawing)


def largest(rings: Sequence[Points2]) -> Points2:
    """Return the ring with the largest box around it."""
    return max(rings, key=lambda ring: round(float(np.prod(np.ptp(ring, axis=0))), 6))
