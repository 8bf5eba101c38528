"""Every card states the same facts on the terminal, in a report and on the page."""

import io
import re
from collections.abc import Callable
from dataclasses import replace
from html import unescape
from importlib import import_module
from inspect import isfunction
from pathlib import Path
from pkgutil import iter_modules
from types import SimpleNamespace

import numpy as np
import pytest
from cleaning_report import small_report, soaked_report
from coupon_bench import BENCH
from found_place import found_place
from made_findings import made_finding
from part_session import part_session
from rich.console import Console
from shapely import Polygon
from tiny_session import tiny_session
from tracked import line_program
from tuned_recipe import UNMET, proposal

import reports.cards
from boards.part.scan import Scan
from cleaning.calibration.confidence import Estimate
from cleaning.calibration.coupon import Coupons
from cleaning.calibration.fit_kinetics import GapFit, Undetermined
from cleaning.calibration.fit_spray import PatternFit, RingFit, Sheet
from cleaning.calibration.measurements import Measurements
from cleaning.parameters.chemistries import chemistries
from cleaning.parameters.load import read_parameters
from cleaning.part_faces import FaceVerdict
from cleaning.uncertainty.bath import Bath, BoardInBath
from cleaning.uncertainty.comparison import compare_measured
from cleaning.uncertainty.measured_table import METHODS, Measured, MeasuredTable
from cleaning.undersides.rinse import Cascade, RinseWater
from cleaning.validation.compare import validate
from cleaning.verdicts.results import CleaningReport
from cleaning.verdicts.rules import RESIDUE_LEFT
from geometry.coverage.spacing import Spacing
from programs.program import TimedProgram
from recipes.load import read_recipe
from reports.cards.calibration import gap_card, pattern_card, ring_card
from reports.cards.cleaning import (
    cleaned_component_card,
    cleaned_face_card,
    cleaning_card,
    comparison_card,
    face_verdict_table,
    faces_card,
    headline_card,
    worst_card,
)
from reports.cards.measured import bath_card, measured_card
from reports.cards.placement import part_relocation_card, relocation_card
from reports.cards.program import instructions_card, part_run_card, program_card, run_card
from reports.cards.recipe_search import levelled_card, spacings_card, tuned_card
from reports.cards.robot import cell_card, check_card, remedy_card
from reports.cards.specs import chemistry_card, parameters_card, recipe_card
from reports.cards.validation import validation_card
from reports.cards.workpiece import (
    board_card,
    classes_card,
    component_card,
    face_card,
    part_card,
    scan_card,
    workpiece_card,
)
from reports.html.page import blocks_html
from reports.tables.comparison import compare_cleaning
from reports.tables.run_report import face_results
from reports.tables.table import (
    Bar,
    Block,
    Card,
    Column,
    FactList,
    FindingList,
    Line,
    Lines,
    Note,
    Table,
    Text,
    Verbatim,
    lines_of,
)
from reports.terminal.console import print_card
from robotcell.cell.cell_edits import parse_edit
from robotcell.cell.load import read_cell
from robotcell.diagnosis.changes import Remedy
from robotcell.search_placement import PlacementTrial
from robotcell.track import track
from rulesengine.levelling.pass_spacing import AllowedSpacing, SpacingTable
from rulesengine.levelling.report import Amounts, FilmOf, FilmSpread, LevelledStep, LevelReport
from rulesengine.surface.part_job import survey_part
from rulesengine.tuning.report import Reason
from specs.finding import worst_first
from specs.source import Source
from webui.theme.html import card_html

FINDINGS = (
    made_finding("slow", "warning", "Slower than <asked>.", "sequence[0]/around/U12", (1.0, 2.0, 3.0)),
    made_finding("bad", "error", "It touches & stops."),
)
VERDICT = FaceVerdict("face-1", Source(0, "wash"), "dirty", 120.0, 1.5, 0.9, 0.4, 0.2, 1.1, 12.0, ("clamp", "stand"))
HOSTILE = "<img src=x onerror='1'> & \"co\" [red]"


def every_block(name: str, rows: int) -> Card:
    """A card with each kind of block, and with a name in each place that a file can fill."""
    columns = (Column(name, is_name=True), Column("share", "right"), Column("notes"))
    notes = Lines("first", (Text(f"below {name}", "quiet"),))
    cells = [(Text(f"{name} {at}", "code"), Bar(at / 10, f"{at} % {name}"), notes) for at in range(rows)]
    return Card(
        (Text(name, "strong"), " with ", Text("a recipe", tone="clean")),
        (
            FactList([(name, f"fact of {name}"), ("time", "12 s")]),
            "",
            Text(f"remark on {name}", "quiet"),
            Table(columns, tuple(cells), f"table of {name}"),
            Note(
                "dirty", (f"rule {name}: ", Text("dirty", tone="dirty")), (f"because {name}", Text("do it", "strong"))
            ),
            FindingList((made_finding("odd", "info", f"found {name}"),)),
            Verbatim(f"board:\n  name: {name}"),
        ),
    )


def calibrations() -> dict[str, Callable[[], Card]]:
    """Fits that were never made: an irregular ring, a profile without times, kinetics of which two are undetermined."""
    at = np.arange(3)
    columns = {"height_mm": np.array([40.0, 40.0, 80.0]), "tilt_deg": np.zeros(3), "cleaned_fraction": np.full(3, 0.5)}
    measured = Measurements(Path("<b>.csv"), "ab" * 32, True, columns, np.array([2, 3, 4]), 1)
    angle, sheets = Estimate(29.5, 29.1, 29.9), (Sheet(40.0, 0.0, 2, 0.12, -0.04), Sheet(80.0, 0.0, 1, 0.3, 0.01))
    ring = RingFit(measured, angle, Estimate(2.0, 1.5, 2.5), (0.3, 0.4, 0.1, 0.0), (0.05, 0.02), 0.2, "mm", sheets)
    pattern = PatternFit(measured, 40.0, at * 10.0, np.array([1.0, 0.5, 0.0]), None, 0.03, at * 9.0, at / 3.0)
    kept = {"soil.k_m_per_s": Undetermined(0.0, 2.0, 0.5), "film.puddle_mm": Undetermined(0.1, np.inf, 0.4)}
    fitted = {"soil.k1_per_s": Estimate(0.008, 0.006, 0.01), "soil.activation_kj_mol": Estimate(42.0, 30.0, 55.0)}
    soil, film = BENCH.parameters.soil, BENCH.parameters.film
    kinetics = GapFit(Coupons(measured, BENCH), fitted, kept, soil, film, np.array([0.4, 0.5, 0.6]))
    return {
        "ring": lambda: ring_card(ring),
        "ring, a circle": lambda: ring_card(replace(ring, waves_deg=(), gain=(), sheets=sheets[:1])),
        "pattern": lambda: pattern_card(pattern),
        "validation": lambda: validation_card(validate(["blow-off", "lane-width"])),
        "kinetics": lambda: gap_card(kinetics),
    }


def films() -> dict[str, Callable[[], Card]]:
    """Spacings of which one is allowed, and one step levelled for each goal and for nothing."""
    wide, narrow = (AllowedSpacing(Spacing(each, 90.0, 110.0, 100.0), 80.0 / each, each < 1, 3) for each in (1.0, 0.5))
    table = SpacingTable("gun", 50.0, 40.0, 1.2, 120.0, "functions.coat", np.arange(3.0), np.ones(3), (wide, narrow))
    film = FilmOf(FilmSpread(120, 30.0, 41.0, 55.0, 0.12), FilmSpread(480, 29.0, 41.0, 56.0, 0.13))
    step = LevelledStep(
        False, Source(0), "coat", "gun", 40.0, 3, film, film, film, 12.0, 9.5, 9.1, 9.0, 1e-6, 30, 12, 40, 3, 5, 0.2,
        0.4, 2,
    )  # fmt: skip
    report = LevelReport("least-time", (step,), Amounts(20.0, 12.0, 0.4), Amounts(18.0, 9.5, 0.3))
    even = LevelReport("even-film", (replace(step, target_um=None, short=0),), report.before, report.after)
    hardly = replace(report, steps=(replace(step, gap=3e-16),), after=Amounts(19.9999, 11.9999, 0.4))
    return {
        "spacings": lambda: spacings_card(table),
        "spacings, none allowed": lambda: spacings_card(replace(table, valleys=(wide,))),
        "spacings, none": lambda: spacings_card(replace(table, valleys=())),
        "levelled": lambda: levelled_card(report),
        "levelled, even": lambda: levelled_card(even),
        "levelled, hardly": lambda: levelled_card(hardly),
    }


def baths(report: CleaningReport) -> dict[str, Callable[[], Card]]:
    """A bath with and without rinse tanks."""
    cascade = Cascade(("di-water",), (0.02,), 0.001, True, (0.1,), 2e-6, (0.3,))
    tanks = replace(report, rinse_water=RinseWater(cascade, 900.0, (12.0,)))
    bath = Bath(40.0, 1000.0, 0.0, 0.03, 2.0, begin_pct=0.5)
    return {
        "bath": lambda: bath_card(bath, "saponifier-15", 3.0, [BoardInBath(1, 0.5, report)]),
        "bath, tanks": lambda: bath_card(bath, "saponifier-15", 3.0, [BoardInBath(n, 0.7, tanks) for n in (1, 50)]),
    }


def found(program: TimedProgram) -> dict[str, Callable[[], Card]]:
    """Places for a board and for a part; of a board also where the robot cannot do the program at any."""
    place = found_place()

    def told(trial: PlacementTrial) -> PlacementTrial:
        known = {"requested": program, "program": program, "findings": FINDINGS}
        return replace(trial, checked=SimpleNamespace(cell=trial.cell, **known))  # type: ignore[arg-type]

    board = replace(place, present=told(place.present), tried=tuple(map(told, place.tried)))
    goal, present = place.details.goal, place.present.placement
    bare = PlacementTrial(present, place.present.cell)
    part = replace(place, present=bare, tried=(bare,))
    return {
        "relocation": lambda: relocation_card(board, goal),
        "relocation, none": lambda: relocation_card(replace(board, tried=()), goal),
        "relocation of a part": lambda: part_relocation_card("bracket <1>", part, 50.0),
    }


def robots() -> dict[str, Callable[[], Card]]:
    """A cell, a remedy for it, and what its robot does with a short program."""
    loaded = read_cell("ur5e-bench")
    edits = tuple(parse_edit(each, loaded.root) for each in ("margin_mm: 3", "base.xyz_mm: [0, 0, 10]"))
    return {
        "cell": lambda: cell_card(loaded, []),
        "remedy": lambda: remedy_card("ur5e-bench", loaded, Remedy("with more margin", loaded.cell, edits)),
        "check": lambda: check_card(track(line_program(), read_cell("gantry").cell, None)),
    }


def parts() -> dict[str, Callable[[], Card]]:
    """A part, its faces, what a plan does to them, what a program cleans, and a scan of it."""
    session = part_session()
    run, part = session.run, session.workpiece.require_part("a card")
    assert run is not None
    scan = Scan(part, None, 24000.0, (0.4, 0.6), (Polygon(), Polygon()))
    results = face_results(part, run.coverings[0])
    return {
        "part": lambda: workpiece_card(part),
        "part, seen": lambda: part_card(part, survey_part(run.recipe, part), "boxes"),
        "part run": lambda: part_run_card(run),
        "face": lambda: face_card(part.faces[0], results[:1] * 2, FINDINGS),
        "scan": lambda: scan_card(scan),
        "faces": lambda: faces_card("bracket", (VERDICT, replace(VERDICT, face="face-2", verdict="clean"))),
        "face table": lambda: Card("bracket", (face_verdict_table([VERDICT]),)),
        "cleaned face": lambda: cleaned_face_card(VERDICT, "step 1, wash"),
    }


def cleaned(report: CleaningReport) -> dict[str, Callable[[], Card]]:
    """What a program cleans, beside another and beside measurements."""
    u1 = next(part for part in report.parts if part.component == "U1")
    rows = (Measured("U1", METHODS["sir"], 20.0, 100.0, 2), Measured("C1", METHODS["rose"], 1.0, 1.5, 3))
    compared = compare_measured(report, MeasuredTable("<m>.csv", "cd" * 32, True, rows))
    commands = ["washboard calibrate gap COUPONS.csv"] * len(compared.recalibrations)
    both = compare_cleaning(report, soaked_report())
    return {
        "cleaning": lambda: cleaning_card(report, "by a test"),
        "cleaning, wet": lambda: cleaning_card(soaked_report(), "by a test"),
        "headline": lambda: headline_card(report, "as planned"),
        "worst": lambda: worst_card(report, 1.0),
        "cleaned component": lambda: cleaned_component_card(report, u1),
        "comparison": lambda: comparison_card(both, report, ("one", "the <other>")),
        "measured": lambda: measured_card(report, compared, commands),
        **baths(report),
    }


def cards() -> dict[str, Callable[[], Card]]:
    session, report = tiny_session(), small_report()
    run, board = session.run, session.workpiece.require_board("a card")
    assert run is not None
    tuned = proposal(session, unmet=(UNMET,)).tuned
    name, chemistry = next(iter(chemistries().items()))
    return {
        "board": lambda: workpiece_card(board),
        "board, cut off": lambda: board_card(replace(board, findings=FINDINGS), rows=1),
        "board, none listed": lambda: board_card(board, rows=0),
        "classes": lambda: classes_card(board.components, run.classified, FINDINGS),
        "component": lambda: component_card(board.components[0], run.classified[0], [("served by", "1\n2")], FINDINGS),
        "run": lambda: run_card(run),
        "program": lambda: program_card(run.program),
        "instructions": lambda: instructions_card(run.program),
        "recipe": lambda: recipe_card(read_recipe("smt-aqueous")),
        "parameters": lambda: parameters_card(read_parameters("default")),
        "solution": lambda: chemistry_card(name, chemistry),
        "tuned": lambda: tuned_card(tuned, [Reason("U1", RESIDUE_LEFT, "residue", "31 %.", "No <way>.")], "+ a\n- b"),
        **parts(),
        **cleaned(report),
        **calibrations(),
        **films(),
        **robots(),
        **found(run.program),
        "no rows": lambda: every_block("x", 0),
        "one row": lambda: every_block("x", 1),
        "many rows": lambda: every_block("x", 11),
        "hostile": lambda: every_block(HOSTILE, 2),
    }


CARDS = cards()
NAMES = [pytest.param(each, marks=pytest.mark.slow) if each == "check" else each for each in CARDS]
"""A robot is tracked in no quarter of a second."""


def test_every_function_that_makes_a_card_is_enrolled() -> None:
    source = Path(__file__).read_text()
    made = {
        name
        for module in (import_module(f"reports.cards.{each.name}") for each in iter_modules(reports.cards.__path__))
        for name, function in vars(module).items()
        if isfunction(function) and function.__module__ == module.__name__ and name[0] != "_"
        if function.__annotations__.get("return") in (Card, "Card")
    }
    assert len(made) > 25
    assert not {name for name in made if f"lambda: {name}(" not in source}


def printed(card: Card, width: int = 10_000) -> str:
    console = Console(file=io.StringIO(), width=width, highlight=False)
    print_card(console, card)
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


def as_text(html: str) -> str:
    return unescape(re.sub(r"<br>", "\n", re.sub(r"<(?!br>)[^>]*>", "", html)))


def drawn(card: Card) -> dict[str, str]:
    return {
        "terminal": printed(card),
        "report": as_text(blocks_html([card.title, *card.blocks])),
        "page": as_text(card_html(card)),
    }


def texts_of(block: Block) -> list[str]:
    """Give each label and value of a block."""
    match block:
        case Table(rows=()):
            return []
        case Table():
            cells = [run.text for row in block.rows for cell in row for line in lines_of(cell) for run in line]
            return [block.title, *(word for each in block.columns for word in each.heading.split()), *cells]
        case FactList():
            return [text for fact in block.facts for part in fact for text in part.splitlines()]
        case FindingList():
            return [each.message for each in worst_first(block.findings)[:1]]  # a terminal groups them by rule
        case Note():
            return [text for line in (block.head, *block.below) for text in texts_of(line)]
        case Verbatim():
            return [line.strip() for line in block.text.splitlines()]
        case _:
            return texts_of_line(block)


def texts_of_line(line: Line) -> list[str]:
    return [run.text for run in lines_of(line)[0]]


def flat(text: str) -> str:
    """Join what layout parts, and leave letters as they are but for the first one of a label."""
    return "".join(text.split()).casefold()


@pytest.mark.parametrize("name", NAMES)
def test_every_label_and_value_is_stated_three_times(name: str) -> None:
    card = CARDS[name]()
    stated = [*texts_of_line(card.title), *(text for block in card.blocks for text in texts_of(block))]
    assert stated
    for renderer, text in drawn(card).items():
        found = flat(text)
        missing = [each for each in stated if flat(each) not in found]
        assert not missing, (renderer, missing[:5])


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("width", [40, 80])
def test_no_line_is_wider_than_the_terminal(name: str, width: int) -> None:
    card = CARDS[name]()
    lines = printed(replace(card, blocks=tuple(each for each in card.blocks if not isinstance(each, Verbatim))), width)
    assert max(map(len, lines.splitlines())) <= width


def test_names_from_files_are_text_in_html() -> None:
    card = CARDS["hostile"]()
    for html in (blocks_html([card.title, *card.blocks]), card_html(card)):
        assert "<img" not in html
        assert html.count("&lt;img") == 10 + 3 * 2


def test_next_to_nothing_is_the_same_on_every_machine() -> None:
    for text in drawn(CARDS["levelled, hardly"]()).values():
        assert (text.count("+0.0 %"), text.count("-0.0"), text.count("duality gap under 1e-07")) == (3, 0, 1)


def test_tables_without_rows_are_not_drawn() -> None:
    card = CARDS["no rows"]()
    for renderer, text in drawn(card).items():
        assert "table of x" not in text.casefold(), renderer
        assert "fact of x" in text, renderer


def test_tables_of_the_same_columns_are_one_on_the_terminal() -> None:
    tables = [Table.of(("part", ">litres"), [(name, "1")], title) for name, title in (("U1", "wash"), ("U22", "rinse"))]
    other = Table.of(("part", ">time"), [("U1", "2 s")])
    text = printed(Card("", (*tables, other)))
    assert [line.split() for line in text.splitlines()] == [
        ["part", "litres"], ["wash"], ["U1", "1"], ["rinse"], ["U22", "1"], ["part", "time"], ["U1", "2", "s"],
    ]  # fmt: skip


def test_a_bar_is_as_long_as_its_share() -> None:
    card = Card("", (Table.of(("", ""), [("all", Bar(1.0, "9 %", marked=True)), ("half", Bar(0.5, "4 %"))]),))
    longest, shorter = printed(card).splitlines()[-2:]
    assert (longest.count("\N{FULL BLOCK}"), shorter.count("\N{FULL BLOCK}")) == (10, 5)
    for html in (blocks_html(card.blocks), card_html(card)):
        assert html.index("width:100%") < html.rindex("width:50%")


def test_lines_of_a_difference_have_its_colours() -> None:
    console = Console(file=io.StringIO(), width=80, force_terminal=True, color_system="standard")
    print_card(console, Card("", (Verbatim("+ more\n- less\n@@ 1 @@\n  same", "changed"),)))
    assert isinstance(console.file, io.StringIO)
    more, less, where, same = console.file.getvalue().splitlines()
    assert more.startswith("\x1b[32m")
    assert less.startswith("\x1b[31m")
    assert where.startswith("\x1b[2m")
    assert same == "  same"


def test_a_board_card_states_what_it_leaves_out() -> None:
    board = tiny_session().workpiece.require_board("a card")
    assert "--all lists them" in printed(board_card(board, rows=1))
    assert "--all" not in printed(board_card(board))
    assert "--all" not in printed(board_card(board, rows=0))
