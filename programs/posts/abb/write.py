"""ABB RAPID: outputs on the path by ``TriggL``, timed by the controller itself."""

from collections.abc import Iterable, Iterator, Sequence

from programs.motion.installation import Installation
from programs.motion.lower import Lowered
from programs.motion.steps import Event, Line, Reach, UseBoard, UseTool
from programs.pose import Pose
from programs.posts.dialect import Dialect, ProgramFiles
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.lines import Placed, turn_limit
from programs.posts.writing.wording import fixed, indent, join_lines, short

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
    pause_form = "WaitTime {seconds};"
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
    wait_contact = ("WaitDI {name},{state}\\MaxTime:={seconds}\\TimeFlag:=bLate;", 'IF bLate stop_job "{message}";')
    wait_sensor = (
        "WaitUntil {reading}>={least}\\MaxTime:={seconds}\\TimeFlag:=bLate;",
        'IF bLate stop_job "{message}";',
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
    move = "MoveL"
    """A motion in a line that switches nothing."""

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        super().__init__(dialect, lowered, installation)
        self.tool, self.board = "tool0", "wobj0"
        self.in_motions: set[str] = set()
        """Tools and work objects that motions name: one that is changed again before any is not declared."""
        self.speeds: dict[str, str] = {}
        self.triggers: dict[str, str] = {}
        """Name of each trigger by its definition; events that define the same share one."""

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Write ``MoveL``, or ``TriggL`` with up to eight triggers."""
        zone = "fine" if line.blend_mm == 0.0 else next(name for size, name in _ZONES if line.blend_mm >= size)
        way = f"{self.point(line.target)},{self.speed(line)}"
        triggers = [self.trigger(event) for event in line.events]
        marks = [f"\\T{n}:={trigger}" for n, trigger in enumerate(triggers[1:], start=2)]
        switched = "".join([f",{trigger}" for trigger in triggers[:1]] + marks)
        yield f"{'TriggL' if triggers else self.move} {way}{switched},{zone},{self.frames()};"

    def reach(self, reach: Reach) -> Iterator[str]:
        """Write ``MoveAbsJ`` and the line that is left, or ``MoveJ``."""
        frames = f"fine,{self.frames()};"
        self.speeds[REACH_SPEED] = "[100,500,5000,1000]"
        if reach.joints:
            seconds = self.pace(reach).seconds  # of the whole motion, in place of a speed
            lasting = "" if seconds is None else f"\\T:={fixed(seconds, 3)}"
            yield f"MoveAbsJ {self.joint_target(reach.joints)}\\NoEOffs,{REACH_SPEED}{lasting},{frames}"
        yield f"{'MoveL' if reach.joints else 'MoveJ'} {self.point(reach.target)},{REACH_SPEED},{frames}"

    def frames(self) -> str:
        """Name tool and work object in a motion."""
        self.in_motions |= {self.tool, self.board}
        return f"{self.tool}\\WObj:={self.board}"

    def use(self, step: UseTool | UseBoard) -> Iterable[str]:
        """Name tool and work object of the motions that follow."""
        name = self.frame_name(step, "t_", "w_")
        if isinstance(step, UseTool):
            self.tool = name
        else:
            self.board = name
        return ()

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
        lead, kind = fixed(-event.offset_s, 3), event.channel.kind[0].upper()
        output = f"\\{kind}Op:={event.channel.name},{short(event.value, 6)}"
        if event.reference == "end" and abs(event.offset_mm) < 5e-4:
            definition = f"TriggIO {{}},{lead}\\Time{output};"
        else:
            start = "\\Start" if event.reference == "start" else ""
            definition = f"TriggEquip {{}},{fixed(abs(event.offset_mm), 3)}{start},{lead}{output};"
        return self.triggers.setdefault(definition, f"ev{len(self.triggers) + 1}")

    def prepare(self) -> Iterable[str]:
        """Leave the configuration to the joint targets, and define the triggers."""
        return ("ConfJ\\Off;", "ConfL\\Off;", "define_events;")

    def home(self) -> Iterator[str]:
        """Go to ``jHome``."""
        if self.installation.home:
            self.speeds[REACH_SPEED] = "[100,500,5000,1000]"
            yield f"MoveAbsJ jHome\\NoEOffs,{REACH_SPEED},fine,{self.first_tool() or 'tool0'};"

    def begin_production(self) -> Iterator[str]:
        """Connect the fault routine too."""
        yield from super().begin_production()
        yield from ("IDelete irFault;", "CONNECT irFault WITH on_fault;", "IError COMMON_ERR,TYPE_ERR,irFault;")

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
        shut = _procedure(self.shut_name, dict.fromkeys(self.shut()))
        stop = [f"{self.shut_name};", 'TPWrite "Washboard: "+sText;', "EXIT;"]
        trap = ["StopMove\\Quick;", f"{self.shut_name};", 'TPWrite "Washboard: fault, valves shut";', "EXIT;"]
        trapped = ["TRAP on_fault", *indent(trap), "ENDTRAP", ""]
        return [*shut, "PROC stop_job(string sText)", *indent(stop), "ENDPROC", "", *trapped]

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write one module, or a module for each routine and a ``.pgf`` that lists them."""
        head = self.heading("Units: mm, s, mm/s, deg/s; targets in the board's CAD frame.")
        triggers = [definition.format(name) for definition, name in self.triggers.items()]
        data = [*head, *self.declarations(), ""]
        procedures = [*_main(main.body), *self.faults()]
        procedures += _procedure("define_events", triggers)
        bodies = [_procedure(routine.name, routine.body) for routine in routines]
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


def _procedure(name: str, body: Iterable[str]) -> list[str]:
    return [f"PROC {name}()", *indent(body), "ENDPROC", ""]


def _main(body: Iterable[str]) -> list[str]:
    """Write main; errors of routines without a handler of their own come to its handler."""
    return ["PROC main()", *indent(body), "ERROR", *indent(["shut_valves;", "RAISE;"]), "ENDPROC", ""]


def _module(name: str, lines: Iterable[str]) -> str:
    return join_lines([f"MODULE {name}", *indent(lines), "ENDMODULE"])
