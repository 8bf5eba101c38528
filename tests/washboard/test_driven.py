"""What a program cleans as its controller drives it, beside what it cleans as planned: what differs, and why."""

from dataclasses import replace
from functools import cache
from typing import cast

import pytest
from cleaning_report import small_report
from small_parts import block, part_of
from tracked import line_program

from cleaning.part_faces import FaceVerdict
from cleaning.verdicts.results import CleaningReport
from cleaning.verdicts.rules import UNDER_EXPOSED, Verdict
from programs.native import parse, render
from reports.files.robot_programs import CellExport, export_tracked
from robotcell.cell.load import read_cell
from robotcell.track import track
from rulesengine.surface.part_job import Survey
from specs.source import Source
from washboard.cleaned import FaceReport
from washboard.driven import DrivenVerdict, find_difference

TEMPLATE = Source(0, "sweep")
AT_ONCE = 5e4
"""mm/s²: no robot follows."""


@cache
def exported(accelerate: float = 500.0) -> CellExport:
    cell = read_cell("gantry")
    program = parse(render(line_program(speed=200.0, accelerate=accelerate)))
    return export_tracked(track(program, cell.cell, None), cell, "linuxcnc")


def faces(**verdicts: Verdict) -> FaceReport:
    rows = tuple(
        FaceVerdict(name, TEMPLATE, verdict, 10.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, ())
        for name, verdict in verdicts.items()
    )
    part = part_of(block((0, 0, 0), (9, 9, 9)))
    return FaceReport(part, exported().report.requested, (), cast("Survey", None), rows)


def with_verdict(component: str, verdict: Verdict) -> CleaningReport:
    """The report on ``tiny`` with another verdict on one of its components."""
    report = small_report()
    judged = next(each for part in report.parts for each in part.judgements if each.rule == UNDER_EXPOSED)
    parts = tuple(
        replace(part, verdict=verdict, judgements=(replace(judged, verdict=verdict),))
        if part.component == component
        else part
        for part in report.parts
    )
    return replace(report, parts=parts)


def test_the_same_verdicts_are_no_finding() -> None:
    assert find_difference(faces(a="clean", b="dirty"), faces(a="clean", b="dirty"), exported()) is None
    assert find_difference(small_report(), small_report(), exported()) is None


def test_faces_that_come_out_worse_are_named_with_the_seconds_and_a_remedy() -> None:
    found = find_difference(
        faces(a="clean", b="clean", c="dirty"), faces(a="dirty", b="marginal", c="dirty"), exported(AT_ONCE)
    )
    assert found is not None
    assert (found.severity, str(found.made_by)) == ("warning", "sequence[0]/sweep")
    assert "planned clean, driven dirty: faces a; planned clean, driven marginal: faces b, as LinuxCNC" in found.message
    planned, driven = (each.totals.spray_s for each in (exported(AT_ONCE).report.requested, exported(AT_ONCE).driven))
    assert driven > 1.03 * planned
    assert (
        f"The jets are on for {driven:.2f} s, planned {planned:.2f} s; farthest off sequence[0]/sweep" in found.message
    )
    assert "Remedy: plan with" in found.message


def test_times_as_planned_leave_a_plan_that_only_just_has_its_verdict() -> None:
    found = find_difference(faces(a="clean"), faces(a="marginal"), exported())
    assert found is not None
    assert "only just has its verdict. Remedy: plan with more time there" in found.message


def test_what_only_comes_out_better_is_a_note() -> None:
    found = find_difference(faces(a="dirty"), faces(a="clean"), exported())
    assert found is not None
    assert found.severity == "info"
    assert "Remedy" not in found.message


@pytest.mark.parametrize(("component", "named"), [("C1", "C1 (top)"), ("R2", "R2 (top)")])
def test_components_are_named_with_their_sides(component: str, named: str) -> None:
    there = with_verdict(component, "marginal")
    found = find_difference(small_report(), there, exported())
    assert found is not None
    assert f"planned clean, driven marginal: {named}, as LinuxCNC" in found.message
    shown = DrivenVerdict("LinuxCNC", small_report(), there, found)
    assert "dirty, 2 of 5 components clean as planned, dirty, 1 of 5 components clean as LinuxCNC" in repr(shown)
    assert shown.data()["driven"] == "dirty"


def test_the_card_states_once_how_many_verdicts_rest_on_uncalibrated_kinetics() -> None:
    report = small_report()
    card = str(DrivenVerdict("LinuxCNC", report, report, None).card())
    assert card.count("uncalibrated") == 1
    assert "uncalibrated" not in str(DrivenVerdict("LinuxCNC", faces(a="clean"), faces(a="clean"), None).card())
