"""A run over a board or a part, or a program."""

from collections import defaultdict
from typing import TYPE_CHECKING

import numpy as np

from boards.board import Workpiece
from programs.program import Command, MoveTo, SetNozzle, TimedProgram, Wait
from programs.summary import by_function
from recipes.recipe import film_in
from reports.tables.run_report import class_counts, face_results
from reports.tables.table import Card, FactList, Facts, FindingList, Table, Text, program_title
from reports.tables.wording import amount, clock, shorten
from rulesengine.planning.fit_recipe import fitted_heights, left_out
from rulesengine.planning.spray_findings import landed_shares
from specs.finding_rules import ORDER_GAIN, SURFACE_ORDER, SURFACE_REPAIR
from specs.source import Source

if TYPE_CHECKING:
    from rulesengine.planning.pipeline import Run
    from rulesengine.surface.part_job import Covering


def run_card(run: "Run") -> Card:
    """Show time and litres by function, members of each class, what was fitted, what lands, and findings."""
    counts = ", ".join(f"{name} {count}" for name, count in class_counts(run).items())
    gains = [finding for finding in run.findings if finding.rule == ORDER_GAIN]
    facts = [
        *_robot(run),
        ("classes", counts),
        *(("fitted", words) for words in [fitted_words(run)] if words),
        *(("lands", f"{words} of the spray on the board") for words in [landed_words(run)] if words),
        *(("order", f"{shorten(str(gain.made_by))}: {gain.message}") for gain in gains),
    ]
    program = program_card(run.program)
    others = tuple(finding for finding in run.findings if finding.rule != ORDER_GAIN)
    return Card(program.title, (*program.blocks, FactList(facts), FindingList(others)))


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


def _robot(run: "Run") -> Facts:
    """What the limits of a cell's robot cost, where the program is timed for one."""
    timing = run.robot
    if timing is None:
        return []
    price = ", ".join(f"{clock(seconds)} {kind}" for kind, seconds in timing.price_s if seconds >= 0.05)
    longer = f"{clock(timing.planned_s - timing.free_s)} longer than the recipe's limits allow"
    ratio, added = timing.robot_s / timing.planned_s, clock(timing.added_s)
    return [
        ("cell", f"{timing.cell} ({timing.robot}): {longer}" + (f"; {price}" if price else "")),
        ("", f"its robot takes {ratio:.3f} times the planned time, and {added} for home and changes of the tool"),
    ]


def part_run_card(run: "Run") -> Card:
    """Show time and litres, what each template does to each face, the rounds of the repair, and findings."""
    program = program_card(run.program)
    blocks, quiet = [*program.blocks], {SURFACE_ORDER: "order", SURFACE_REPAIR: "repair"}
    for covering in run.coverings:
        mine = [each for each in run.findings if each.made_by == covering.made_by]
        facts = [(quiet[each.rule], each.message) for each in mine if each.rule in quiet]
        spec = run.recipe.templates[covering.made_by.template]
        if film_in(spec) is not None:
            blocks += [Text(str(covering.made_by), "strong"), FactList(facts)]
            continue
        uniform = f"{covering.uniform_share:.1%} of the visible area held, {covering.uniform_s:.1f} s of spraying"
        within = f"in the cone, at most {covering.range_mm:.0f} mm from the orifice, for {covering.required_s:g} s"
        held = f"{covering.share:.1%} of the visible area is {within}"
        facts = [*facts[:1], ("uniform", uniform), *facts[1:], ("held", held), ("bound", _bound(covering))]
        blocks += [Text(str(covering.made_by), "strong"), FactList(facts), _covering(run.workpiece, covering)]
    others = tuple(finding for finding in run.findings if finding.rule not in quiet)
    return Card(program.title, (*blocks, FindingList(others)))


def _covering(part: Workpiece, covering: "Covering") -> Table:
    """A row for each sprayed face: stripes, time, what is seen, what is held of it, the least time."""
    rows = [
        (
            each.face, str(each.pieces), f"{each.spray_s:.1f}", f"{each.visible_share:.1%}", f"{each.held_share:.1%}",
            f"{each.least_s:.2f}", f"{each.mean_s:.2f}", ", ".join(each.hidden_by),
        )
        for each in face_results(part, covering)
    ]  # fmt: skip
    headings = (">pieces", ">spraying\ns", ">visible", ">held\nof it", ">least\ns", ">mean\ns", "hidden by")
    return Table.of(("face", *headings), rows)


def _bound(covering: "Covering") -> str:
    """The time of spraying beside the bound, and what that one rests on."""
    least = covering.least()
    if least.seconds <= 0:
        return f"{covering.spray_s:.1f} s of spraying; no bound, since no pose of least tilt holds any of it"
    return (
        f"{covering.spray_s:.1f} s of spraying, {covering.spray_s / least.seconds:.2f} times the {least.seconds:.1f} s "
        f"of a bound proven for {least.poses} poses of least tilt, about {least.apart_mm:.1f} mm apart"
    )


def program_card(program: TimedProgram) -> Card:
    """Show totals, functions, and what is counted once though it may be repeated."""
    origin, totals = program.origin, program.totals
    way = f"{totals.travel_mm / 1000:.2f} m of travel in {amount(totals.moves, 'move')}"
    title = program_title(origin, f": {clock(totals.duration_s)}, {clock(totals.spray_s)} of it spraying; {way}")
    litres = dict(totals.liquid_l)
    rows: list[tuple[str, ...]] = []
    for each in by_function(program):
        liquid = litres.pop(each.function, None)  # litres are known by function: they stand where it comes first
        rows.append((
            each.function, each.nozzle, each.solution, clock(each.duration_s), clock(each.spray_s),
            f"{each.spray_mm / 1000:.2f} m", f"{each.travel_mm / 1000:.2f} m",
            "" if liquid is None else f"{liquid:.2f}",
        ))  # fmt: skip
    headings = ("function", "nozzle", "solution", ">time", ">spraying", ">sprayed way", ">all the way", ">litres")
    repeats = [
        f"{each.made_by} until {' '.join(each.arguments[2:])}, at most {each.arguments[0]} times; counted once here"
        for each in program.instructions
        if isinstance(each, Command) and each.keyword == "REPEAT"
    ]
    return Card(title, (Table.of(headings, rows), FactList([("repeats", text) for text in repeats])))


def instructions_card(program: TimedProgram) -> Card:
    """Show totals, where the orifice goes, how often the jet opens and pauses, and the commands in order of time.

    Commands that one step gives at one moment stand together.
    """
    places = np.array([each.position for each in program.instructions if isinstance(each, MoveTo)]).reshape(-1, 3)
    spans = zip("xyz", places.min(axis=0, initial=np.inf), places.max(axis=0, initial=-np.inf), strict=True)
    extent = ", ".join(f"{axis} {low:.1f} to {high:.1f}" for axis, low, high in spans)
    opened = sum(isinstance(each, SetNozzle) and each.spraying for each in program.instructions)
    waits = [each.duration_s for each in program.instructions if isinstance(each, Wait)]
    pauses = f"{amount(len(waits), 'pause')} of {clock(sum(waits))} together" if waits else "no pauses"
    facts = [("orifice", f"{extent} mm")] if len(places) else []
    facts.append(("jet", f"opens {amount(opened, 'time')}; {pauses}"))
    grouped: dict[tuple[float, Source], list[str]] = {}
    for each in program.instructions:
        if isinstance(each, Command):
            grouped.setdefault((each.time_s, each.made_by), []).append(" ".join([each.keyword, *each.arguments]))
    rows = [(clock(time_s), ", ".join(words), shorten(str(made_by))) for (time_s, made_by), words in grouped.items()]
    totals = program_card(program)
    commands = Table.of((">at", "commands", "recipe entry"), rows)
    return Card(totals.title, (*totals.blocks, FactList(facts), commands))
