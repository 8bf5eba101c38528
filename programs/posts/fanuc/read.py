"""Reads TP programs back, as a controller would execute them."""

import math
import re
from collections.abc import Mapping

from programs.errors import ProgramError
from programs.motion.steps import Line
from programs.pose import Pose
from programs.posts.dialect import ProgramFiles
from programs.posts.fanuc.write import LONGEST_WAIT_S, POSITION, SLOW_CORNER_S, Tp, attributes_of
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import Action, skip
from programs.posts.reading.forms import Values
from programs.posts.reading.statements import Statement, look_up, refusal
from programs.posts.rebuilt import Due, ReadSignal, TextPlace
from programs.posts.writing.angles import from_fixed_xyz
from programs.posts.writing.lines import is_straight
from programs.posts.writing.wording import join_lines

_N = r"(-?\d*\.?\d+)"
_OPERAND = r"\(?-?\d*\.?\d+\)?"
_M = r"\(?(-?\d*\.?\d+)\)?"
"""A number that stands in brackets if it is negative."""
_ENTERED = rf"(UFRAME|UTOOL)\[(\d+)\]=PR\[{POSITION}\]"
_INSTRUCTION = re.compile(r" *(\d+):(?:  )?(.*) ;")
_POSITION = re.compile(
    rf"P\[(\d+)\]\{{\n   GP1:\n\tUF : (\d+), UT : (\d+),(?:\t\tCONFIG : '[NF] U T, -?\d, -?\d, -?\d',\n\t"
    rf"X = +{_N}  mm,\tY = +{_N}  mm,\tZ = +{_N}  mm,\n\tW = +{_N} deg,\tP = +{_N} deg,\tR = +{_N} deg"
    rf"|\n\t(J1 = [^}}]*))\n\}};\n"
)


class TpReader(Reader):
    """All programs with their positions, and the controller's tables."""

    syntax = Tp
    handlers = frozenset({"main", "BG logic"})

    def __init__(self) -> None:
        super().__init__()
        self.positions = self.declares("position")
        """User frame, tool, and pose or joint values, by program and number."""
        self.tables: dict[tuple[str, str], Pose] = {}
        self.register = [""] * 6
        self.frames: dict[str, str] = {}
        self.background = ""
        """Name of the program that is the BG logic."""

    @classmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give the share of CNT: all of it straight on, else what keeps within the zone; and whole degrees a second."""
        share = 1.0
        if not is_straight(line, after):
            share = line.blend_mm / max(SLOW_CORNER_S * line.speed_mm_s, 0.1)
        turns = line.turns_on_the_spot
        rate = max(math.floor(math.degrees(line.turn_rad_s) + 0.3), 1) if turns else None
        return Due(0.01 * min(max(math.floor(100.0 * share), 1), 100), rate)

    def load(self, files: ProgramFiles) -> str:
        """Read the programs; the first is the main one, which begins when that of the frames has been run."""
        programs = {file.removesuffix(".ls"): text for file, text in files.items() if file.endswith(".ls")}
        for name, text in programs.items():
            self.load_program(name, f"{name}.ls", text)
        enters = [name for name, text in programs.items() if re.search(_ENTERED, text)]
        main = next(iter(programs), "")
        others = [name for name in programs if name != main]  # it may be called like one of these itself
        self.shut_name = next((name for name in others if name.endswith("_SH")), self.shut_name)
        self.background = next((name for name in others if name.endswith("_BG")), "")
        self.routines["(all)"] = [*(f"CALL {name}" for name in enters), f"CALL {main}"]
        return "(all)"

    def load_program(self, name: str, file: str, text: str) -> None:
        """Read the instructions and positions of a program."""
        head, found, rest = text.partition("/MN\n")
        body, _, points = rest.partition("/POS\n")
        attributes = attributes_of(name, body.count("\n"), "P[" in points)
        if not (found and f"{head}{found}" == join_lines(attributes) and points.endswith("/END\n")):
            raise ProgramError(f"{name} is no TP program.", file=file)
        instructions: list[str] = []
        first = head.count("\n") + 2
        for number, line in enumerate(body.splitlines(), start=1):
            match, place = _INSTRUCTION.fullmatch(line), TextPlace(file, first + number - 1)
            if match is None or int(match[1]) != number:
                raise refusal(Statement(line, place), f"is not numbered {number} or does not end in ' ;'")
            instructions.append(Statement(match[2], place))
        self.routines[name] = instructions
        for match in _POSITION.finditer(points):
            number, frame, tool, *numbers, joints = match.groups()
            values = tuple(float(word) for word in re.findall(rf"J\d+ = +{_N} ", joints or ""))
            pose = values or read_pose(numbers, from_fixed_xyz)
            if re.findall(r"J(\d+) =", joints or "") != [str(axis) for axis in range(1, 1 + len(values))]:
                raise ProgramError(f"the joints of P[{number}] are not in order.", file=file)
            self.positions.add((name, number), (frame, tool, pose), Statement("", TextPlace(file, 1)))
        if len(_POSITION.sub("", points)) != len("/END\n"):
            raise ProgramError("a position is not written as expected.", file=file)

    def fields(self) -> Mapping[str, str]:
        """Give the pattern of each field of the writer's forms."""
        numbers = dict.fromkeys(
            ("scale", "offset", "least", "height", "group_value", "analog_value"), _M.replace("(-", "(?:-")
        )
        return {**super().fields(), **numbers, "point": r"P\[\d+\]", "routine": r"[A-Z]\w*"}

    def grammar(self) -> dict[str, Action]:
        """List the other instructions."""
        return {
            rf"L P\[(\d+)\] (\d+)(mm/sec|deg/sec) (FINE|CNT\d+)(?: TB {_N}sec,(.*))?": self.move,
            r"LBL\[99\]|!.*": skip,
            rf"WAIT {_N}\(sec\)": lambda match: self.hold(float(match[1]), LONGEST_WAIT_S),
            rf"PR\[{POSITION},([1-6])\]={_M}": self.enter_value,
            _ENTERED: self.enter_frame,
            rf"PR\[{POSITION}\]=LPOS": skip,
        }

    def read_shut(self) -> tuple[str, ...]:
        """Give the outputs that the fault routine shuts; the BG logic has to shut the same, under each condition.

        Raises:
            ProgramError: it does not, or does something else.
        """
        self.called.add(self.background)
        stopped: dict[str, set[str]] = {"!UO[3]": set()}
        for statement in self.routines.get(self.background, []):
            found = re.fullmatch(r"IF \((!UO\[3\]|DI\[(\d+)\]=(ON|OFF))\),DO\[(\d+)\]=\(OFF\)", statement)
            if found is None:
                raise refusal(statement, "does not belong to the BG logic")
            stopped.setdefault(found[1], set()).add(f"digital {found[4]}")
            if found[2] and (found[2], found[3] == "OFF") not in self.watched:
                self.watched.append((found[2], found[3] == "OFF"))
        self.shut_by.add("BG logic")
        shut = super().read_shut()
        self.watches_inputs = bool(shut)  # without a valve there is nothing to do when one leaves its state
        if wrong := next((condition for condition, each in stopped.items() if each != set(shut)), None):
            raise ProgramError(f"under {wrong} the BG logic shuts {sorted(stopped[wrong])}, not {sorted(shut)}.")
        return shut

    def enter_value(self, match: re.Match[str]) -> None:
        """Enter a number into the position register, once for each frame."""
        if self.register[int(match[1]) - 1]:
            raise ProgramError(f"{match[0]!r} is entered twice.")
        self.register[int(match[1]) - 1] = match[2]

    def enter_frame(self, match: re.Match[str]) -> None:
        """Enter the position register into a table."""
        if (match[1], match[2]) in self.tables or "" in self.register:
            raise ProgramError(f"{match[0]!r} is entered twice, or without all numbers.")
        self.tables[match[1], match[2]] = read_pose(self.register, from_fixed_xyz)
        self.register = [""] * 6

    def select_tool(self, values: Values) -> None:
        """Use another tool from now on."""
        self.use_tool(values["slot"], self.select("UTOOL", values["slot"]))

    def select_board(self, values: Values) -> None:
        """Use another user frame from now on."""
        self.use_board(self.select("UFRAME", values["slot"]))

    def select(self, table: str, number: str) -> Pose:
        """Look up an entry of a table, and keep its number."""
        self.frames[table] = number
        return look_up(self.tables, (table, number), f"{table}[{number}]")

    def use_first_tool(self, name: str) -> None:
        """Use the tool whose orifice is raised."""
        look_up(self.tables, ("UTOOL", name), f"UTOOL[{name}]")

    def place_of(self, point: str) -> Pose | tuple[float, ...]:
        """Look up a position, taught in the frames in use."""
        number = point[2:-1]
        frame, tool, pose = self.positions.use((self.routine, number))
        if (frame, tool) != (self.frames.get("UFRAME"), self.frames.get("UTOOL")):
            raise ProgramError(f"P[{number}] is of frame {frame} and tool {tool}, which are not in use.")
        return pose

    def pose_of(self, point: str) -> Pose:
        """Look up a position that is a pose."""
        pose = self.place_of(point)
        if not isinstance(pose, Pose):
            raise ProgramError(f"{point} is not cartesian.")
        return pose

    def move(self, match: re.Match[str]) -> None:
        """Move in a line."""
        number, speed, unit, ending, lead, output = match.groups()
        pose = self.pose_of(f"P[{number}]")
        signals = (ReadSignal(*self.output_of(output), 1.0, -float(lead)),) if lead is not None else ()
        turns = unit == "deg/sec"
        zone = 0.0 if ending == "FINE" else 0.01 * float(ending.removeprefix("CNT"))
        self.state(zone=zone, turn_deg_s=float(speed) if turns else None)
        self.line(pose, ending == "FINE", 0.0 if turns else float(speed), signals)
