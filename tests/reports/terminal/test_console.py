"""What the terminal says of a run, a program and its findings."""

import io

import pytest
from made_findings import made_finding
from rich.console import Console

from boards.load import board_library, load_board
from recipes.load import load_recipe
from reports.cards.program import instructions_card, program_card, run_card
from reports.tables.wording import amount, clock, shorten
from reports.terminal.console import print_card, print_findings, print_table
from rulesengine.planning.pipeline import Run, run


@pytest.fixture(scope="module")
def done() -> Run:
    return run(load_recipe("smt-aqueous"), load_board(board_library()["tiny"]))


def paper(width: int = 1000) -> Console:
    return Console(file=io.StringIO(), width=width, highlight=False)


def printed(console: Console) -> str:
    assert isinstance(console.file, io.StringIO)
    return "\n".join(line.rstrip() for line in console.file.getvalue().splitlines())


def test_the_head_line_says_time_and_way(done: Run) -> None:
    console, totals = paper(), done.program.totals
    print_card(console, program_card(done.program))
    assert printed(console).splitlines()[0] == (
        f"tiny with smt-aqueous: {clock(totals.duration_s)}, {clock(totals.spray_s)} of it spraying; "
        f"{totals.travel_mm / 1000:.2f} m of travel in {totals.moves:,} moves"
    )


def test_the_table_has_one_row_for_each_step_and_litres_where_liquid_flows(done: Run) -> None:
    console = paper()
    print_card(console, program_card(done.program))
    lines = printed(console).splitlines()
    litres = dict(done.program.totals.liquid_l)
    assert lines[1].split()[:5] == ["function", "nozzle", "solution", "time", "spraying"]
    assert [line.split()[:3] for line in lines[2:5]] == [
        ["clean", "ring60", "saponifier-15"],
        ["rinse", "ring60", "di-water"],
        ["dry", "knife", "hot-air"],
    ]
    assert [line.split()[-1] for line in lines[2:5]] == [f"{litres['clean']:.2f}", f"{litres['rinse']:.2f}", "m"]
    assert lines[5] == "repeats   sequence[1] until resistivity_mohm_cm >= 1.000, at most 4 times; counted once here"


def test_a_run_ends_in_classes_order_and_findings(done: Run) -> None:
    console = paper()
    print_card(console, run_card(done))
    text = printed(console)
    assert "\nclasses   bottom_terminated 1, fine_pitch 0, small 3, large 1\n" in text
    assert "\norder     sequence[0]/around: Order of 5 strokes: " in text
    assert "info order-gain" not in text
    assert f"\nFindings: {sum(each.rule.id != 'order-gain' for each in done.findings)} info; worst first.\n" in text
    assert "\n  info class-empty  classes/fine_pitch\n    Class 'fine_pitch' has no member on tiny.\n" in text


def test_the_room_holds_every_move(done: Run) -> None:
    console = paper()
    print_card(console, instructions_card(done.program))
    text = printed(console)
    assert f" to {done.recipe.limits.park_height_mm:.1f} mm" in text
    assert "jet       opens 15 times; 12 pauses of " in text


def test_commands_of_one_moment_stand_on_one_line(done: Run) -> None:
    console = paper()
    print_table(console, instructions_card(done.program).blocks[-1])
    lines = printed(console).splitlines()
    first = (
        "FUNCTION clean, NOZZLE ring60 TOOL 1, SOLUTION saponifier-15, SET pressure_bar 3.500, SET temperature_c 60.000"
    )
    assert lines[1].split("  ")[-2:] == [first, "sequence[0]"] or first in lines[1]
    assert [line.rsplit(maxsplit=1)[-1] for line in lines[1:]] == [f"sequence[{index}]" for index in (0, 1, 1, 2)]
    assert "REPEAT 4 UNTIL resistivity_mohm_cm >= 1.000" in lines[2]


@pytest.mark.parametrize("width", [40, 80, 100])
def test_nothing_is_wider_than_the_terminal(done: Run, width: int) -> None:
    console = paper(width)
    print_card(console, run_card(done))
    print_card(console, instructions_card(done.program))
    assert max(map(len, printed(console).splitlines())) <= width


def test_findings_worst_first_one_entry_for_each_rule() -> None:
    console = paper()
    notes = [made_finding("note", "info", f"[n] {index}", "a/b/C1+C2+C3+C4") for index in range(3)]
    print_findings(console, [*notes, made_finding("bad", "error", "mend it", where=(1.0, 2.0, 3.04))])
    assert printed(console) == (
        "Findings: 1 error, 3 info; worst first.\n  error bad  at 1.0, 2.0, 3.0 mm\n    mend it\n"
        "  info note  a/b/C1+C2+2 more  and 2 more\n    [n] 0"
    )


def test_no_findings() -> None:
    console = paper()
    print_findings(console, [])
    assert printed(console) == "No findings."


def test_names_of_people_are_not_markup(done: Run) -> None:
    from dataclasses import replace

    console = paper()
    print_card(console, program_card(replace(done.program, origin=replace(done.program.origin, board="[red]x[/red]"))))
    assert printed(console).startswith("[red]x[/red] with ")


def test_words_for_numbers() -> None:
    assert [amount(count, "move") for count in (0, 1, 44712)] == ["no moves", "1 move", "44,712 moves"]
    assert amount(2, "class", "classes") == "2 classes"
    assert [clock(each) for each in (0.0, 42.34, 59.94, 59.96, 431.2, 3599.7)] == [
        *("0.0 s", "42.3 s", "59.9 s", "1 min 00 s", "7 min 11 s", "60 min 00 s")
    ]


def test_long_groups_are_counted() -> None:
    assert shorten("sequence[0]/around/U1+C4+R2+R3: late") == "sequence[0]/around/U1+C4+2 more: late"
    assert shorten("around/U1+C4") == "around/U1+C4"
