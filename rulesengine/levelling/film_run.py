"""Planning with films: numbers for what a template leaves to the planner, passes, and levelled speeds along them.

A recipe without a film is planned as it is.
"""

from collections.abc import Callable
from dataclasses import replace

from boards.board import Workpiece
from cleaning.exposure.segment_rates import film_of_pass
from cleaning.jet.jet import form_of
from cleaning.parameters.load import load_parameters
from geometry.coverage.spacing import find_spacings, overlap
from programs.plan import Plan
from recipes.errors import RecipeError
from recipes.paths import Film, Slices
from recipes.recipe import Recipe, film_in, film_of, has_film
from rulesengine.levelling.level_plan import level_plan
from rulesengine.levelling.report import Goal, LevelReport
from rulesengine.planning.pipeline import Fitted, Run, require_fit, run
from rulesengine.strokes.step_commands import jet_of
from rulesengine.strokes.workload import require_totals
from rulesengine.timing.time_plan import ACCELERATION_SHARE, time_plan
from specs.finding import Finding, worst_first
from specs.finding_rules import FILM_LEVELLED, FILM_UNEVEN
from specs.progress import Progress, no_progress, subprogress

_RIPPLE = 0.35
"""Of the tolerance: the widest spacing whose ripple on a flat plate is no more leaves the rest for the surface."""
_LEAST_WIDTH = 0.1
"""Of the pattern's width: narrower spacings overlap ten times and more."""
_LATER = 0.4
"""Share of the work before levelling."""
_MOST_OVERSHOOT_MM = 1000.0
_MARGIN_MM = 5.0
_TOUCHED_S = 0.01


def run_levelled(
    recipe: Recipe,
    workpiece: Workpiece,
    progress: Progress = no_progress,
    sketched: Callable[[Plan], None] | None = None,
    before: Run | None = None,
) -> Run:
    """Plan and time a recipe on a workpiece, and level the speeds of what lays a film; arguments as for ``run``.

    Raises:
        RecipeError: as ``run`` does, or no spacing lays the film at an allowed speed.
    """
    if not has_film(recipe):
        return run(recipe, workpiece, progress, sketched, before)
    laid = lay_films(recipe, workpiece, subprogress(progress, 0.0, _LATER), sketched, before)
    return level_run(laid, progress=subprogress(progress, _LATER, 1.0))[0]


def lay_films(
    recipe: Recipe,
    workpiece: Workpiece,
    progress: Progress = no_progress,
    sketched: Callable[[Plan], None] | None = None,
    before: Run | None = None,
) -> Run:
    """Plan and time a recipe as ``run_levelled`` does, with the passes of films at one speed.

    Raises:
        RecipeError: as there.
    """
    require_fit(recipe, workpiece)
    planned = Fitted(recipe, fit_films(recipe)) if has_film(recipe) else recipe
    return run(planned, workpiece, progress, sketched, before)


def level_run(
    laid: Run, goal: Goal = "even-film", film_um: float | None = None, progress: Progress = no_progress
) -> tuple[Run, LevelReport]:
    """Level the speeds of a run; arguments as for ``level_plan``, findings on how even films become.

    Raises:
        RecipeError: there is nothing to level, or it takes more than a day or 1,000 litres.
    """
    plan, report = level_plan(laid.plan, laid.workpiece, laid.fitted, goal, film_um, progress)
    program = time_plan(plan, laid.fitted.limits)
    require_totals(program.totals.duration_s, sum(litres for _, litres in program.totals.liquid_l))
    own = set(laid.program.findings)
    kept = [each for each in laid.findings if each not in own]
    found = worst_first([*kept, *program.findings, *_findings(laid.recipe, report)])
    return replace(laid, plan=plan, program=program, findings=found), report


def _findings(recipe: Recipe, report: LevelReport) -> list[Finding]:
    found: list[Finding] = []
    for step in report.steps:
        film = None if step.made_by.step is None else film_of(recipe, step.made_by.step)
        if film is None or step.target_um != film.thickness_um:
            continue
        before, laid = step.before.finer, step.timed.finer
        reached = f"{laid.least:.2f} to {laid.most:.2f} µm, ±{laid.deviation:.2%} of {film.thickness_um:g} µm"
        where = f"on {laid.cells:,} cells finer than those of the linear program"
        text = f"levelled to {reached}, {where}; at one speed ±{before.deviation:.2%}."
        if not step.levelled:
            text = f"laid at one speed, {reached}, {where}: levelled it would be no more even."
        found.append(Finding(FILM_LEVELLED, text, step.made_by))
        if laid.deviation * film.thickness_um > film.tolerance_um:
            text = (
                f"±{laid.deviation * film.thickness_um:.2f} µm is reached where tolerance_um is {film.tolerance_um:g}. "
                "Take a narrower spacing_mm or more overshoot_mm, raise limits.acceleration_mm_s2, or lay thinner "
                "films more often."
            )
            found.append(Finding(FILM_UNEVEN, text, step.made_by))
    return found


def fit_films(recipe: Recipe) -> Recipe:
    """Put numbers in place of what templates with a film leave to the planner: spacing, overshoot, speed.

    Raises:
        RecipeError: no even spacing lays the film at an allowed speed.
    """
    templates = dict(recipe.templates)
    for index, step in enumerate(recipe.sequence):
        for name in step.paths if step.enabled else ():
            spec = recipe.templates[name]
            if isinstance(spec, Slices) and (film := film_in(spec)) is not None:
                templates[name] = _fitted(recipe, index, name, spec, film)
    return recipe.model_copy(update={"templates": templates})


def _fitted(recipe: Recipe, index: int, name: str, spec: Slices, film: Film) -> Slices:
    step = recipe.sequence[index]
    function, times = recipe.functions[step.function], step.repeat * step.paths.count(name)
    flow = jet_of(recipe, step).flow_lpm * film.deposited * times
    form = form_of(recipe.nozzles[step.nozzle], flow, load_parameters("default").spray)
    across, laid = film_of_pass(form, spec.standoff_mm)
    width = float(across[-1] - across[0])
    fastest = function.max_speed_mm_s
    if film.max_speed_mm_s != "auto":
        fastest = min(fastest, film.max_speed_mm_s)
    if spec.spacing_mm == "auto":
        valleys = find_spacings(across, laid, _LEAST_WIDTH * width)
        allowed = [each for each in valleys if each.middle / film.thickness_um <= fastest]
        if not allowed:
            slowest = valleys[0].middle / film.thickness_um if valleys else float("inf")
            raise RecipeError(
                f"no even spacing of passes lays {film.thickness_um:g} µm at {fastest:g} mm/s or less: the widest "
                f"needs {slowest:.0f} mm/s. Lower the flow, allow more speed, or lay a thicker film.",
                path=f"templates.{name}.film",
            )
        enough = [each for each in allowed if each.ripple <= _RIPPLE * film.tolerance_um / film.thickness_um]
        chosen = enough[0] if enough else min(allowed, key=lambda each: each.ripple)
    else:
        chosen = overlap(across, laid, spec.spacing_mm)
    speed = min(chosen.middle / film.thickness_um, fastest) if film.speed_mm_s == "auto" else film.speed_mm_s
    ramp = speed**2 / (2.0 * ACCELERATION_SHARE * recipe.limits.acceleration_mm_s2)
    over = min(width / 2.0 + ramp + _MARGIN_MM, _MOST_OVERSHOOT_MM)
    fitted = film.model_copy(update={"speed_mm_s": speed})
    return spec.model_copy(update={
        "film": fitted,
        "spacing_mm": chosen.spacing,
        "overshoot_mm": over if spec.overshoot_mm == "auto" else spec.overshoot_mm,
        "required_s": _TOUCHED_S,  # of a film counts what it lays, and in a plan whether the jet comes by at all
        "repair": False,
    })  # fmt: skip
