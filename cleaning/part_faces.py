"""Verdicts on the faces of a part: the time in the cone of a program, as Sandia 1993, section 2.4, analyses it.

Only exposure: a part has no components and no gaps that the model of boards would follow.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from boards.board import Part, scene_of
from boards.part.cells import served_cells
from cleaning.jet.drops import spray_cone
from cleaning.part_film import FilmOnFace, LaidFilm, film_laid, film_on_face
from cleaning.verdicts.rules import VERDICTS, Verdict
from geometry.arrays import Indices, Scalars
from geometry.solids.cone_view import Cells, Stretch, cells_in_view, turns_between
from programs.playback import Timeline, build_timeline, play
from programs.program import TimedProgram
from recipes.paths import OverFaces
from recipes.recipe import Recipe, film_in
from specs.progress import Progress, no_progress
from specs.source import Source

CLEAN_SHARE = 0.99
"""Of the visible area of a face, held for the required time: clean from here on."""
MARGINAL_SHARE = 0.95
MISSED_SHARE = 0.005
"""Of the visible area of a part: with a dirty face that lacks more than this the part is not clean."""
_MOMENT_S = 0.02
"""Between moments at which the cone is looked at; what is held is known to half of it."""


@dataclass(frozen=True, slots=True, eq=False)
class HeldTimes:
    """How long one template of one step keeps each cell of a part in the cone."""

    made_by: Source
    required_s: float
    cells: Cells
    cell_face: Indices
    """(c,) index into ``part.faces``."""
    seconds: Scalars
    """(c,)"""
    film: LaidFilm | None = None
    """What it lays, where the template states a film."""


@dataclass(frozen=True, slots=True)
class FaceVerdict:
    """What one template does to one face."""

    face: str
    made_by: Source
    verdict: Verdict
    area_mm2: float
    required_s: float
    visible_share: float
    """Of its area, by any free pose of the nozzle."""
    held_share: float
    """Of what is visible; of a film what is within its tolerance."""
    least_s: float
    mean_s: float
    unseen_mm2: float
    hidden_by: tuple[str, ...]
    short_mm2: float = 0.0
    """Visible, and held for less than the required time."""
    lacking_s: float = 0.0
    """Of the required time, in the mean over that area."""
    film: FilmOnFace | None = None
    """Where the template states a film, which decides then."""


@dataclass(frozen=True, slots=True)
class PartVerdict:
    """What a program does to a part: its faces weighed by their visible area."""

    verdict: Verdict
    held_share: float
    """Of the visible area, in the template that holds the least."""
    short_mm2: float
    """Visible in all, and held for less than the required time, in that template."""
    lacking_s: float
    """Of the required time, in the mean over that area."""


def times_in_cone(
    program: TimedProgram, part: Part, recipe: Recipe, progress: Progress = no_progress
) -> tuple[HeldTimes, ...]:
    """Follow a program over a part and add up the time that each cell is in the cone and seen from the orifice.

    Args:
        program: Planned on the part.
        part: With its fixtures, which hide too.
        recipe: The program's: it has the nozzles and the required times.
        progress: Receives the stage and the share done.

    Returns:
        One for each template of each step that follows surfaces, in the order of the sequence.

    Raises:
        ProgramError: the program has no move.
    """
    timeline = build_timeline(program)
    count = max(1, int(np.ceil(float(timeline.times[-1]) / _MOMENT_S)))
    each_s = float(timeline.times[-1]) / count
    states = play(timeline, (np.arange(count, dtype=np.float64) + 0.5) * each_s)
    motion = _motions(timeline, count, each_s)
    found, scene = served_cells(part), scene_of(part)
    held: list[HeldTimes] = []
    sprayed = [(index, name) for index, step in enumerate(recipe.sequence) if step.enabled for name in step.paths]
    for done, (index, name) in enumerate(dict.fromkeys(sprayed)):
        spec, nozzle = recipe.templates[name], recipe.nozzles[recipe.sequence[index].nozzle]
        if isinstance(spec, OverFaces):
            cone = spray_cone(nozzle, recipe.functions[recipe.sequence[index].function], spec)
            mine = np.array([maker.place == Source(index, name) for maker in states.makers], dtype=np.bool_)
            rows = np.flatnonzero(states.spraying & mine[states.made_by])
            stretch = Stretch(motion.ways[rows], motion.turns[rows])
            view = cells_in_view(found.cells, scene, cone, states.tcp[rows], states.approach[rows], stretch)
            seconds = np.asarray(view.sum(axis=0), dtype=np.float64).ravel() * each_s
            place = Source(index, name)
            laid = None if film_in(spec) is None else film_laid(program, part, recipe, place)
            held.append(HeldTimes(place, spec.required_s, found.cells, found.face, seconds, laid))
        progress("time in the cone", (done + 1) / len(sprayed))
    return tuple(held)


def _motions(timeline: Timeline, count: int, each_s: float) -> Stretch:
    """How the nozzle moves in each of (count,) moments, whose states are those of their middles."""
    ends = play(timeline, np.arange(count + 1, dtype=np.float64) * each_s)
    return Stretch(np.diff(ends.tcp, axis=0), turns_between(ends.approach))


def is_held(times: HeldTimes) -> NDArray[np.bool_]:
    """(c,) cells in the cone for the required time, to half a moment, or with the film that is required."""
    if times.film is not None:
        return times.film.is_within[times.film.nearest(times.cells.points)]
    return np.asarray(times.seconds >= times.required_s - _MOMENT_S / 2)


def judge_faces(
    part: Part, held: tuple[HeldTimes, ...], visible: NDArray[np.bool_], hider: Indices
) -> tuple[FaceVerdict, ...]:
    """Judge each served face under each template; what no free pose sees does not count, and is listed.

    Args:
        part: The part.
        held: ``times_in_cone``.
        visible: (c,) cells that some free pose sees.
        hider: (c,) index into the part's bodies of what hides a cell.
    """
    found: list[FaceVerdict] = []
    for times in held:
        for number, face in enumerate(part.faces):
            if face.serve:
                own = times.cell_face == number
                found.append(_judge(part, number, times, (own & visible, own & ~visible), hider))
    return tuple(found)


def _judge(
    part: Part, number: int, times: HeldTimes, cells: tuple[NDArray[np.bool_], NDArray[np.bool_]], hider: Indices
) -> FaceVerdict:
    seen, unseen = cells
    areas, face = times.cells.areas_mm2, part.faces[number]
    visible, hidden = float(areas[seen].sum()), float(areas[unseen].sum())
    enough = seen & is_held(times)
    share = float(areas[enough].sum()) / visible if visible > 0 else 0.0
    film = None
    if times.film is not None and visible > 0:
        laid = times.film
        at = KDTree(times.cells.points).query(laid.cells.points)[1]
        mine = (laid.cells.face == number) & (seen | ~(times.cell_face == number))[at]
        film = film_on_face(laid, mine)
        share = film.within_share
    by = np.bincount(hider[unseen], areas[unseen], len(part.bodies)) if hidden > 0 else np.zeros(len(part.bodies))
    short = seen & ~is_held(times)
    lacking, lost = float(areas[short].sum()), float((areas * (times.required_s - times.seconds))[short].sum())
    least = float(times.seconds[seen].min()) if seen.any() else 0.0
    mean = float((times.seconds[seen] * areas[seen]).sum() / max(visible, 1e-12))
    hiders = [part.bodies[body].name for body in np.argsort(-by, kind="stable").tolist() if by[body] > 0.1 * hidden]
    return FaceVerdict(
        face=face.name,
        made_by=times.made_by,
        verdict=_verdict_of(share) if visible > 0 else "no verdict",
        area_mm2=face.area_mm2,
        required_s=times.required_s,
        visible_share=visible / max(visible + hidden, 1e-12),
        held_share=share,
        least_s=least,
        mean_s=mean,
        unseen_mm2=hidden,
        hidden_by=tuple(hiders) if hidden > 0 else (),
        short_mm2=lacking if film is None else film.thin_mm2 + film.thick_mm2,
        lacking_s=lost / lacking if lacking > 0 and film is None else 0.0,
        film=film,
    )


def _verdict_of(share: float) -> Verdict:
    return "clean" if share >= CLEAN_SHARE else "marginal" if share >= MARGINAL_SHARE else "dirty"


def weigh_faces(faces: Sequence[FaceVerdict]) -> PartVerdict:
    """Judge a part by the share of its visible area that is held, template by template; the worst one decides.

    A face that is dirty, and lacks more than half a percent of the part's visible area, keeps it from being clean.
    """
    found: list[PartVerdict] = []
    for maker in dict.fromkeys(each.made_by for each in faces):
        mine = [each for each in faces if each.made_by == maker and each.verdict != "no verdict"]
        visible = sum(each.area_mm2 * each.visible_share for each in mine)
        if visible <= 0:
            continue
        short = sum(each.short_mm2 for each in mine)
        lost = sum(each.short_mm2 * each.lacking_s for each in mine)
        verdict = _verdict_of(1.0 - short / visible)
        missed = any(each.verdict == "dirty" and each.short_mm2 > MISSED_SHARE * visible for each in mine)
        if verdict == "clean" and missed:
            verdict = "marginal"
        found.append(PartVerdict(verdict, 1.0 - short / visible, short, lost / short if short > 0 else 0.0))
    nothing = PartVerdict("no verdict", 0.0, 0.0, 0.0)
    return min(found, key=lambda each: (VERDICTS.index(each.verdict), each.held_share), default=nothing)
