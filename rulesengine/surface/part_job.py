"""A recipe over the faces of a part: the stripes of its templates, covered, repaired and ordered, and ways around."""

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from boards.board import Face, Part
from geometry.arrays import Directions, Indices, Scalars
from geometry.coverage.route import Effort
from geometry.solids.cone_view import Cells
from programs.plan import Plan, PlanItem
from recipes.errors import RecipeError
from recipes.paths import OverFaces, Slices
from recipes.recipe import Recipe, Step
from rulesengine.strokes.classify import Classified
from rulesengine.strokes.laid import Notices, Ordered, Pose
from rulesengine.strokes.stroke import PlanCache
from rulesengine.surface.airways import PartWays, build_airways, lay
from rulesengine.surface.bound import LeastSpray, least_spray
from rulesengine.surface.coverage import cover, find_visible, share_held
from rulesengine.surface.negotiate import negotiate
from rulesengine.surface.order import order_pieces
from rulesengine.surface.repair import Round, repair
from rulesengine.surface.site import PartSite, Piece, build_site, up_of
from rulesengine.surface.striping.divide import Sliced, divide_face
from rulesengine.surface.striping.passes import stripe_passes
from rulesengine.surface.striping.stripe import Stripe
from specs.finding import Finding
from specs.finding_rules import (
    SURFACE_CUT,
    SURFACE_ORDER,
    SURFACE_REPAIR,
    SURFACE_SHORT,
    SURFACE_SLICES,
    SURFACE_UNSEEN,
)
from specs.progress import Progress, no_progress, subprogress
from specs.source import Source

_NOTICED = 0.002
"""Of a face's area: less of it that is not seen or not held is no finding."""


@dataclass(frozen=True, slots=True, eq=False)
class Survey:
    """What can be seen of a part at all, by poses whose lance is free."""

    cells: Cells
    cell_face: Indices
    """(c,) index into the part's faces."""
    visible: NDArray[np.bool_]
    """(c,) by any free pose."""
    hider: Indices
    """(c,) index into the part's bodies of what hides a cell; -1 where it is visible."""


@dataclass(frozen=True, slots=True, eq=False)
class Covering(Survey):
    """What one template of one step does to the faces of a part. The part's frame, mm, s."""

    made_by: Source
    required_s: float
    stripes: int
    """Pieces along stripes: one that is interrupted counts once for each of its parts."""
    pieces: tuple[Piece, ...]
    """In the order and sense in which they are sprayed."""
    air_mm: float
    """Straight travel between them."""
    uniform_share: float
    """Of the visible area that is held for the required time before any repair."""
    uniform_s: float
    """Time with the jet on before any repair."""
    share: float
    rounds: tuple[Round, ...]
    spray_s: float
    """Time with the jet on that the stripes and pauses have, before timing."""
    least: Callable[[], LeastSpray]
    """Proven bound to the time with the jet on, over poses of least tilt; worked out, in seconds, the first time."""
    seconds: Scalars
    """(c,) in the cone."""
    range_mm: float
    """From the orifice: farther the jet does not count."""


@dataclass(frozen=True, slots=True, eq=False)
class _Planned:
    """A template on a part: its strokes in order, and the ways around."""

    covering: Covering
    ordered: Ordered
    findings: tuple[Finding, ...]


@dataclass(frozen=True, slots=True, eq=False)
class PartJob:
    """A recipe on a part."""

    recipe: Recipe
    workpiece: Part
    cache: PlanCache
    planned: dict[tuple[int, str], _Planned] = field(default_factory=dict[tuple[int, str], _Planned])
    """By step and template."""
    findings: tuple[Finding, ...] = ()
    classified: tuple[Classified, ...] = ()

    @property
    def coverings(self) -> tuple[Covering, ...]:
        """What each template of each step does, in the order of the sequence."""
        return tuple(each.covering for each in self.planned.values())

    def start(self, step: Step) -> Pose:
        """The parked pose, whatever the step."""
        return _parked(self.workpiece, self.recipe)

    def turn(self, before: Step, step: Step, pose: Pose, made_by: Source) -> tuple[list[PlanItem], Pose]:
        """A part lies as it lies: nothing is turned over between steps."""
        return [], pose

    def require_bounds(self, again: Mapping[int, int], progress: Progress) -> None:
        """Stripes are as many as the area of the faces allows."""

    def begin(self, index: int, step: Step, pose: Pose, progress: Progress) -> list[Finding]:
        """Plan the templates of a step, each as from the pose before the step.

        Raises:
            RecipeError: no face can be sprayed.
        """
        for done, name in enumerate(step.paths):
            part = subprogress(progress, done / len(step.paths), (done + 1) / len(step.paths))
            function = self.recipe.functions[step.function]
            specs = (self.recipe.templates[name], self.recipe.nozzles[step.nozzle], self.recipe.limits, function)
            key: Hashable = ("part", index, name, pose.tcp.tobytes(), *(each.model_dump_json() for each in specs))
            planned = self.cache.take(key, partial(_plan_template, self, pose, (index, name), part))
            self.planned[index, name] = planned
        return [finding for name in step.paths for finding in self.planned[index, name].findings]

    def order(self, index: int, step: Step, name: str, pose: Pose, effort: Effort, progress: Progress) -> Ordered:
        """The strokes of a template, in the same order whenever it is repeated."""
        return self.planned[index, name].ordered

    def notice(self, plan: Plan, notices: Notices) -> list[Finding]:
        """All that is to be noticed is found template by template."""
        return []

    def nothing_to_spray(self) -> RecipeError:
        """Error where all templates come out empty."""
        return RecipeError(f"there is nothing to spray on {self.workpiece.name}.", path="sequence")


def survey_part(recipe: Recipe, part: Part, progress: Progress = no_progress) -> Survey:
    """Find what can be seen of the served faces of a part with the nozzle of a recipe's first step over surfaces.

    Raises:
        RecipeError: no step follows the faces of parts.
    """
    for index, step in enumerate(recipe.sequence):
        for name in step.paths:
            spec = recipe.templates[name]
            if step.enabled and isinstance(spec, OverFaces):
                site = build_site(part, recipe, Source(index, name))
                sight = find_visible(site, np.zeros(len(site.cells.points), dtype=np.bool_), progress)
                return Survey(site.cells, site.cell_face, sight.visible, sight.hider)
    raise RecipeError("no step has a template with path: surface or slices. Name a recipe for parts.", path="sequence")


def _plan_template(job: PartJob, start: Pose, what: tuple[int, str], progress: Progress) -> _Planned:
    (index, name), recipe, part = what, job.recipe, job.workpiece
    made_by = Source(index, name)
    progress("building the scene", 0.0)
    site = build_site(part, recipe, made_by)
    spec = site.spec
    if site.range_mm < spec.standoff_mm and site.film is None:
        raise RecipeError(
            f"the standoff of {spec.standoff_mm:g} mm is beyond the {site.range_mm:g} mm that the jet reaches "
            "(nozzles.*.range_mm). Lower standoff_mm.",
            path=f"templates.{name}.standoff_mm",
        )
    divided = [_divide(site, face) for face in part.served]
    stripes = [stripe for each in divided for stripe in (each.stripes if isinstance(each, Sliced) else each)]
    sliced = [Finding(SURFACE_SLICES, each.text, made_by) for each in divided if isinstance(each, Sliced)]
    negotiated = negotiate(site, stripes, subprogress(progress, 0.05, 0.4))
    pieces = [piece for each in negotiated for piece in each]
    if not pieces:
        raise RecipeError(
            f"no face of {part.name} can be sprayed: the lance meets a body everywhere. Raise standoff_mm or "
            "tilt_max_deg, or make nozzles.*.body smaller.",
            path=f"templates.{name}",
        )
    covered = cover(site, pieces)
    sight = find_visible(site, covered.seconds > 0, subprogress(progress, 0.45, 0.7))
    uniform = covered
    rounds: tuple[Round, ...] = ()
    if spec.repair:
        covered, rounds = repair(site, covered, sight, subprogress(progress, 0.7, 0.9))
    ordered = order_pieces(covered.pieces, start.tcp, spec.order, subprogress(progress, 0.9, 0.95))
    covering = Covering(
        made_by=made_by,
        required_s=spec.required_s,
        stripes=sum(len(piece.tcp) > 1 for piece in covered.pieces),
        pieces=ordered.pieces,
        air_mm=ordered.air_mm,
        uniform_share=share_held(site, uniform, sight),
        uniform_s=uniform.spray_s,
        share=share_held(site, covered, sight),
        rounds=rounds,
        spray_s=covered.spray_s,
        least=cache(partial(least_spray, site, covered, sight)),
        cells=site.cells,
        cell_face=site.cell_face,
        seconds=covered.seconds,
        range_mm=site.range_mm,
        visible=sight.visible,
        hider=sight.hider,
    )
    progress("building the ways around", 0.95)
    ways = PartWays(_parked(part, recipe), build_airways(site, up_of(part)))
    cut = sum(len(each) != 1 for each in negotiated)
    strokes = tuple(lay(site, piece) for piece in ordered.pieces)
    return _Planned(covering, Ordered(strokes, ways), (*sliced, *_findings(part, covering, cut)))


def _divide(site: PartSite, face: Face) -> list[Stripe] | Sliced:
    """Stripes of a face; passes where they are to lay a film."""
    spec = site.spec
    if isinstance(spec, Slices) and site.film is not None:
        return stripe_passes(site, spec, site.film, face)
    return divide_face(site, face)


def _findings(part: Part, covering: Covering, cut: int) -> list[Finding]:
    """What is to be noticed: order, interrupted stripes, rounds of the repair, what is not seen and not held."""
    made_by = covering.made_by
    way = sum(piece.length_mm for piece in covering.pieces)
    text = (
        f"{covering.stripes} stripes on {len(part.served)} faces: {way:.0f} mm over the surface, "
        f"{covering.air_mm:.0f} mm straight between them."
    )
    found = [Finding(SURFACE_ORDER, text, made_by)]
    if cut:
        text = f"{cut} stripes are interrupted or left out where no pose within the limits of tilt is free."
        found.append(Finding(SURFACE_CUT, text, made_by))
    before = (covering.uniform_share, covering.uniform_s)
    for number, each in enumerate(covering.rounds, start=1):
        text = (
            f"round {number}: {each.what}: {before[0]:.1%} of the visible area held in {before[1]:.1f} s became "
            f"{each.share:.1%} in {each.spray_s:.1f} s."
        )
        found.append(Finding(SURFACE_REPAIR, text, made_by))
        before = (each.share, each.spray_s)
    return [*found, *_unseen(part, covering), *_short(part, covering)]


def _unseen(part: Part, covering: Covering) -> list[Finding]:
    areas, found = covering.cells.areas_mm2, list[Finding]()
    for number, face in enumerate(part.faces):
        hidden = (covering.cell_face == number) & ~covering.visible
        area = float(areas[hidden].sum())
        if face.serve and area > _NOTICED * face.area_mm2:
            by = np.bincount(covering.hider[hidden], areas[hidden], len(part.bodies))
            names = [part.bodies[body].name for body in np.argsort(-by, kind="stable") if by[body] > 0.1 * area]
            text = (
                f"{area:.0f} of {face.area_mm2:.0f} mm2 of {face.name} are seen by no free pose within the range of "
                f"{covering.range_mm:.0f} mm; hidden by {' and '.join(names)}."
            )
            found.append(Finding(SURFACE_UNSEEN, text, replace(covering.made_by, components=(face.name,))))
    return found


def _short(part: Part, covering: Covering) -> list[Finding]:
    areas, found = covering.cells.areas_mm2, list[Finding]()
    for number, face in enumerate(part.faces):
        own = (covering.cell_face == number) & covering.visible
        lacking = own & (covering.seconds < covering.required_s * (1 - 1e-9))
        share = float(areas[lacking].sum() / max(areas[own].sum(), 1e-12))
        if share > 0.01:
            worst = int(np.flatnonzero(lacking)[np.argmin(np.round(covering.seconds[lacking], 6))])
            x, y, z = covering.cells.points[worst].tolist()
            text = (
                f"{share:.1%} of what can be seen of {face.name} is in the cone for less than "
                f"{covering.required_s:g} s, the least {covering.seconds[worst]:.2f} s. Repair it (repair: true), "
                "raise required_s, or take narrower stripes."
            )
            made_by = replace(covering.made_by, components=(face.name,))
            found.append(Finding(SURFACE_SHORT, text, made_by, (x, y, z)))
    return found


def _parked(part: Part, recipe: Recipe) -> Pose:
    """Above the middle of the part, away from what it stands on, pointing at it."""
    up = up_of(part)
    own, everything = part.patches.reshape(-1, 3), np.concatenate([body.patches.reshape(-1, 3) for body in part.bodies])
    corners = np.unique(np.round(own, 4), axis=0)
    middle = corners.mean(axis=0)
    height = float((everything @ up).max() - middle @ up) + recipe.limits.park_height_mm
    return Pose(middle + up * height, -up, _reference(part, -up))


def _reference(part: Part, approach: Directions) -> Directions:
    """(3,) tool +X at the parked pose: along the first edge of the part that is not along the jet."""
    for patch in part.patches:
        for edge in (patch[1] - patch[0], patch[2] - patch[0]):
            across = edge - approach * float(edge @ approach)
            if np.linalg.norm(across) > 0.1 * np.linalg.norm(edge):
                return across / np.linalg.norm(across)
    raise AssertionError("a part has patches in more than one direction")
