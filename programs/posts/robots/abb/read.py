"""Reads RAPID back, as a controller would execute it, and describes the language."""

import re
from collections.abc import Iterator, Mapping

from programs.errors import ProgramError
from programs.motion.lower import Capability
from programs.motion.steps import Line
from programs.pose import Pose
from programs.posts.dialect import Dialect, FileForm, ProgramFiles
from programs.posts.layout import Layout, words_of
from programs.posts.reading.driver import Reader, checked
from programs.posts.reading.execution import Block, N, Values, look_up, refusal, skip, statements_of
from programs.posts.rebuilt import Due, ReadSignal
from programs.posts.robots.abb.write import NO_AXES, REACH_SPEED, Rapid
from programs.posts.writing.chapters import turn_limit
from programs.posts.writing.forms import NUMBER
from programs.timing.controller import Controller

_DATA = re.compile(r"(?:LOCAL )?(?:CONST|PERS|VAR) (\w+) (\w+)(?::=(.*))?;")
_LIST = rf"{NUMBER}(?:,(?:{NUMBER}|9E9))*"
_ZONES_MM = {"z0": 0.3, "z1": 1.0, "z5": 5.0}
"""Radii of the predefined zones."""
_WHOLE_TURN_DEG_S = 500.0
"""Of lines that hardly turn."""
_POSE = rf"\[\[{N},{N},{N}\],\[{N},{N},{N},{N}\]\]"
_SHAPES = {
    "robtarget": rf"{_POSE[:-2]},\[0,0,0,0\],{re.escape(NO_AXES)}\]",
    "jointtarget": rf"\[\[({_LIST})\],\[((?:9E9|{NUMBER})(?:,(?:9E9|{NUMBER})){{5}})\]\]",
    "tooldata": rf"\[TRUE,{_POSE},\[{N},\[{N},{N},{N}\],\[1,0,0,0\],{N},{N},{N}\]\]",
    "wobjdata": rf'\[FALSE,TRUE,"",{_POSE},\[\[0,0,0\],\[1,0,0,0\]\]\]',
    "speeddata": rf"\[{N},{N},5000,1000\]",
    "triggdata": "()",
    "num": "([01])",
    "bool": "(FALSE)",
    "intnum": "()",
}
"""Patterns of the values of each type; their groups are its numbers."""
WORDS = f"""
    MODULE ENDMODULE LOCAL CONST PERS VAR TRAP ENDTRAP AND TRUE FALSE Time DOp GOp AOp TriggL string
    z z# sBrush# ev# p# {" ".join(_SHAPES)}
"""
"""Words that no form of statements has."""


_OF_MOVE = ("point", "speed", "triggers", "zone", "tool", "board")


class RapidReader(Reader):
    """Data, procedures and triggers of all modules."""

    verbs = "MoveL|MoveJ|TriggL"
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
            if name.endswith(".pgf") and re.findall(r"<Module>([^<]*)</Module>", text) != list(modules):
                raise ProgramError("the .pgf does not list the modules.", file=name)
        for name, text in modules.items():
            first = re.match(r"\s*MODULE \w+\n", text)
            last = text[text.rstrip().rfind("\n") :]
            if first is None or not re.fullmatch(r"\n[ \t]*ENDMODULE\n", last):
                line = 1 if first is None else text.count("\n")
                raise ProgramError("this is no whole module.", file=name, line=line)
            lines = statements_of(name, text)
            statements = (line for line in lines if not line.startswith(("!", "MODULE ", "ENDMODULE")))
            named = (line.become(f"PROC {line[5:]}()") if line.startswith("TRAP ") else line for line in statements)
            routines = (line.become("ENDPROC") if line == "ENDTRAP" else line for line in named)
            for line in self.sort(routines, Rapid.routine_form):
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
        yield [Rapid.move], self.move
        yield Rapid.on_error, lambda values: self.shut_by.add("ERROR")
        yield Rapid.fault_forms, self.read_faults
        yield [*Rapid.last], lambda values: self.acting.discard("irFault")
        yield ["ENDIF"], skip
        yield from (([form], self.define_trigger) for form in Rapid.trigger_forms)
        yield [Rapid.go_home], self.go_home
        yield from super().blocks()

    def fields(self) -> Mapping[str, str]:
        """Give the pattern of each field of the writer's forms."""
        words = dict.fromkeys(("point", "speed", "zone", "tool", "board", "trigger", "name"), r"\w+")
        words |= {"verb": self.verbs, "triggers": r"(?:,ev\d+)?(?:\\T\d:=ev\d+)*", "kind": "[DGA]"}
        external = rf"{_LIST}|9E9(?:,9E9)*"
        return {**super().fields(), **words, "joints": rf"\[\[{_LIST}\],\[(?:{external})\]\]"}

    def use_variable(self, name: str) -> None:
        """Use a number that is declared."""
        self.values.use(("num", name))

    def use_wait(self) -> None:
        """Use what stops the program where a wait is over."""
        self.values.use(("bool", "bLate"))
        self.expect("stop_job", Rapid.stop_body)

    def use_first_tool(self, name: str) -> None:
        """Use the tool whose orifice is raised."""
        self.numbers("pStart", "robtarget")
        self.pose_in(name, "tooldata")
        self.numbers(REACH_SPEED, "speeddata")

    def read_faults(self, values: Values) -> None:
        """Have the fault routine run at errors."""
        self.connect("irFault")
        self.acting.add("irFault")

    def connect(self, interrupt: str) -> None:
        """Connect the fault routine."""
        self.expect("on_fault", Rapid.fault_body)
        self.values.use(("intnum", interrupt))
        self.shut_by.add("TRAP")

    def read_watch(self, values: Values) -> None:
        """Begin to watch an input."""
        self.connect(f"irWatch{values['index']}")
        super().read_watch(values)

    def go_home(self, values: Values) -> None:
        """Go home."""
        self.come_home(_joints(*self.values.use(("jointtarget", "jHome"))))
        self.check_reach(REACH_SPEED, values["tool"])

    def check_reach(self, speed: str, tool: str) -> None:
        """Make sure that a joint motion has the speed of all, and a tool that there is."""
        if self.numbers(speed, "speeddata") != [100.0, 500.0]:
            raise ProgramError(f"speed {speed} of joint motions is not [100,500,5000,1000].")
        if tool != "tool0":
            self.numbers(tool, "tooldata")

    def move_joints(self, values: Values) -> None:
        """Come to joint values: the robot's, and those of external axes that there are."""
        self.check_reach(values["speed"], values["tool"])
        self.numbers(values["board"], "wobjdata")
        self.lasts_s = float(values["seconds"]) if "seconds" in values else None
        self.come_to(_joints(*values["joints"][2:-2].split("],[")))

    def define_trigger(self, values: Values) -> None:
        """Define when a trigger leaves."""
        self.values.use(("triggdata", values["trigger"]))
        place, lead, value = (float(values.get(name, 0.0)) for name in ("place", "lead", "value"))
        self.triggers.add(values["trigger"], (place, "start" in values, lead, values["name"], value), self.statement)

    def move(self, values: Values) -> None:
        """Move in a line, or by joints."""
        target, speed, triggers, zone, tool, board = (values[name] for name in _OF_MOVE)
        self.use_tool(tool, self.pose_in(tool, "tooldata"))
        self.use_board(self.pose_in(board, "wobjdata"))
        pose = self.pose_in(target, "robtarget")
        names = re.findall(r"ev\d+", triggers)
        if values["verb"] == "MoveJ" or self.counted:
            self.check_reach(speed, tool)
            if zone != "fine" or names:
                raise ProgramError(
                    f"the motion to {target} comes to a pose and does not stop there, or switches something."
                )
            self.reach(pose, self.counted)
            return
        if [f"\\T{number}:=" for number in range(2, 1 + len(names))] != re.findall(r"\\T\d:=", triggers):
            raise ProgramError(f"the triggers of the motion to {target} are not counted from T2.")
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

    def pose_in(self, name: str, kind: str) -> Pose:
        """Give the pose that a target, tool or work object begins with."""
        x, y, z, a, b, c, d = self.numbers(name, kind)[:7]
        return Pose((x, y, z), checked((a, b, c, d)))


def _joints(robot: str, external: str) -> list[float]:
    """Give the joint values of the robot, and those of the external axes that there are."""
    return [float(word) for word in (*robot.split(","), *external.split(",")) if word != "9E9"]


DIALECT = Dialect(
    title="ABB RAPID",
    notes="Modules for RobotWare 6 and 7; outputs by TriggEquip and TriggIO. Load the .pgf, or the one .mod.",
    capability=Capability(
        controller_class=1,
        timing="distance and time",
        cycle_s=0.002,
        most_events=8,  # TriggL takes Trigg_1 and \T2 to \T8
        longest_lead_s=0.5,  # assumed: what TriggIO \Time and EquipLag take without a change of Event Preset Time
        step_mm_s=0.1,
    ),
    layout=Layout(
        "!", comma=",", equals="=", single_blanks=True, leading_zero=True, powers=True, words=words_of(Rapid, WORDS)
    ),
    form=FileForm(".mod", beside=(".pgf",)),
    longest_line=200,
    most_steps=2000,  # of a module: with a target and an instruction for each, below 5,000 lines; assumed
    write=Rapid.write,
    rebuild=RapidReader.rebuild,
    controller=Controller(
        blending="zone",
        settle_s=0.05,
        look_ahead=20,
        least_line_s=0.01,
        most_lines=10_000,
        sources={
            "blending": "RAPID overview: zones that overlap shrink to half the distance of their points",
            "acceleration_mm_s2": "RAPID overview: acceleration is that of the motors, so the joints limit it",
        },
    ),
    maker="abb",
    without_joints="Stand the arm in the configuration that it is to keep (ConfJ\\Off, ConfL\\Off).",
)
