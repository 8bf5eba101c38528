"""Reads URScript back, as a controller would execute it."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence

from programs.errors import ProgramError
from programs.motion.steps import RESOLUTION_MM, Line
from programs.pose import Pose, angle, distance
from programs.posts.dialect import ProgramFiles
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import Action, skip
from programs.posts.reading.statements import NUMBER, N, Statement, U, refusal, statements_of
from programs.posts.rebuilt import Due, ReadSignal
from programs.posts.ur.watcher import KINDS, WATCHER
from programs.posts.ur.write import ACCELERATION, NARROWEST_MM, REACH_SPEED, UrScript
from programs.posts.writing.angles import from_rotation_vector

_POSE = rf"p\[{N},{N},{N},{N},{N},{N}\]"
_OUTPUT = rf"([012]), (\d+), {N}"
_ACCELERATION_MM_S2 = 1000.0 * float(ACCELERATION.removeprefix("a="))
_CHANNELS = {str(code): kind for kind, code in KINDS.items()}


class UrScriptReader(Reader):
    """Functions, declared poses, and outputs that wait for their places."""

    syntax = UrScript
    handlers = frozenset({"main", "stop_job", "thread"})
    height_unit_mm = 1000.0

    def __init__(self) -> None:
        super().__init__()
        self.guards_override = None
        self.armed: list[tuple[Pose, Pose, ReadSignal]] = []
        self.poses = self.declares("pose")
        self.variables = self.declares("variable")
        self.settled = True
        """Whether nothing is left that waits for its place."""

    @classmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give the blend, at most 0.45 of either way that is watched, and the time of a turn on the spot."""
        ways = [each.length_mm for each in (line, after) if each is not None]
        room = min((way for way in ways if way > RESOLUTION_MM), default=math.inf)
        zone = min(line.blend_mm, max(0.45 * room, NARROWEST_MM))
        return Due(zone, None, max(line.duration_s, 0.01) if line.turns_on_the_spot else None)

    def load(self, files: ProgramFiles) -> str:
        """Find the thread as it is written, and the functions; the first is the program."""
        statements = [line for file, text in files.items() for line in _statements(file, text)]
        watcher = _statements("", "\n".join(WATCHER))
        begins = [at for at, line in enumerate(statements) if line == watcher[0]]
        if len(begins) != 1 or statements[begins[0] : begins[0] + len(watcher)] != watcher:
            raise ProgramError("the thread that switches the outputs is not as it is written.")
        del statements[begins[0] : begins[0] + len(watcher)]
        self.sort_nested(statements)
        return next(iter(self.routines), "")

    def sort_nested(self, statements: Iterable[Statement]) -> None:
        """Sort statements into functions, one inside the other; an end belongs to what was opened last."""
        opened: list[list[str]] = []
        loops = 0
        for statement in statements:
            if match := re.fullmatch(r"(?:def|thread) (\w+)\((?:text)?\):", statement):
                opened.append([])
                self.routines[match[1]] = opened[-1]
            elif not opened:
                if statement != f"{next(iter(self.routines), '')}()":  # in a Script node it is called
                    raise refusal(statement, "stands outside any function")
            elif statement == "end" and loops == 0:
                opened.pop()
            else:
                loops += statement.startswith(("while ", "if ")) - (statement == "end")
                opened[-1].append(statement)
        if opened:
            raise ProgramError("a function has no end.")

    def fields(self) -> Mapping[str, str]:
        """Give the pattern of each field of the writer's forms."""
        return {**super().fields(), "point": rf"pose_trans\(board, p\[(?:{NUMBER},){{5}}{NUMBER}\]\)"}

    def grammar(self) -> dict[str, Action]:
        """List the other statements."""
        target = rf"\(pose_trans\(board, {_POSE}\), "
        fast, slow = re.escape(ACCELERATION), re.escape(REACH_SPEED)
        return {
            rf"movel{target}{fast}, ([vt])={U}, r={U}\)": self.move,
            rf"movej\(\[((?:{NUMBER},)*{NUMBER})\], (?:{slow}|t={U})\)": self.move_radians,
            rf"arm\({_POSE}, {_POSE}, {U}, {_OUTPUT}\)": self.arm,
            r"run_watch_inputs = run watch_inputs\(\)": self.read_thread,
            r"global (n_start) = (1)(?: #.*)?": lambda match: self.variables.add(match[1], match[2]),
            r"kill run_watch_inputs": skip,
            r"set_tcp\((\w+)\)": lambda match: self.use_tool(match[1], self.poses.use(match[1])),
            r"board = (\w+)": lambda match: self.use_board(self.poses.use(match[1])),
            rf"global (\w+) = {_POSE}": self.declare,
            r"settle\(\)": self.settle,
            rf"set_payload\({U}, \[0,0,{N}\]\)|run_watch = run watch\(\)|kill run_watch": skip,
        }

    def use_variable(self, name: str) -> None:
        """Use the part to start at."""
        if name == "n_start":
            self.variables.use(name)

    def use_wait(self) -> None:
        """Read the function that ends the program."""
        self.expect("stop_job", r"shut_valves\(\)", r"popup\(text, .*\)", "halt")
        self.shut_by.add("stop_job")

    def use_first_tool(self, name: str) -> None:
        """Use the tool whose orifice is raised."""
        self.use_tool(name, self.poses.use(name))

    def pose_of(self, point: str) -> Pose:
        """Read a pose on the board."""
        return _pose(re.findall(NUMBER, point))

    def read_thread(self, match: re.Match[str]) -> None:
        """Read the thread that watches inputs: it stops the program when one leaves its state."""
        self.use_wait()
        self.called.add("watch_inputs")
        inside = list(self.routines.get("watch_inputs", []))
        if inside[:1] != ["while True:"] or inside[-2:] != ["sync()", "end"]:
            raise ProgramError("the thread that watches inputs is not as it is written.")
        for first, stop, end in zip(*(iter(inside[1:-2]),) * 3, strict=True):
            found = re.fullmatch(r"if get_standard_digital_in\((\d+)\) != (True|False):", first)
            if found is None or not re.fullmatch(r'stop_job\("[^"]*"\)', stop) or end != "end":
                raise ProgramError("the thread that watches inputs is not as it is written.")
            self.watched.append((found[1], found[2] == "True"))
        self.shut_by.add("thread")

    def move_radians(self, match: re.Match[str]) -> None:
        """Come to joint values, in a time or at the cautious speed."""
        self.lasts_s = float(match[2]) if match[2] else None
        self.come_to(math.degrees(float(word)) for word in match[1].split(","))

    def declare(self, match: re.Match[str]) -> None:
        """Declare a pose."""
        self.poses.add(match[1], _pose(match.groups()[1:]))

    def settle(self, match: re.Match[str]) -> None:
        """Switch at a stop what the thread has left."""
        if self.settled:
            raise ProgramError("settle() does not follow a move with outputs that stops.")
        self.settled = True

    def execute(self, statement: str) -> None:
        """Make sure that outputs of a move that stops are settled right after it."""
        if not self.settled and statement != "settle()":
            raise ProgramError(f"settle() is missing before {statement!r}.")
        super().execute(statement)

    def arm(self, match: re.Match[str]) -> None:
        """Arm an output for the next move."""
        numbers = match.groups()
        way, kind, number, value = numbers[12:]
        start, target = _pose(numbers[:6]), _pose(numbers[6:12])
        share = 1000.0 * float(way) / distance(start, target)
        self.armed.append((start, target, ReadSignal(f"{_CHANNELS[kind]} {number}", float(value), share, 0.0)))

    def move(self, match: re.Match[str]) -> None:
        """Move in a line; what is armed has to be armed for it."""
        numbers = match.groups()
        pose, (kind, pace, blend) = _pose(numbers[:6]), numbers[6:]
        for start, target, _ in self.armed:
            if self.pose is None or _apart(start, self.pose) or _apart(target, pose):
                raise ProgramError("an output is armed for another move than the next.")
        signals = tuple(signal for _, _, signal in self.armed)
        self.settled = not signals or float(blend) > 0.0
        self.armed = []
        self.state(zone=1000.0 * float(blend), acceleration_mm_s2=_ACCELERATION_MM_S2)
        self.state(duration_s=float(pace) if kind == "t" else None)
        self.line(pose, float(blend) == 0.0, 1000.0 * float(pace) if kind == "v" else 0.0, signals)


def _apart(one: Pose, other: Pose) -> bool:
    return distance(one, other) > 1e-6 or angle(one, other) > 1e-6


def _pose(numbers: Sequence[str]) -> Pose:
    """Read a pose in metres and radians."""
    pose = read_pose(numbers, from_rotation_vector)
    x, y, z = pose.position
    return Pose((1000.0 * x, 1000.0 * y, 1000.0 * z), pose.quaternion)


def _statements(file: str, text: str) -> list[Statement]:
    return [line for line in statements_of(file, text) if line and not line.startswith("#")]
