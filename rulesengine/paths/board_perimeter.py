"""Board perimeter: along the edge of the board."""

from dataclasses import replace

import numpy as np

from geometry.arrays import Points2, Scalars
from recipes.paths import BoardPerimeter, height_of
from rulesengine.paths.closed_path import RingRule, offset_rings, ring_stroke
from rulesengine.strokes.stroke import Site, StrokeSet, own_frame
from specs.finding import Finding
from specs.finding_rules import NO_PATH_INSIDE

_CORNERS = {"front_left": (-1, -1), "front_right": (1, -1), "back_left": (-1, 1), "back_right": (1, 1)}
_AS_FAR_MM = 1e-3


def plan_board_perimeter(spec: BoardPerimeter, site: Site) -> StrokeSet:
    """Follow the outer edge at its offset, and with ``outline_and_cutouts`` the edges of holes and slots too."""
    if spec.repeats == 0:
        return StrokeSet((), "fixed")
    rule = RingRule(
        height_mm=height_of(spec),
        speed_mm_s=spec.speed_mm_s,
        tilt_deg=spec.tilt_deg,
        lean=spec.toward,
        corner_deg=spec.corner_deg,
        delay_s=spec.corner_delay_s,
        laps=spec.repeats,
        lead_in_mm=spec.lead_in_mm,
    )
    frame, outline = own_frame(site.board), site.board.outline
    rings = offset_rings(outline, spec.offset_mm, frame)
    findings: tuple[Finding, ...] = ()
    if not rings:
        message = (
            f"One path {-spec.offset_mm:g} mm inside the board's edge does not exist; the edge itself is followed. "
            "Raise offset_mm."
        )
        findings = (Finding(NO_PATH_INSIDE, message, site.made_by),)
        rings = offset_rings(outline, 0.0, frame)
    rings = rings if spec.follow == "outline_and_cutouts" else rings[:1]
    ahead = spec.direction == "counterclockwise"
    outer, *inner = [ring_stroke(ring if ahead else ring[::-1], rule, site, site.made_by) for ring in rings]
    if spec.start != "auto":  # the entry farthest out in the direction of the corner
        entries: Points2 = outer.tcp[list(outer.entries), :2]
        out: Scalars = entries @ np.array(_CORNERS[spec.start])
        farthest = int(np.argmax(out > out.max() - _AS_FAR_MM))
        outer = replace(outer, entries=(outer.entries[farthest],))
    return StrokeSet((outer, *inner), "fixed", findings=findings)
