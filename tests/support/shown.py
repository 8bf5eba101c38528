"""What a command shows, as text that is short enough to review: lines of one shape become one, with their figures.

Figures are rounded, so that another processor's last digit does not count; pictures are described by what was drawn.
"""

import base64
import json
import re
from collections import Counter, defaultdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import Outcome
from matplotlib.axes import Axes
from matplotlib.collections import Collection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Text

import cleaning
from reports.pictures.sheet import Sheet

_DRAWN = "drawn:\n"
_PLACE = "\N{WHITE SQUARE}"
"""Stands for a figure"""
_NUMBER = re.compile(r"(?<![\w.#])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w#]|\.\d)")
_IMAGE = re.compile(r"data:image/[a-z+]+;base64,([A-Za-z0-9+/=]+)")
_DIGEST = re.compile(r"\b[0-9a-f]{12,64}\b")


def describe_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have each picture written as a description of what was drawn."""
    monkeypatch.setattr(Sheet, "content", lambda sheet: (_DRAWN + described(sheet.figure)).encode())


def described(figure: Figure) -> str:
    """Give each artist of a figure a line: kind, place, colours, text."""
    lines = [f"figure {_figures(figure.get_size_inches())}", *map(_artist, figure.texts)]
    for axes in figure.axes:
        lines.append(f"axes {_figures(axes.get_position().bounds)} x {_figures(axes.get_xlim())} {axes.get_xlabel()!r}")
        lines.append(f"  y {_figures(axes.get_ylim())} {axes.get_ylabel()!r} {axes.get_xscale()} {axes.get_yscale()}")
        legend = axes.get_legend()
        lines += [f"  {_artist(artist)}" for artist in axes.get_children() if _is_drawn(artist, axes)]
        lines += [] if legend is None else [f"  legend {text.get_text()!r}" for text in legend.get_texts()]
    return "\n".join(line for line in lines if line.strip())


def _is_drawn(artist: Any, axes: Axes) -> bool:
    return artist.get_visible() and artist is not axes.patch and artist not in axes.spines.values()


def _artist(artist: Any) -> str:
    match artist:
        case Text():
            style = f"{artist.get_fontsize():.3g} {artist.get_rotation():g} {artist.get_ha()} {artist.get_va()}"
            place, text = _figures(artist.get_position()), artist.get_text()
            return f"text {text!r} at {place} {_colours(artist.get_color())} {style}" if text else ""
        case Line2D():
            style = f"{artist.get_linestyle()} {artist.get_linewidth():g} {artist.get_marker()}"
            return f"line {_points(artist.get_xydata())} {_colours(artist.get_color())} {style}"
        case Patch():
            points = artist.get_transform().transform_path(artist.get_path()).vertices
            style = f"{artist.get_linewidth():g} {artist.get_hatch() or ''}"
            return f"patch {_points(points)} {_colours(artist.get_facecolor(), artist.get_edgecolor())} {style}"
        case AxesImage():
            values = np.asarray(artist.get_array(), dtype=float)
            shape = "x".join(map(str, values.shape))
            return f"image {shape} {_points(values.reshape(-1, 1))} in {_figures(artist.get_extent())}"
        case Collection():
            places = np.asarray(artist.get_offsets(), dtype=float).reshape(-1, 2)
            paths = [path.vertices for path in artist.get_paths()]
            values = [] if artist.get_array() is None else np.asarray(artist.get_array(), dtype=float).reshape(-1, 1)
            colours = _colours(*artist.get_facecolor(), *artist.get_edgecolor())
            return f"marks {_points(places)} {_points(np.concatenate(paths or [places]))} {_points(values)} {colours}"
    return ""


def _points(points: Any) -> str:
    """How many points, and their mean with growing weights, which their order changes too."""
    points = np.ma.filled(np.ma.asarray(points, dtype=float), np.nan)
    known = points[np.isfinite(points).all(axis=1)] if len(points) else points
    return f"{len(points)}:{_figures(_mean(known)) if len(known) else ''}"


def _mean(rows: Any) -> Any:
    weights = 1.0 + np.arange(len(rows)) / len(rows)
    return np.average(np.asarray(rows, dtype=float), axis=0, weights=weights)


def _colours(*colours: Any) -> str:
    return "/".join(dict.fromkeys(to_hex(each, keep_alpha=True) for each in colours))


def _figures(numbers: Any) -> str:
    return ",".join(f"{0.0 if abs(number) < 1e-9 else number:.4g}" for number in np.asarray(numbers, dtype=float))


def shown(outcome: Outcome, files: dict[str, bytes], folder: Path) -> str:
    """Give what a command printed and wrote, in short."""
    parts = [f"exit {outcome.code}", _short(outcome.out), _short(outcome.err)]
    for name, data in sorted(files.items()):
        parts += [f"--- {name}", _short(_text(name, data))]
    text = "\n".join(part for part in parts if part)
    text = text.replace(f"{Path(cleaning.__path__[0]).parent}/", "")
    return text.replace(str(folder), "FOLDER").replace(version("washboard"), "VERSION") + "\n"


def _text(name: str, data: bytes) -> str:
    try:
        text = data.decode()
    except UnicodeDecodeError:
        return f"{len(data)} bytes"
    if name.endswith(".json"):
        leaves: dict[str, list[Any]] = defaultdict(list)
        _gather(json.loads(text), "", leaves)
        return "\n".join(_told(path, values) for path, values in leaves.items())
    if name.endswith(".html"):
        text = re.sub(r"<style>.*?</style>|<script>.*?</script>", "", text, flags=re.DOTALL)
        text = _IMAGE.sub(lambda image: "\n" + base64.b64decode(image[1]).decode(errors="replace") + "\n", text)
        text = re.sub(r"(</(?:p|tr|table|section|div|h\d|li|figure|svg)>|<(?:tr|path|g|text)\b)", r"\n\1", text)
    return text


def _gather(data: Any, path: str, leaves: dict[str, list[Any]]) -> None:
    if isinstance(data, dict):
        for key, each in data.items():
            _gather(each, f"{path}.{key}", leaves)
    elif isinstance(data, list):
        for each in data:
            _gather(each, path, leaves)
    else:
        leaves[path].append(data)


def _told(path: str, values: list[Any]) -> str:
    numbers = [each for each in values if isinstance(each, int | float) and not isinstance(each, bool)]
    words = Counter(
        json.dumps(each, ensure_ascii=False)
        for each in values
        if isinstance(each, bool) or not isinstance(each, int | float)
    )
    told = [f"{number} x {word}" if number > 1 else word for word, number in words.items()]
    if numbers:
        mean = _mean(numbers)  # what is left of rounding differs from processor to processor
        shown = f"{len(numbers)}: {0.0 if abs(mean) < 1e-12 else mean:.6g}"
        told.insert(0, f"{numbers[0]}" if len(numbers) == 1 else shown)
    return f"{path} {'; '.join(told)}"


def _short(text: str) -> str:
    """Give one line for all lines that differ in numbers only, with the means of these."""
    shapes: dict[str, list[list[str]]] = defaultdict(list)
    for line in text.splitlines():
        line = _DIGEST.sub("DIGEST", line.rstrip())
        shapes[re.sub(r"\[\d+\]", "[]", _NUMBER.sub(_PLACE, line))].append(_NUMBER.findall(line))
    return "\n".join(_line(shape, rows) for shape, rows in shapes.items() if shape)


def _line(shape: str, rows: list[list[str]]) -> str:
    if len(rows) == 1 or not rows[0]:
        numbers = iter(_rounded(number) for number in rows[0])
        told = re.sub(_PLACE, lambda _: next(numbers), shape)
        return told if len(rows) == 1 else f"{len(rows)} x {told}"
    return f"{len(rows)} x {shape}  {','.join(f'{mean:.6g}' for mean in _mean(rows))}"


def _rounded(number: str) -> str:
    return number if len(number) < 8 else f"{float(number):.6g}"
