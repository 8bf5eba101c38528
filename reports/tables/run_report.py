"""A run over a board or a part, and the verdicts on a part's faces, as plain data."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from boards.board import Workpiece
from geometry.arrays import Indices, Scalars
from programs.program import TimedProgram
from programs.summary import by_function
from rulesengine.planning.fit_recipe import fitted_heights, left_out
from rulesengine.planning.spray_findings import landed_shares, served_by
from specs.finding import finding_data
from specs.json import Json
from specs.source import Source

if TYPE_CHECKING:
    from cleaning.part_faces import FaceVerdict
    from cleaning.part_film import FilmOnFace
    from cleaning.report import Traceability
    from rulesengine.planning.pipeline import Run
    from rulesengine.surface.part_job import Covering


def report(run: "Run") -> dict[str, Json]:
    """Collect totals, functions, classes, components and findings; the same run gives the same data."""
    origin = run.plan.origin
    return {
        "washboard_report": 1,
        "board": {"name": origin.board, "sha256": origin.board_sha256},
        "recipe": {"name": origin.recipe, "sha256": origin.recipe_sha256},
        **_robot(run),
        "fitted": {
            "height_mm": dict[str, Json](fitted_heights(run.recipe, run.fitted)),
            "again": {str(Source(step)): times for step, times in run.again.items()},
            "left_out": [str(Source(step)) for step in left_out(run.recipe, run.fitted)],
        },
        "totals": _totals(run.program),
        "functions": [
            {key: round(value, 4) if isinstance(value, float) else value for key, value in asdict(each).items()}
            for each in by_function(run.program)
        ],
        "sprayed": [
            {
                "made_by": str(each.made_by),
                **_rounded(each, seconds=4, height_mm=3),
                "landed_share": round(each.share, 4),
                "half_landed_mm": None if each.mended_mm is None else round(each.mended_mm, 3),
            }
            for each in landed_shares(run.recipe, run.board, run.plan.items)
        ],
        "classes": dict(class_counts(run)),
        "components": _components(run),
        "findings": [finding_data(finding) for finding in run.findings],
    }


def _robot(run: "Run") -> dict[str, Json]:
    """Cell and times of its robot, where the program is timed for one."""
    timing, origin = run.robot, run.program.origin
    if timing is None:
        return {}
    price: dict[str, Json] = {kind: round(seconds, 4) for kind, seconds in timing.price_s}
    times = _rounded(timing, free_s=4, planned_s=4, robot_s=4, added_s=4)
    return {"cell": {"name": origin.cell, "sha256": origin.cell_sha256}, "robot": {**times, "price_s": price}}


def _rounded(item: object, **digits: int) -> dict[str, Json]:
    """Give some numbers of an object by their names, each rounded to so many digits."""
    return {name: round(getattr(item, name), places) for name, places in digits.items()}


def _totals(program: TimedProgram) -> dict[str, Json]:
    totals = _rounded(program.totals, duration_s=4, spray_s=4, travel_mm=3, moves=0)
    return {**totals, "liquid_l": {name: round(litres, 4) for name, litres in program.totals.liquid_l}}


def class_counts(run: "Run") -> dict[str, int]:
    """Members of each class, in the recipe's order."""
    counts = Counter(each.component_class for each in run.classified)
    return {name: counts[name] for name in run.recipe.classes}


def _components(run: "Run") -> list[Json]:
    passes = served_by(run.plan.items)
    return [
        {
            "name": component.name,
            "class": classified.component_class,
            "because": classified.because,
            "package": component.package,
            "pins": component.pins,
            "side": component.side,
            "height_mm": round(component.height_mm, 3),
            "height_source": component.height_source,
            "area_mm2": round(component.area_mm2, 3),
            "standoff_mm": component.gap_height_mm,
            "standoff_source": component.gap_height_source,
            "neighbour_mm": component.neighbours[0][1] if component.neighbours else None,
            "served_by": list[Json](sorted(passes.get(component.name, []))),
        }
        for component, classified in zip(run.board.components, run.classified, strict=True)
    ]


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
    origin = run.plan.origin
    return {
        "washboard_report": 1,
        "part": {"name": origin.board, "sha256": origin.board_sha256},
        "recipe": {"name": origin.recipe, "sha256": origin.recipe_sha256},
        "totals": _totals(run.program),
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
    faces = [{**asdict(each), "hidden_by": list[Json](each.hidden_by)} for each in face_results(part, covering)]
    return {
        "made_by": str(covering.made_by),
        "required_s": covering.required_s,
        "range_mm": round(covering.range_mm, 2),
        "stripes": covering.stripes,
        "pieces": len(covering.pieces),
        "way_mm": round(sum(piece.length_mm for piece in covering.pieces), 2),
        "air_mm": round(covering.air_mm, 2),
        "uniform": {"held_share": round(covering.uniform_share, 5), "spray_s": round(covering.uniform_s, 3)},
        "held_share": round(covering.share, 5),
        "spray_s": round(covering.spray_s, 3),
        "bound": {
            "spray_s": round(covering.least().seconds, 3),
            **_rounded(covering.least(), poses=0, apart_mm=2, cells=0),
        },
        "rounds": rounds,
        "faces": list[Json](faces),
    }


def _film(film: "FilmOnFace") -> dict[str, Json]:
    """A film as plain data, rounded."""
    return {
        name: [round(number, 2) for number in value] if isinstance(value, tuple) else round(value, 5)
        for name, value in asdict(film).items()
    }


def part_cleaning_report(
    part: Workpiece, program: TimedProgram, verdicts: "Sequence[FaceVerdict]", trace: "Traceability | None" = None
) -> dict[str, Json]:
    """Give the verdicts on the faces of a part as plain data, with what an operator entered."""
    from cleaning.part_faces import weigh_faces  # late: a report of a plan needs nothing of the model

    origin, found = program.origin, weigh_faces(verdicts)
    entered = trace is not None and any(asdict(replace(trace, program_sha256="")).values())
    digits = {
        "visible_share": 5,
        "held_share": 5,
        "least_s": 3,
        "mean_s": 3,
        "unseen_mm2": 2,
        "short_mm2": 2,
        "lacking_s": 3,
    }
    faces: list[Json] = [
        {
            "face": each.face,
            "made_by": str(each.made_by),
            "verdict": each.verdict,
            "area_mm2": round(each.area_mm2, 2),
            "required_s": each.required_s,
            **_rounded(each, **digits),
            "hidden_by": list[Json](each.hidden_by),
            **({} if each.film is None else {"film": _film(each.film)}),
        }
        for each in verdicts
    ]
    return {
        "washboard_part_cleaning": 1,
        "part": {"name": part.name, "sha256": part.sha256},
        "recipe": {"name": origin.recipe, "sha256": origin.recipe_sha256},
        "verdict": found.verdict,
        **_rounded(found, held_share=5, short_mm2=2, lacking_s=3),
        **({"traceability": asdict(trace)} if trace is not None and entered else {}),
        "faces": faces,
    }
