"""ABB RAPID: outputs on the path by ``TriggL``, timed by the controller itself."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence

from programs.errors import ProgramError
from programs.motion.installation import Installation
from programs.motion.lower import Capability, Lowered
from programs.motion.steps import Event, Line, Reach
from programs.pose import Pose
from programs.posts.dialect import Dialect, FileForm, ProgramFiles
from programs.posts.reading.driver import Reader, checked
from programs.posts.reading.execution import Block, N, Values, look_up, refusal, skip, statements_of
from programs.posts.rebuilt import Due, ReadSignal
from programs.posts.writing.chapters import Placed, turn_limit
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.forms import NUMBER, fill, fixed, short
from programs.posts.writing.frame import under_each
from programs.posts.writing.wording import indent, join_lines
from programs.timing.controller import Controller

_NO_AXES = "[9E9,9E9,9E9,9E9,9E9,9E9]"
_RESERVED = frozenset({
    "main", "define_events", "shut_valves", "on_fault", "stop_job", "nstart", "blate",
    "alias", "and", "backward", "case", "connect", "const", "default", "div", "do", "else",
    "elseif", "endfor", "endfunc", "endif", "endmodule", "endproc", "endrecord", "endtest", "endtrap", "endwhile",
    "error", "exit", "false", "for", "from", "func", "goto", "if", "inout", "local", "mod", "module", "nostepin",
    "not", "noview", "or", "pers", "proc", "raise", "readonly", "record", "retry", "return", "step", "sysmodule",
    "test", "then", "to", "trap", "true", "trynext", "undo", "var", "viewonly", "while", "with", "xor",
})  # fmt: skip
"""Words of the language, and the routines that every program has."""
_ZONES = ((5.0, "z5"), (1.0, "z1"), (0.0, "z0"))
"""Predefined zones by their radius; z0 is 0.3 mm, and the controller shrinks a zone that has no room."""
REACH_SPEED = "s100"


class Rapid(Syntax):
    """RAPID: modules of targets and procedures."""

    mark = "! "
    call_form = "{routine};"
    pause_form = "WaitTime {seconds:3};"
    routine_form = ("PROC {routine}({takes_text:string sText})", "ENDPROC")
    move = "{verb} {point},{speed}{triggers},{zone},{tool}\\WObj:={board};"
    to_joints = "MoveAbsJ {joints}\\NoEOffs,{speed}{lasting:\\T:={seconds:3}},fine,{tool}\\WObj:={board};"
    go_home = f"MoveAbsJ jHome\\NoEOffs,{REACH_SPEED},fine,{{tool}};"
    trigger_forms = (
        "TriggIO {trigger},{lead:3}\\Time\\{kind}Op:={name},{value:-~6};",
        "TriggEquip {trigger},{place:3}{start:\\Start},{lead:3}\\{kind}Op:={name},{value:-~6};",
    )
    """At the end of a line, and somewhere on it."""
    begin = ("ConfJ\\Off;", "ConfL\\Off;")
    frame_prefixes, flange_names = ("t_", "w_"), ("tool0", "wobj0")
    fault_forms = ("IDelete irFault;", "CONNECT irFault WITH on_fault;", "IError COMMON_ERR,TYPE_ERR,irFault;")
    stop_body = ("shut_valves;", 'TPWrite "Washboard: "+sText;', "EXIT;")
    fault_body = ("StopMove\\Quick;", "shut_valves;", 'TPWrite "Washboard: fault, valves shut";', "EXIT;")
    on_error = ("ERROR", "  shut_valves;", "  RAISE;")
    """What errors of routines without a handler of their own come to, at the end of main."""
    digital = "SetDO {name},{value};"
    group = "SetGO {name},{value};"
    analog = "SetAO {name},{value};"
    reserved = _RESERVED
    longest_name = 32
    longest_program_name = 26
    loop_begin = ("{counter}:=0;", "WHILE {condition} DO", "  {counter}:={counter}+1;")
    loop_end = ("ENDWHILE",)
    counted = "{counter}<{count}"
    sensed = "{counter}<{count} AND ({counter}=0 OR {reading}<{least})"
    reading = "{scale}*AInput({name})+{offset}"
    reading_digits = 6
    part_form = ("IF {start}<={number} {call}",)
    enter_begin = ("IF {start}={number} THEN", "  {start}:=1;")
    enter_end = ("ENDIF",)
    guard = ('IF CSpeedOverride()<>100 stop_job "speed override is not 100 percent";',)
    wait_contact, wait_sensor = under_each(
        ("{condition}\\MaxTime:={seconds}\\TimeFlag:=bLate;", 'IF bLate stop_job "{message}";'),
        "WaitDI {name},{state}",
        "WaitUntil {reading}>={least}",
    )
    watch = (
        "IDelete irWatch{index};",
        "CONNECT irWatch{index} WITH on_fault;",
        "ISignalDI {name},{other},irWatch{index};",
    )
    rise_forms = (
        "pStart:=CRobT(\\Tool:={tool}\\WObj:=wobj0);",
        "IF pStart.trans.z<{height} THEN",
        "  pStart.trans.z:={height};",
        f"  MoveL pStart,{REACH_SPEED},fine,{{tool}}\\WObj:=wobj0;",
        "ENDIF",
    )
    verb = "MoveL"
    """Of a motion in a line that switches nothing."""

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        super().__init__(dialect, lowered, installation)
        self.in_motions: set[str] = set()
        """Tools and work objects that motions name: one that is changed again before any is not declared."""
        self.speeds: dict[str, str] = {}
        self.triggers: dict[str, str] = {}
        """Name of each trigger by its definition; events that define the same share one."""

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Write ``MoveL``, or ``TriggL`` with up to eight triggers."""
        zone = "fine" if line.blend_mm == 0.0 else next(name for size, name in _ZONES if line.blend_mm >= size)
        names = [self.trigger(event) for event in line.events]
        yield fill(
            self.move,
            verb="TriggL" if names else self.verb,
            point=self.point(line.target),
            speed=self.speed(line),
            triggers="".join(
                [*(f",{name}" for name in names[:1]), *(f"\\T{n}:={name}" for n, name in enumerate(names[1:], 2))]
            ),
            zone=zone,
            **self.frames(),
        )

    def reach(self, reach: Reach) -> Iterator[str]:
        """Write ``MoveAbsJ`` and the line that is left, or ``MoveJ``."""
        self.speeds[REACH_SPEED] = "[100,500,5000,1000]"
        words = {**self.frames(), "speed": REACH_SPEED, "zone": "fine", "triggers": ""}
        if reach.joints:
            seconds = self.pace(reach).seconds  # of the whole motion, in place of a speed
            joints = self.joint_target(reach.joints)
            yield fill(self.to_joints, **words, joints=joints, lasting=seconds is not None, seconds=seconds)
        yield fill(self.move, **words, verb="MoveL" if reach.joints else "MoveJ", point=self.point(reach.target))

    def frames(self) -> dict[str, str]:
        """Name tool and work object in a motion."""
        self.in_motions |= {self.tool_name, self.board_name}
        return {"tool": self.tool_name, "board": self.board_name}

    def point(self, pose: Pose) -> str:
        """Declare a target."""
        self.points += 1
        self.data.append(f"LOCAL CONST robtarget p{self.points}:=[{_pose(pose)[1:-1]},[0,0,0,0],{_NO_AXES}];")
        return f"p{self.points}"

    def joint_target(self, joints: tuple[float, ...]) -> str:
        """Write joint values; up to six joints are the robot's, what follows are external axes."""
        values = self.joints(joints)
        robot = [*values[:6], *["0"] * (6 - len(values[:6]))]
        external = [*values[6:12], *["9E9"] * (6 - len(values[6:12]))]
        return f"[[{','.join(robot)}],[{','.join(external)}]]"

    def speed(self, line: Line) -> str:
        """Name the speed of a line: the TCP's, and the turn's where it decides."""
        turn = turn_limit(line)
        rate = "500" if turn is None else short(turn, 1)
        speed = "100" if line.turns_on_the_spot else short(line.speed_mm_s, 1)
        name = f"s{speed}_r{rate}".replace(".", "p").replace("_r500", "")
        self.speeds[name] = f"[{speed},{rate},5000,1000]"
        return name

    def trigger(self, event: Event) -> str:
        """Name the trigger of an event."""
        at_end = event.reference == "end" and abs(event.offset_mm) < 5e-4
        words = {"place": abs(event.offset_mm), "start": event.reference == "start", "lead": -event.offset_s}
        words |= {"kind": event.channel.kind[0].upper(), "name": event.channel.name, "value": event.value}
        definition = fill(self.trigger_forms[not at_end], trigger="{}", **words)
        return self.triggers.setdefault(definition, f"ev{len(self.triggers) + 1}")

    def prepare(self) -> Iterator[str]:
        """Leave the configuration to the joint targets, and define the triggers."""
        yield from super().prepare()
        yield "define_events;"

    def home(self) -> Iterator[str]:
        """Go to ``jHome``."""
        if self.installation.home:
            self.speeds[REACH_SPEED] = "[100,500,5000,1000]"
            yield fill(self.go_home, tool=self.first_tool() or "tool0")

    def begin_production(self) -> Iterator[str]:
        """Connect the fault routine too."""
        yield from super().begin_production()
        yield from self.fault_forms

    def setup(self) -> Iterator[str]:
        """State what the integrator has to set up."""
        yield f"event routine {self.shut_name} for Stop and QStop (Controller, Event Routine): a stop shuts no output"
        yield "the signals below in the I/O configuration; after a stop start from main (PP to Main)"
        yield "tooldata and wobjdata are in this module: compare them with yours, and identify the loads"

    def declarations(self) -> Iterator[str]:
        """Declare tools, work objects, speeds, triggers and counters."""
        named = self.in_motions | ({self.first_tool()} if self.rises or self.installation.home else set())
        for name, tool in ((name, tool) for name, tool in self.tools.items() if name in named):
            middle_mm = max(0.5 * tool.T_flange_tcp.position[2], 1.0)  # a centre of gravity at 0 is refused
            weight = f"[{short(tool.mass_kg, 3)},[0,0,{fixed(middle_mm, 1)}],[1,0,0,0],0,0,0]"
            yield f"PERS tooldata {name}:=[TRUE,{_pose(tool.T_flange_tcp)},{weight}];"
        for name, place in ((name, place) for name, place in self.boards.items() if name in named):
            yield f'PERS wobjdata {name}:=[FALSE,TRUE,"",{_pose(place)},[[0,0,0],[1,0,0,0]]];'
        if self.rises:
            yield f"VAR robtarget pStart:=[[0,0,0],[1,0,0,0],[0,0,0,0],{_NO_AXES}];"
        if self.installation.home:
            yield f"CONST jointtarget jHome:={self.joint_target(self.installation.home)};"
        yield from (f"CONST speeddata {name}:={value};" for name, value in self.speeds.items())
        yield from (f"VAR triggdata {name};" for name in self.triggers.values())
        yield from ("PERS num nStart:=1;", "VAR bool bLate:=FALSE;", "VAR intnum irFault;")
        watched = (index for index, wait in enumerate(self.installation.waits, start=1) if wait.watched)
        yield from (f"VAR intnum irWatch{index};" for index in watched)
        yield from (f"VAR num nLoop{number}:=0;" for number in self.loops)

    def faults(self) -> list[str]:
        """Write the routines that shut the valves: the one for all, and those for faults and for what is lacking."""
        stop = self.whole("stop_job", self.stop_body, takes_text=True)
        trap = ["TRAP on_fault", *indent(self.fault_body), "ENDTRAP", ""]
        return [*self.whole(self.shut_name, dict.fromkeys(self.shut())), *stop, *trap]

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write one module, or a module for each routine and a ``.pgf`` that lists them."""
        head = self.heading("Units: mm, s, mm/s, deg/s; targets in the board's CAD frame.")
        triggers = [definition.format(name) for definition, name in self.triggers.items()]
        data = [*head, *self.declarations(), ""]
        begin, *inside, end, after = self.whole("main", main.body)
        procedures = [
            begin,
            *inside,
            *self.on_error,
            end,
            after,
            *self.faults(),
            *self.whole("define_events", triggers),
        ]
        bodies = [self.whole(routine.name, routine.body) for routine in routines]
        if self.fits_one_file:
            targets = [line for routine in routines for line in routine.data]
            inside = [line for body in bodies for line in body]
            return {f"{self.name}.mod": _module(self.name, [*data, *targets, "", *procedures, *inside])}
        files = {f"{self.name}.mod": _module(self.name, [*data, *procedures])}
        for routine, body in zip(routines, bodies, strict=True):
            name = f"{self.name}_{routine.number:02d}"
            files[f"{name}.mod"] = _module(name, [*routine.data, "", *body])
        listed = "".join(f"  <Module>{file}</Module>\n" for file in files)
        listing = f'<?xml version="1.0" encoding="ISO-8859-1" ?>\n<Program>\n{listed}</Program>\n'
        return {f"{self.name}.pgf": listing, **files}


def _pose(pose: Pose) -> str:
    """Write a pose: position in mm, quaternion w, x, y, z."""
    position = ",".join(fixed(value, 3) for value in pose.position)
    return f"[[{position}],[{','.join(fixed(value, 7) for value in pose.quaternion)}]]"


def _module(name: str, lines: Iterable[str]) -> str:
    return join_lines([f"MODULE {name}", *indent(lines), "ENDMODULE"])


_DATA = re.compile(r"(?:LOCAL )?(?:CONST|PERS|VAR) (\w+) (\w+)(?::=(.*))?;")
_LIST = rf"{NUMBER}(?:,(?:{NUMBER}|9E9))*"
_ZONES_MM = {"z0": 0.3, "z1": 1.0, "z5": 5.0}
"""Radii of the predefined zones."""
_WHOLE_TURN_DEG_S = 500.0
"""Of lines that hardly turn."""
_POSE = rf"\[\[{N},{N},{N}\],\[{N},{N},{N},{N}\]\]"
_SHAPES = {
    "robtarget": rf"{_POSE[:-2]},\[0,0,0,0\],{re.escape(_NO_AXES)}\]",
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
            if name.endswith(".pgf") and re.findall(r"<Module>(.*)</Module>", text) != list(modules):
                raise ProgramError("the .pgf does not list the modules.", file=name)
        for name, text in modules.items():
            if not re.match(r"MODULE \w+\n", text) or not text.endswith("\nENDMODULE\n"):
                raise ProgramError("this is no whole module.", file=name)
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
        yield Rapid.fault_forms[1:], lambda values: self.connect("irFault")
        yield from (([form], skip) for form in (Rapid.fault_forms[0], "ENDIF"))
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
        self.triggers.add(values["trigger"], (place, "start" in values, lead, values["name"], value))

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
    notes="Modules for RobotWare 6 and 7; outputs by TriggEquip and TriggIO. Load the .pgf, or the one .mod. "
    "Identify the tools' loads before running.",
    capability=Capability(
        controller_class=1,
        timing="distance and time",
        cycle_s=0.002,
        most_events=8,  # TriggL takes Trigg_1 and \T2 to \T8
        longest_lead_s=0.5,  # assumed: what TriggIO \Time and EquipLag take without a change of Event Preset Time
        step_mm_s=0.1,
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
