"""Reads RAPID back, as a controller would execute it."""

import re

from programs.errors import ProgramError
from programs.pose import Pose
from programs.posts.dialect import ProgramFiles
from programs.posts.reading.driver import Action, N, Reader, look_up, refusal, skip, statements_of
from programs.posts.rebuilt import ReadSignal

_DATA = re.compile(r"(?:LOCAL )?(?:CONST|PERS|VAR) (\w+) (\w+)(?::=(.*))?;")
_OUTPUT = r"\\[DGA]Op:=(\w+),([\d.-]+);"
_NUMBER = re.compile(r"-?[\d.]+(?:E\d+)?")
_LIST = r"[\d.,E-]+"
_Z0_MM = 0.3
"""Radius of the zone z0."""
_POSE = "[[0,0,0],[0,0,0,0]]"
_SHAPES = {
    "robtarget": "[[0,0,0],[0,0,0,0],[0,0,0,0],[0,0,0,0,0,0]]",
    "jointtarget": "[[0,0,0,0,0,0],[0,0,0,0,0,0]]",
    "tooldata": f"[TRUE,{_POSE},[0,[0,0,0],[0,0,0,0],0,0,0]]",
    "wobjdata": f'[FALSE,TRUE,"",{_POSE},{_POSE}]',
    "speeddata": "[0,0,0,0]",
    "triggdata": "",
    "num": "0",
    "bool": "FALSE",
    "intnum": "",
}
"""How the values of each type are nested, every number as 0."""


class RapidReader(Reader):
    """Data, procedures and triggers of all modules."""

    moves = "MoveL|MoveJ|TriggL"
    handlers = frozenset({"main", "ERROR", "TRAP"})

    def __init__(self) -> None:
        super().__init__()
        self.values: dict[tuple[str, str], str] = {}
        """By type and name."""
        self.triggers: dict[str, tuple[float, bool, float, str, float]] = {}
        """Place in mm, whether it counts from the start, lead in seconds, channel and value by name."""

    def load(self, files: ProgramFiles) -> str:
        """Read the declarations; the modules have to be those that the ``.pgf`` lists."""
        modules = {name: text for name, text in files.items() if name.endswith(".mod")}
        for name, text in files.items():
            if name.endswith(".pgf") and re.findall(r"<Module>(.*)</Module>", text) != list(modules):
                raise ProgramError("the .pgf does not list the modules.", file=name)
        for name, text in modules.items():
            lines = statements_of(name, text)
            statements = (line for line in lines if not line.startswith(("!", "MODULE ", "ENDMODULE")))
            for line in self.sort(
                statements, r"(?:PROC (?=\w+\()|TRAP )(\w+)(?:\((?:string sText)?\))?", "ENDPROC|ENDTRAP"
            ):
                match = _DATA.fullmatch(line)
                if match is None or _NUMBER.sub("0", match[3] or "") != _SHAPES.get(match[1]):
                    raise refusal(line, "declares nothing")
                self.values[match[1], match[2]] = match[3] or ""
        return "main"

    def grammar(self) -> dict[str, Action]:
        """List the statements."""
        looks = r" AND \(\1=0 OR ([\d.-]+)\*AInput\(\w+\)\+([\d.-]+)<([\d.-]+)\)"
        return {
            rf"({self.moves}) (\w+),(\w+)((?:,ev\d+)?(?:\\T\d:=ev\d+)*),(\w+),(\w+)\\WObj:=(\w+);": self.move,
            r"shut_valves;": self.shut("main"),
            r"IF nStart<=(\d+) (\w+);": lambda match: self.run(match[2]) if self.begin_part(match[1]) else None,
            r"IF nStart=(\d+) THEN": lambda match: self.enter(match[1], "ENDIF"),
            r'IF CSpeedOverride\(\)<>100 stop_job "[^"]*";': self.guard,
            r"WaitDI (\w+),([01])\\MaxTime:=([\d.]+)\\TimeFlag:=bLate;": self.wait_contact,
            rf"WaitUntil {N}\*AInput\((\w+)\)\+{N}>={N}\\MaxTime:=([\d.]+)\\TimeFlag:=bLate;": self.wait_sensor,
            r"CONNECT (\w+) WITH on_fault;": self.connect,
            r"ERROR": self.handle_error,
            r"IDelete \w+;|nStart:=1;|ENDIF": skip,
            rf"MoveAbsJ \[\[({_LIST})\],\[({_LIST})\]\]\\NoEOffs,.*": self.move_to_joints,
            r"MoveAbsJ jHome\\NoEOffs,.*": skip,
            rf"TriggEquip (\w+),([\d.-]+)(\\Start)?,([\d.-]+){_OUTPUT}": self.define_trigger,
            rf"TriggIO (\w+),()()([\d.-]+)\\Time{_OUTPUT}": self.define_trigger,
            r"Set[DGA]O (\w+),([\d.-]+);": lambda match: self.switch(match[1], float(match[2])),
            r"WaitTime ([\d.]+);": self.pause,
            rf"WHILE (\w+)<(\d+)(?:{looks})? DO": lambda match: self.repeat(match[2], match.groups()[2:]),
            r"ENDWHILE": self.end_repeat,
            r"(ConfJ\\Off|ConfL\\Off|nLoop\d+:=.*);": skip,
            r"([A-Za-z]\w*);": self.call,
        }

    def wait_contact(self, match: re.Match[str]) -> None:
        """Wait for a signal."""
        self.stop_late()
        self.wait_for(match[1], match[2] == "1", float(match[3]))

    def wait_sensor(self, match: re.Match[str]) -> None:
        """Wait for a quantity."""
        self.stop_late()
        scale, channel, offset, least, timeout_s = match.groups()
        self.wait_least(channel, (scale, offset, least), float(timeout_s))

    def stop_late(self) -> None:
        """Stop where a wait is over."""
        self.pass_on(r'IF bLate stop_job "[^"]*";')
        self.expect("stop_job", r"shut_valves;", r"TPWrite .*;", r"EXIT;")

    def connect(self, match: re.Match[str]) -> None:
        """Connect the fault routine with errors, or with a signal that leaves its state."""
        self.expect("on_fault", r"StopMove\\Quick;", r"shut_valves;", r"TPWrite .*;", r"EXIT;")
        (cause,) = self.pass_on(rf"IError COMMON_ERR,TYPE_ERR,{match[1]};|ISignalDI (\w+),([01]),{match[1]};")
        self.shut_by.add("TRAP")
        if cause[1]:
            self.watched.append((cause[1], cause[2] == "0"))

    def handle_error(self, match: re.Match[str]) -> None:
        """Come to the end of main: what follows is the handler of errors."""
        self.pass_on(r"shut_valves;", r"RAISE;")
        self.shut_by.add("ERROR")

    def move_to_joints(self, match: re.Match[str]) -> None:
        """Come to joint values: the robot's, and those of external axes that there are."""
        external = [word for word in match[2].split(",") if word != "9E9"]
        self.come_to(float(word) for word in (*match[1].split(","), *external))

    def define_trigger(self, match: re.Match[str]) -> None:
        """Define when a trigger leaves."""
        name, place_mm, start, lead, channel, value = match.groups()
        self.triggers[name] = (float(place_mm or 0.0), bool(start), float(lead), channel, float(value))

    def move(self, match: re.Match[str]) -> None:
        """Move in a line, or by joints."""
        kind, target, speed, triggers, zone, tool, board = match.groups()
        self.use_tool(tool, self.pose_of(tool, "tooldata"))
        self.use_board(self.pose_of(board, "wobjdata"))
        pose = self.pose_of(target, "robtarget")
        if kind == "MoveJ":
            self.reach(pose)
            return
        length_mm = self.length_to(pose)
        speed_mm_s, turn_deg_s, *_ = self.numbers(speed, "speeddata")
        self.state(zone=_Z0_MM if zone == "z0" else float(zone[1:]) if zone != "fine" else 0.0, turn_deg_s=turn_deg_s)
        signals = tuple(self.signal(name, length_mm) for name in re.findall(r"ev\d+", triggers))
        self.line(pose, zone == "fine", speed_mm_s if length_mm else 0.0, signals)

    def signal(self, name: str, length_mm: float) -> ReadSignal:
        """Place a trigger on a line."""
        place_mm, from_start, lead_s, channel, value = look_up(self.triggers, name, f"trigger {name}")
        share = place_mm / length_mm if length_mm else 0.0
        return ReadSignal(channel, value, share if from_start else 1.0 - share, -lead_s)

    def numbers(self, name: str, kind: str) -> list[float]:
        """Give the numbers of a declared value."""
        value = look_up(self.values, (kind, name), f"{kind} {name}")
        return [float(word) for word in _NUMBER.findall(value)]

    def pose_of(self, name: str, kind: str) -> Pose:
        """Give the pose that a target, tool or work object begins with."""
        x, y, z, a, b, c, d = self.numbers(name, kind)[:7]
        return Pose((x, y, z), (a, b, c, d))
