"""Apertures of a Gerber file: the rectangle around each, whatever its shape; arithmetic of macros included."""

import ast
import math
import operator
import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from boards.bounds import FARTHEST_MM, number_within
from boards.errors import Line
from geometry.arrays import Points2

AGAIN = "Export the layer again as RS-274X or Gerber X2."
_CIRCLE_POINTS = 64
_LONGEST = 2000
"""Characters of one expression of a macro."""

_MOST_POINTS = 5000
_OPERATORS: dict[type, Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}


@dataclass(frozen=True, slots=True)
class Aperture:
    """The smallest rectangle around a shape, mm, about the place of its flash."""

    length_mm: float
    width_mm: float
    turn_rad: float = 0.0
    is_round: bool = False
    middle: tuple[float, float] = (0.0, 0.0)


def standard_aperture(kind: str, sizes: Sequence[float], line: Line) -> Aperture:
    """Aperture of a standard template: circle, rectangle, obround or polygon.

    Args:
        kind: C, R, O or P.
        sizes: Its parameters, lengths in mm.
        line: For messages.

    Raises:
        BoardError: A parameter is missing, or a size is negative.
    """
    if min(sizes[: 2 if kind in ("R", "O") else 1], default=0.0) < 0.0:
        raise line.error(f"an aperture of the template {kind} has a negative size. {AGAIN}")
    match kind, len(sizes):
        case "C", count if count > 0:
            return Aperture(sizes[0], sizes[0], is_round=True)
        case "R", count if count > 1:
            return Aperture(sizes[0], sizes[1])
        case "O", count if count > 1:
            return Aperture(sizes[0], sizes[1], is_round=abs(sizes[0] - sizes[1]) < 1e-9)
        case "P", count if count > 1:
            return Aperture(sizes[0], sizes[0], is_round=True)
        case _:
            raise line.error(f"an aperture of the template {kind[:20]!r} lacks a size. {AGAIN}")


def macro_aperture(body: Sequence[str], stated: Sequence[float], scale_mm: float, line: Line) -> Aperture:
    """Aperture of a macro: the rectangle around its primitives that are exposed.

    Args:
        body: Its blocks, in order.
        stated: Parameters of the aperture, in the file's unit where they are lengths.
        scale_mm: Length of that unit, mm.
        line: For messages.

    Raises:
        BoardError: A block cannot be read.
    """
    values = {str(place): value for place, value in enumerate(stated, start=1)}
    points: list[Points2] = []
    for block in body:
        if block.startswith("0"):
            continue
        if hit := re.fullmatch(r"\$(\d{1,4})=(.+)", block):
            values[hit[1]] = _value(hit[2], values, line)
            continue
        code, *words = block.split(",")
        primitive = _primitive(code, [_value(word, values, line) for word in words[:_MOST_POINTS]], line)
        if primitive is not None:
            points.append(primitive)
    if not points:
        return Aperture(0.0, 0.0)
    around = np.concatenate(points) * scale_mm
    if not bool((np.abs(around) <= FARTHEST_MM).all()):
        raise line.error(f"an aperture reaches more than {FARTHEST_MM / 1000.0:g} m. {AGAIN}")
    return _rectangle(around)


def _value(text: str, values: Mapping[str, float], line: Line) -> float:
    """Evaluate an expression of numbers, parameters and + - x /; a parameter that is not stated is 0."""
    plain = re.sub(r"\$(\d{1,4})", lambda hit: f"({values.get(hit[1], 0.0)!r})", text)
    plain = plain.replace("x", "*").replace("X", "*").strip()
    try:
        if len(plain) > _LONGEST:
            raise ValueError
        with warnings.catch_warnings(action="error"):  # what Python only warns of is no expression either
            value = _evaluate(ast.parse(plain, mode="eval").body)
    except (SyntaxError, ValueError, ZeroDivisionError, RecursionError, MemoryError, OverflowError):
        raise line.error(f"the macro's expression {text[:40]!r} cannot be computed. {AGAIN}") from None
    if not math.isfinite(value):
        raise line.error(f"the macro's expression {text[:40]!r} is no finite number. {AGAIN}")
    return value


def _evaluate(node: ast.expr) -> float:
    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            return float(value)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_evaluate(operand)
        case ast.UnaryOp(op=ast.UAdd(), operand=operand):
            return _evaluate(operand)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
            return _OPERATORS[type(op)](_evaluate(left), _evaluate(right))
        case _:
            raise ValueError


def _primitive(code: str, numbers: Sequence[float], line: Line) -> Points2 | None:
    """Points around a primitive, turned about the macro's origin; ``None`` of one that removes copper."""
    try:
        match code.strip():
            case "1" if numbers[0]:
                return _turned(_circle(numbers[2:4], numbers[1] / 2.0), numbers[4] if len(numbers) > 4 else 0.0)
            case "20" | "2" if numbers[0]:
                start, end, half = np.array(numbers[2:4]), np.array(numbers[4:6]), numbers[1] / 2.0
                along = (end - start) / (np.hypot(*(end - start)) or 1.0) * half
                across = np.array([-along[1], along[0]])
                return _turned(np.array([start + across, start - across, end - across, end + across]), numbers[6])
            case "21" if numbers[0]:
                return _turned(_box(numbers[3:5], numbers[1], numbers[2]), numbers[5])
            case "22" if numbers[0]:
                middle = (numbers[3] + numbers[1] / 2.0, numbers[4] + numbers[2] / 2.0)
                return _turned(_box(middle, numbers[1], numbers[2]), numbers[5])
            case "4" if numbers[0]:
                count = int(numbers[1]) + 1
                return _turned(np.array(numbers[2 : 2 + 2 * count]).reshape(-1, 2), numbers[2 + 2 * count])
            case "5" if numbers[0]:
                return _circle(numbers[2:4], numbers[4] / 2.0)
            case "6":
                return _circle(numbers[0:2], numbers[2] / 2.0)
            case "7":
                return _circle(numbers[0:2], numbers[2] / 2.0)
            case _:
                return None
    except (IndexError, ValueError, OverflowError):
        raise line.error(f"the macro's primitive {code[:10]!r} is incomplete. {AGAIN}") from None


def _circle(middle: Sequence[float], radius: float) -> Points2:
    turn = np.linspace(0.0, 2.0 * np.pi, _CIRCLE_POINTS, endpoint=False)
    return np.array(middle) + radius * np.column_stack([np.cos(turn), np.sin(turn)])


def _box(middle: Sequence[float], width: float, height: float) -> Points2:
    return np.array(middle) + np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * [width / 2.0, height / 2.0]


def _turned(points: Points2, turn_deg: float) -> Points2:
    cos, sin = math.cos(math.radians(turn_deg)), math.sin(math.radians(turn_deg))
    return points @ np.array([[cos, sin], [-sin, cos]])


def _rectangle(points: Points2) -> Aperture:
    box = shapely.minimum_rotated_rectangle(shapely.MultiPoint(points))
    if not isinstance(box, shapely.Polygon):
        return Aperture(0.0, 0.0)
    corners = np.asarray(box.exterior.coords)[:4]
    along, across = corners[1] - corners[0], corners[3] - corners[0]
    x, y = corners.mean(axis=0).round(9).tolist()
    turn = math.atan2(along[1], along[0])
    length, width = float(np.hypot(*along)), float(np.hypot(*across))
    quarter = round(turn / (math.pi / 2.0))
    if quarter % 2:  # a rectangle along the axes reads as one
        length, width = width, length
    return Aperture(length, width, turn - quarter * math.pi / 2.0, False, (x, y))


def lengths(words: Sequence[str], scale_mm: float, line: Line) -> list[float]:
    """Parameters of an aperture as numbers times a scale.

    Raises:
        BoardError: One is no number, or beyond what a board reaches.
    """
    values = [number_within(word, FARTHEST_MM, scale_mm) for word in words]
    if any(map(math.isnan, values)):
        raise line.error(f"an aperture's size is no number within ±{FARTHEST_MM / scale_mm:g}. {AGAIN}")
    return values
