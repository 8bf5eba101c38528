"""LinuxCNC's real controller on small programs: what the log of a run holds."""

from pathlib import Path

import numpy as np
import pytest
from real_linuxcnc import MISSING, Axis, run_on_linuxcnc

pytestmark = [pytest.mark.controller, pytest.mark.skipif(bool(MISSING), reason=MISSING)]
AXES = (
    Axis("X", turns=False, least=-300, most=300, speed=1000, acceleration=5000),
    Axis("Y", turns=False, least=-300, most=300, speed=1000, acceleration=5000),
    Axis("C", turns=True, least=-1000, most=1000, speed=360, acceleration=2000),
)
SQUARE = """G21 G90 G17 G40 G49 G80
G64 P0.05 Q0
G94
M65 P1
M62 P1
G1 X50 F6000
G1 Y50
M63 P1
G1 X0
M68 E2 Q3.5
G1 Y0 C90
G4 P0.1
M2
"""


def test_a_run_is_logged_in_every_servo_cycle(tmp_path: Path) -> None:
    program = tmp_path / "square.ngc"
    program.write_text(SQUARE, "ascii")
    log = run_on_linuxcnc(program, AXES, limit_s=60.0)
    moving = log.joints[log.moving]
    assert (moving[0].tolist(), moving[-1].tolist()) == ([0.0, 0.0, 0.0], [0.0, 0.0, 90.0])
    assert np.abs(np.diff(moving[:, :2], axis=0)).max() <= 0.1 + 1e-6  # 6000 mm/min in 1 ms
    corner = np.linalg.norm(moving[:, :2] - [50.0, 50.0], axis=1).min()
    assert 0.0 < corner < 0.055  # G64 P0.05, and the way of a cycle
    (begins, on), (ends, off) = log.edges("P1")
    assert (on, off) == (True, False)
    assert log.joints[round(begins / 1e-3), 0] == pytest.approx(0.0, abs=0.1)
    assert log.joints[round(ends / 1e-3)] == pytest.approx([50.0, 50.0, 0.0], abs=0.2)
    assert log.outputs["E2"][-1] == 3.5
    assert log.messages == ()


def test_a_program_that_leaves_the_travel_does_not_move_and_gives_a_message(tmp_path: Path) -> None:
    program = tmp_path / "far.ngc"
    program.write_text("G21 G90\nG1 X400 F6000\nM2\n", "ascii")
    log = run_on_linuxcnc(program, AXES, limit_s=60.0)
    assert log.moving == slice(0, 0)
    assert "exceed X's positive limit" in " ".join(log.messages)
