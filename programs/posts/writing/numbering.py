"""Tools and boards by number, for controllers that keep them in tables."""

from dataclasses import dataclass, replace

from programs.motion.installation import Installation, Tool
from programs.motion.steps_of_robot import Line, MotionProgram, Reach, UseBoard, UseTool
from programs.pose import Pose
from programs.posts.writing.angles import fixed_xyz
from programs.posts.writing.chapters import Chapter, Part
from programs.posts.writing.wording import fixed


@dataclass(frozen=True, slots=True)
class Tables:
    """What has to stand in the controller's tables of tools and user frames."""

    tools: dict[int, Tool]
    """By the number in ``NOZZLE name TOOL number``."""
    boards: dict[str, tuple[int, Pose]]
    """Number, from 1 in the order of use, and ``T_base_board``, by the placement."""


@dataclass(slots=True)
class Frames:
    """The numbers of the tool and the board in use."""

    tables: Tables
    tool: int = 0
    board: int = 0

    def use(self, step: UseTool | UseBoard) -> None:
        """Use another tool or board from now on."""
        if isinstance(step, UseTool):
            self.tool = step.number
        else:
            self.board = self.tables.boards[step.placement][0]

    def begin(self, chapter: Chapter) -> None:
        """Use what is in use when a chapter begins."""
        for step in (chapter.tool, chapter.board):
            if step is not None:
                self.use(step)


def number_frames(motion: MotionProgram, installation: Installation) -> Tables:
    """Number the tools and boards of a program."""
    tables = Tables({}, {})
    for step in motion.steps:
        if isinstance(step, UseTool):
            tables.tools[step.number] = installation.tool(step.number)
        elif isinstance(step, UseBoard) and step.placement not in tables.boards:
            tables.boards[step.placement] = (len(tables.boards) + 1, step.T_base_board)
    return tables


def table_lines(tables: Tables, tool_word: str, board_word: str) -> tuple[str, ...]:
    """Say the tables in words: mm, and degrees about the fixed x, then y, then z axis."""
    tools = [(f"{tool_word} {number}", tool.name, tool.T_flange_tcp) for number, tool in tables.tools.items()]
    boards = [
        (f"{board_word} {number}", placement or "board as mounted", place)
        for placement, (number, place) in tables.boards.items()
    ]
    return tuple(f"{label} = {pose_words(pose)}  {name}" for label, name, pose in (*tools, *boards))


def pose_words(pose: Pose) -> str:
    """Say a pose as x, y, z in mm and rx, ry, rz in degrees."""
    x, y, z = (fixed(value, 3) for value in pose.position)
    rx, ry, rz = (fixed(value, 4) for value in fixed_xyz(pose.quaternion))
    return f"X {x} Y {y} Z {z} Rx {rx} Ry {ry} Rz {rz}"


def part_at_boards(parts: tuple[Part, ...]) -> tuple[Part, ...]:
    """Divide chapters where the board is put elsewhere, for languages in which a routine has one user frame."""
    divided: list[Part] = []
    count = 0
    for part in parts:
        if not isinstance(part, Chapter):
            divided.append(part)
            continue
        for piece in _pieces(part):
            count += 1
            divided.append(replace(piece, number=count))
    return tuple(divided)


def _pieces(chapter: Chapter) -> list[Chapter]:
    first = next((at for at, step in enumerate(chapter.steps) if isinstance(step, Line | Reach)), len(chapter.steps))
    cuts = [at for at, step in enumerate(chapter.steps) if isinstance(step, UseBoard) and at > first]
    pieces: list[Chapter] = []
    tool, board = chapter.tool, chapter.board
    for begin, end in zip([0, *cuts], [*cuts, len(chapter.steps)], strict=True):
        steps = chapter.steps[begin:end]
        pieces.append(replace(chapter, steps=steps, tool=tool, board=board))
        tool = next((step for step in reversed(steps) if isinstance(step, UseTool)), tool)
        board = next((step for step in reversed(steps) if isinstance(step, UseBoard)), board)
    return pieces
