"""Every language in the library's cells of its maker: written and read back to the same motion; refused elsewhere."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from installations import ARM_LANGUAGES, MACHINE_LANGUAGES
from robot_programs import PROGRAMS, joints_of

from programs.errors import ProgramError
from programs.export import Exported, Variant, check_maker, export
from programs.motion.installation import MAKER_NAMES, Installation, JointConvention
from programs.motion.layout import Tracking, on_time
from programs.motion.make_motion import make_motion
from programs.motion.steps import Call, Reach, UseTool
from programs.posts.dialects import DIALECTS
from programs.posts.proving.compare import compare
from programs.posts.rebuilt import ReadReach
from programs.posts.writing.axes import from_controller_counts, in_degrees_and_mm
from programs.program import TimedProgram
from robotcell.cell.installation import installation_of
from robotcell.cell.load import cell_library, read_cell

NEUTRAL = ("ur5e-bench", "gantry")


@cache
def installed(cell: str) -> Installation:
    """A cell whose joints are its controller's axes: joints that are made up belong to no tool points."""
    return replace(installation_of(read_cell(cell)), tool_point=None)


def cells_of(dialect: str) -> list[str]:
    """Library cells in which a language is tried: those of its maker, or two for languages that take any robot."""
    maker = DIALECTS[dialect].maker
    return [cell for cell in cell_library() if (installed(cell).maker == maker if maker else cell in NEUTRAL)]


QUICK = ("two_tools", "bottom", "loop")
"""Two nozzles and their valves, a board that is turned over, a sensor."""
CASES = [
    pytest.param(dialect, cell, made, id=f"{dialect}-{cell}-{made}")
    for dialect in ARM_LANGUAGES
    for cell in cells_of(dialect)
    for made in QUICK
]


def joints_in(program: TimedProgram, installation: Installation) -> Tracking:
    """Joints that move as the orifice does, as many as the robot has; slides by whole millimetres."""
    scales = np.array([100.0 if joint.kind == "prismatic" else 1.0 for joint in installation.joints])
    return on_time(program, np.tile(joints_of(program).joints, (1, 2))[:, : len(scales)] * scales)


@pytest.mark.parametrize(("dialect", "cell", "made"), CASES)
def test_it_is_read_back_as_planned_or_refused(dialect: str, cell: str, made: str) -> None:
    language, installation, program = DIALECTS[dialect], installed(cell), PROGRAMS[made]()
    joints = joints_in(program, installation)
    motion = make_motion(program, installation, joints, switches_at_rest=language.capability.switches_at_rest)
    written = written_or_refused(dialect, installation, program, joints)
    if isinstance(written, str):
        assert is_a_sentence(written)
    else:
        assert compare(language.read(written.files), written.commanded, installation) == ()
        assert [(step.target, step.made_by) for step in written.commanded.lines] == [
            (step.target, step.made_by) for step in motion.lines
        ]
        calls = {step.name for step in motion.steps if isinstance(step, Call) and dialect != "joint-table"}
        assert sum(text.count("You provide ") for text in written.files.values()) == len(calls)
        tools = {step.number for step in motion.steps if isinstance(step, UseTool) and dialect != "joint-table"}
        assert sum(len(re.findall(r"Tools \d+ [(\[]", text)) for text in written.files.values()) == (len(tools) > 1)


@pytest.mark.parametrize("dialect", ARM_LANGUAGES)
def test_a_library_robot_takes_the_languages_of_its_maker_and_no_others(dialect: str) -> None:
    language = DIALECTS[dialect]
    assert cells_of(dialect)
    for cell in cell_library():
        if language.maker in (None, installed(cell).maker):
            check_maker(language, installed(cell))
            continue
        with pytest.raises(ProgramError) as caught:
            check_maker(language, installed(cell))
        assert is_a_sentence(str(caught.value))
        assert MAKER_NAMES[language.maker] in str(caught.value)
        assert installed(cell).robot in str(caught.value)


@pytest.mark.parametrize("cell", cell_library())
def test_a_library_cell_takes_the_languages_of_machines_if_it_states_tool_points(cell: str) -> None:
    installation = installed(cell)
    for dialect in MACHINE_LANGUAGES:
        language = DIALECTS[dialect]
        if installation.tool_point is not None:
            check_maker(language, installation)
            continue
        with pytest.raises(ProgramError) as caught:
            check_maker(language, installation)
        assert is_a_sentence(str(caught.value))
        assert language.title in str(caught.value)
        assert installation.cell in str(caught.value)


@pytest.mark.parametrize("dialect", ARM_LANGUAGES)
def test_a_program_without_joint_values_has_none_or_is_refused(dialect: str) -> None:
    program, language = PROGRAMS["two_tools"](), DIALECTS[dialect]
    cell = installed("kr6-bench" if language.maker != "kuka" else "ur5e-bench")
    joints = joints_in(program, cell)
    if not language.without_joints:
        with pytest.raises(ProgramError) as caught:
            export(program, cell, dialect, joints, Variant(without_joints=True))
        assert is_a_sentence(str(caught.value))
        return
    done = export(program, cell, dialect, joints, Variant(without_joints=True))
    reached = [step for step in language.read(done.files).steps if isinstance(step, ReadReach)]
    assert reached
    assert all(not step.joints for step in reached)
    assert "without-joints" in {finding.rule.id for finding in done.findings}
    assert "Written without joint values" in "".join(done.files.values())
    elsewhere = replace(cell, home=(0.1,) * len(cell.joints))
    assert export(program, elsewhere, dialect, joints, Variant(without_joints=True)).files == done.files
    evenly = replace(joints, share=np.ones(len(joints.clock)))  # other orientations between the ends, and half turns
    assert export(program, cell, dialect, evenly, Variant(without_joints=True)).files == done.files


@pytest.mark.parametrize("dialect", [name for name, each in DIALECTS.items() if each.maker not in (None, "yaskawa")])
def test_joint_values_are_read_back_as_the_controller_counts_them(dialect: str) -> None:
    """Zeros, signs and a coupling that no library robot has, so that none of them can be left out."""
    program, language = PROGRAMS["two_tools"](), DIALECTS[dialect]
    rows = np.diag([1.0, -1.0, 1.0, 1.0, -1.0, 1.0])
    rows[2, 1] = -1.0
    convention = JointConvention(tuple(map(tuple, rows.tolist())), (0.0, 90.0, -15.0, 0.0, 0.0, 180.0))
    plain = replace(installed(cells_of(dialect)[0]), convention=None)
    counted = replace(plain, convention=convention)
    joints = joints_in(program, plain)
    motion = make_motion(program, counted, joints, switches_at_rest=language.capability.switches_at_rest)
    done = export(program, counted, dialect, joints)
    files = done.files
    reached = [step for step in language.read(files).steps if isinstance(step, ReadReach)]
    planned = [step for step in motion.steps if isinstance(step, Reach)]
    for read, step in zip(reached, planned, strict=True):
        values = from_controller_counts(read.joints, counted)
        np.testing.assert_allclose(values, in_degrees_and_mm(step.joints, counted), atol=1e-3)
    assert compare(language.read(files), done.commanded, counted) == ()
    assert compare(language.read(files), done.commanded, plain) != ()  # the same text, read as another convention


def written_or_refused(
    dialect: str, installation: Installation, program: TimedProgram, joints: Tracking | None
) -> Exported | str:
    """Give the export, or why there is none."""
    try:
        return export(program, installation, dialect, joints)
    except ProgramError as refusal:
        return str(refusal)


@pytest.mark.parametrize("dialect", [name for name, language in ARM_LANGUAGES.items() if language.needs_joints])
def test_a_language_of_joints_is_refused_without_them(dialect: str) -> None:
    with pytest.raises(ProgramError) as caught:
        export(PROGRAMS["two_tools"](), installed("ur5e-bench"), dialect)
    assert is_a_sentence(str(caught.value))


def is_a_sentence(text: str) -> bool:
    return "\n" not in text and text.endswith(".") and len(text) < 300
