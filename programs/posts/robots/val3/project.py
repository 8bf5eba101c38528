"""The files of a VAL3 project, and the task that switches its outputs."""

from collections.abc import Iterable, Sequence

from programs.pose import Pose
from programs.posts.writing.angles import moving_xyz
from programs.posts.writing.forms import fixed, short
from programs.posts.writing.wording import pose_words

QUEUE = 64
"""Outputs that may wait at once."""
PERIOD_S = 0.004
"""Of the task that switches outputs."""
OUTPUTS = {"digital": "do", "group": "go", "analog": "ao"}
"""What the variables of outputs begin with; their number follows."""
_XSI = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
_STAUBLI = "http://www.staubli.com/robotics/VAL3"

PATH_OUTPUTS = (
    "while true",
    "  while nTail!=nHead and getMoveId()>=nMove[nTail]",
    "    call setOutput(nOutput[nTail],nValue[nTail])",
    f"    nTail=(nTail+1)%{QUEUE}",
    "  endWhile",
    "  delay(0)",
    "endWhile",
)
"""The synchronous task: sets each output when the move that it belongs to is being executed."""

TRIGGER = (
    "nMove[nHead]=x_nMove",
    "nOutput[nHead]=x_nOutput",
    "nValue[nHead]=x_nValue",
    f"nHead=(nHead+1)%{QUEUE}",
)
"""Puts an output into the queue of the task."""


def listing(programs: Sequence[str], data: str) -> str:
    """Write the project file."""
    listed = "".join(f'    <Program file="{name}.pgx" />\n' for name in programs)
    return (
        '<?xml version="1.0" encoding="utf-8" ?>\n'
        f'<Project xmlns="{_STAUBLI}/Project/3">\n'
        '  <Parameters version="s7.3.1" stackSize="5000" millimeterUnit="true" />\n'
        f"  <Programs>\n{listed}  </Programs>\n"
        f'  <Database>\n    <Data file="{data}.dtx" />\n  </Database>\n'
        "  <Libraries />\n</Project>\n"
    )


def database(values: Iterable[str]) -> str:
    """Write the data file."""
    inside = "".join(values)
    return (
        '<?xml version="1.0" encoding="utf-8" ?>\n'
        f'<Database {_XSI} xmlns="{_STAUBLI}/Data/2">\n  <Datas>\n{inside}  </Datas>\n</Database>\n'
    )


def variable(name: str, kind: str, values: Sequence[str], size: int = 0) -> str:
    """Write a variable: an array of values, each as its attributes."""
    head = f'    <Data name="{name}" access="private" xsi:type="array" type="{kind}" size="{size or len(values)}"'
    if not values:
        return f"{head} />\n"
    rows = "".join(f'      <Value key="{key}" {value} />\n' for key, value in enumerate(values))
    return f"{head}>\n{rows}    </Data>\n"


def code(name: str, body: Iterable[str], parameters: Sequence[str] = ()) -> str:
    """Write a program file; all parameters are numbers."""
    listed = "".join(f'      <Parameter name="{each}" type="num" xsi:type="element" />\n' for each in parameters)
    declared = f'    <Parameters xmlns="{_STAUBLI}/Param/1">\n{listed}    </Parameters>\n' if parameters else ""
    inside = "".join(f"  {line}\n" for line in body).replace("]]>", "]] >")
    return (
        '<?xml version="1.0" encoding="utf-8" ?>\n'
        f'<Programs {_XSI} xmlns="{_STAUBLI}/Program/2">\n'
        f'  <Program name="{name}" access="private">\n{declared}'
        f"    <Code><![CDATA[begin\n{inside}end]]></Code>\n  </Program>\n</Programs>\n"
    )


def place(pose: Pose, father: str) -> str:
    """Write a pose as attributes: mm, and degrees about x, the new y, the new z."""
    words = zip(("x", "y", "z", "rx", "ry", "rz"), pose_words(pose, moving_xyz), strict=True)
    numbers = " ".join(f'{name}="{word}"' for name, word in words)
    return f'{numbers} fatherId="{father}[0]"'


def movement(speed_mm_s: float, turn_deg_s: float, blend_mm: float, percent: int = 100) -> str:
    """Write a movement descriptor as attributes."""
    zone = fixed(blend_mm, 2)
    blend = "cartesian" if blend_mm > 0.0 else "off"
    return (
        f'accel="100" vel="{percent}" decel="100" tmax="{short(speed_mm_s, 1)}" rmax="{short(turn_deg_s, 1)}" '
        f'blend="{blend}" leave="{zone}" reach="{zone}"'
    )
