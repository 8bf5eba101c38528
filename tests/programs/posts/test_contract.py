"""Every language in every library cell: written and read back to the same motion, or refused in one sentence."""

from collections.abc import Mapping
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from robot_programs import PROGRAMS, joints_of

from programs.errors import ProgramError
from programs.export import export
from programs.motion.installation import Installation
from programs.motion.make_motion import make_motion
from programs.posts.dialects import DIALECTS
from programs.posts.reading.compare import compare
from programs.program import TimedProgram
from robotcell.cell.installation import installation_of
from robotcell.cell.load import cell_library, read_cell

QUICK = ("two_tools", "bottom", "loop")
"""Two nozzles and their valves, a board that is turned over, a sensor."""
CASES = [
    pytest.param(dialect, cell, made, id=f"{dialect}-{cell}-{made}", marks=() if made in QUICK else pytest.mark.slow)
    for dialect in DIALECTS
    for cell in cell_library()
    for made in PROGRAMS
]


@cache
def installed(cell: str) -> Installation:
    return installation_of(read_cell(cell))


def joints_in(program: TimedProgram, installation: Installation) -> NDArray[np.float64]:
    """Joints that move as the orifice does, as many as the robot has; slides by whole millimetres."""
    scales = np.array([100.0 if joint.kind == "prismatic" else 1.0 for joint in installation.joints])
    return np.tile(joints_of(program), (1, 2))[:, : len(scales)] * scales


@pytest.mark.parametrize(("dialect", "cell", "made"), CASES)
def test_it_is_read_back_as_planned_or_refused(dialect: str, cell: str, made: str) -> None:
    language, installation, program = DIALECTS[dialect], installed(cell), PROGRAMS[made]()
    joints = joints_in(program, installation) if language.needs_joints else None
    motion = make_motion(program, installation, joints)
    written = written_or_refused(dialect, installation, program, joints)
    if isinstance(written, str):
        assert is_a_sentence(written)
    else:
        assert compare(language.read(written), motion, installation) == ()


def written_or_refused(
    dialect: str, installation: Installation, program: TimedProgram, joints: NDArray[np.float64] | None
) -> Mapping[str, str] | str:
    """Give the files, or why there are none."""
    try:
        return export(program, installation, dialect, joints).files
    except ProgramError as refusal:
        return str(refusal)


@pytest.mark.parametrize("dialect", [name for name, language in DIALECTS.items() if language.needs_joints])
def test_a_language_of_joints_is_refused_without_them(dialect: str) -> None:
    with pytest.raises(ProgramError) as caught:
        export(PROGRAMS["two_tools"](), installed("ur5e-bench"), dialect)
    assert is_a_sentence(str(caught.value))


def is_a_sentence(text: str) -> bool:
    return "\n" not in text and text.endswith(".") and len(text) < 300
