"""A nozzle's wave front on a flat plate as a small drawing."""

from itertools import pairwise

import numpy as np

from geometry.arrays import Points2
from recipes.footprint import core_footprint, footprint
from recipes.nozzles import HollowCone, Nozzle
from webui.theme.palette import ACCENT, QUIET, to_hex

_SIZE = 150.0
_MARGIN = 16.0
_GRID = (5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0)
_DOWN = np.array([0.0, 0.0, -1.0])
_ALONG = np.array([1.0, 0.0, 0.0])
_HEIGHT_MM = 50.0


def sketch_nozzle(nozzle: Nozzle) -> str:
    """Draw where the spray meets a plate at right angles, as SVG, with a ruler.

    A measured ring is drawn at the height at which it was measured, everything else at 50 mm.
    """
    measured = nozzle.wavefront if isinstance(nozzle, HollowCone) else None
    height = _HEIGHT_MM if measured is None else measured.height_mm
    outer = footprint(nozzle, height, _DOWN, _ALONG)
    reach = float(np.abs(outer).max())
    scale = (_SIZE / 2 - _MARGIN) / reach
    shapes = [_closed(outer, scale, fill=to_hex(ACCENT), opacity=0.22)]
    if isinstance(nozzle, HollowCone):
        middle = core_footprint(nozzle, height, _DOWN, _ALONG)
        inner = 2 * middle - outer if measured is None else _inner(nozzle)
        shapes.append(_closed(inner, scale, fill="#ffffff", opacity=1.0))
        shapes.append(_closed(middle, scale, fill="none", opacity=1.0))
    origin = "measured" if measured is not None else "from the half angle" if isinstance(nozzle, HollowCone) else "edge"
    return (
        f'<svg viewBox="0 0 {_SIZE:g} {_SIZE:g}" width="{_SIZE:g}" height="{_SIZE:g}" role="img" '
        f'aria-label="Spray on a plate {height:g} mm below">{"".join(shapes)}{_cross()}{_ruler(scale, reach)}</svg>'
        f'<div style="font-size:0.8em;color:{to_hex(QUIET)}">On a plate {height:g} mm below, {origin}</div>'
    )


def _inner(nozzle: HollowCone) -> Points2:
    assert nozzle.wavefront is not None
    table = np.array(nozzle.wavefront.points)
    around = np.radians(table[:, 0])
    return table[:, 1:2] * np.column_stack([np.cos(around), -np.sin(around)])


def _closed(points: Points2, scale: float, *, fill: str, opacity: float) -> str:
    places = points * [scale, -scale] + _SIZE / 2
    spelt = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    line = f' stroke="{to_hex(ACCENT)}" stroke-width="1.4"' if fill == "none" else ""
    return f'<polygon points="{spelt}" fill="{fill}" fill-opacity="{opacity:g}"{line}/>'


def _cross() -> str:
    middle = _SIZE / 2
    ends = ((middle - 4, middle, middle + 4, middle), (middle, middle - 4, middle, middle + 4))
    return "".join(f'<path d="M{a:g} {b:g}L{c:g} {d:g}" stroke="{to_hex(QUIET)}"/>' for a, b, c, d in ends)


def _ruler(scale: float, reach: float) -> str:
    """A length that is easy to read, near half of the drawing."""
    length = next((small for small, large in pairwise(_GRID) if large > reach), _GRID[-1])
    left, low = _MARGIN / 2, _SIZE - 4
    return (
        f'<path d="M{left:g} {low:g}h{length * scale:.1f}" stroke="{to_hex(QUIET)}" stroke-width="2"/>'
        f'<text x="{left:g}" y="{low - 4:g}" font-size="9" fill="{to_hex(QUIET)}">{length:g} mm</text>'
    )
