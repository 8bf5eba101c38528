"""Reads KRL back, as a controller would execute it."""

import re
from collections.abc import Iterator, Mapping

from programs.errors import ProgramError
from programs.motion.steps import Line
from programs.pose import Pose
from programs.posts.dialect import ProgramFiles
from programs.posts.kuka.write import HEAD, TURN_DEG_S2, Krl
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import Action, skip
from programs.posts.reading.forms import Block, Values
from programs.posts.reading.statements import NUMBER, N, U, refusal, statements_of
from programs.posts.rebuilt import Due, ReadSignal
from programs.posts.writing.angles import from_moving_zyx
from programs.posts.writing.lines import turn_limit

_ORI_DEG_S = 200.0
"""Of lines that hardly turn."""
_FRAME = re.compile(rf"\{{X {N},Y {N},Z {N},A {N},B {N},C {N}\}}")
_AXES = rf"\{{A1 {N}(?:,[AE]\d {N})*\}}"
_LOAD = re.compile(rf"\{{M {N},CM {_FRAME.pattern},J \{{X {N},Y {N},Z {N}\}}\}}")
_SHAPES = {"FRAME": _FRAME, "E6AXIS": re.compile(_AXES), "LOAD": _LOAD, "INT": re.compile("[01]")}
_DECLARATION = re.compile(r"DECL (?:GLOBAL )?(FRAME|E6AXIS|LOAD|INT) (\w+)=(.*)")
_PREPARATION = r"BAS\(#INITMOV,0\)|BAS\(#ACC_PTP,100\)|\$ORI_TYPE=#VAR|PTP \$AXIS_ACT|\w+_start=1|ENDIF"


class KrlReader(Reader):
    """Declarations and routines of all modules."""

    syntax = Krl
    handlers = frozenset({"main", "interrupt"})

    def __init__(self) -> None:
        super().__init__()
        self.modules: dict[str, str] = {}
        """Module by the routine's name."""
        self.values = self.declares("data")
        """Declared values by module and name; global ones have no module."""
        self.speed_mm_s = 0.0
        self.second_turn: float | None = None
        self.triggers: list[tuple[float, float, str, float]] = []
        """Place in mm from the end, seconds, channel and value: for the next motion."""

    @classmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give the zone, and a rate of turn a little above the planned one."""
        rate = turn_limit(line)
        return Due(line.blend_mm, _ORI_DEG_S if rate is None else rate)

    def load(self, files: ProgramFiles) -> str:
        """Read sources and data lists; the first file's first routine is the main one."""
        for file, text in files.items():
            module, _, kind = file.rpartition(".")
            if f"{module}.{'dat' if kind == 'src' else 'src'}" not in files:
                raise ProgramError("a .src and a .dat belong together.", file=file)
            known = len(self.routines)
            for line in self.sort(statements_of(file, text, ";"), r"DEF (\w+)\( \)", "END"):
                if match := _DECLARATION.fullmatch(line):
                    if not _SHAPES[match[1]].fullmatch(match[3]):
                        raise refusal(line, f"has no {match[1]}")
                    key = ("" if "GLOBAL" in line else module, match[2])
                    self.values.add(key, match[3], line)
                    if match[2] == "nWait":
                        self.values.used.add(key)  # by waits alone, which a program need not have
                elif line not in HEAD and line not in (f"DEFDAT {module} PUBLIC", "ENDDAT"):
                    raise refusal(line, "is unknown there")
            self.modules |= dict.fromkeys(list(self.routines)[known:], module)
        return next(iter(self.routines), "")

    def fields(self) -> Mapping[str, str]:
        """Give the pattern of each field of the writer's forms."""
        words = {"start": r"\w+_start", "name": r"(?!nWait)[A-Za-z]\w*"}
        return {**super().fields(), **words, "group_value": rf"TRUE|FALSE|{NUMBER}"}

    def blocks(self) -> Iterator[Block]:
        """List the statements of forms."""
        yield from super().blocks()
        yield ("INTERRUPT DECL {interrupt} WHEN $STOPMESS==TRUE DO on_fault( )", Krl.watch[1]), self.read_stop

    def grammar(self) -> dict[str, Action]:
        """List the other statements."""
        return {
            r"LIN (\w+)( C_DIS)?": self.move,
            rf"\$VEL\.CP={U}": self.set_speed,
            rf"\$VEL\.ORI1={U}": lambda match: self.state(turn_deg_s=float(match[1])),
            rf"\$APO\.CDIS={U}": lambda match: self.state(zone=float(match[1])),
            rf"\$VEL\.ORI2={U}": self.set_second_turn,
            rf"\$ACC\.ORI1=({TURN_DEG_S2})": lambda match: self.state(turn_acceleration_deg_s2=float(match[1])),
            rf"\$ACC\.ORI2={TURN_DEG_S2}": skip,
            rf"TRIGGER WHEN (?:PATH={N}|DISTANCE=1) DELAY=(-?\d+) DO (.*)": self.define_trigger,
            _PREPARATION: skip,
            r"BAS\(#VEL_PTP,(\d+)\)": lambda match: self.set_share(match[1]),
            r"PTP (HOME_POSITION)": self.go_home,
            r"\$LOAD=(\w+)": self.use_load,
            r"PTP (\w+)": lambda match: self.reach(self.frame(match[1])),
            rf"PTP {_AXES}": lambda match: self.come_to(_axes(match[0])),
            r"\$TOOL=(\w+)": lambda match: self.use_tool(match[1], self.frame(match[1])),
            r"\$BASE=\$ROBROOT:(\w+)": lambda match: self.use_board(self.frame(match[1])),
        }

    def use_variable(self, name: str) -> None:
        """Use a declared value."""
        self.value(name)

    def use_wait(self) -> None:
        """Use the counter of waits."""
        self.value("nWait")

    def use_first_tool(self, name: str) -> None:
        """Use the tool whose orifice is raised."""
        self.frame("xStart")
        self.use_tool(name, self.frame(name))

    def read_fault(self) -> None:
        """Read what interrupts lead to."""
        after = ("BRAKE F", r"shut_valves\( \)", r'MsgNotify\("[^"]*"\)', "LOOP", "HALT", "ENDLOOP")
        self.expect("on_fault", *after)

    def read_stop(self, values: Values) -> None:
        """Have the fault routine run at a stop."""
        self.read_fault()
        self.shut_by.add("interrupt")

    def read_watch(self, values: Values) -> None:
        """Have the fault routine run when an input leaves its state."""
        self.read_fault()
        super().read_watch(values)

    def switched(self, values: Values) -> tuple[str, float]:
        """Give the channel and the value of an output; that of a group may be one of a single signal."""
        truth = {"TRUE": "1", "FALSE": "0"}.get(values.get("group_value", ""))
        return super().switched(values if truth is None else {**values, "group_value": truth})

    def frame(self, name: str) -> Pose:
        """Give a declared frame: of the module that runs, or a global one."""
        if match := _FRAME.fullmatch(self.value(name)):
            return read_pose(match.groups(), from_moving_zyx)
        raise ProgramError(f"{name} is not declared as FRAME.")

    def value(self, name: str) -> str:
        """Give a declared value: of the module that runs, or a global one."""
        key = (self.modules[self.routine], name)
        return self.values.use(key if key in self.values.values else ("", name))

    def use_load(self, match: re.Match[str]) -> None:
        """Use a declared load."""
        self.value(match[1])

    def go_home(self, match: re.Match[str]) -> None:
        """Go to the declared joint values of home."""
        self.come_home(_axes(self.value(match[1])))

    def set_speed(self, match: re.Match[str]) -> None:
        """Set the speed of the TCP, m/s."""
        self.speed_mm_s = 1000.0 * float(match[1])

    def set_second_turn(self, match: re.Match[str]) -> None:
        """Set the rate of the turn about the tool's own axis."""
        self.second_turn = float(match[1])

    def define_trigger(self, match: re.Match[str]) -> None:
        """Set an output with the next motion."""
        self.triggers.append((float(match[1] or 0.0), float(match[2]) / 1000.0, *self.output_of(match[3])))

    def move(self, match: re.Match[str]) -> None:
        """Move in a line; the triggers before it are this motion's."""
        pose = self.frame(match[1])
        length_mm = self.length_to(pose)
        if not self.counted and self.second_turn != self.terms.turn_deg_s:
            raise ProgramError("$VEL.ORI2 is not as $VEL.ORI1.")
        signals = tuple(
            ReadSignal(channel, value, 1.0 + place / (length_mm or 1.0), seconds)
            for place, seconds, channel, value in self.triggers
        )
        self.triggers = []
        self.line(pose, match[2] is None, self.speed_mm_s if length_mm else 0.0, signals)


def _axes(text: str) -> list[float]:
    """Give the joint values of an E6AXIS."""
    return [float(word) for word in re.findall(rf"[AE]\d {N}", text)]
