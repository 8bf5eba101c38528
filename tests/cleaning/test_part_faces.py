"""Verdicts on faces: the time in the cone against what can be worked out by hand."""

import numpy as np
import pytest
from small_parts import block, part_of, surface_recipe

from cleaning.part_faces import judge_faces, times_in_cone, weigh_faces
from programs.plan import Origin
from programs.program import MoveTo, SetNozzle, TimedProgram, Totals
from specs.source import Source

DOWN = (0.0, 1.0, 0.0, 0.0)
MADE_BY = Source(0, "all", ("face-1",))
PLATE = part_of(block((0, 0, 0), (100, 60, 10)), "face-2", "face-3", "face-4", "face-5", "face-6")


def pass_over(seconds: float, y_mm: float = 30.0) -> TimedProgram:
    """One pass along the middle of the plate, the orifice 60 mm above it, from 20 mm before it to 20 mm behind it."""
    begin, end = ((x, y_mm, 70.0) for x in (-20.0, 120.0))
    speed = 140.0 / seconds
    instructions = (
        MoveTo(0.0, begin, DOWN, 0.0, MADE_BY), SetNozzle(0.0, True, MADE_BY),
        MoveTo(seconds, end, DOWN, speed, MADE_BY), SetNozzle(seconds, False, MADE_BY),
    )  # fmt: skip
    return TimedProgram(Origin("thing", PLATE.sha256, "small", ""), Totals(seconds, seconds, 140, 2, ()), instructions)


def test_a_cell_is_held_while_its_chord_of_the_cone_passes() -> None:
    seconds = 14.0
    (held,) = times_in_cone(pass_over(seconds), PLATE, surface_recipe())
    radius = 60 * np.tan(np.radians(15))
    across = np.abs(held.cells.points[:, 1] - 30)
    chord = 2 * np.sqrt(np.maximum(radius**2 - across**2, 0))
    clear = np.abs(across - radius) > 0.5
    np.testing.assert_allclose(held.seconds[clear], (chord * seconds / 140)[clear], atol=0.11)


@pytest.mark.parametrize(("seconds", "verdict"), [(40.0, "clean"), (2.0, "dirty")])
def test_the_verdict_counts_what_is_visible_only(seconds: float, verdict: str) -> None:
    held = times_in_cone(pass_over(seconds), PLATE, surface_recipe())
    near = np.abs(held[0].cells.points[:, 1] - 30) < 12
    found = judge_faces(PLATE, held, near, np.where(near, -1, 0))
    assert [each.verdict for each in found] == [verdict]
    assert found[0].hidden_by == ("part",)
    assert found[0].unseen_mm2 == pytest.approx(found[0].area_mm2 * (1 - found[0].visible_share))
    assert weigh_faces(found).verdict == verdict


def test_a_face_that_nothing_sees_has_no_verdict() -> None:
    held = times_in_cone(pass_over(10.0), PLATE, surface_recipe())
    nothing = np.zeros(len(held[0].seconds), dtype=bool)
    assert judge_faces(PLATE, held, nothing, np.zeros(len(nothing), dtype=np.int64))[0].verdict == "no verdict"


@pytest.mark.parametrize("before_s", [0.0, 1.003, 1.017, 2.009])
def test_what_is_held_for_just_the_required_time_is_held_whatever_the_program_takes(before_s: float) -> None:
    """The moments that are looked at are no fault of the program's."""
    above, aside = (50.0, 30.0, 70.0), (50.0, 500.0, 70.0)
    until = before_s + 1.0
    instructions = (
        MoveTo(0.0, aside, DOWN, 0.0, MADE_BY), MoveTo(before_s, above, DOWN, 1e6, MADE_BY),
        SetNozzle(before_s, True, MADE_BY), SetNozzle(until, False, MADE_BY),
        MoveTo(until + 0.004, above, DOWN, 0.0, MADE_BY),
    )  # fmt: skip
    totals = Totals(until + 0.004, 1.0, 470, 3, ())
    program = TimedProgram(Origin("thing", PLATE.sha256, "small", ""), totals, instructions)
    held = times_in_cone(program, PLATE, surface_recipe())
    inside = np.linalg.norm(held[0].cells.points[:, :2] - above[:2], axis=1) < 14
    assert [each.verdict for each in judge_faces(PLATE, held, inside, np.where(inside, -1, 0))] == ["clean"]
