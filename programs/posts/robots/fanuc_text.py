"""The text of TP programs: what stands before the instructions, their numbers, and positions; written and read."""

import re
from collections.abc import Mapping, Sequence
from typing import TypeAlias

from programs.errors import ProgramError
from programs.pose import Pose
from programs.posts.reading.driver import read_pose
from programs.posts.reading.execution import Statement, differing, located, refusal, statements_of
from programs.posts.rebuilt import TextPlace
from programs.posts.writing.angles import fixed_xyz, from_fixed_xyz
from programs.posts.writing.forms import fixed
from programs.posts.writing.wording import join_lines, pose_words

NUMBER = r"-?\d*\.?\d+"
"""As the controller lists it: .04, but 0.00."""
Position: TypeAlias = tuple[str, str, "Pose | tuple[float, ...]"]
"""User frame, tool, and pose or joint values."""
_OPERAND = rf"\(?{NUMBER}\)?"
"""A number that stands in brackets if it is negative."""
FIELDS = {
    **dict.fromkeys(("scale", "offset", "least", "height", "group_value", "analog_value", "value", *"xyz"), _OPERAND),
    **{"point": r"P\[\d+\]", "routine": r"[A-Z]\w*", "unit": "mm/sec|cm/min|deg/sec", "ending": r"FINE|CNT\d+"},
    **{"lead": NUMBER, "seconds": NUMBER, "table": "UFRAME|UTOOL", "slot": r"\d+"},
}
"""Patterns of the texts in instructions."""
NOTES = (
    "R[91] and up count loops, R[90] holds a reading, PR[91] is used to enter the frames",
    "Speeds are whole mm/sec or cm/min; an output's TB counts from the end of its motion, in hundredths",
)
"""What the program uses, and how it counts."""
_INSTRUCTION = re.compile(r" *(\d+):(?:  )?(.*) ;")
_POSITION = re.compile(
    rf"P\[(\d+)\]\{{\n   GP1:\n\tUF : (\d+), UT : (\d+),(?:\t\tCONFIG : '[NF] [UD] [TB], -?\d, -?\d, -?\d',\n\t"
    rf"X = +({NUMBER})  mm,\tY = +({NUMBER})  mm,\tZ = +({NUMBER})  mm,\n"
    rf"\tW = +({NUMBER}) deg,\tP = +({NUMBER}) deg,\tR = +({NUMBER}) deg"
    rf"|\n\t(J1 = [^}}]*))\n\}};\n"
)


def hundredths(seconds: float) -> str:
    """Write a time as the controller lists it: .04, but 0.00."""
    text = fixed(seconds, 2)
    return text if text == "0.00" else text.removeprefix("0")


def write_program(name: str, body: Sequence[str], positions: Sequence[str]) -> str:
    """Write a program: its instructions are numbered, and its positions behind them."""
    lines = _attributes_of(name, len(body), bool(positions))
    for number, line in enumerate(body, start=1):
        lines.append(f"{number:4d}:{'' if line.startswith(('J P', 'L P')) else '  '}{line} ;")
    return join_lines([*lines, "/POS", *positions, "/END"])


def _attributes_of(name: str, instructions: int, moves: bool) -> list[str]:
    """Write what is before the instructions: it has no date, so that the same program gives the same bytes.

    Args:
        name: Of the program.
        instructions: How many there are.
        moves: Whether it has positions.
    """
    return [
        f"/PROG  {name}",
        "/ATTR",
        "OWNER\t\t= MNEDITOR;",
        'COMMENT\t\t= "Washboard";',
        "PROG_SIZE\t= 0;",
        "FILE_NAME\t= ;",
        "VERSION\t\t= 0;",
        f"LINE_COUNT\t= {instructions};",
        "MEMORY_SIZE\t= 0;",
        "PROTECT\t\t= READ_WRITE;",
        "TCD:  STACK_SIZE\t= 0,",
        "      TASK_PRIORITY\t= 50,",
        "      TIME_SLICE\t= 0,",
        "      BUSY_LAMP_OFF\t= 0,",
        "      ABORT_REQUEST\t= 0,",
        "      PAUSE_REQUEST\t= 0;",
        f"DEFAULT_GROUP\t= {'1' if moves else '*'},*,*,*,*;",
        "CONTROL_CODE\t= 00000000 00000000;",
        "/MN",
    ]


def position_text(number: int, frame: int, tool: int, what: str) -> str:
    """Write a position in its frames: a pose, or joint values."""
    return f"P[{number}]{{\n   GP1:\n\tUF : {frame}, UT : {tool}{what}\n}};"


def pose_text(pose: Pose, configuration: str) -> str:
    """Write what a position has for a pose."""
    x, y, z, w, p, r = pose_words(pose, fixed_xyz)
    where = f"X = {x:>9}  mm,\tY = {y:>9}  mm,\tZ = {z:>9}  mm"
    turned = f"W = {w:>10} deg,\tP = {p:>10} deg,\tR = {r:>10} deg"
    return f",\t\tCONFIG : '{configuration}',\n\t{where},\n\t{turned}"


def joints_text(values: Sequence[float], kinds: Sequence[str]) -> str:
    """Write what a position has for joint values, three in a row."""
    units = ["deg" if kind == "revolute" else " mm" for kind in kinds]
    words = [f"J{n} = {fixed(v, 4):>10} {unit}" for n, (v, unit) in enumerate(zip(values, units, strict=True), 1)]
    return "".join(f",\n\t{row}" for row in (",\t".join(words[at : at + 3]) for at in range(0, len(words), 3)))


def read_program(name: str, text: str) -> tuple[list[str], Mapping[str, Position]]:
    """Read the instructions of a program, without remarks, and its positions by their numbers.

    Raises:
        ProgramError: it is not as it is written.
    """
    file = f"{name}.ls"
    head, found, rest = text.partition("/MN\n")
    body, _, points = rest.partition("/POS\n")
    attributes = _attributes_of(name, body.count("\n"), "P[" in points)
    if not (found and f"{head}{found}" == join_lines(attributes) and points.endswith("/END\n")):
        wrong = differing([*statements_of(file, text)], [line.strip() for line in attributes])
        raise located(f"{name} is no TP program.", wrong)
    instructions: list[str] = []
    first = head.count("\n") + 2
    for number, line in enumerate(body.splitlines(), start=1):
        match, place = _INSTRUCTION.fullmatch(line), TextPlace(file, first + number - 1)
        if match is None or int(match[1]) != number:
            raise refusal(Statement(line, place), f"is not numbered {number} or does not end in ' ;'")
        instructions += [] if match[2].startswith("!") else [Statement(match[2], place)]
    positions: dict[str, Position] = {}
    for match in _POSITION.finditer(points):
        number, frame, tool, *numbers, joints = match.groups()
        line = text[: len(text) - len(points) + match.start()].count("\n") + 1
        values = tuple(float(word) for word in re.findall(rf"J\d+ = +({NUMBER}) ", joints or ""))
        if re.findall(r"J(\d+) =", joints or "") != [str(axis) for axis in range(1, 1 + len(values))]:
            raise ProgramError(f"the joints of P[{number}] are not in order.", file=file, line=line)
        if number in positions:
            raise ProgramError(f"P[{number}] is declared twice.", file=file, line=line)
        positions[number] = frame, tool, values or read_pose(numbers, from_fixed_xyz)
    if left := _POSITION.sub("", points).removesuffix("/END\n"):
        begin = text.find(left.partition("\n")[0], len(text) - len(points))
        line = text[: max(begin, 0)].count("\n") + 1
        raise ProgramError("a position is not written as expected.", file=file, line=line)
    return instructions, positions
