"""ABB RAPID: outputs on the path by ``TriggL``, timed by the controller itself."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from programs.motion.installation import Channel, Installation, Tool
from programs.motion.lower import Capability, Lowered
from programs.motion.steps_of_robot import (
    Call,
    EndRepeat,
    Event,
    Line,
    Note,
    Pause,
    Reach,
    Repeat,
    Step,
    Switch,
    UseBoard,
    UseTool,
)
from programs.pose import Pose
from programs.posts.abb.data import NO_AXES, RESERVED, jointtarget, pose_data
from programs.posts.writing.chapters import Begin, Chapter, End, Part, divide, nest
from programs.posts.writing.heading import heading
from programs.posts.writing.routines import Names, tell_steps, turn_limit
from programs.posts.writing.wording import cut, fixed, make_name, short

TITLE = "ABB RAPID"
NOTES = (
    "Modules for RobotWare 6 and 7; outputs by TriggEquip and TriggIO. Load the .pgf, or the one .mod. "
    "Identify the tools' loads before running."
)
LONGEST_LINE = 200
CAPABILITY = Capability(
    controller_class=1,
    says="distance and time",
    cycle_s=0.002,
    most_events=8,  # TriggL takes Trigg_1 and \T2 to \T8
    longest_lead_s=0.5,  # assumed: what TriggIO \Time and EquipLag take without a change of Event Preset Time
    step_mm_s=0.1,
)
MOST_STEPS = 2000
"""Of a module: with a target and an instruction for each line, below 5,000 lines. Assumed; nobody states a limit."""
_LONGEST_NAME = 32
_ZONES = ((5.0, "z5"), (1.0, "z1"), (0.0, "z0"))
"""Predefined zones by their radius; z0 is 0.3 mm, and the controller shrinks a zone that has no room."""
_REACH_SPEED = "s100"


@dataclass(frozen=True, slots=True)
class Words:
    """What the RAPID of another option says in another way."""

    title: str
    capability: Capability
    move: str
    """A motion in a line that switches nothing."""
    set_output: Callable[[Channel, float], str]
    """Change an output, in program order."""
    data: tuple[str, ...] = ()
    """More declarations."""


def render(lowered: Lowered, installation: Installation) -> dict[str, str]:
    """Write a program: one module, or a module for each part and a ``.pgf`` that lists them."""
    return render_with(lowered, installation, Words(TITLE, CAPABILITY, "MoveL", set_output))


def render_with(lowered: Lowered, installation: Installation, words: Words) -> dict[str, str]:
    """Write a program in the words of an option."""
    parts = divide(lowered.motion, MOST_STEPS)
    chapters = [part for part in parts if isinstance(part, Chapter)]
    name = make_name(lowered.motion.origin.board, _LONGEST_NAME - 6, RESERVED)
    writer = _Writer(installation, words, Names(_LONGEST_NAME, {name.lower(), *RESERVED}))
    writer.names.reserve_calls(lowered.motion)
    routines = {chapter.number: _routine(writer, chapter) for chapter in chapters}
    main = _main(writer, parts)
    head = [
        f"! {cut(line, LONGEST_LINE - 4)}" for line in heading(lowered, installation, words.capability, words.title)
    ]
    data = [*head, "! Units: mm, s, mm/s, deg/s; targets in the board's CAD frame.", *_data(writer), *words.data, ""]
    if sum(len(chapter.steps) for chapter in chapters) <= MOST_STEPS:
        targets = [line for number in routines for line in routines[number][0]]
        bodies = [line for number in routines for line in routines[number][1]]
        return {f"{name}.mod": _module(name, [*data, *targets, "", *main, *bodies])}
    files = {f"{name}.mod": _module(name, [*data, *main])}
    for number, (targets, body) in routines.items():
        files[f"{name}_{number:02d}.mod"] = _module(f"{name}_{number:02d}", [*targets, "", *body])
    listed = "".join(f"  <Module>{file}</Module>\n" for file in files)
    listing = f'<?xml version="1.0" encoding="ISO-8859-1" ?>\n<Program>\n{listed}</Program>\n'
    return {f"{name}.pgf": listing, **files}


@dataclass(slots=True)
class _Writer:
    """The names given so far, and the tool and board in use."""

    installation: Installation
    words: Words
    names: Names
    speeds: dict[str, str] = field(default_factory=dict[str, str])
    events: dict[str, str] = field(default_factory=dict[str, str])
    tools: dict[str, Tool] = field(default_factory=dict[str, Tool])
    boards: dict[str, Pose] = field(default_factory=dict[str, Pose])
    tool: str = "tool0"
    board: str = "wobj0"
    targets: list[str] = field(default_factory=list[str])
    target_count: int = 0
    loops: int = 0

    def use(self, step: UseTool | UseBoard) -> None:
        """Use another tool or board from now on."""
        if isinstance(step, UseTool):
            tool = self.installation.tool(step.number)
            self.tool = self.names.give("tool", step.number, f"t_{tool.name}")
            self.tools[self.tool] = tool
        else:
            self.board = self.names.give("board", step.placement, f"w_{step.placement or 'board'}")
            self.boards[self.board] = step.T_base_board

    @property
    def frames(self) -> str:
        """Tool and work object of a motion."""
        return f"{self.tool}\\WObj:={self.board}"

    def target(self, pose: Pose) -> str:
        """Name a target."""
        self.target_count += 1
        name = f"p{self.target_count}"
        self.targets.append(f"LOCAL CONST robtarget {name}:=[{pose_data(pose)[1:-1]},[0,0,0,0],{NO_AXES}];")
        return name

    def speed(self, line: Line) -> str:
        """Name the speed of a line: the TCP's, and the turn's where it decides."""
        turn = turn_limit(line)
        rate = "500" if turn is None else short(turn, 1)
        speed = "100" if line.turns_on_the_spot else short(line.speed_mm_s, 1)
        name = f"s{speed}_r{rate}".replace(".", "p").replace("_r500", "")
        self.speeds[name] = f"[{speed},{rate},5000,1000]"
        return name

    def event(self, event: Event) -> str:
        """Name the trigger of an event; events that say the same share one."""
        lead = fixed(-event.offset_s, 3)
        output = f"{_OUTPUTS[event.channel.kind]}:={event.channel.name},{short(event.value, 6)}"
        if event.reference == "end" and abs(event.offset_mm) < 5e-4:
            said = f"TriggIO {{}},{lead}\\Time{output};"
        else:
            start = "\\Start" if event.reference == "start" else ""
            said = f"TriggEquip {{}},{fixed(abs(event.offset_mm), 3)}{start},{lead}{output};"
        return self.events.setdefault(said, f"ev{len(self.events) + 1}")


_OUTPUTS = {"digital": "\\DOp", "group": "\\GOp", "analog": "\\AOp"}
_SETTERS = {"digital": "SetDO", "group": "SetGO", "analog": "SetAO"}


def _routine(writer: _Writer, chapter: Chapter) -> tuple[list[str], list[str]]:
    """Targets and instructions of a chapter."""
    writer.targets = []
    body = tell_steps(chapter.steps, lambda maker: f"! {cut(maker, 100)}", lambda step: _instructions(writer, step))
    name = _routine_name(writer, chapter)
    return writer.targets, [f"PROC {name}()", *(f"  {line}" for line in body), "ENDPROC", ""]


def _routine_name(writer: _Writer, chapter: Chapter) -> str:
    return writer.names.give("routine", chapter.number, f"{make_name(chapter.title, 20)}_{chapter.number:02d}")


def _instructions(writer: _Writer, step: Step) -> Iterable[str]:
    """Write one step."""
    match step:
        case Line():
            zone = "fine" if step.blend_mm == 0.0 else next(name for size, name in _ZONES if step.blend_mm >= size)
            ways = [writer.target(step.target), writer.speed(step)]
            triggers = [writer.event(event) for event in step.events]
            named = [f"\\T{n}:={trigger}" for n, trigger in enumerate(triggers[1:], start=2)]
            move = "TriggL" if triggers else writer.words.move
            first = "".join([f",{trigger}" for trigger in triggers[:1]] + named)
            yield f"{move} {','.join(ways)}{first},{zone},{writer.frames};"
        case Reach():
            writer.speeds[_REACH_SPEED] = "[100,500,5000,1000]"
            if step.joints:
                joints = jointtarget(step.joints, writer.installation)
                yield f"MoveAbsJ {joints}\\NoEOffs,{_REACH_SPEED},fine,{writer.frames};"
            move = "MoveL" if step.joints else "MoveJ"
            yield f"{move} {writer.target(step.target)},{_REACH_SPEED},fine,{writer.frames};"
        case Pause():
            yield f"WaitTime {fixed(step.duration_s, 3)};"
        case Switch():
            yield writer.words.set_output(step.channel, step.value)
        case UseTool() | UseBoard():
            writer.use(step)
        case Call():
            yield f"{writer.names.give('call', step.name, step.name)};"
        case Note():
            yield f"! {cut(step.text, 100)}"
        case Repeat() | EndRepeat():
            raise AssertionError("loops are in main")


def set_output(channel: Channel, value: float) -> str:
    """Change an output when the robot comes to the instruction."""
    return f"{_SETTERS[channel.kind]} {channel.name},{short(value, 6)};"


def _main(writer: _Writer, parts: tuple[Part, ...]) -> list[str]:
    """Write main, and the routine that defines the events."""
    home = _home(writer)
    body = ["ConfJ\\Off;", "ConfL\\Off;", "define_events;", *home]
    for indent, part in nest(parts):
        match part:
            case Chapter():
                body.append(f"{indent}{_routine_name(writer, part)};")
            case Begin(number, loop):
                writer.loops = number
                body += [f"{indent}{line}" for line in _loop(loop, f"nLoop{number}")]
            case End():
                body.append(f"{indent}ENDWHILE")
    events = [said.format(name) for said, name in writer.events.items()]
    return [
        "PROC main()",
        *(f"  {line}" for line in [*body, *home]),
        "ENDPROC",
        "",
        "PROC define_events()",
        *(f"  {line}" for line in events),
        "ENDPROC",
        "",
    ]


def _home(writer: _Writer) -> list[str]:
    if not writer.installation.home:
        return []
    writer.speeds[_REACH_SPEED] = "[100,500,5000,1000]"
    tool = next(iter(writer.tools), "tool0")
    return [f"MoveAbsJ jHome\\NoEOffs,{_REACH_SPEED},fine,{tool};"]


def _loop(step: Repeat, counter: str) -> list[str]:
    looks = ""
    if step.sensor is not None:
        reading = f"{short(step.sensor.scale, 6)}*AInput({step.sensor.name})+{short(step.sensor.offset, 6)}"
        looks = f" AND ({counter}=0 OR {reading}<{short(step.least, 6)})"
    return [
        f"! until {cut(step.key, 40)} >= {short(step.least, 6)}, {step.count} times at most",
        f"{counter}:=0;",
        f"WHILE {counter}<{step.count}{looks} DO",
        f"  {counter}:={counter}+1;",
    ]


def _data(writer: _Writer) -> list[str]:
    """Declare tools, work objects, speeds, triggers and counters."""
    lines: list[str] = []
    for name, tool in writer.tools.items():
        middle_mm = max(0.5 * tool.T_flange_tcp.position[2], 1.0)  # a centre of gravity at 0 is refused
        weight = f"[{short(tool.mass_kg, 3)},[0,0,{fixed(middle_mm, 1)}],[1,0,0,0],0,0,0]"
        lines.append(f"PERS tooldata {name}:=[TRUE,{pose_data(tool.T_flange_tcp)},{weight}];")
    for name, place in writer.boards.items():
        lines.append(f'PERS wobjdata {name}:=[FALSE,TRUE,"",{pose_data(place)},[[0,0,0],[1,0,0,0]]];')
    if writer.installation.home:
        lines.append(f"CONST jointtarget jHome:={jointtarget(writer.installation.home, writer.installation)};")
    lines += [f"CONST speeddata {name}:={value};" for name, value in writer.speeds.items()]
    lines += [f"VAR triggdata {name};" for name in writer.events.values()]
    lines += [f"VAR num nLoop{number}:=0;" for number in range(1, writer.loops + 1)]
    return lines


def _module(name: str, lines: list[str]) -> str:
    inside = "".join(f"  {line}\n" if line else "\n" for line in lines)
    return f"MODULE {name}\n{inside}ENDMODULE\n"
