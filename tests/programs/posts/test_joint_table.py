"""Joint tables that are damaged are refused with their row."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from installations import small_cell
from robot_programs import PROGRAMS, joints_of

from programs.errors import ProgramError
from programs.export import export, write_motion
from programs.motion.make_motion import make_motion
from programs.motion.steps import Line
from programs.posts.joint_table import DIALECT
from programs.posts.proving.compare import compare

ROW = 20


@pytest.fixture(scope="module")
def table() -> tuple[str, list[str]]:
    program = PROGRAMS["loop"]()
    ((file, text),) = export(program, small_cell(), "joint-table", joints_of(program)).files.items()
    return file, text.splitlines()


DAMAGES: dict[str, Callable[[str], str]] = {
    "a value lost": lambda row: row.partition(",")[2],
    "two values lost": lambda row: row.rpartition(",")[0].rpartition(",")[0],
    "a value too many": lambda row: f"{row},0",
    "no row": lambda row: "",
    "a quotation mark": lambda row: f'"{row}',
    "a value that never ends": lambda row: f"{row}{'x' * 200_000}",
    "no number": lambda row: row.replace(",", ",x", 1),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_row_is_refused(table: tuple[str, list[str]], damage: str) -> None:
    file, lines = table
    text = "\n".join([*lines[:ROW], DAMAGES[damage](lines[ROW]), *lines[ROW + 1 :]])
    with pytest.raises(ProgramError, match="row") as caught:
        DIALECT.read({file: text})
    assert caught.value.line == ROW + 1


@pytest.mark.parametrize("kept", [1, 20, -1])
def test_a_table_that_ends_early_is_refused(table: tuple[str, list[str]], kept: int) -> None:
    file, lines = table
    header = next(at for at, line in enumerate(lines) if not line.startswith("#"))
    rows = lines[header + 1 :]
    text = "\n".join([*lines[: header + 1], *rows[:kept]])
    with pytest.raises(ProgramError, match=rf"ends at node {len(rows[:kept])} of {len(rows)}: it was cut off"):
        DIALECT.read({file: text})


def test_a_signal_right_after_a_moment_of_the_motion_has_a_row_at_the_same_place() -> None:
    program = PROGRAMS["loop"]()
    cell, joints = small_cell(), joints_of(program)
    ((file, text),) = export(program, cell, "joint-table", joints).files.items()
    rows = [row for row in text.splitlines() if not row.startswith("# Rows")]
    at = next(at for at, row in enumerate(rows) if at > ROW and " = " in row and "transfer" in row)
    node, time_s, *rest = rows[at].split(",")
    rest[-2] = ""
    rows.insert(at, ",".join([node, f"{float(time_s) - 4e-6:.6f}", *rest]))
    for later in range(at + 1, len(rows)):
        _, _, values = rows[later].partition(",")
        rows[later] = f"{int(node) + later - at},{values}"
    motion = make_motion(program, cell, joints)
    assert compare(DIALECT.read({file: "\n".join(rows)}), motion, cell) == ()


def test_the_moments_right_before_the_end_of_a_line_belong_to_it_though_another_follows() -> None:
    program = PROGRAMS["three_speeds"]()
    motion = make_motion(program, small_cell(), joints_of(program))

    def slowly(line: Line) -> Line:
        samples, late = line.samples, 1.0 - 3e-4 / line.length_mm
        seconds = np.array([samples.second_at(late) + 0.05, samples.seconds[-1] + 0.1])
        rows = [[np.interp(late, samples.shares, column), column[-1]] for column in samples.joints.T]
        before = samples.shares < late
        return replace(
            line,
            samples=replace(
                samples,
                seconds=np.append(samples.seconds[before], seconds),
                shares=np.append(samples.shares[before], [late, 1.0]),
                joints=np.vstack((samples.joints[before], np.array(rows).T)),
            ),
        )

    after = (*motion.steps[1:], None)
    slowed = [
        isinstance(a, Line) and isinstance(b, Line) and a.length_mm > 0.0
        for a, b in zip(motion.steps, after, strict=True)
    ]
    steps = tuple(slowly(step) if slow else step for step, slow in zip(motion.steps, slowed, strict=True))
    assert sum(slowed) > 3
    write_motion(DIALECT, replace(motion, steps=steps), small_cell())
