"""Names and numbers that a program gives to routines, tools and frames."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from programs.errors import ProgramError
from programs.motion.installation import Installation
from programs.motion.steps import MotionProgram, UseBoard, UseTool
from programs.pose import Pose
from programs.posts.writing.angles import fixed_xyz
from programs.posts.writing.forms import fill
from programs.posts.writing.wording import make_name, pose_words

TABLE_FORM = "{table} {number:0} = X {x:-3} Y {y:-3} Z {z:-3} Rx {a:-4} Ry {b:-4} Rz {c:-4}  {name}"
"""Of a frame that is to be entered in a table of the controller."""


@dataclass(slots=True)
class Names:
    """The names given so far; a thing has the same name each time, unlike all others."""

    longest: int
    """Characters that the language allows."""
    taken: set[str]
    """Names in use, and the words of the language; lower case."""
    spell: Callable[[str], str] = str
    """``str.upper`` or ``str.lower`` where the language has one case."""
    link: str = "_"
    """Character before the number of a name that was taken."""
    given: dict[tuple[str, object], str] = field(default_factory=dict[tuple[str, object], str])

    def give(self, kind: str, key: object, proposed: str, longest: int = 0) -> str:
        """Name a thing."""
        if (kind, key) not in self.given:
            chosen = make_name(proposed, longest or self.longest, self.taken, self.link)
            self.taken.add(chosen.lower())
            self.given[kind, key] = self.spell(chosen)
        return self.given[kind, key]


@dataclass(slots=True)
class Slots:
    """The controller's numbers for tools and places of the board, and those in use."""

    tools: dict[int, int]
    """By the number in ``NOZZLE name TOOL number``: the same where the controller has it, else the first free one."""
    boards: dict[str, tuple[int, Pose]]
    """Number, from 1 in the order of use, and ``T_base_board``, by the placement."""
    tool: int = 0
    board: int = 0

    def use(self, step: UseTool | UseBoard) -> None:
        """Use another tool or board from now on."""
        if isinstance(step, UseTool):
            self.tool = self.tools[step.number]
        else:
            self.board = self.boards[step.placement][0]

    def entries(self, installation: Installation) -> Iterator[tuple[str, int, str, Pose]]:
        """Give kind, number, name and pose of each tool and each place of the board."""
        for number, slot in self.tools.items():
            tool = installation.tool(number)
            yield "tool", slot, tool.name, tool.T_flange_tcp
        for placement, (slot, place) in self.boards.items():
            yield "board", slot, placement or "board as mounted", place


def number_slots(motion: MotionProgram, most: int | None = None) -> Slots:
    """Number the tools and boards of a program.

    Args:
        motion: The program.
        most: Numbers that the controller has, from 1; ``None`` where tools have any number.

    Raises:
        ProgramError: they are too few.
    """
    boards: dict[str, tuple[int, Pose]] = {}
    numbers = list(dict.fromkeys(step.number for step in motion.steps if isinstance(step, UseTool)))
    for step in motion.steps:
        if isinstance(step, UseBoard) and step.placement not in boards:
            boards[step.placement] = (len(boards) + 1, step.T_base_board)
    if most is None:
        return Slots({number: number for number in numbers}, boards)
    if max(len(numbers), len(boards)) > most:
        used = f"{len(numbers)} tools and {len(boards)} places of the board"
        raise ProgramError(f"the program uses {used}; this controller has {most} of each.")
    tools = {number: number for number in numbers if 1 <= number <= most}
    free = iter([slot for slot in range(1, most + 1) if slot not in tools])
    return Slots({number: tools[number] if number in tools else next(free) for number in numbers}, boards)


def table_lines(slots: Slots, installation: Installation, tool_word: str, board_word: str) -> Iterator[str]:
    """Describe the controller's tables: mm, and degrees about the fixed x, then y, then z axis."""
    for kind, number, name, pose in slots.entries(installation):
        words = dict(zip("xyzabc", pose_words(pose, fixed_xyz), strict=True))
        yield fill(TABLE_FORM, **words, table=tool_word if kind == "tool" else board_word, number=number, name=name)
