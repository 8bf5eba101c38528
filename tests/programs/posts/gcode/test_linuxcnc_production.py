"""The production frame on LinuxCNC's real controller: waits, a start at a later part, and valves after a stop."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from installations import WASH, small_cell
from real_linuxcnc import MISSING, Axis, ControllerLog, Stop, Surroundings, run_on_linuxcnc
from robot_programs import PROGRAMS

from programs.export import export
from programs.motion.installation import Joint
from programs.motion.layout import on_time
from programs.program import MoveTo

pytestmark = [pytest.mark.controller, pytest.mark.skipif(bool(MISSING), reason=MISSING)]
AXES = tuple(Axis(letter, turns=False, least=-500, most=500, speed=1000, acceleration=5000) for letter in "XYZ")
HOME, BEGINS = (0.0, 0.0, 150.0), (0.0, 0.0, 50.0)
"""Where the axes are at home, and where the first pass begins."""
_SMALL = small_cell()
CELL = replace(
    _SMALL,
    joints=tuple(Joint(letter, "prismatic") for letter in "XYZ"),
    home=HOME,
    waits=tuple(replace(wait, timeout_s=2.0) for wait in _SMALL.waits),
)
PART = 3
"""Contact that is on where there is a board; the door's is off where it is closed."""
CALL_ON_ABORT = "ON_ABORT_COMMAND = O <shut_valves> call"


def written(folder: Path, start: int = 1) -> Path:
    """Export a program of loops, and set up what its header states."""
    program = PROGRAMS["loop"]()
    places = np.array([each.position for each in program.instructions if isinstance(each, MoveTo)])
    text, shut = export(program, CELL, "linuxcnc", on_time(program, places)).files.values()
    assert CALL_ON_ABORT in text
    (folder / "shut_valves.ngc").write_text(shut, "ascii")
    path = folder / "loop.ngc"
    path.write_text(text.replace("\n#<_start> = 1\n", f"\n#<_start> = {start}\n", 1), "ascii")
    return path


def wiring() -> dict[str, str]:
    """Give what the documentation tells the integrator to wire, as it stands there."""
    text = (Path(__file__).parents[4] / "docs" / "robot-programs.md").read_text("utf-8")
    blocks = {kind: re.search(rf"^```{kind}\n(.*?)^```", text, re.DOTALL | re.MULTILINE) for kind in ("hal", "python")}
    return {kind: found[1] for kind, found in blocks.items() if found}


def run(
    folder: Path,
    *,
    start: int = 1,
    contacts: tuple[int, ...] = (PART,),
    stop: Stop | None = None,
    after: int = 1,
) -> ControllerLog:
    """Run it on the controller; stopped as soon as the valve has changed so many times, or not at all."""
    stop_at = None if stop is None else WASH.number
    around = Surroundings((CALL_ON_ABORT,), contacts, stop_at, after, stop or "abort")
    return run_on_linuxcnc(written(folder, start), AXES, limit_s=60.0, around=around)


@pytest.mark.parametrize(
    ("stop", "after"),
    [
        pytest.param("abort", 1, id="abort while it sprays"),
        pytest.param("abort", 2, id="abort between two jets, where the next one is queued"),
        pytest.param("abort", 3, id="abort while it sprays once more"),
        pytest.param("emergency stop", 1, id="emergency stop while it sprays"),
        pytest.param("emergency stop", 2, id="emergency stop between two jets"),
    ],
)
def test_a_program_that_is_stopped_leaves_every_valve_shut(stop: Stop, after: int, tmp_path: Path) -> None:
    log = run(tmp_path, stop=stop, after=after)
    assert [on for _, on in log.edges("P1")] == [True, False] * ((after + 1) // 2)
    assert np.abs(log.joints[-1] - HOME).max() > 1.0  # it was stopped on its way


@pytest.mark.parametrize("wired", [True, False])
def test_where_the_task_controller_is_killed_the_wired_watchdog_shuts_every_valve(
    *, wired: bool, tmp_path: Path
) -> None:
    around = Surroundings((CALL_ON_ABORT,), (PART,), WASH.number, 1, "kill")
    if wired:
        lines = wiring()
        sampled = {"motion.digital-out-01": "valve-1.out"}
        around = replace(around, wiring=lines["hal"], watch=lines["python"], sampled=sampled)
    log = run_on_linuxcnc(written(tmp_path), AXES, limit_s=60.0, around=around)
    edges = [on for _, on in log.edges("P1")]
    if wired:
        assert edges == [True, False]
        assert np.abs(log.joints[-1] - HOME).max() > 1.0
    else:  # the motion module drives what is queued, and leaves the outputs as they are
        assert edges == [True]


def test_a_board_is_finished_from_a_later_part(tmp_path: Path) -> None:
    log = run(tmp_path, start=2)
    assert log.messages == ()
    np.testing.assert_allclose(log.joints[-1], HOME)
    assert [on for _, on in log.edges("P1")] == [True, False] * 2
    (opened, _), *_ = log.edges("P1")
    np.testing.assert_allclose(log.joints[round(opened * 1e3)], BEGINS, atol=0.1)
    assert log.outputs["E1"][-1] == pytest.approx(7.5)  # the pressure, which part 1 sets otherwise


def test_a_part_that_is_not_there_is_waited_for_no_longer_than_stated(tmp_path: Path) -> None:
    late = run(tmp_path, contacts=())
    assert "no part present" in " ".join(late.messages)
    assert late.moving == slice(0, 0)
    assert late.edges("P1") == []
