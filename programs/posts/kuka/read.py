"""Reads KRL back, as a controller would execute it."""

import re

from programs.errors import ProgramError
from programs.motion.steps import Line
from programs.pose import Pose
from programs.posts.dialect import ProgramFiles
from programs.posts.kuka.write import HEAD, TURN_DEG_S2
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import Action, skip
from programs.posts.reading.statements import N, U, refusal, statements_of
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
_ASSIGNMENT = r"(?:\$(OUT|ANOUT)\[(\d+)\]|([A-Za-z]\w*))=(TRUE|FALSE|-?\d+(?:\.\d+)?)"
_COUNTED = r"UNTIL (nLoop\d+)>=(\d+)"
_LOOKED = rf"UNTIL \((nLoop\d+)>=(\d+)\) OR \(\(?{N}\)?\*\$ANIN\[(\d+)\]\+\(?{N}\)?>=\(?{N}\)?\)"
_LEAST = rf"\(?{N}\)?\*\$ANIN\[(\d+)\]\+\(?{N}\)?<\(?{N}\)?"
_LATE = (r"WAIT SEC 0\.1", r"nWait=nWait\+1", "ENDWHILE")
_REFUSED = (r'MsgNotify\("[^"]*"\)', "RETURN", "ENDIF")
_INTERRUPT = r"INTERRUPT DECL (\d+) WHEN (?:\$STOPMESS==TRUE|\$IN\[(\d+)\]==(TRUE|FALSE)) DO on_fault\( \)"
_PREPARATION = (
    r"BAS\(#INITMOV,0\)|BAS\(#ACC_PTP,100\)|\$ORI_TYPE=#VAR|PTP \$AXIS_ACT"
    r"|\w+_start=1|ENDIF"
)


class KrlReader(Reader):
    """Declarations and routines of all modules."""

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

    def rise_from(self, match: re.Match[str]) -> None:
        """Raise the orifice from wherever it is."""
        self.frame("xStart")
        self.pass_on(r"xStart=\$POS_ACT")
        self.rise(rf"IF xStart\.Z<{N} THEN", rf"xStart\.Z={N}")
        self.pass_on(r"\$VEL\.CP=0\.1", "LIN xStart", "ENDIF")

    def grammar(self) -> dict[str, Action]:
        """List the statements."""
        return {
            r"LIN (\w+)( C_DIS)?": self.move,
            r"shut_valves\( \)": self.shut("main"),
            r"IF (\w+_start)<=(\d+) THEN": self.do_part,
            r"IF (\w+_start)==(\d+) THEN": self.enter_part,
            r"IF \$OV_PRO<>100 THEN": self.refuse_override,
            r"nWait=0": self.read_wait,
            r"\$BASE=\$NULLFRAME": self.rise_from,
            _INTERRUPT: self.interrupt,
            rf"\$VEL\.CP={U}": self.set_speed,
            rf"\$VEL\.ORI1={U}": lambda match: self.state(turn_deg_s=float(match[1])),
            rf"\$APO\.CDIS={U}": lambda match: self.state(zone=float(match[1])),
            rf"\$VEL\.ORI2={U}": self.set_second_turn,
            rf"\$ACC\.ORI1=({TURN_DEG_S2})": lambda match: self.state(turn_acceleration_deg_s2=float(match[1])),
            rf"\$ACC\.ORI2={TURN_DEG_S2}": skip,
            rf"TRIGGER WHEN (?:PATH={N}|DISTANCE=1) DELAY=(-?\d+) DO {_ASSIGNMENT}": self.define_trigger,
            _PREPARATION: skip,
            r"BAS\(#VEL_PTP,(\d+)\)": lambda match: self.set_share(match[1]),
            r"PTP (HOME_POSITION)": self.go_home,
            r"\$LOAD=(\w+)": self.use_load,
            r"(nLoop\d+)=0": self.set_counter,
            r"(nLoop\d+)=\1\+1": self.raise_counter,
            r"PTP (\w+)": lambda match: self.reach(self.frame(match[1])),
            rf"PTP {_AXES}": lambda match: self.come_to(_axes(match[0])),
            rf"WAIT SEC {U}": self.pause,
            r"REPEAT": self.begin_loop,
            rf"{_COUNTED}|{_LOOKED}": self.end_repeat,
            r"\$TOOL=(\w+)": lambda match: self.use_tool(match[1], self.frame(match[1])),
            r"\$BASE=\$ROBROOT:(\w+)": lambda match: self.use_board(self.frame(match[1])),
            _ASSIGNMENT: lambda match: self.switch(*_assigned(match.groups())),
            r"([A-Za-z]\w*)\( \)": self.call,
        }

    def do_part(self, match: re.Match[str]) -> None:
        """Do a part of main, unless the start is at a later one."""
        self.value(match[1])
        self.run_part(match[2], r"(\w+)\( \)", "ENDIF")

    def enter_part(self, match: re.Match[str]) -> None:
        """Begin a part at which the program starts."""
        self.value(match[1])
        self.enter(match[2], "ENDIF")

    def refuse_override(self, match: re.Match[str]) -> None:
        """Refuse to start where the speed override is not 100 %."""
        self.pass_on(*_REFUSED)
        self.guards_override = True

    def read_wait(self, match: re.Match[str]) -> None:
        """Wait for an input or a quantity, and end where that takes too long."""
        self.value("nWait")
        contact, least = r"\$IN\[(\d+)\]<>(TRUE|FALSE)", _LEAST
        (begins,) = self.pass_on(rf"WHILE \((?:{contact}|{least})\) AND \(nWait<(\d+)\)")
        *_, looks, _, _, _ = self.pass_on(*_LATE, rf"IF (?:{contact}|{least}) THEN", *_REFUSED)
        number, state, scale, sensor, offset, value, tenths = begins.groups()
        if looks.groups() != begins.groups()[:-1]:
            raise ProgramError("what is waited for is not what is looked at then.")
        if number:
            self.wait_for(number, state == "TRUE", float(tenths) / 10.0)
        else:
            self.wait_least(sensor, (scale, offset, value), float(tenths) / 10.0)

    def interrupt(self, match: re.Match[str]) -> None:
        """Have the fault routine run at a stop, or when an input leaves its state."""
        self.pass_on(rf"INTERRUPT ON {match[1]}")
        after = ("BRAKE F", r"shut_valves\( \)", r'MsgNotify\("[^"]*"\)', "LOOP", "HALT", "ENDLOOP")
        self.expect("on_fault", *after)
        if match[2]:
            self.watched.append((match[2], match[3] == "FALSE"))
        else:
            self.shut_by.add("interrupt")

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

    def set_counter(self, match: re.Match[str]) -> None:
        """Set a loop's counter, which is declared, to 0."""
        self.value(match[1])
        super().set_counter(match)

    def set_speed(self, match: re.Match[str]) -> None:
        """Set the speed of the TCP, m/s."""
        self.speed_mm_s = 1000.0 * float(match[1])

    def set_second_turn(self, match: re.Match[str]) -> None:
        """Set the rate of the turn about the tool's own axis."""
        self.second_turn = float(match[1])

    def define_trigger(self, match: re.Match[str]) -> None:
        """Set an output with the next motion."""
        place, delay, *assigned = match.groups()
        self.triggers.append((float(place or 0.0), float(delay) / 1000.0, *_assigned(assigned)))

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

    def begin_loop(self, match: re.Match[str]) -> None:
        """Find how a loop ends, past those in it."""
        depth = 0
        for found in self.ahead(rf"REPEAT|{_COUNTED}|{_LOOKED}"):
            depth += 1 if found[0] == "REPEAT" else -1
            if depth == 0:
                self.repeat(found[2] or found[4], found.groups()[4:], found[1] or found[3])
                return
        raise ProgramError("a REPEAT has no UNTIL.")


def _axes(text: str) -> list[float]:
    """Give the joint values of an E6AXIS."""
    return [float(word) for word in re.findall(rf"[AE]\d {N}", text)]


def _assigned(words: "tuple[str | None, ...] | list[str | None]") -> tuple[str, float]:
    """Channel and value of an assignment."""
    kind, number, name, text = words
    value = {"TRUE": 1.0, "FALSE": 0.0}.get(text or "")
    return name or f"{'digital' if kind == 'OUT' else 'analog'} {number}", float(text or 0) if value is None else value
