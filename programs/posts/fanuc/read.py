"""Reads TP programs back, as a controller would execute them."""

import math
import re

from programs.errors import ProgramError
from programs.motion.steps import Line
from programs.pose import Pose
from programs.posts.dialect import ProgramFiles
from programs.posts.fanuc.write import LONGEST_WAIT_S, POSITION, READING, SLOW_CORNER_S, attributes_of
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import Action, skip
from programs.posts.reading.statements import Statement, look_up, refusal
from programs.posts.rebuilt import Due, ReadSignal, TextPlace
from programs.posts.writing.angles import from_fixed_xyz
from programs.posts.writing.lines import is_straight
from programs.posts.writing.wording import join_lines

_N = r"(-?\d*\.?\d+)"
_M = r"\(?(-?\d*\.?\d+)\)?"
"""A number that stands in brackets if it is negative."""
_ASSIGNMENT = rf"(DO|GO|AO)\[(\d+)\]=(ON|OFF|{_M})"
_ENTERED = rf"(UFRAME|UTOOL)\[(\d+)\]=PR\[{POSITION}\]"
_SCALED = rf"R\[{READING}\]=AI\[(\d+)\]\*{_M}"
_SHIFTED = rf"R\[{READING}\]=R\[{READING}\]\+{_M}"
_AGAIN = rf"IF R\[(\d+)\]<(\d+)(?: AND R\[{READING}\]<{_M})?,JMP LBL\[(\d+)\]"
_INSTRUCTION = re.compile(r" *(\d+):(?:  )?(.*) ;")
_POSITION = re.compile(
    rf"P\[(\d+)\]\{{\n   GP1:\n\tUF : (\d+), UT : (\d+),(?:\t\tCONFIG : '[NF] U T, -?\d, -?\d, -?\d',\n\t"
    rf"X = +{_N}  mm,\tY = +{_N}  mm,\tZ = +{_N}  mm,\n\tW = +{_N} deg,\tP = +{_N} deg,\tR = +{_N} deg"
    rf"|\n\t(J1 = [^}}]*))\n\}};\n"
)
_KINDS = {"DO": "digital", "GO": "group", "AO": "analog"}


class TpReader(Reader):
    """All programs with their positions, and the controller's tables."""

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

    def grammar(self) -> dict[str, Action]:
        """List the instructions."""
        return {
            rf"L P\[(\d+)\] (\d+)(mm/sec|deg/sec) (FINE|CNT\d+)(?: TB {_N}sec,{_ASSIGNMENT})?": self.move,
            rf"CALL {self.shut_name}": self.shut("main"),
            r"IF R\[89\]<=(\d+),CALL (\w+)": lambda match: self.call_part(match[1], match[2]),
            r"IF R\[89\]<>(\d+),JMP LBL\[99\]": lambda match: self.enter(match[1], r"LBL\[99\]"),
            r"R\[88\]=\$MCR\.\$GENOVERRIDE": self.refuse_override,
            r"\$WAITTMOUT=(\d+)": self.wait_contact,
            r"R\[88\]=0": self.wait_sensor,
            r"LBL\[99\]|R\[89\]=1": skip,
            r"!.*": skip,
            r"J P\[(\d+)\] (\d+)% FINE": self.move_by_joints,
            r"UFRAME_NUM=0": self.rise_from,
            r"(UFRAME|UTOOL)_NUM=(\d+)": self.use_frame,
            _ASSIGNMENT: lambda match: self.switch(*_assigned(*match.groups())),
            rf"WAIT {_N}\(sec\)": lambda match: self.hold(float(match[1]), LONGEST_WAIT_S),
            r"LBL\[(\d+)\]": self.begin_loop,
            _AGAIN: self.end_repeat,
            r"CALL ([A-Z]\w*)": self.call,
            rf"PR\[{POSITION},([1-6])\]={_M}": self.enter_value,
            _ENTERED: self.enter_frame,
            r"R\[(\d+)\]=0": self.set_counter,
            r"R\[(\d+)\]=R\[\1\]\+1": self.raise_counter,
            rf"PR\[{POSITION}\]=LPOS|{_SCALED}|{_SHIFTED}": skip,
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

    def refuse_override(self, match: re.Match[str]) -> None:
        """Refuse to start where the speed override is not 100 %."""
        self.pass_on(r"IF R\[88\]=100,JMP LBL\[88\]", r"MESSAGE\[.*\]", "ABORT", r"LBL\[88\]")
        self.guards_override = True

    def wait_contact(self, match: re.Match[str]) -> None:
        """Wait for an input, and abort where that takes too long."""
        waits, goes, late, _, _, ready = self.pass_on(
            r"WAIT DI\[(\d+)\]=(ON|OFF) TIMEOUT,LBL\[(\d+)\]", r"JMP LBL\[(\d+)\]", r"LBL\[(\d+)\]", r"MESSAGE\[.*\]",
            "ABORT", r"LBL\[(\d+)\]",
        )  # fmt: skip
        if waits[3] != late[1] or goes[1] != ready[1]:
            raise ProgramError(f"{waits[0]} does not lead to its message.")
        self.wait_for(waits[1], waits[2] == "ON", float(match[1]) / 100.0)

    def wait_sensor(self, match: re.Match[str]) -> None:
        """Wait for a quantity, and abort where that takes too long."""
        again, scaled, shifted, enough, *_, repeats, _, _, ready = self.pass_on(
            r"LBL\[(\d+)\]", rf"R\[{READING}\]=AI\[(\d+)\]\*{_M}", _SHIFTED,
            rf"IF R\[{READING}\]>={_M},JMP LBL\[(\d+)\]", r"WAIT \.10\(sec\)", r"R\[88\]=R\[88\]\+1",
            r"IF R\[88\]<(\d+),JMP LBL\[(\d+)\]", r"MESSAGE\[.*\]", "ABORT", r"LBL\[(\d+)\]",
        )  # fmt: skip
        if repeats[2] != again[1] or enough[2] != ready[1]:
            raise ProgramError(f"{enough[0]} does not lead past its message.")
        self.wait_least(scaled[1], (scaled[2], shifted[1], enough[1]), float(repeats[1]) / 10.0)

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

    def use_frame(self, match: re.Match[str]) -> None:
        """Use another tool or user frame from now on."""
        table, number = match.groups()
        pose = look_up(self.tables, (table, number), f"{table}[{number}]")
        self.frames[table] = number
        if table == "UTOOL":
            self.use_tool(number, pose)
        else:
            self.use_board(pose)

    def rise_from(self, match: re.Match[str]) -> None:
        """Raise the orifice from wherever it is."""
        (tool,) = self.pass_on(r"UTOOL_NUM=(\d+)")
        look_up(self.tables, ("UTOOL", tool[1]), f"UTOOL[{tool[1]}]")
        self.pass_on(rf"PR\[{POSITION}\]=LPOS", rf"R\[88\]=PR\[{POSITION},3\]")
        self.rise(rf"IF R\[88\]>={_M},JMP LBL\[98\]", rf"PR\[{POSITION},3\]={_M}")
        self.pass_on(rf"L PR\[{POSITION}\] 100mm/sec FINE", r"LBL\[98\]")

    def position(self, number: str) -> Pose | tuple[float, ...]:
        """Look up a position, taught in the frames in use."""
        frame, tool, pose = self.positions.use((self.routine, number))
        if (frame, tool) != (self.frames.get("UFRAME"), self.frames.get("UTOOL")):
            raise ProgramError(f"P[{number}] is of frame {frame} and tool {tool}, which are not in use.")
        return pose

    def move(self, match: re.Match[str]) -> None:
        """Move in a line."""
        number, speed, unit, ending, lead, *assigned = match.groups()
        pose = self.position(number)
        if not isinstance(pose, Pose):
            raise ProgramError(f"P[{number}] is not cartesian.")
        signals = (ReadSignal(*_assigned(*assigned), 1.0, -float(lead)),) if lead is not None else ()
        turns = unit == "deg/sec"
        zone = 0.0 if ending == "FINE" else 0.01 * float(ending.removeprefix("CNT"))
        self.state(zone=zone, turn_deg_s=float(speed) if turns else None)
        self.line(pose, ending == "FINE", 0.0 if turns else float(speed), signals)

    def move_by_joints(self, match: re.Match[str]) -> None:
        """Come to a position by joints."""
        self.set_share(match[2])
        self.move_to(self.position(match[1]))

    def begin_loop(self, match: re.Match[str]) -> None:
        """Find how a loop ends: the jump back to its label, and the reading before it."""
        channel = scale = offset = None
        for found in self.ahead(rf"{_SCALED}|{_SHIFTED}|{_AGAIN}"):
            channel, scale, offset = found[1] or channel, found[2] or scale, found[3] or offset
            if found[7] == match[1]:
                if found[6] and (scale is None or offset is None):
                    raise ProgramError(f"the loop at {match[0]} does not read its input.")
                self.repeat(found[5], (scale, channel, offset, found[6]) if found[6] else (), found[4])
                return
        raise ProgramError(f"nothing jumps to {match[0]}.")


def _assigned(kind: str, number: str, word: str, value: str | None) -> tuple[str, float]:
    """Channel and value of an assignment."""
    return f"{_KINDS[kind]} {number}", float(value) if value is not None else float(word == "ON")
