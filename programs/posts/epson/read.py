"""Reads SPEL+ back, as a controller would execute it."""

import re
from collections.abc import Iterator, Mapping

from programs.errors import ProgramError
from programs.motion.steps import Line
from programs.pose import Pose
from programs.posts.dialect import ProgramFiles
from programs.posts.epson.write import ACCELERATION, MOST_TRAPS, SETTINGS, TURN_ACCELERATION, Spel
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import Action, skip
from programs.posts.reading.forms import Block, Values
from programs.posts.reading.statements import NUMBER, U, refusal, statements_of
from programs.posts.rebuilt import Due, ReadSignal
from programs.posts.writing.angles import from_moving_zyx
from programs.posts.writing.lines import degrees_per_s

_XY = rf"XY\(((?:{NUMBER}, ){{5}}{NUMBER})\)"
_PARALLEL = re.compile(r"D(\d+); ([^;]*)(?:; |$)")


class SpelReader(Reader):
    """Functions, tools and locals."""

    syntax = Spel
    handlers = frozenset({"main", "stop_job", "Error", "Emergency", "Abort"})

    def __init__(self) -> None:
        super().__init__()
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

    def fields(self) -> Mapping[str, str]:
        """Give the pattern of each field of the writer's forms."""
        words = {"turns": "(?: ROT)?", "passes": "(?: CP)?", "parallel": "(?: !.*!)?", "index": f"[1-{MOST_TRAPS}]"}
        return {**super().fields(), **words, "frame": _XY, "point": rf"{_XY} /\d+"}

    def blocks(self) -> Iterator[Block]:
        """List the statements of forms."""
        yield [Spel.move], self.move
        yield from super().blocks()
        yield from (([f"{form}, Forced"], self.read_switch) for form in self.output_forms()[:1])
        yield [Spel.declare], lambda values: self.counter_names.add(values["counter"], 0)

    def grammar(self) -> dict[str, Action]:
        """List the other statements."""
        settings = "|".join(setting for setting in SETTINGS if not setting.startswith(("AccelS", "AccelR")))
        return {
            r"Speed (\d+)": lambda match: self.set_share(match[1]),
            rf"SpeedS {U}": self.set_speed,
            rf"SpeedR {U}": self.set_turn,
            rf"AccelS ({ACCELERATION}), \1": lambda match: self.state(acceleration_mm_s2=float(match[1])),
            rf"AccelR ({TURN_ACCELERATION}), \1": lambda match: self.state(turn_acceleration_deg_s2=float(match[1])),
            r"Trap (Error|Emergency|Abort) Xqt on_fault": self.trap,
            rf"{settings}|EndIf": skip,
        }

    def use_variable(self, name: str) -> None:
        """Use a counter, or the part to start at."""
        (self.variables if name == "nStart" else self.counter_names).use(name)

    def use_first_tool(self, name: str) -> None:
        """Use the tool whose orifice is raised."""
        self.select_tool({"slot": name})

    def use_wait(self) -> None:
        """Read the function that ends the program."""
        self.expect("stop_job", "Call shut_valves", r"Print .*", "Quit All")
        self.shut_by.add("stop_job")

    def trap(self, match: re.Match[str]) -> None:
        """Have the fault routine run at an event."""
        self.read_trap()
        self.shut_by.add(match[1])

    def read_trap(self) -> None:
        """Read what traps lead to."""
        self.use_wait()
        self.expect("on_fault", "Call shut_valves", r"Print .*", "Quit All")

    def read_watch(self, values: Values) -> None:
        """Begin to watch an input."""
        self.read_trap()
        if values["index"] in self.traps:
            raise ProgramError(f"trap {values['index']} is set twice.")
        self.traps.add(values["index"])
        super().read_watch(values)

    def set_speed(self, match: re.Match[str]) -> None:
        """Set the speed of the TCP."""
        self.speed_mm_s = float(match[1])

    def set_turn(self, match: re.Match[str]) -> None:
        """Set the rate of turns on the spot."""
        self.turn_deg_s = float(match[1])

    def move(self, values: Values) -> None:
        """Move in a line."""
        pose, turns, passes = self.pose_of(values["point"]), bool(values["turns"]), bool(values["passes"])
        self.state(zone=float(passes), turn_deg_s=self.turn_deg_s if turns else None)
        signals = tuple(self.signals(values["parallel"][2:-1]))
        self.line(pose, not passes, 0.0 if turns else self.speed_mm_s, signals)

    def pose_of(self, point: str) -> Pose:
        """Read a pose, and use the local of a point."""
        frame, _, local = point.partition(" /")
        if local:
            self.use_board(self.slots.use(("board", local)))
        return read_pose(frame[3:-1].split(", "), from_moving_zyx)

    def signals(self, parallel: str) -> Iterator[ReadSignal]:
        """Read the outputs of a move."""
        at = 0
        while match := _PARALLEL.match(parallel, at):
            yield ReadSignal(*self.output_of(match[2]), float(match[1]) / 100.0, 0.0)
            at = match.end()
        if at < len(parallel):
            raise ProgramError(f"unknown parallel processing {parallel!r}.")
