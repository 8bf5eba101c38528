"""KUKA KRL: outputs on the path by ``TRIGGER``, timed by the controller itself."""

from collections.abc import Iterable
from dataclasses import dataclass, field

from programs.motion.installation import Installation, Tool
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
from programs.posts.kuka.text import ANALOG, assign, axes, data_list, frame, operand, source
from programs.posts.writing.chapters import Begin, Chapter, End, Part, divide, nest
from programs.posts.writing.heading import heading
from programs.posts.writing.routines import Names, tell_steps, turn_limit
from programs.posts.writing.wording import cut, fixed, make_name, short

TITLE = "KUKA KRL"
NOTES = (
    "A .src and a .dat for KSS 8; outputs by TRIGGER WHEN PATH. Groups are SIGNALs of $config.dat, $ANOUT counts from "
    "-1 to 1. LIN keeps the configuration of the first PTP."
)
LONGEST_LINE = 200
CAPABILITY = Capability(
    controller_class=1,
    says="distance and time",
    cycle_s=0.004,  # assumed: the interpolation cycle of a KR C4; integrators report 1 ms for triggers
    references=("end",),  # PATH counts from the end point; ONSTART needs a newer KSS
    step_mm=0.01,
    step_mm_s=0.1,
    most_events=8,  # integrators report eight triggers at work at once
    analog=ANALOG,
)
MOST_STEPS = 1500
"""Of a module: about 4,500 lines of .src. Assumed; nobody states a limit."""
_LONGEST_NAME = 24
"""Of a module or a variable in KSS 8."""
_PTP_PERCENT = 10
_ORI_DEG_S = 200.0
_RESERVED = {"home", "main", "end", "def", "loop", "tool", "base", "frame", "load", "signal", "path", "trigger"}


def render(lowered: Lowered, installation: Installation) -> dict[str, str]:
    """Write a program: one module, or a module for each part and one that calls them."""
    parts = divide(lowered.motion, MOST_STEPS)
    chapters = [part for part in parts if isinstance(part, Chapter)]
    name = make_name(lowered.motion.origin.board, _LONGEST_NAME - 5, _RESERVED)
    writer = _Writer(installation, name, Names(_LONGEST_NAME, {name.lower(), *_RESERVED}))
    writer.names.reserve_calls(lowered.motion)
    routines = [_routine(writer, chapter) for chapter in chapters]
    main = _main(writer, parts)
    head = [f"; {cut(line, LONGEST_LINE - 4)}" for line in heading(lowered, installation, CAPABILITY, TITLE)]
    head.append("; Units: mm, degrees (A, B, C about z, y', x''), m/s, ms; points in the board's CAD frame.")
    if sum(len(chapter.steps) for chapter in chapters) <= MOST_STEPS:
        points = [line for routine in routines for line in routine.points]
        bodies = [line for routine in routines for line in ["", f"DEF {routine.name}( )", *routine.body, "END"]]
        return {
            f"{name}.src": source(name, [*head, *main], bodies),
            f"{name}.dat": data_list(name, [*_data(writer), *points]),
        }
    files = {f"{name}.src": source(name, [*head, *main], []), f"{name}.dat": data_list(name, _data(writer))}
    for routine in routines:
        files[f"{routine.name}.src"] = source(routine.name, routine.body, [])
        files[f"{routine.name}.dat"] = data_list(routine.name, routine.points)
    return files


@dataclass(frozen=True, slots=True)
class _Routine:
    """A chapter as KRL: its points are declared in a data list."""

    name: str
    points: list[str]
    body: list[str]


@dataclass(slots=True)
class _Writer:
    """The names given so far, and what holds at the end of what is written."""

    installation: Installation
    program: str
    names: Names
    tools: dict[str, Tool] = field(default_factory=dict[str, Tool])
    boards: dict[str, Pose] = field(default_factory=dict[str, Pose])
    settings: dict[str, str] = field(default_factory=dict[str, str])
    points: list[str] = field(default_factory=list[str])
    point_count: int = 0
    loops: int = 0

    def use(self, step: UseTool | UseBoard) -> list[str]:
        """Use another tool or board from now on. The names are global, so they begin with the program's."""
        prefix = self.program[:10]
        if isinstance(step, UseTool):
            tool = self.installation.tool(step.number)
            name = self.names.give("tool", step.number, f"{prefix}_t_{tool.name}")
            self.tools[name] = tool
            return [f"$TOOL={name}", f"$LOAD={self.names.give('load', step.number, f'{prefix}_l_{tool.name}')}"]
        name = self.names.give("board", step.placement, f"{prefix}_b_{step.placement or 'board'}")
        self.boards[name] = step.T_base_board
        return [f"$BASE=$ROBROOT:{name}"]

    def point(self, pose: Pose) -> str:
        """Name a point."""
        self.point_count += 1
        self.points.append(f"DECL FRAME P{self.point_count}={frame(pose)}")
        return f"P{self.point_count}"

    def set(self, variable: str, value: str) -> list[str]:
        """Set a system variable if it has another value."""
        if self.settings.get(variable) == value:
            return []
        self.settings[variable] = value
        return [f"{variable}={value}"]


def _routine(writer: _Writer, chapter: Chapter) -> _Routine:
    """Points and instructions of a chapter; it sets what it needs, so that it runs alone."""
    writer.points, writer.settings = [], {}
    body: list[str] = []
    for step in (chapter.board, chapter.tool):
        body += writer.use(step) if step is not None else []
    body += tell_steps(chapter.steps, lambda maker: f"; {cut(maker, 100)}", lambda step: _instructions(writer, step))
    return _Routine(_routine_name(writer, chapter), writer.points, body)


def _routine_name(writer: _Writer, chapter: Chapter) -> str:
    wanted = f"{make_name(f'{writer.program}_{chapter.title}', _LONGEST_NAME - 6)}_{chapter.number:02d}"
    return writer.names.give("routine", chapter.number, wanted)


def _instructions(writer: _Writer, step: Step) -> Iterable[str]:
    """Write one step."""
    match step:
        case Line():
            yield from _speeds(writer, step)
            yield from (_trigger(step, event) for event in step.events)
            if step.blend_mm > 0.0:
                yield from writer.set("$APO.CDIS", short(step.blend_mm, 3))
            yield f"LIN {writer.point(step.target)}{' C_DIS' if step.blend_mm > 0.0 else ''}"
        case Reach():
            yield from _reach(writer, step)
        case Pause():
            yield f"WAIT SEC {fixed(step.duration_s, 3)}"
        case Switch():
            yield assign(step.channel, step.value)
        case UseTool() | UseBoard():
            yield from writer.use(step)
        case Call():
            yield f"{writer.names.give('call', step.name, step.name)}( )"
        case Note():
            yield f"; {cut(step.text, 100)}"
        case Repeat() | EndRepeat():
            raise AssertionError("loops are in main")


def _reach(writer: _Writer, step: Reach) -> Iterable[str]:
    if not step.joints:
        yield f"PTP {writer.point(step.target)}"
        return
    yield f"PTP {axes(step.joints, writer.installation)}"
    yield from writer.set("$VEL.CP", "0.1")
    yield f"LIN {writer.point(step.target)}"


def _speeds(writer: _Writer, line: Line) -> Iterable[str]:
    """Set the speed of the TCP in m/s, and that of the turn in degrees/s, each where it matters."""
    if not line.turns_on_the_spot:
        yield from writer.set("$VEL.CP", short(line.speed_mm_s / 1000.0, 6))
    turn = turn_limit(line)
    rate = _ORI_DEG_S if turn is None else turn
    yield from writer.set("$VEL.ORI1", short(rate, 1))
    yield from writer.set("$VEL.ORI2", short(rate, 1))


def _trigger(line: Line, event: Event) -> str:
    """Say when an output changes: so many mm from the end of the next motion, so many ms from there."""
    place = "DISTANCE=1" if line.turns_on_the_spot else f"PATH={fixed(event.offset_mm, 2)}"
    delay = round(1000.0 * event.offset_s)
    return f"TRIGGER WHEN {place} DELAY={delay} DO {assign(event.channel, event.value)}"


def _main(writer: _Writer, parts: tuple[Part, ...]) -> list[str]:
    """Write what the main routine does."""
    body = [
        "; the controller's own defaults; a slow PTP",
        "BAS(#INITMOV,0)",
        f"BAS(#VEL_PTP,{_PTP_PERCENT})",
        "$ORI_TYPE=#VAR",
        "PTP HOME_POSITION" if writer.installation.home else "PTP $AXIS_ACT",
    ]
    for indent, part in nest(parts):
        match part:
            case Chapter():
                body.append(f"{indent}{_routine_name(writer, part)}( )")
            case Begin(number, loop):
                writer.loops = number
                body += [f"{indent}{line}" for line in _loop(loop, f"nLoop{number}")]
            case End(number, loop):
                body.append(f"{indent}{_until(loop, f'nLoop{number}')}")
    return [*body, *(["PTP HOME_POSITION"] if writer.installation.home else [])]


def _loop(step: Repeat, counter: str) -> list[str]:
    words = f"; until {cut(step.key, 40)} >= {short(step.least, 6)}, {step.count} times at most"
    return [words, f"{counter}=0", "REPEAT", f"  {counter}={counter}+1"]


def _until(step: Repeat, counter: str) -> str:
    if step.sensor is None:
        return f"UNTIL {counter}>={step.count}"
    scale, offset = ANALOG.reading(step.sensor)
    reading = f"{operand(scale, 9)}*$ANIN[{step.sensor.number}]+{operand(offset, 9)}"
    return f"UNTIL ({counter}>={step.count}) OR ({reading}>={operand(step.least)})"


def _data(writer: _Writer) -> list[str]:
    """Declare tools, loads, boards, home and counters."""
    lines: list[str] = []
    for name, tool in writer.tools.items():
        number = next(key for (kind, key), each in writer.names.given.items() if kind == "tool" and each == name)
        middle = fixed(0.5 * tool.T_flange_tcp.position[2], 1)
        inertia = "J {X 0.0,Y 0.0,Z 0.0}"
        weight = f"{{M {fixed(tool.mass_kg, 3)},CM {{X 0.0,Y 0.0,Z {middle},A 0.0,B 0.0,C 0.0}},{inertia}}}"
        lines.append(f"DECL GLOBAL FRAME {name}={frame(tool.T_flange_tcp)}")
        lines.append(f"DECL GLOBAL LOAD {writer.names.given['load', number]}={weight}")
    lines += [f"DECL GLOBAL FRAME {name}={frame(place)}" for name, place in writer.boards.items()]
    if writer.installation.home:
        lines.append(f"DECL E6AXIS HOME_POSITION={axes(writer.installation.home, writer.installation)}")
    return [*lines, *(f"DECL INT nLoop{number}=0" for number in range(1, writer.loops + 1))]
