"""ABB RAPID: outputs on the path by ``TriggL``, timed by the controller itself."""

from collections.abc import Iterable, Iterator, Sequence

from programs.motion.installation import Installation
from programs.motion.lower import Lowered
from programs.motion.steps import Event, Line, Reach
from programs.pose import Pose
from programs.posts.dialect import Dialect, ProgramFiles, Task
from programs.posts.writing.chapters import Placed, turn_limit
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.forms import fill, fixed, short
from programs.posts.writing.frame import under_each
from programs.posts.writing.vocabulary import RAPID
from programs.posts.writing.wording import indent, join_lines

NO_AXES = "[9E9,9E9,9E9,9E9,9E9,9E9]"
_ZONES = ((5.0, "z5"), (1.0, "z1"), (0.0, "z0"))
"""Predefined zones by their radius; z0 is 0.3 mm, and the controller shrinks a zone that has no room."""
REACH_SPEED = "s100"


class Rapid(Syntax):
    """RAPID: modules of targets and procedures."""

    mark = "! "
    call_form = "{routine};"
    shared = "main, its routines and data have the same names: one program is loaded at a time"
    pause_form = "WaitTime {seconds:3};"
    mount_forms = ('TPWrite "Washboard: {mount}";', "Stop;")
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
    stop_body = ("{fault}", "shut_valves;", 'TPWrite "Washboard: "+sText;', "EXIT;")
    fault_body = ("{fault}", "StopMove\\Quick;", "shut_valves;", 'TPWrite "Washboard: fault, valves shut";', "EXIT;")
    on_error = ("ERROR", "  shut_valves;", "  RAISE;")
    """What errors of routines without a handler of their own come to, at the end of main."""
    digital = "SetDO {name},{value};"
    group = "SetGO {name},{value};"
    analog = "SetAO {name},{value};"
    address_forms = ("DO {name}", "GO {name}", "AO {name}")
    contact_form, sensor_form = "DI {name}", "AI {name}"
    angles = ("q1 q2 q3 q4", "the quaternion", tuple[float, ...])
    vocabulary, named_channels = RAPID, frozenset({"digital", "group", "analog", "input", "sensor"})
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
    end_watch, last = ("IDelete irWatch{index};",), ("IDelete irFault;",)
    await_contact = ("WaitDI {name},{state};",)
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
        self.data.append(f"LOCAL CONST robtarget p{self.points}:=[{_pose(pose)[1:-1]},[0,0,0,0],{NO_AXES}];")
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

    def setup(self) -> Iterator[Task]:
        """State what the integrator has to set up."""
        hooks = (f'      -Routine "{self.shut_name}" -Shelf "{shelf}" -Task "T_ROB1"' for shelf in ("STOP", "QSTOP"))
        text = f"event routine {self.shut_name} for Stop and QStop (Controller, Event Routine): a stop shuts no output"
        yield Task(text, ("# SYS.cfg", "CAB_EXEC_HOOKS:", *hooks))
        kinds = ((each.address.split()[0], each.name) for each in self.signal_table())
        lines = (f'      -Name "{name}" -SignalType "{kind}" -Device "YOURS" -DeviceMap "0"' for kind, name in kinds)
        yield Task("the signals below in the I/O configuration, on your devices", ("# EIO.cfg", "EIO_SIGNAL:", *lines))
        if not all(self.installation.tool(number).payload.is_stated for number in self.slots.tools):
            yield Task("identify the loads of the tools: 1 kg stands where the cell states none")

    def remarks(self) -> Iterator[str]:
        """State what has to hold when the program is started."""
        yield "After a stop start from main (PP to Main)"
        yield "tooldata and wobjdata are in this module: compare them with yours"

    def declarations(self) -> Iterator[str]:
        """Declare tools, work objects, speeds, triggers and counters."""
        named = self.in_motions | ({self.first_tool()} if self.rises or self.installation.home else set())
        for name, tool in ((name, tool) for name, tool in self.tools.items() if name in named):
            load, (x, y, z) = tool.payload, tool.centre_mm
            middle = f"{short(x, 1)},{short(y, 1)},{fixed(z if x or y else max(z, 1.0), 1)}"  # none at 0 is taken
            inertia = ",".join(short(value, 6) for value in load.inertia_kg_m2)
            weight = f"[{short(load.mass_kg, 3)},[{middle}],[1,0,0,0],{inertia}]"
            yield f"PERS tooldata {name}:=[TRUE,{_pose(tool.T_flange_tcp)},{weight}];"
        for name, place in ((name, place) for name, place in self.boards.items() if name in named):
            yield f'PERS wobjdata {name}:=[FALSE,TRUE,"",{_pose(place)},[[0,0,0],[1,0,0,0]]];'
        if self.rises:
            yield f"VAR robtarget pStart:=[[0,0,0],[1,0,0,0],[0,0,0,0],{NO_AXES}];"
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
        stop = self.whole("stop_job", self.with_fault(self.stop_body), takes_text=True)
        trap = ["TRAP on_fault", *indent(self.with_fault(self.fault_body)), "ENDTRAP", ""]
        return [*self.whole(self.shut_name, dict.fromkeys(self.shut())), *stop, *trap]

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write one module, or a module for each routine and a ``.pgf`` that lists them."""
        head = self.heading(f"Units: mm, s, mm/s, deg/s; targets in {self.cad_frame}.")
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
