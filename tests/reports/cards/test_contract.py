"""Every card states the same facts on the terminal, in a report and on the page."""

import io
import re
from collections.abc import Callable
from dataclasses import replace
from html import unescape

import pytest
from cleaning_report import small_report, soaked_report
from found_place import found_place
from made_findings import made_finding
from rich.console import Console
from tiny_session import tiny_session

from cleaning.parameters.load import read_parameters
from cleaning.part_faces import FaceVerdict
from recipes.load import read_recipe
from reports.cards.cleaning import (
    cleaned_component_card,
    cleaned_face_card,
    cleaning_card,
    face_verdict_table,
    faces_card,
    headline_card,
    worst_card,
)
from reports.cards.placement import details_blocks
from reports.cards.program import instructions_card, program_card, run_card
from reports.cards.robot import cell_card
from reports.cards.specs import parameters_card, recipe_card
from reports.cards.workpiece import board_card, classes_card, component_card
from reports.html.page import blocks_html
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
from robotcell.cell.load import read_cell
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


def cards() -> dict[str, Callable[[], Card]]:
    session, report = tiny_session(), small_report()
    run, board = session.run, session.workpiece.require_board("a card")
    assert run is not None
    u1 = next(part for part in report.parts if part.component == "U1")
    return {
        "board": lambda: board_card(board),
        "board, cut off": lambda: board_card(replace(board, findings=FINDINGS), rows=1),
        "board, none listed": lambda: board_card(board, rows=0),
        "classes": lambda: classes_card(board.components, run.classified, FINDINGS),
        "component": lambda: component_card(board.components[0], run.classified[0], [("served by", "1\n2")], FINDINGS),
        "run": lambda: run_card(run),
        "program": lambda: program_card(run.program),
        "instructions": lambda: instructions_card(run.program),
        "recipe": lambda: recipe_card(read_recipe("smt-aqueous")),
        "parameters": lambda: parameters_card(read_parameters("default")),
        "cell": lambda: cell_card(read_cell("ur5e-bench"), []),
        "cleaning": lambda: cleaning_card(report, "by a test"),
        "cleaning, wet": lambda: cleaning_card(soaked_report(), "by a test"),
        "headline": lambda: headline_card(report, "as planned"),
        "worst": lambda: worst_card(report, 1.0),
        "cleaned component": lambda: cleaned_component_card(report, u1),
        "faces": lambda: faces_card("bracket", (VERDICT, replace(VERDICT, face="face-2", verdict="clean"))),
        "face table": lambda: Card("bracket", (face_verdict_table([VERDICT]),)),
        "cleaned face": lambda: cleaned_face_card(VERDICT, "step 1, wash"),
        "relocation": lambda: Card("best place", details_blocks(found_place().details, found_place().mapped)),
        "no rows": lambda: every_block("x", 0),
        "one row": lambda: every_block("x", 1),
        "many rows": lambda: every_block("x", 11),
        "hostile": lambda: every_block(HOSTILE, 2),
    }


CARDS = cards()


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


@pytest.mark.parametrize("name", CARDS)
def test_every_label_and_value_is_stated_three_times(name: str) -> None:
    card = CARDS[name]()
    stated = [*texts_of_line(card.title), *(text for block in card.blocks for text in texts_of(block))]
    assert stated
    for renderer, text in drawn(card).items():
        found = flat(text)
        missing = [each for each in stated if flat(each) not in found]
        assert not missing, (renderer, missing[:5])


@pytest.mark.parametrize("name", CARDS)
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
