"""Everything an independent reader of a program may complain about, for one run; also runs by hand on any board.

python tests/support/acceptance.py BOARD RECIPE [PARTS]
"""

import sys
from pathlib import Path

import judge
import judge_space
import numpy as np
from shapely import MultiPoint

from programs import native
from recipes.nozzles import FullCone, HollowCone
from recipes.paths import ComponentPerimeter, Raster, StepFunction, for_class
from rulesengine.strokes.classify import read_masks

_ROUNDING_TURNS = 2e-3


def complaints(run):
    """List what is wrong with a run's program, read back from its text; empty if nothing is."""
    track = judge.read_track(native.render(run.program))
    limits = run.fitted.limits
    speeds = {name: function.max_speed_mm_s for name, function in run.fitted.functions.items()}
    triangles = np.concatenate([body.patches for body in run.board.bodies])
    return [
        *judge.times_running_back(track),
        *judge.wrong_totals(track),
        *judge.wrong_stated_speeds(track),
        *judge.too_fast(track, speeds),
        *judge.too_sharp(track, limits.acceleration_mm_s2),
        *judge.turning_too_fast(track, limits.rotation_deg_s),
        *judge.turning_too_sharply(track, limits.rotation_acceleration_deg_s2),
        *judge.spraying_in_transfers(track),
        *judge.jet_on_at_end(track),
        *judge_space.too_close(track, triangles, limits.clearance_mm),
        *_path_complaints(run, track),
    ]


def _path_complaints(run, track):
    for index, step in enumerate(run.fitted.sequence):
        for name in step.paths if step.enabled else ():
            spec, maker = run.fitted.templates[name], f"sequence[{index}]/{name}"
            told = {each.rule.id: each.message for each in run.findings if str(each.made_by) == maker}
            if isinstance(spec, ComponentPerimeter):
                yield from _uncircled(run, track, spec, step, maker, told)
            elif "cut-by-mask" in told:
                continue  # what is left of its lines is neither a cover nor a line
            elif isinstance(spec, Raster):
                yield from _unwetted(run, track, spec, step, maker, told)
            elif isinstance(spec, StepFunction):
                classes = {each.component: each.component_class for each in run.classified}
                served = [each for each in _served(run, step.side) if for_class(spec.delay_s, classes[each.name]) > 0]
                outlines = {each.name: each.outline for each in served}
                yield from judge_space.wrong_pauses(track, maker, outlines, run.board.surface_z_mm(step.side))


def _served(run, side):
    """Components of a side that are neither avoided nor ignored."""
    read, _ = read_masks(run.fitted, run.board)
    apart = read.ignored | set(dict(read.avoided))
    return [each for each in run.board.components if each.side == side and each.name not in apart]


def _uncircled(run, track, spec, step, maker, told):
    bodies = {body.name: body for body in run.board.bodies}
    classes = {each.component: each.component_class for each in run.classified}
    components = [each for each in _served(run, step.side) if classes[each.name] in (spec.only or run.fitted.classes)]
    centres = {}
    for each in components:
        middle = MultiPoint(bodies[each.name].patches.reshape(-1, 3)[:, :2]).convex_hull.centroid
        centres[each.name] = (middle.x, middle.y)
    turns = judge_space.turns_around(track, maker, centres)
    excused = {
        name.rstrip(".")
        for each in run.findings
        if each.rule.id == "not-circled" and str(each.made_by).startswith(maker)
        for name in each.message.replace(",", " ").split()
    }
    excused |= set(told.get("cut-by-mask", "").replace("+", " ").replace(",", " ").replace(".", " ").split())
    for each in components:
        asked = for_class(spec.passes, classes[each.name])
        if spec.near and spec.near.passes is not None and each.neighbour_mm <= spec.near.within_mm:
            asked = spec.near.passes
        asked *= step.repeat * step.paths.count(maker.split("/")[1])
        if each.name not in excused and turns.get(each.name, 0.0) < asked - _ROUNDING_TURNS:
            yield f"{maker}: {each.name} is circled {turns.get(each.name, 0.0):.2f} times instead of {asked}"


def _unwetted(run, track, spec, step, maker, told):
    nozzle = run.fitted.nozzles[step.nozzle]
    area = run.board.outline.buffer(-max(spec.margin_mm, 0.0))
    is_cone = isinstance(nozzle, HollowCone | FullCone)
    # A margin that leaves nothing promises nothing, and neither does a pitch that is wider than the spray.
    if area.is_empty or not is_cone or "pitch-too-wide" in told or spec.repeats == 0:
        return
    share = judge_space.covered_share(
        track, maker.__eq__, nozzle.half_angle_deg, run.board.surface_z_mm(step.side), area
    )
    if share < 0.995:
        yield f"{maker}: only {100 * share:.2f} % of the board is inside the cone"


def _main(board, recipe="smt-aqueous", parts=None):
    from boards.load import load_board
    from recipes.load import load_recipe
    from rulesengine.planning.pipeline import run

    done = run(load_recipe(recipe), load_board(Path(board), Path(parts) if parts else None))
    wrong = complaints(done)
    sys.stdout.write("\n".join([f"{board} {recipe}: {len(wrong)} complaints", *wrong[:40], ""]))


if __name__ == "__main__":
    _main(*sys.argv[1:])
