"""Board perimeter: along the edge of the board."""

from dataclasses import replace

import numpy as np

from geometry.arrays import Points2, Scalars
from recipes.paths import BoardPerimeter
from rulesengine.paths.closed_path import RingRule, offset_rings, ring_stroke
from rulesengine.strokes.board_grid import own_frame
from rulesengine.strokes.stroke import Site, Stroke, StrokeSet
from specs.finding import Finding
from specs.finding_rules import NO_PATH_INSIDE

_CORNERS = {"front_left": (-1, -1), "front_right": (1, -1), "back_left": (-1, 1), "back_right": (1, 1)}
_AS_FAR_MM = 1e-3


def plan_board_perimeter(spec: BoardPerimeter, site: Site) -> StrokeSet:
    """Follow the outer edge at its offset, and the edges of holes and slots too if that is asked for."""
    rule = RingRule(
        height_mm=spec.height_mm,
        speed_mm_s=spec.speed_mm_s,
        tilt_deg=spec.tilt_deg,
        lean=spec.toward,
        corner_deg=spec.corner_deg,
        delay_s=spec.corner_delay_s,
        laps=spec.repeats,
        lead_in_mm=spec.lead_in_mm,
    )
    if spec.repeats == 0:
        return StrokeSet((), "fixed")
    frame, outline = own_frame(site.board), site.board.outline
    rings = offset_rings(outline, spec.offset_mm, frame)
    findings = () if rings else (_no_ring(spec, site),)
    outer, *inner = rings or offset_rings(outline, 0.0, frame)
    rings = [outer, *inner] if spec.follow == "outline_and_cutouts" else [outer]
    strokes = [
        ring_stroke(ring if spec.direction == "counterclockwise" else ring[::-1], rule, site, site.made_by)
        for ring in rings
    ]
    return StrokeSet((_begun(strokes[0], spec), *strokes[1:]), "fixed", findings=findings)


def _no_ring(spec: BoardPerimeter, site: Site) -> Finding:
    message = (
        f"One path {-spec.offset_mm:g} mm inside the board's edge does not exist; the edge itself is followed. "
        "Raise offset_mm."
    )
    return Finding(NO_PATH_INSIDE, message, site.made_by)


def _begun(stroke: Stroke, spec: BoardPerimeter) -> Stroke:
    """Let the stroke begin at the corner that is asked for: the entry farthest out in its direction."""
    if spec.start == "auto":
        return stroke
    entries: Points2 = stroke.tcp[list(stroke.entries), :2]
    out: Scalars = entries @ np.array(_CORNERS[spec.start])
    farthest = int(np.argmax(out > out.max() - _AS_FAR_MM))
    return replace(stroke, entries=(stroke.entries[farthest],))
