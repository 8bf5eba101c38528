"""Picture of a scan: both silhouettes, and the outline of the part that was made of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from shapely import Polygon

from boards.part.scan import Scan
from boards.part.silhouette import Silhouette
from reports.pictures.sheet import (
    ACCENT,
    FAINT,
    INK,
    QUIET,
    TOP_MM,
    add_panels,
    check_suffix,
    sheet,
    to_bytes,
    write_foot,
    write_title,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_PANEL_MM, _BOTTOM_MM = 160.0, 20.0


def draw_scan(scan: Scan, views: tuple[Silhouette, Silhouette], suffix: str) -> bytes:
    """Draw both views; the same scan gives the same bytes.

    Args:
        scan: What was made of the views.
        views: From the front and from the side.
        suffix: ``.png`` or ``.svg``.
    """
    check_suffix(suffix)
    size = " x ".join(f"{each:.2f}" for each in np.ptp(scan.part.patches.reshape(-1, 3), axis=0).tolist())
    with sheet(TOP_MM + _PANEL_MM + _BOTTOM_MM) as figure:
        panels = add_panels(figure, 2, 2, bottom_mm=_BOTTOM_MM, spaces=(0.12, 0.1))
        rows = zip(panels, views, scan.shadows, scan.off_px, ("front", "side"), strict=True)
        for axes, view, shadow, off_px, word in rows:
            _draw(axes, view, shadow)
            axes.set_title(f"{word}: {view.name}, within {off_px:.2f} pixels", fontsize=9, loc="left", color=INK)
        symmetry = scan.symmetry or "no symmetry: the hull of both views"
        write_title(figure, scan.part.name, f"{size} mm    {scan.volume_mm3 / 1000:.3f} cm3    {symmetry}")
        write_foot(figure, "grey: silhouettes as seen; red: outline of the part")
        return to_bytes(figure, suffix)


def _draw(axes: Axes, view: Silhouette, shadow: Polygon) -> None:
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    rings = [np.asarray(ring.coords) for ring in (view.contour.exterior, *view.contour.interiors)]
    axes.add_patch(PathPatch(Path.make_compound_path(*map(Path, rings)), facecolor=FAINT, edgecolor="none"))
    for ring in (shadow.exterior, *shadow.interiors):
        axes.plot(*np.asarray(ring.coords).T[:2], color=ACCENT, linewidth=0.9)
    axes.set_aspect("equal")
    axes.set_xlabel("mm", color=QUIET)
    axes.autoscale_view()
