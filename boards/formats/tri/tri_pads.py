"""The ``pads`` of an object in a ``.tri`` file: ``x,y,length,width,degrees,rect`` or ``round``, ``;`` between pads."""

import math
from pathlib import Path

from boards.board import Pad
from boards.errors import BoardError
from boards.formats.tri.tri_records import MILLIMETRES, Item
from boards.formats.tri.tri_text import is_number

_SHAPES = ("rect", "round")
_FARTHEST_MM = 1e6


def read_pads(item: Item, units: str, file: Path) -> tuple[Pad, ...]:
    """Read the pads of an object; lengths become millimetres.

    Raises:
        BoardError: One of them is not written as it must be.
    """
    text = item.attributes.get("pads", "")
    return tuple(_read_pad(word, item, units, file) for word in text.split(";")) if text else ()


def _read_pad(word: str, item: Item, units: str, file: Path) -> Pad:
    fields = [field.strip() for field in word.split(",")]
    if len(fields) == 6 and fields[5] in _SHAPES and all(map(is_number, fields[:5])):
        x, y, length, width = (float(field) * MILLIMETRES[units] + 0.0 for field in fields[:4])
        if round(min(length, width), 4) > 0.0 and max(abs(x), abs(y), length, width) <= _FARTHEST_MM:
            return Pad(x, y, length, width, math.radians(float(fields[4])), fields[5] == "round")
    message = (
        f"pad {word[:60]!r} of {item.name}: write x,y,length,width,degrees,rect (or round), pads with ';' between."
    )
    raise BoardError(message, file=file, line=item.line)


def write_pads(pads: tuple[Pad, ...]) -> str | None:
    """Write pads as one word; ``None`` without any."""
    return ";".join(map(_write_pad, pads)) if pads else None


def _write_pad(pad: Pad) -> str:
    numbers = (pad.x_mm, pad.y_mm, pad.length_mm, pad.width_mm, math.degrees(pad.turn_rad))
    return ",".join([*(f"{round(number, 4) + 0.0:.4f}" for number in numbers), _SHAPES[pad.round]])
