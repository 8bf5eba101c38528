"""Names, comments and numbers that a controller accepts."""

import re
import unicodedata
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from hashlib import sha256

from programs.errors import ProgramError
from programs.motion.installation import Installation
from programs.motion.steps import MotionProgram, UseBoard, UseTool
from programs.pose import Pose, Quaternion
from programs.posts.writing.angles import fixed_xyz
from programs.posts.writing.forms import fill, fixed
from programs.posts.writing.vocabulary import Vocabulary

TABLE_FORM = "{table} {number:0} = X {x:-3} Y {y:-3} Z {z:-3} Rx {a:-4} Ry {b:-4} Rz {c:-4}  {name}"
"""Of a frame that is to be entered in a table of the controller."""


@dataclass(slots=True)
class Names:
    """The names given so far; a thing has the same name each time, unlike all others and the words of the language."""

    vocabulary: Vocabulary
    taken: set[str]
    """Names in use; lower case."""
    spell: Callable[[str], str] = str
    """``str.upper`` or ``str.lower`` where the language has one case."""
    link: str = "_"
    """Character before the number of a name that was taken."""
    given: dict[tuple[str, object], str] = field(default_factory=dict[tuple[str, object], str])

    def give(self, kind: str, key: object, proposed: str, longest: int = 0) -> str:
        """Name a thing."""
        if (kind, key) not in self.given:
            chosen = make_name(proposed, longest or self.vocabulary.longest, self, self.link)
            self.taken.add(chosen.lower())
            self.given[kind, key] = self.spell(chosen)
        return self.given[kind, key]

    def __contains__(self, name: str) -> bool:
        """Whether a name is in use."""
        return name.lower() in self.taken or self.vocabulary.has(name)


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


_LETTERS = {
    "\N{GREEK CAPITAL LETTER OMEGA}": "Ohm",
    "\N{OHM SIGN}": "Ohm",
    "\N{MICRO SIGN}": "u",
    "\N{GREEK SMALL LETTER MU}": "u",
    "ß": "ss",
    "ø": "o",
    "Ø": "O",
    "æ": "ae",
    "Æ": "Ae",
    "°": "deg",
    "…": "...",
}

_DEVICES = frozenset(
    {"con", "prn", "aux", "nul", *(f"{port}{number}" for port in ("com", "lpt") for number in range(10))}
)
"""Names that no file may have under Windows, on which many controllers and most makers' tools run."""


def plain(text: str) -> str:
    """Spell a text in printable ASCII: letters without their accents, a question mark for what has no letter."""
    if text.isascii() and text.isprintable():
        return text
    spelt = "".join(_LETTERS.get(letter, letter) for letter in text)
    flat = "".join(letter for letter in unicodedata.normalize("NFKD", spelt) if not unicodedata.combining(letter))
    return "".join(letter if " " <= letter <= "~" else "?" for letter in flat)


def cut(text: str, longest: int) -> str:
    """Shorten a comment to what a line holds, and show that something is missing."""
    words = plain(text)
    return words if len(words) <= longest else words[: max(longest - 3, 0)] + "..."[:longest]


def make_name(text: str, longest: int, taken: Container[str] = (), link: str = "_") -> str:
    """Make an identifier: letters, digits and underscores, a letter first, unlike those taken whatever their case.

    A file may have it as its name.

    Args:
        text: What it describes.
        longest: Characters that the language allows.
        taken: Names in use; lower case.
        link: Character before the number of a name that is taken.
    """
    words = re.sub(r"[^A-Za-z0-9_]+", "_", plain(text)).strip("_")
    name = words if words[:1].isalpha() else f"W{words}"
    chosen, number = name[:longest].rstrip("_"), 2
    while chosen.lower() in _DEVICES or chosen.lower() in taken:
        end = f"{link}{number}"
        chosen, number = name[: longest - len(end)].rstrip("_") + end, number + 1
    return chosen


_WHOLE_NAME = re.compile(r"[a-z][a-z0-9]*(?:-[a-z0-9]+)*")
"""Of a board or a recipe: letters may become others of their case and hyphens underscores, and names stay different."""
_HASH_DIGITS = "0123456789abcdefghijklmnopqrstuvwxyz"
_HASH_LENGTH, _LONGEST_STEM = 4, 200


def name_program(board: str, recipe: str, longest: int, link: str = "_", first: str = "") -> str:
    """Name a program by its board and its recipe: programs of others have other names.

    Where letters are cut or spelled otherwise four letters that depend on both end the name.

    Args:
        board: Name of the board.
        recipe: Name of the recipe.
        longest: Characters that the language allows.
        link: Character between the parts of a name; empty where names are short.
        first: Word that the name begins with, so that it differs from the name without it.
    """
    parts = [*filter(None, [first]), board, recipe]
    whole = "--".join(parts).replace("-", link or "-")
    if link and len(whole) <= longest and _WHOLE_NAME.fullmatch(board) and _WHOLE_NAME.fullmatch(recipe):
        return whole
    rest, letters = int.from_bytes(sha256("\0".join(parts).encode()).digest()), ""
    while len(letters) < _HASH_LENGTH:
        rest, digit = divmod(rest, len(_HASH_DIGITS))
        letters += _HASH_DIGITS[digit]
    stem = make_name("_".join(parts), _LONGEST_STEM).replace("_", link)
    return f"{stem[: longest - _HASH_LENGTH - len(link)].rstrip('_')}{link}{letters}"


def name_motion(motion: MotionProgram, longest: int, link: str = "_") -> str:
    """Name the program of a motion; that of a first run has a name of its own, so that it replaces no other."""
    first = "first" if motion.first_run else ""
    return name_program(motion.origin.board, motion.origin.recipe, longest, link, first)


def pose_words(pose: Pose, angles: Callable[[Quaternion], Sequence[float]]) -> list[str]:
    """Write a pose as six numbers: mm with three decimals, and the angles of a maker, degrees with four."""
    return [
        *(fixed(value, 3) for value in pose.position),
        *(fixed(value, 4) for value in angles(pose.quaternion)),
    ]


def split_wait(seconds: float, longest_s: float, digits: int) -> list[float]:
    """Divide a time into waits that an instruction can hold: whole longest ones, then the rest."""
    left, waits = round(seconds, digits), list[float]()
    while left > longest_s:
        waits.append(longest_s)
        left = round(left - longest_s, digits)
    return [*waits, left]


def join_lines(lines: Iterable[str]) -> str:
    """Give the text of a file: each line with its end."""
    return "".join(f"{line}\n" for line in lines)


def indent(lines: Iterable[str]) -> list[str]:
    """Indent lines by two spaces; empty ones stay empty."""
    return [f"  {line}" if line else "" for line in lines]
