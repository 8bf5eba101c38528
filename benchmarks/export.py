"""Programs as their controllers take them: size, time of the moves, predicted time, event errors, by language.

Run: ``OMP_NUM_THREADS=1 python benchmarks/export.py [BOARD [LANGUAGE ...]]``

Every language in the first library cell of its maker, G-code on the gantry. Prints a row for each language, as stands
in ``docs/robot-programs.md``; then what is found on time and size, and where moves are short while a jet is on.
"""

import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from boards.board import Board
from boards.load import load_board
from programs.export import Exported
from programs.posts.dialects import DIALECTS
from programs.program import TimedProgram
from programs.timing.forecast import MoveTime
from recipes.load import load_recipe
from reports.files.export_robot import write_tracked
from robotcell.cell.hold import hold_board
from robotcell.cell.load import cell_library, read_cell
from robotcell.track import terms_of, track
from rulesengine.planning.pipeline import run
from specs.finding_rules import SLOWER_ON_CONTROLLER, TOO_MANY_POINTS

_ANY_ROBOT = dict.fromkeys(("linuxcnc", "heidenhain", "sinumerik", "fanuc-cnc"), "gantry")
"""Cells of languages that take any robot."""
_HEAD = (
    "| language | cell | moves | bytes | files | shortest | median | under 20 ms | predicted | x plan | event error |",
    "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
)


def main(words: list[str]) -> None:
    board = load_board(Path(words[0] if words else "smt-demo"))
    planned = run(load_recipe("smt-aqueous"), board).program
    languages = words[1:] or [name for name, each in DIALECTS.items() if each.controller is not None]
    print("\n".join(_HEAD))
    notes: list[str] = []
    by_cell: dict[str, list[str]] = {}
    for language in languages:
        by_cell.setdefault(cell_of(language), []).append(language)
    for cell, own in by_cell.items():
        for language, exported in written(planned, board, cell, own):
            print(row(language, cell, exported), flush=True)
            notes += [f"{language}: {note}" for note in remarks(exported)]
    print("", *notes, sep="\n")


def cell_of(language: str) -> str:
    """Give the library cell that a language is written for."""
    if language in _ANY_ROBOT:
        return _ANY_ROBOT[language]
    maker = DIALECTS[language].maker
    return next(cell for cell in cell_library() if read_cell(cell).cell.robot.maker == maker)


def written(program: TimedProgram, board: Board, cell: str, languages: list[str]) -> Iterator[tuple[str, Exported]]:
    """Write what a cell's robot does with a program in some languages."""
    held = hold_board(read_cell(cell), board)
    report = track(program, held.cell, board, terms=terms_of(held))
    for finding in report.findings:
        if finding.severity == "error":
            print(f"{cell}: {finding.message}", file=sys.stderr)
    for language in languages:
        yield language, write_tracked(report, held, language)


def row(language: str, cell: str, exported: Exported) -> str:
    """Give the table's row of a program."""
    forecast = exported.forecast
    if forecast is None:
        return f"| {language} | {cell} |"
    size = sum(len(text) for text in exported.files.values())
    cells = (
        language, cell, f"{len(forecast.moves):,}", f"{size:,}", str(len(exported.files)),
        f"{1e3 * forecast.shortest_s:.1f} ms", f"{1e3 * forecast.median_s:.0f} ms",
        f"{len(forecast.short)}, {sum(move.at_corner for move in forecast.short)} at corners",
        f"{forecast.predicted_s:.1f} s", f"{forecast.ratio:.3f}",
        f"{forecast.event_mm:.2f} mm, {1e3 * forecast.event_s:.1f} ms",
    )  # fmt: skip
    return f"| {' | '.join(cells)} |"


def remarks(exported: Exported) -> Iterator[str]:
    """Give the findings on time and size, what takes longer than planned, and where moves are short."""
    for finding in exported.findings:
        if finding.rule in (SLOWER_ON_CONTROLLER, TOO_MANY_POINTS):
            yield f"{finding.rule}: {finding.message}"
    if (forecast := exported.forecast) is None:
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
