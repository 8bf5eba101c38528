"""A run as plain data: what ``--report`` writes and the summary prints."""

from collections import Counter, defaultdict
from dataclasses import asdict
from typing import TYPE_CHECKING

from boards.board import STATED_HEIGHT, Board
from boards.undersides.underside import undersides_of
from programs.summary import by_function
from rulesengine.planning.fit_recipe import fitted_heights, left_out
from rulesengine.planning.landed_spray import landed_shares
from rulesengine.planning.unserved import served_by
from specs.finding import finding_data
from specs.json import Json
from specs.source import Source

if TYPE_CHECKING:
    from rulesengine.planning.pipeline import Run


def report(run: "Run") -> dict[str, Json]:
    """Collect totals, functions, classes, components and findings; the same run gives the same data."""
    totals = run.program.totals
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
        "totals": {
            "duration_s": round(totals.duration_s, 4),
            "spray_s": round(totals.spray_s, 4),
            "travel_mm": round(totals.travel_mm, 3),
            "moves": totals.moves,
            "liquid_l": {name: round(litres, 4) for name, litres in totals.liquid_l},
        },
        "functions": [
            {key: round(value, 4) if isinstance(value, float) else value for key, value in asdict(each).items()}
            for each in by_function(run.program)
        ],
        "sprayed": [
            {
                "made_by": str(each.made_by),
                "seconds": round(each.seconds, 4),
                "height_mm": round(each.height_mm, 3),
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
    times = {name: round(getattr(timing, name), 4) for name in ("free_s", "planned_s", "robot_s", "added_s")}
    return {"cell": {"name": origin.cell, "sha256": origin.cell_sha256}, "robot": {**times, "price_s": price}}


def landed_words(run: "Run") -> str:
    """Which share of the spray of each step lands on the board, such as ``"sequence[0] 62 %, sequence[1] 51 %"``."""
    seconds, landed = defaultdict[int, float](float), defaultdict[int, float](float)
    for each in landed_shares(run.recipe, run.board, run.plan.items):
        step = each.made_by.step
        if step is not None:
            seconds[step] += each.seconds
            landed[step] += each.share * each.seconds
    return ", ".join(f"{Source(step)} {landed[step] / seconds[step]:.0%}" for step in seconds)


def fitted_words(run: "Run") -> str:
    """What the recipe left to the board, such as ``"height_mm: sweep 35; sequence[0]: soak 3 times more"``."""
    heights = [f"{name} {height:g}" for name, height in fitted_heights(run.recipe, run.fitted).items()]
    again = [
        f"{Source(step)}: {run.recipe.sequence[step].paths[-1]} {times} {'time' if times == 1 else 'times'} more"
        for step, times in run.again.items()
    ]
    idle = [str(Source(step)) for step in left_out(run.recipe, run.fitted)]
    words = [f"height_mm: {', '.join(heights)}"] if heights else []
    return "; ".join([*words, *again, *([f"{', '.join(idle)} left out, no components there"] if idle else [])])


def class_counts(run: "Run") -> dict[str, int]:
    """Members of each class, in the recipe's order."""
    counts = Counter(each.component_class for each in run.classified)
    return {name: counts[name] for name in run.recipe.classes}


def board_facts(board: Board) -> dict[str, str]:
    """What was understood of a board, for its card."""
    x_min, y_min, x_max, y_max = board.outline.bounds
    top = [component for component in board.components if component.side == "top"]
    tallest = max(board.components, key=lambda component: component.height_mm, default=None)
    sources = Counter(component.gap_height_source.split(" ")[0] for component in board.components)
    joints = [underside.joints_source for underside in undersides_of(board)]
    known = Counter(next(word for word in ("board file", "family", "unknown") if word in source) for source in joints)
    origins = ", ".join(f"{count} {source}" for source, count in known.most_common())
    facts = {
        "size": f"{x_max - x_min:.2f} x {y_max - y_min:.2f} mm, {board.top_z_mm - board.bottom_z_mm:.2f} mm thick",
        "outline": f"{board.outline.area / 100:.1f} cm2, {len(board.outline.interiors)} holes and slots",
        "surfaces": f"top at z = {board.top_z_mm:.3f} mm, bottom at z = {board.bottom_z_mm:.3f} mm",
        "origin": f"front left corner of the outline at x = {x_min:.2f}, y = {y_min:.2f} mm",
        "components": f"{len(board.components)} ({len(top)} top, {len(board.components) - len(top)} bottom)",
        "patches": str(sum(len(body.patches) for body in board.bodies)),
        "standoff": ", ".join(f"{count} {source}" for source, count in sources.most_common()) or "no components",
        "undersides": f"{len(joints)} thin gaps, joints: {origins}" if joints else "no thin gaps",
        "sha256": board.sha256[:16],
    }
    if tallest is not None:
        facts["tallest"] = f"{tallest.name}, {tallest.height_mm:.2f} mm"
    heights = Counter(component.height_source.split(" ")[0].rstrip(",") for component in board.components)
    if set(heights) - {STATED_HEIGHT}:
        facts["heights"] = ", ".join(f"{count} {word}" for word, count in heights.most_common())
    fixtures = sum(body.role == "fixture" for body in board.bodies)
    return facts | ({"fixtures": str(fixtures)} if fixtures else {})


def _components(run: "Run") -> list[Json]:
    served: list[Json] = []
    passes = served_by(run.plan.items)
    for component, classified in zip(run.board.components, run.classified, strict=True):
        entry: dict[str, Json] = {
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
        served.append(entry)
    return served
