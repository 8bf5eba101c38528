"""Reads SPEL+ back, as a controller would execute it."""

import re
from collections.abc import Iterator, Sequence

from programs.errors import ProgramError
from programs.motion.steps import Line
from programs.posts.dialect import ProgramFiles
from programs.posts.epson.write import ACCELERATION, MOST_TRAPS, SETTINGS, TURN_ACCELERATION
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import Action, skip
from programs.posts.reading.statements import NUMBER, N, U, refusal, statements_of
from programs.posts.rebuilt import Due, ReadSignal
from programs.posts.writing.angles import from_moving_zyx
from programs.posts.writing.lines import degrees_per_s

_XY = rf"XY\(((?:{NUMBER}, ){{5}}{NUMBER})\)"
_OUTPUT = rf"(?:(On|Off) (\d+)|(Out|AIO_Out) (\d+), {N})"
_PARALLEL = re.compile(rf"D(\d+); {_OUTPUT}(?:; |$)")
_STOP = r'Call stop_job\("[^"]*"\)'
_WHILE = rf"Loop While (nLoop\d+) < (\d+)(?: And {N} \* AIO_In\((\d+)\) \+ {N} < {N})?"


class SpelReader(Reader):
    """Functions, tools and locals."""

    handlers = frozenset({"main", "stop_job", "Error", "Emergency", "Abort"})

    def __init__(self) -> None:
        super().__init__()
        self.frames = self.declares("frame")
        self.counter_names = self.declares("counter")
        self.variables = self.declares("variable")
        self.speed_mm_s, self.turn_deg_s = 0.0, 0.0
        self.traps: set[str] = set()
        """Numbers of those that watch inputs."""

    @classmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give 1 for ``CP``, and the rate of a turn on the spot."""
        return Due(1.0, degrees_per_s(line) if line.turns_on_the_spot else None)

    def load(self, files: ProgramFiles) -> str:
        """Sort the functions."""
        lines = (line for file, text in files.items() for line in statements_of(file, text, "'"))
        for line in self.sort(lines, r"Function (\w+)(?:\(text\$ As String\))?", "Fend"):
            if line != "Global Preserve Integer nStart":
                raise refusal(line, "stands outside a function")
            self.variables.add("nStart", 1, line)
        return "main"

    def grammar(self) -> dict[str, Action]:
        """List the statements."""
        settings = "|".join(setting for setting in SETTINGS if not setting.startswith(("AccelS", "AccelR")))
        return {
            rf"(Move|Go) {_XY} /(\d+)( ROT)?( CP)?(?: !(.*)!)?": self.move,
            r"Speed (\d+)": lambda match: self.set_share(match[1]),
            rf"SpeedS {U}": self.set_speed,
            rf"SpeedR {U}": self.set_turn,
            rf"AccelS ({ACCELERATION}), \1": lambda match: self.state(acceleration_mm_s2=float(match[1])),
            rf"AccelR ({TURN_ACCELERATION}), \1": lambda match: self.state(turn_acceleration_deg_s2=float(match[1])),
            _OUTPUT: lambda match: self.switch(*_switched(match.groups())),
            rf"Wait {U}": self.pause,
            r"Call shut_valves": self.shut("main"),
            r"(On|Off) (\d+), Forced": lambda match: self.switch(*_switched((*match.groups(), None, None, None))),
            r"If nStart <= (\d+) Then Call (\w+)": self.do_part,
            r"If nStart = (\d+) Then": lambda match: self.enter(match[1], "EndIf"),
            rf"If SpeedFactor <> 100 Then {_STOP}": self.guard,
            rf"Wait Sw\((\d+)\) = (On|Off), {N}": self.wait_contact,
            r"TmReset 0": self.wait_sensor,
            rf"Trap (?:([1-{MOST_TRAPS}]), Sw\((\d+)\) = (On|Off)|(Error|Emergency|Abort)) Xqt on_fault": self.trap,
            rf"If CZ\(Here\) < ({NUMBER}) Then Move Here :Z\(\1\)": lambda match: self.raise_to(float(match[1])),
            r"EndIf|nStart = 1": skip,
            r"Call (\w+)": self.call,
            r"Do": self.begin_loop,
            _WHILE: self.end_repeat,
            rf"(TLSet|Local) (\d+), {_XY}": self.set_frame,
            r"Tool (\d+)": lambda match: self.use_tool(match[0], self.frames.use(("TLSet", match[1]))),
            rf"Go JA\(({NUMBER}(?:, {NUMBER})*)\)": self.move_joints,
            r"Integer (nLoop\d+)": lambda match: self.counter_names.add(match[1], 0),
            r"(nLoop\d+) = 0": self.set_counter,
            r"(nLoop\d+) = \1 \+ 1": self.raise_counter,
            settings: skip,
        }

    def do_part(self, match: re.Match[str]) -> None:
        """Do a part of main, unless the start is at a later one."""
        self.variables.use("nStart")
        self.call_part(match[1], match[2])

    def wait_contact(self, match: re.Match[str]) -> None:
        """Wait for an input, and stop where that takes too long."""
        self.pass_on(rf"If TW = True Then {_STOP}")
        self.read_stop()
        self.wait_for(match[1], match[2] == "On", float(match[3]))

    def wait_sensor(self, match: re.Match[str]) -> None:
        """Wait for a quantity, and stop where that takes too long."""
        least = rf"{N} \* AIO_In\((\d+)\) \+ {N} < {N}"
        waits, _, _, looks = self.pass_on(
            rf"Do While {least} And Tmr\(0\) < {N}", r"Wait 0\.1", "Loop", rf"If {least} Then {_STOP}"
        )
        scale, sensor, offset, value, seconds = waits.groups()
        if looks.groups() != waits.groups()[:-1]:
            raise ProgramError("what is waited for is not what is looked at then.")
        self.read_stop()
        self.wait_least(sensor, (scale, offset, value), float(seconds))

    def read_stop(self) -> None:
        """Read the function that ends the program."""
        self.expect("stop_job", "Call shut_valves", r"Print .*", "Quit All")
        self.shut_by.add("stop_job")

    def trap(self, match: re.Match[str]) -> None:
        """Have the fault routine run at an event."""
        self.read_stop()
        self.expect("on_fault", "Call shut_valves", r"Print .*", "Quit All")
        if match[4]:
            self.shut_by.add(match[4])
        elif match[1] in self.traps:
            raise ProgramError(f"trap {match[1]} is set twice.")
        else:
            self.traps.add(match[1])
            self.watched.append((match[2], match[3] == "Off"))

    def begin_loop(self, match: re.Match[str]) -> None:
        """Begin a loop whose counter is the first thing in it."""
        counter = next((found[1] for found in self.ahead(r"(nLoop\d+) = nLoop\d+ \+ 1")), "")
        end = self.find_end(_WHILE, counter)
        self.counter_names.use(end[1])
        self.repeat(end[2], end.groups()[2:], end[1])

    def set_speed(self, match: re.Match[str]) -> None:
        """Set the speed of the TCP."""
        self.speed_mm_s = float(match[1])

    def set_turn(self, match: re.Match[str]) -> None:
        """Set the rate of turns on the spot."""
        self.turn_deg_s = float(match[1])

    def set_frame(self, match: re.Match[str]) -> None:
        """Set a tool or a local."""
        self.frames.add((match[1], match[2]), read_pose(match[3].split(", "), from_moving_zyx))

    def move(self, match: re.Match[str]) -> None:
        """Move in a line, or by joints."""
        word, values, local, turns, passes, parallel = match.groups()
        self.use_board(self.frames.use(("Local", local)))
        pose = read_pose(values.split(", "), from_moving_zyx)
        if word == "Go":
            self.reach(pose)
        else:
            self.state(zone=0.0 if passes is None else 1.0, turn_deg_s=self.turn_deg_s if turns else None)
            self.line(pose, passes is None, 0.0 if turns else self.speed_mm_s, tuple(_signals(parallel or "")))


def _signals(parallel: str) -> Iterator[ReadSignal]:
    at = 0
    while match := _PARALLEL.match(parallel, at):
        yield ReadSignal(*_switched(match.groups()[1:]), float(match[1]) / 100.0, 0.0)
        at = match.end()
    if at < len(parallel):
        raise ProgramError(f"unknown parallel processing {parallel!r}.")


def _switched(words: Sequence[str | None]) -> tuple[str, float]:
    """Channel and value of an output."""
    switch, bit, word, number, value = words
    if switch:
        return f"digital {bit}", float(switch == "On")
    return f"{'group' if word == 'Out' else 'analog'} {number}", float(value or 0.0)
