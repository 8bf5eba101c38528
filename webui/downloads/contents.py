"""The text in a zip that lists its files, and what an integrator needs to load the robot's program."""

from collections.abc import Mapping, Sequence

from programs.export import find_dialect
from programs.plan import Command
from programs.posts.writing.frame import TOOLS_CHANGED, name_tools
from reports.tables.wording import clock
from robotcell.cell.cell_edits import place_of
from robotcell.cell.hold import describe_held
from robotcell.cell.load import LoadedCell
from webui.page.evaluations import Checked


def contents_text(about: Mapping[str, str], how: Sequence[str]) -> bytes:
    """List files with what each is, then further lines."""
    width = max(map(len, about))
    lines = [f"{name:<{width}}  {description}" for name, description in about.items()]
    return "\n".join([*lines, *([""] if how else []), *how, ""]).encode()


def how_to_load(cell: LoadedCell, checked: Checked, dialect: str) -> tuple[str, ...]:
    """Where robot and board have to be, how long the robot takes, what the program calls, and how it is loaded.

    Args:
        cell: The cell that the program was written for.
        checked: The program in it.
        dialect: Name of its language.
    """
    base, board = place_of(cell.cell.T_cell_base), place_of(cell.cell.held_pose)
    robots_s, planned_s = (each.totals.duration_s for each in (checked.program, checked.run.program))
    commands = [each for each in checked.run.plan.items if isinstance(each, Command)]
    calls = dict.fromkeys(each.arguments[0] for each in commands if each.keyword == "CALL")
    tools = {each.arguments[2]: each.arguments[0] for each in commands if each.keyword == "NOZZLE"}
    return (
        f"Cell: {cell.cell.name}, robot {cell.cell.robot.name}. The real cell must be as its file, in mm and degrees:",
        f"  robot's base at {_list(base.xyz_mm)}, roll, pitch and yaw {_list(base.rpy_deg)}",
        f"  board held by its {describe_held(cell.spec.board.held_by)}, which is at {_list(board.xyz_mm)}, roll, pitch "
        f"and yaw {_list(board.rpy_deg)}",
        f"Time: {clock(robots_s)} as the robot moves, for which the program is written. Report and picture have what "
        f"the recipe alone takes, {clock(planned_s)}.",
        *(f"You provide {name}: the program calls it, and goes on when it returns." for name in calls),
        *([f"You change the tools, {name_tools(tools)}: {TOOLS_CHANGED}."] if len(tools) > 1 else []),
        "What is waited for, outputs and what to set up stand in the head of the program. Run it slowly and dry first.",
        f"To load the robot's program: {find_dialect(dialect).notes}",
    )


def _list(values: Sequence[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)
