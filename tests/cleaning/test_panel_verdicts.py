"""A panel's components are judged like those of its boards, and counted by board."""

import io

import pytest
from analysed import DRY, PARAMETERS, RINSE, WASH, board_of, recipe_of, report_of
from rich.console import Console

from boards.panel import PanelLayout, compose_panel
from cleaning.prepared_board import prepare
from cleaning.report import cleaning_report
from cleaning.verdicts.results import parts_by_instance
from reports.cards.cleaning import cleaning_card
from reports.terminal.console import print_card


@pytest.mark.slow
def test_verdicts_are_counted_by_board() -> None:
    layout = PanelLayout.model_validate_json(
        '{"board": "small", "nx": 2, "pitch_mm": [60, 0], "instances": [{}, {"turn_deg": 180}]}'
    )
    panel = compose_panel(layout, board_of("U1", "C1"), "pair")
    report = report_of(recipe_of(WASH, RINSE, DRY), prepare(panel, PARAMETERS, lambda *_: None))
    boards = parts_by_instance(report)
    assert {name: [part.component for part in parts] for name, parts in boards.items()} == {
        "1": ["U1@1", "C1@1"],
        "2": ["U1@2", "C1@2"],
    }
    rows = cleaning_report(report)["boards"]
    assert isinstance(rows, list)
    assert [row["board"] for row in rows] == ["1", "2"]
    assert all(sum(row["components"].values()) == 2 for row in rows)
    assert sum(len(parts) for parts in boards.values()) == len(report.parts)
    out = io.StringIO()
    print_card(Console(file=out, width=200), cleaning_card(report, "by a test"))
    assert "board 1" in out.getvalue()
    assert "board 2" in out.getvalue()


def test_a_single_board_has_no_counts_by_board() -> None:
    report = report_of(recipe_of(WASH))
    assert parts_by_instance(report) == {}
    assert "boards" not in cleaning_report(report)
