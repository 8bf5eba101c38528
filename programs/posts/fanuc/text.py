"""How TP programs are written, whatever they do."""

import math
from collections.abc import Sequence

from programs.motion.analog import Counting
from programs.motion.installation import Channel
from programs.posts.writing.wording import cut, fixed, short

ANALOG = Counting(full=2000.0, step=1.0)
"""AI and AO are whole numbers: users cite the manual of the AAD04A, 2000 for 10 V. Assumed of other modules."""
_LONGEST_REMARK = 32
_MOTIONS = ("J P", "L P")


def remark(text: str) -> str:
    """Write a comment; a semicolon would end it."""
    return f"!{cut(text, _LONGEST_REMARK).replace(';', ',')}"


def hundredths(seconds: float) -> str:
    """Write a time as the controller lists it: .04, but 0.00."""
    text = fixed(seconds, 2)
    return text if text == "0.00" else text.removeprefix("0")


def operand(value: float, digits: int = 6) -> str:
    """Write a number; a negative one stands in brackets."""
    text = short(value, digits)
    return f"({text})" if text.startswith("-") else text


def assign(channel: Channel, value: float) -> str:
    """Set an output."""
    match channel.kind:
        case "digital":
            return f"DO[{channel.number}]={'ON' if value else 'OFF'}"
        case "group":
            return f"GO[{channel.number}]={operand(value)}"
        case "analog":
            return f"AO[{channel.number}]={operand(ANALOG.count(channel, value))}"


def configure(degrees: Sequence[float]) -> str:
    """Wrist and turns from the joints; elbow up and toward are assumed, as no table of the arm is at hand."""
    turns = [math.floor((value + 180.0) / 360.0) for value in (degrees[0], *degrees[3:6:2])]
    flip = "F" if len(degrees) > 4 and degrees[4] > 0.0 else "N"
    return f"{flip} U T, {', '.join(str(turn) for turn in [*turns, 0, 0, 0][:3])}"


def program_text(name: str, body: Sequence[str], positions: Sequence[str]) -> str:
    """Write a program: the attributes have no date, so that the same program gives the same bytes."""
    lines = [
        f"/PROG  {name}",
        "/ATTR",
        "OWNER\t\t= MNEDITOR;",
        'COMMENT\t\t= "Washboard";',
        "PROG_SIZE\t= 0;",
        "FILE_NAME\t= ;",
        "VERSION\t\t= 0;",
        f"LINE_COUNT\t= {len(body)};",
        "MEMORY_SIZE\t= 0;",
        "PROTECT\t\t= READ_WRITE;",
        "TCD:  STACK_SIZE\t= 0,",
        "      TASK_PRIORITY\t= 50,",
        "      TIME_SLICE\t= 0,",
        "      BUSY_LAMP_OFF\t= 0,",
        "      ABORT_REQUEST\t= 0,",
        "      PAUSE_REQUEST\t= 0;",
        f"DEFAULT_GROUP\t= {'1' if positions else '*'},*,*,*,*;",
        "CONTROL_CODE\t= 00000000 00000000;",
        "/MN",
        *(
            f"{number:4d}:{'' if line.startswith(_MOTIONS) else '  '}{line} ;"
            for number, line in enumerate(body, start=1)
        ),
        "/POS",
        *positions,
        "/END",
    ]
    return "".join(f"{line}\n" for line in lines)
