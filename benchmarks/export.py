"""Programs as their controllers take them, by language, cell and board: check, size, time of the moves, event errors.

Run: ``OMP_NUM_THREADS=1 python benchmarks/export.py [LANGUAGE ...] [--boards BOARD ...] [--recipes RECIPE ...]
[--for-cell] [--doses] [--verdicts]``

Every language in the library's cells of its maker, G-code on the gantry, the joint table for the Cairo arm. Each board
is planned, checked and exported, as the commands do it; a row each, as stands in ``docs/benchmarks.md``. *robot*
and *predicted* are from home to home, the former by the check; *x plan* is without the motions that a plan does not
have. ``--doses`` prints another table: how many strokes take the jet outside 0.97 to 1.03 of the planned time, and all
jets' time over the planned one, by the controller's model, with lines at the plan's speeds and as they are exported;
``--verdicts`` adds what the program cleans as planned and as it is driven, ``--samples`` takes all of the library.
Boards are planned with ``smt-aqueous`` and parts with ``part-degrease``, or with what is named. ``--for-cell`` plans
for the cell's robot. ``--notes`` adds the first finding of each rule, where time is lost against the plan, and where
moves are short while a jet is on. Exits with 1 where a check or an export has an error, or where strokes are off, or
a verdict is another one, and no finding states it.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from statistics import median
from unittest.mock import patch

from boards.board import Workpiece
from boards.load import board_library
from boards.part.sources import part_library
from boards.workpiece import load_workpiece
from programs.export import Exported
from programs.motion.steps import Line
from programs.posts.dialects import DIALECTS
from programs.posts.proving.findings import strokes_off
from programs.timing.forecast import Forecast, MoveTime
from recipes.load import load_recipe
from reports.files.robot_programs import CellExport, write_tracked
from robotcell.cell.load import LoadedCell, cell_library, hold_board, read_cell
from robotcell.track import CellReport, terms_of, track
from rulesengine.planning.cell_plan import plan_for_cell
from rulesengine.planning.pipeline import Run, run
from specs.errors import JobError
from specs.finding import Finding
from specs.finding_rules import DOSE_DIFFERS, VERDICT_DIFFERS
from washboard.cleaned import analyse
from washboard.driven import DrivenVerdict, describe, judge_driven

_BOARDS = ("tiny", "sensor-hub", "smt-demo")
_ANY_ROBOT = dict.fromkeys(("linuxcnc", "heidenhain", "sinumerik", "fanuc-cnc"), ("gantry",)) | {
    "joint-table": ("cairo-bench",)
}
"""Cells of languages that take any robot."""
_DOSE_COLUMNS = (
    "language", "cell", "workpiece", "recipe", "strokes", "off at the plan's speeds", "off",
    "jets at the plan's speeds", "jets", "farthest off",
)  # fmt: skip
_VERDICT_COLUMNS = ("as planned", "as driven", "stated by")
_COLUMNS = (
    "language", "robot", "cell", "board", "check", "moves", "bytes", "files", "shortest, jet on", "median, jet on",
    "under 20 ms, jet on", "planned", "robot", "predicted", "x robot", "x plan", "event error", "findings",
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """What a cell's robot does with a board, and how that is written in a language."""

    language: str
    cell: str
    board: str
    planned: Run
    held: LoadedCell
    report: CellReport
    exported: Exported

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Of the plan, the robot and the language."""
        return (*self.planned.findings, *self.report.findings, *self.exported.findings)


def main(words: list[str]) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("languages", nargs="*", default=list(DIALECTS), metavar="LANGUAGE")
    parser.add_argument("--boards", nargs="+", default=_BOARDS, metavar="BOARD")
    parser.add_argument("--samples", action="store_true", help="all boards and parts of the library")
    parser.add_argument("--recipes", nargs="+", default=[], metavar="RECIPE")
    parser.add_argument("--for-cell", action="store_true", help="plan for the robot of the cell")
    parser.add_argument("--doses", action="store_true", help="time of the jets in place of sizes and times")
    parser.add_argument("--verdicts", action="store_true", help="with --doses: what is cleaned")
    parser.add_argument("--notes", action="store_true", help="findings, lost time, places of short moves")
    options = parser.parse_args(words)
    columns = (*_DOSE_COLUMNS, *_VERDICT_COLUMNS[: 3 * options.verdicts]) if options.doses else _COLUMNS
    print(f"| {' | '.join(columns)} |\n|{' --- |' * len(columns)}")
    notes: list[str] = []
    failed = False
    for board in (*board_library(), *part_library()) if options.samples else options.boards:
        loaded = load_workpiece(board, over_faces=board in part_library())
        for recipe in options.recipes or ["part-degrease" if loaded.faces else "smt-aqueous"]:
            planned = run(load_recipe(recipe), loaded)
            for case, verdict in judged_cases(planned, loaded, options):
                failed |= case is None or is_silent(case, verdict)
                if case is not None:
                    print(dose_row(case, verdict) if options.doses else row(case), flush=True)
                    failed |= any(each.severity == "error" for each in case.findings)
                    notes += [f"{case.language}, {case.cell}, {board}: {note}" for note in remarks(case)]
    print("", *notes[: None if options.notes else 0], sep="\n")
    sys.exit(failed)


def judged_cases(
    planned: Run, board: Workpiece, options: argparse.Namespace
) -> Iterator[tuple[Case | None, DrivenVerdict | None]]:
    """Give a plan in every language and cell, with its verdicts if asked for; none where it is refused, as printed."""
    cleaned = analyse(planned) if options.verdicts else None
    for cell, languages in cells_of(options.languages).items():
        try:
            for case in cases(planned, board, cell, languages, for_cell=options.for_cell):
                done = CellExport(case.report, case.exported)
                yield case, cleaned and judge_driven(planned, done, planned=cleaned)
        except JobError as error:
            name = f"{'/'.join(languages)} | {cell} | {board.name} | {planned.recipe.recipe}"
            print(f"| {name} | refused: {error} |", flush=True)
            yield None, None


def is_silent(case: Case, verdict: DrivenVerdict | None) -> bool:
    """Whether strokes are off, or a verdict is another one, and no finding states it."""
    forecast, rules = case.exported.forecast, {each.rule for each in case.exported.findings}
    other = verdict is not None and verdict.finding is None and verdict.data()["planned"] != verdict.data()["driven"]
    return other or (forecast is not None and bool(strokes_off(forecast)) and DOSE_DIFFERS not in rules)


def cells_of(languages: Sequence[str]) -> dict[str, list[str]]:
    """Give the library's cells in which languages are written, each with these languages."""
    by_cell: dict[str, list[str]] = {}
    makers = {cell: read_cell(cell).cell.robot.maker for cell in cell_library()}
    for language in languages:
        own = [cell for cell, maker in makers.items() if maker == DIALECTS[language].maker]
        for cell in _ANY_ROBOT.get(language, own):
            by_cell.setdefault(cell, []).append(language)
    return by_cell


def cases(planned: Run, board: Workpiece, cell: str, languages: list[str], *, for_cell: bool) -> Iterator[Case]:
    """Write what a cell's robot does with a board in some languages.

    Raises:
        JobError: a cell or a language cannot do what the program needs.
    """
    held = hold_board(read_cell(cell), board)
    if for_cell:
        planned = plan_for_cell(planned, held)
    report = track(planned.program, held.cell, board, terms=terms_of(held))
    for language in languages:
        yield Case(language, cell, board.name, planned, held, report, write_tracked(report, held, language))


def row(case: Case) -> str:
    """Give the table's row of a program."""
    exported, own_s = case.exported, added_s(case.report)
    planned_s, robot_s = case.planned.program.totals.duration_s, case.report.program.totals.duration_s
    cells = [
        case.language, case.report.cell.robot.name, case.cell, case.board, names_of(case.report.findings),
        f"{sum(isinstance(step, Line) for step in exported.motion.steps):,}",
        f"{sum(len(text) for text in exported.files.values()):,}", str(len(exported.files)),
        *times_of(exported.forecast), f"{planned_s:.1f} s", f"{robot_s:.1f} s",
    ]  # fmt: skip
    if (forecast := exported.forecast) is None:
        error = exported.error
        cells += ["", "", "", f"{error.distance_mm:.2f} mm, {1e3 * error.time_s:.1f} ms"]
    else:
        cells += [
            f"{forecast.predicted_s:.1f} s", f"{forecast.ratio:.3f}",
            f"{(forecast.predicted_s - own_s) / planned_s:.3f}",
            f"{forecast.event_mm:.2f} mm, {1e3 * forecast.event_s:.1f} ms",
        ]  # fmt: skip
    return f"| {' | '.join([*cells, names_of(exported.findings)])} |"


def dose_row(case: Case, verdict: DrivenVerdict | None) -> str:
    """Give the row of a program with the times of its jets, at the plan's speeds and as it is exported."""
    name = [case.language, case.cell, case.board, case.planned.recipe.recipe]
    judged: list[str] = []
    if verdict is not None:
        states = [each.rule.id for each in (*case.exported.findings, verdict.finding) if each is not None]
        named = [each for each in (DOSE_DIFFERS.id, VERDICT_DIFFERS.id) if each in states]
        judged = [*(describe(each) for each in (verdict.planned, verdict.driven)), ", ".join(named)]
    with patch("programs.export._FITS", 0):
        before = write_tracked(case.report, case.held, case.language).forecast
    after = case.exported.forecast
    if before is None or after is None:
        return f"| {' | '.join([*name, 'states all times', *[''] * 5, *judged])} |"
    off = strokes_off(after)
    shares = [f"{len(each)} ({len(each) / len(after.strokes()):.1%})" for each in (strokes_off(before), off)]
    jets = [f"{sum(s.jet_s for s in each.strokes()) / planned_jets_s(each):.3f}" for each in (before, after)]
    worst = max(off, key=lambda each: abs(each.late_s), default=None)
    why = "" if worst is None else f"{worst.jet_s:.2f} s for {worst.jet_planned_s:.2f} s: {worst.longest.cause}"
    return f"| {' | '.join([*name, str(len(after.strokes())), *shares, *jets, why, *judged])} |"


def planned_jets_s(forecast: Forecast) -> float:
    """Give the planned time of all jets."""
    return sum(each.jet_planned_s for each in forecast.strokes())


def times_of(forecast: Forecast | None) -> tuple[str, str, str]:
    """Give the shortest and the median time of moves with a jet on, and how many are under 20 ms."""
    nominal = (
        [] if forecast is None else [each.nominal_s for each in forecast.moves if each.spraying and each.nominal_s]
    )
    if forecast is None or not nominal:
        return "", "", ""
    short = f"{len(forecast.short)}, {sum(move.at_corner for move in forecast.short)} at corners"
    return f"{1e3 * min(nominal):.1f} ms", f"{1e3 * median(nominal):.0f} ms", short


def added_s(report: CellReport) -> float:
    """Give the time of the motions that a plan does not have: from home, to tools and back."""
    return report.added.from_home + report.added.tool_changes + report.added.to_home


def names_of(findings: Iterable[Finding]) -> str:
    """Count findings by severity and rule; the worst first."""
    counted = Counter((each.severity, str(each.rule)) for each in findings)
    order = {"error": 0, "warning": 1, "info": 2}
    rows = sorted(counted.items(), key=lambda item: (order[item[0][0]], item[0][1]))
    return ", ".join(f"{severity} {rule}{f' x {count}' * (count > 1)}" for (severity, rule), count in rows) or "-"


def remarks(case: Case) -> Iterator[str]:
    """Give the first finding of each rule, what takes longer than planned, and where moves are short."""
    findings = (*case.report.findings, *case.exported.findings)
    first = {(each.severity, each.rule): each for each in reversed(findings)}
    for finding in reversed(first.values()):
        yield f"{finding.severity} {finding.rule}: {finding.message}"
    if (forecast := case.exported.forecast) is None:
        return
    losses = ", ".join(f"{cause} {lost_s:+.1f} s on {count}" for cause, lost_s, count, _ in forecast.losses())
    yield f"against the plan: {losses}"
    where = Counter(place(move) for move in forecast.short)
    if where:
        yield "short moves: " + ", ".join(f"{count} of {source}" for source, count in where.most_common(6))


def place(move: MoveTime) -> str:
    """Name the recipe's entry that a move comes from, without its components."""
    return str(replace(move.made_by, components=())) or "program"


if __name__ == "__main__":
    main(sys.argv[1:])
