"""Reads RAPID back, as a controller would execute it."""

import re
from collections.abc import Iterator

from programs.errors import ProgramError
from programs.motion.steps import Line
from programs.pose import Pose
from programs.posts.abb.write import REACH_SPEED, Rapid
from programs.posts.dialect import ProgramFiles
from programs.posts.reading.driver import Reader, checked
from programs.posts.reading.execution import Action, skip
from programs.posts.reading.forms import Block, Values
from programs.posts.reading.statements import NUMBER, N, U, look_up, refusal, statements_of
from programs.posts.rebuilt import Due, ReadSignal
from programs.posts.writing.lines import turn_limit

_DATA = re.compile(r"(?:LOCAL )?(?:CONST|PERS|VAR) (\w+) (\w+)(?::=(.*))?;")
_OUTPUT = r"\\[DGA]Op:=(\w+),([\d.-]+);"
_LIST = rf"{NUMBER}(?:,(?:{NUMBER}|9E9))*"
_ZONES_MM = {"z0": 0.3, "z1": 1.0, "z5": 5.0}
"""Radii of the predefined zones."""
_WHOLE_TURN_DEG_S = 500.0
"""Of lines that hardly turn."""
_POSE = rf"\[\[{N},{N},{N}\],\[{N},{N},{N},{N}\]\]"
_NO_AXES = re.escape("[9E9,9E9,9E9,9E9,9E9,9E9]")
_SHAPES = {
    "robtarget": rf"{_POSE[:-2]},\[0,0,0,0\],{_NO_AXES}\]",
    "jointtarget": rf"\[\[({_LIST})\],\[((?:9E9|{NUMBER})(?:,(?:9E9|{NUMBER})){{5}})\]\]",
    "tooldata": rf"\[TRUE,{_POSE},\[{N},\[0,0,{N}\],\[1,0,0,0\],0,0,0\]\]",
    "wobjdata": rf'\[FALSE,TRUE,"",{_POSE},\[\[0,0,0\],\[1,0,0,0\]\]\]',
    "speeddata": rf"\[{N},{N},5000,1000\]",
    "triggdata": "()",
    "num": "([01])",
    "bool": "(FALSE)",
    "intnum": "()",
}
"""Patterns of the values of each type; their groups are its numbers."""


class RapidReader(Reader):
    """Data, procedures and triggers of all modules."""

    moves = "MoveL|MoveJ|TriggL"
    syntax = Rapid
    handlers = frozenset({"main", "ERROR", "TRAP"})

    def __init__(self) -> None:
        super().__init__()
        self.values = self.declares("data")
        """Numbers by type and name."""
        self.triggers = self.declares("trigger")
        """Place in mm, whether it counts from the start, lead in seconds, channel and value by name."""

    @classmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give the widest predefined zone within the planned one, and ``v_ori``, a little above the planned turn."""
        zone = max((each for each in _ZONES_MM.values() if each <= line.blend_mm), default=min(_ZONES_MM.values()))
        rate = turn_limit(line)
        return Due(zone=zone, turn_deg_s=_WHOLE_TURN_DEG_S if rate is None else rate)

    def load(self, files: ProgramFiles) -> str:
        """Read the declarations; the modules have to be those that the ``.pgf`` lists."""
        modules = {name: text for name, text in files.items() if name.endswith(".mod")}
        for name, text in files.items():
            if name.endswith(".pgf") and re.findall(r"<Module>(.*)</Module>", text) != list(modules):
                raise ProgramError("the .pgf does not list the modules.", file=name)
        for name, text in modules.items():
            if not re.match(r"MODULE \w+\n", text) or not text.endswith("\nENDMODULE\n"):
                raise ProgramError("this is no whole module.", file=name)
            lines = statements_of(name, text)
            statements = (line for line in lines if not line.startswith(("!", "MODULE ", "ENDMODULE")))
            for line in self.sort(
                statements, r"(?:PROC (?=\w+\()|TRAP )(\w+)(?:\((?:string sText)?\))?", "ENDPROC|ENDTRAP"
            ):
                match = _DATA.fullmatch(line)
                shape = match and re.fullmatch(_SHAPES.get(match[1], "(?!)"), match[3] or "")
                if match is None or shape is None:
                    raise refusal(line, "declares nothing")
                self.values.add((match[1], match[2]), shape.groups(), line)
                if match[1] == "bool":
                    self.values.used.add((match[1], match[2]))  # by waits alone, which a program need not have
        self.called.add("stop_job")
        return "main"

    def blocks(self) -> Iterator[Block]:
        """List the statements of forms."""
        yield from super().blocks()
        fault = ("CONNECT irFault WITH on_fault;", "IError COMMON_ERR,TYPE_ERR,irFault;")
        yield fault, lambda values: self.connect("irFault")

    def grammar(self) -> dict[str, Action]:
        """List the other statements."""
        slow = rf"({REACH_SPEED}),fine,(\w+)"
        timed = rf"({REACH_SPEED})(?:\\T:={U})?,fine,(\w+)"
        external = rf"{_LIST}|9E9(?:,9E9)*"
        return {
            rf"({self.moves}) (\w+),(\w+)((?:,ev\d+)?(?:\\T\d:=ev\d+)*),(\w+),(\w+)\\WObj:=(\w+);": self.move,
            r"ERROR": self.handle_error,
            r"IDelete irFault;|ENDIF": skip,
            rf"MoveAbsJ \[\[({_LIST})\],\[({external})\]\]\\NoEOffs,{timed}\\WObj:=(\w+);": self.move_to_joints,
            rf"MoveAbsJ (jHome)\\NoEOffs,{slow};": self.go_home,
            rf"TriggEquip (\w+),([\d.]+)(\\Start)?,([\d.]+){_OUTPUT}": self.define_trigger,
            rf"TriggIO (\w+),()()([\d.]+)\\Time{_OUTPUT}": self.define_trigger,
            r"(ConfJ\\Off|ConfL\\Off);": skip,
        }

    def use_variable(self, name: str) -> None:
        """Use a number that is declared."""
        self.values.use(("num", name))

    def use_wait(self) -> None:
        """Use what stops the program where a wait is over."""
        self.values.use(("bool", "bLate"))
        self.expect("stop_job", r"shut_valves;", r"TPWrite .*;", r"EXIT;")

    def use_first_tool(self, name: str) -> None:
        """Use the tool whose orifice is raised."""
        self.numbers("pStart", "robtarget")
        self.frame_of(name, "tooldata")
        self.numbers(REACH_SPEED, "speeddata")

    def connect(self, interrupt: str) -> None:
        """Connect the fault routine."""
        self.expect("on_fault", r"StopMove\\Quick;", r"shut_valves;", r"TPWrite .*;", r"EXIT;")
        self.values.use(("intnum", interrupt))
        self.shut_by.add("TRAP")

    def read_watch(self, values: Values) -> None:
        """Begin to watch an input."""
        self.connect(f"irWatch{values['index']}")
        super().read_watch(values)

    def handle_error(self, match: re.Match[str]) -> None:
        """Come to the end of main: what follows is the handler of errors."""
        self.pass_on(r"shut_valves;", r"RAISE;")
        self.shut_by.add("ERROR")

    def go_home(self, match: re.Match[str]) -> None:
        """Go home."""
        self.come_home(_joints(*self.values.use(("jointtarget", match[1]))))
        self.check_reach(match[2], match[3])

    def check_reach(self, speed: str, tool: str) -> None:
        """Make sure that a joint motion has the speed of all, and a tool that there is."""
        if self.numbers(speed, "speeddata") != [100.0, 500.0]:
            raise ProgramError(f"speed {speed} of joint motions is not [100,500,5000,1000].")
        if tool != "tool0":
            self.numbers(tool, "tooldata")

    def move_to_joints(self, match: re.Match[str]) -> None:
        """Come to joint values: the robot's, and those of external axes that there are."""
        self.check_reach(match[3], match[5])
        self.numbers(match[6], "wobjdata")
        self.lasts_s = float(match[4]) if match[4] else None
        self.come_to(_joints(match[1], match[2]))

    def define_trigger(self, match: re.Match[str]) -> None:
        """Define when a trigger leaves."""
        name, place_mm, start, lead, channel, value = match.groups()
        self.values.use(("triggdata", name))
        self.triggers.add(name, (float(place_mm or 0.0), bool(start), float(lead), channel, float(value)))

    def move(self, match: re.Match[str]) -> None:
        """Move in a line, or by joints."""
        kind, target, speed, triggers, zone, tool, board = match.groups()
        self.use_tool(tool, self.frame_of(tool, "tooldata"))
        self.use_board(self.frame_of(board, "wobjdata"))
        pose = self.frame_of(target, "robtarget")
        names = re.findall(r"ev\d+", triggers)
        if kind == "MoveJ" or self.counted:
            self.check_reach(speed, tool)
            if zone != "fine" or names:
                raise ProgramError(f"{match[0]!r} comes to a pose and does not stop there, or switches something.")
            self.reach(pose, self.counted)
            return
        if [f"\\T{number}:=" for number in range(2, 1 + len(names))] != re.findall(r"\\T\d:=", triggers):
            raise ProgramError(f"the triggers of {match[0]!r} are not counted from T2.")
        length_mm = self.length_to(pose)
        speed_mm_s, turn_deg_s = self.numbers(speed, "speeddata")
        zone_mm = 0.0 if zone == "fine" else look_up(_ZONES_MM, zone, f"zone {zone}")
        self.state(zone=zone_mm, turn_deg_s=turn_deg_s)
        signals = tuple(self.signal(name, length_mm) for name in names)
        self.line(pose, zone == "fine", speed_mm_s if length_mm else 0.0, signals)

    def signal(self, name: str, length_mm: float) -> ReadSignal:
        """Place a trigger on a line."""
        place_mm, from_start, lead_s, channel, value = self.triggers.use(name)
        share = place_mm / length_mm if length_mm else place_mm
        return ReadSignal(channel, value, share if from_start else 1.0 - share, -lead_s)

    def numbers(self, name: str, kind: str) -> list[float]:
        """Give the numbers of a declared value."""
        return [float(word) for word in self.values.use((kind, name))]

    def frame_of(self, name: str, kind: str) -> Pose:
        """Give the pose that a target, tool or work object begins with."""
        x, y, z, a, b, c, d = self.numbers(name, kind)[:7]
        return Pose((x, y, z), checked((a, b, c, d)))


def _joints(robot: str, external: str) -> list[float]:
    """Give the joint values of the robot, and those of the external axes that there are."""
    return [float(word) for word in (*robot.split(","), *external.split(",")) if word != "9E9"]
