"""A part, a run over it, and what is seen and held of each face: as tables and as plain data."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from boards.board import Workpiece
from cleaning.part_faces import FaceVerdict, worst_verdict
from cleaning.report import Traceability
from geometry.arrays import Indices, Scalars
from programs.program import TimedProgram
from programs.summary import by_function
from reports.tables.table import Facts, Table
from specs.finding import finding_data
from specs.json import Json

if TYPE_CHECKING:
    from rulesengine.planning.pipeline import Run
    from rulesengine.surface.part_job import Covering, Survey

_UNTRACED = Traceability()
FACES_CAVEAT = (
    "A face is clean where at least 99 % of what can be seen of it is in the cone for the required time, marginal from "
    "95 %. Only exposure is judged: a part has no components and no gaps."
)


def part_facts(part: Workpiece) -> Facts:
    """What was understood of a part, for its card."""
    low, high = part.box
    served = [face for face in part.faces if face.serve]
    patches = sum(len(body.patches) for body in part.bodies if body.role == "part")
    area = sum(face.area_mm2 for face in part.faces)
    fixtures = [body.name for body in part.bodies if body.role == "fixture"]
    return [
        ("size", " x ".join(f"{each:.2f}" for each in (high - low).tolist()) + " mm"),
        ("patches", str(patches)),
        ("faces", f"{len(part.faces)}, {len(served)} of them sprayed, {sum(not each.flat for each in served)} curved"),
        ("area", f"{area / 100:.1f} cm2, {sum(face.area_mm2 for face in served) / 100:.1f} of them sprayed"),
        ("fixtures", ", ".join(fixtures) or "none"),
        ("sha256", part.sha256[:16]),
    ]


def face_table(part: Workpiece, survey: "Survey") -> Table:
    """A row for each face: kind, normal, area, the share that can be seen, and what hides the rest."""
    rows: list[tuple[str, ...]] = []
    for number, face in enumerate(part.faces):
        normal = ", ".join(f"{each + 0.0:.2f}" for each in face.normal)
        seen, hiders = "", ""
        if face.serve:
            own = survey.cell_face == number
            seen = f"{share_of(survey.cells.areas_mm2, own & survey.visible, own):.1%}"
            hiders = ", ".join(hiders_of(part, survey.cells.areas_mm2, own & ~survey.visible, survey.hider))
        kind = "plane" if face.flat else "curved"
        rows.append((face.name, kind, normal, f"{face.area_mm2:.0f}", "yes" if face.serve else "no", seen, hiders))
    return Table.of(("face", "kind", "normal", ">area\nmm2", "sprayed", ">visible", "hidden by"), rows)


def share_of(areas: Scalars, chosen: NDArray[np.bool_], among: NDArray[np.bool_]) -> float:
    """Share of the area of some cells that others have."""
    return float(areas[chosen].sum() / max(areas[among].sum(), 1e-12))


def hiders_of(part: Workpiece, areas: Scalars, hidden: NDArray[np.bool_], hider: Indices) -> list[str]:
    """Names of the bodies that hide at least a tenth of some cells' area, most first."""
    total = float(areas[hidden].sum())
    if total <= 0:
        return []
    by = np.bincount(hider[hidden], areas[hidden], len(part.bodies))
    return [part.bodies[body].name for body in np.argsort(-by, kind="stable") if by[body] > 0.1 * total]


def covering_table(part: Workpiece, covering: "Covering") -> Table:
    """A row for each sprayed face: stripes, time, what is seen, what is held of it, the least time."""
    rows = [
        (
            each.face, str(each.pieces), f"{each.spray_s:.1f}", f"{each.visible_share:.1%}", f"{each.held_share:.1%}",
            f"{each.least_s:.2f}", f"{each.mean_s:.2f}", ", ".join(each.hidden_by),
        )
        for each in face_results(part, covering)
    ]  # fmt: skip
    return Table.of(
        ("face", ">pieces", ">spraying\ns", ">visible", ">held\nof it", ">least\ns", ">mean\ns", "hidden by"), rows
    )


@dataclass(frozen=True, slots=True)
class FaceResult:
    """What a covering does to one face."""

    face: str
    area_mm2: float
    pieces: int
    spray_s: float
    visible_share: float
    """Of its area, by any free pose."""
    held_share: float
    """Of what is visible, in the cone for the required time."""
    least_s: float
    mean_s: float
    most_tilt_deg: float
    hidden_by: tuple[str, ...]


def face_results(part: Workpiece, covering: "Covering") -> list[FaceResult]:
    """What a covering does to each sprayed face."""
    found: list[FaceResult] = []
    areas = covering.cells.areas_mm2
    for number, face in enumerate(part.faces):
        if not face.serve:
            continue
        own = covering.cell_face == number
        seen = own & covering.visible
        held = seen & (covering.seconds >= covering.required_s * (1 - 1e-9))
        pieces = [piece for piece in covering.pieces if piece.face == face.name]
        weights = areas[seen]
        found.append(
            FaceResult(
                face=face.name,
                area_mm2=round(face.area_mm2, 2),
                pieces=len(pieces),
                spray_s=round(sum(piece.spray_s for piece in pieces), 3),
                visible_share=round(share_of(areas, seen, own), 5),
                held_share=round(share_of(areas, held, seen), 5),
                least_s=round(float(covering.seconds[seen].min()) if seen.any() else 0.0, 3),
                mean_s=round(float((covering.seconds[seen] * weights).sum() / max(weights.sum(), 1e-12)), 3),
                most_tilt_deg=max((round(float(piece.tilts_deg.max()), 2) for piece in pieces), default=0.0),
                hidden_by=tuple(hiders_of(part, areas, own & ~covering.visible, covering.hider)),
            )
        )
    return found


def part_report(run: "Run") -> dict[str, Json]:
    """Totals, functions, faces and findings of a run over a part; the same run gives the same data."""
    totals, origin = run.program.totals, run.plan.origin
    return {
        "washboard_report": 1,
        "part": {"name": origin.board, "sha256": origin.board_sha256},
        "recipe": {"name": origin.recipe, "sha256": origin.recipe_sha256},
        "totals": {
            "duration_s": round(totals.duration_s, 4),
            "spray_s": round(totals.spray_s, 4),
            "travel_mm": round(totals.travel_mm, 3),
            "moves": totals.moves,
            "liquid_l": {name: round(litres, 4) for name, litres in totals.liquid_l},
        },
        "functions": [
            {"function": each.function, "spray_s": round(each.spray_s, 4)} for each in by_function(run.program)
        ],
        "coverings": [_covering(run.workpiece, each) for each in run.coverings],
        "findings": [finding_data(finding) for finding in run.findings],
    }


def _covering(part: Workpiece, covering: "Covering") -> dict[str, Json]:
    """Give what one template of one step does, as plain data."""
    rounds: list[Json] = [
        {"what": each.what, "held_share": round(each.share, 5), "spray_s": round(each.spray_s, 3)}
        for each in covering.rounds
    ]
    faces: list[Json] = [
        {**asdict(each), "hidden_by": list[Json](each.hidden_by)} for each in face_results(part, covering)
    ]
    return {
        "made_by": str(covering.made_by),
        "required_s": covering.required_s,
        "stripes": covering.stripes,
        "pieces": len(covering.pieces),
        "way_mm": round(sum(piece.length_mm for piece in covering.pieces), 2),
        "air_mm": round(covering.air_mm, 2),
        "uniform": {"held_share": round(covering.uniform_share, 5), "spray_s": round(covering.uniform_s, 3)},
        "held_share": round(covering.share, 5),
        "spray_s": round(covering.spray_s, 3),
        "bound": {
            "spray_s": round(covering.least.seconds, 3),
            "poses": covering.least.poses,
            "apart_mm": round(covering.least.apart_mm, 2),
            "cells": covering.least.cells,
        },
        "rounds": rounds,
        "faces": faces,
    }


def verdict_table(verdicts: Sequence[FaceVerdict]) -> Table:
    """A row for each face and template: its verdict, what is visible and held, and what hides the rest."""
    rows = [
        (
            each.face, each.verdict, f"{each.required_s:g}", f"{each.least_s:.2f}", f"{each.mean_s:.2f}",
            f"{each.visible_share:.1%}", f"{each.held_share:.1%}", f"{each.unseen_mm2:.0f}", ", ".join(each.hidden_by),
        )
        for each in verdicts
    ]  # fmt: skip
    headings = (">required\ns", ">least\ns", ">mean\ns", ">visible", ">held\nof it", ">unseen\nmm2", "hidden by")
    return Table.of(("face", "verdict", *headings), rows)


def part_cleaning_report(
    part: Workpiece, program: TimedProgram, verdicts: Sequence[FaceVerdict], trace: Traceability = _UNTRACED
) -> dict[str, Json]:
    """Give the verdicts on the faces of a part as plain data, with what an operator entered."""
    origin = program.origin
    faces: list[Json] = [
        {
            "face": each.face,
            "made_by": str(each.made_by),
            "verdict": each.verdict,
            "area_mm2": round(each.area_mm2, 2),
            "required_s": each.required_s,
            "visible_share": round(each.visible_share, 5),
            "held_share": round(each.held_share, 5),
            "least_s": round(each.least_s, 3),
            "mean_s": round(each.mean_s, 3),
            "unseen_mm2": round(each.unseen_mm2, 2),
            "hidden_by": list[Json](each.hidden_by),
        }
        for each in verdicts
    ]
    return {
        "washboard_part_cleaning": 1,
        "part": {"name": part.name, "sha256": part.sha256},
        "recipe": {"name": origin.recipe, "sha256": origin.recipe_sha256},
        "verdict": worst_verdict(verdicts),
        **({} if replace(trace, program_sha256="") == _UNTRACED else {"traceability": asdict(trace)}),
        "faces": faces,
    }
