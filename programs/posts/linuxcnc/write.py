"""G-code for LinuxCNC: a gantry's axes from its joint motion, outputs in step with the motion by ``M62`` to ``M67``.

The machine has trivial kinematics: each axis is a joint. The orifice follows its line because blocks are short enough,
and keeps its speed because a block takes the time that the orifice needs: where only X, Y and Z move that is ``F`` in
mm/min, else inverse time (``G93``), whatever the turning axes do to the length of the way.
"""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from programs.errors import ProgramError
from programs.motion.installation import Channel, Installation
from programs.motion.lower import Capability, Lowered
from programs.motion.steps_of_robot import (
    Call,
    EndRepeat,
    Line,
    MotionProgram,
    Note,
    Pause,
    Reach,
    Repeat,
    Step,
    Switch,
    UseBoard,
    UseTool,
)
from programs.posts.linuxcnc.axes import AxisWriter, Machine, make_machine
from programs.posts.writing.chapters import Begin, Chapter, End, Part, divide, nest
from programs.posts.writing.heading import heading
from programs.posts.writing.routines import Names, channels_of, tell_steps
from programs.posts.writing.wording import cut, fixed, make_name, short

TITLE = "LinuxCNC G-code"
NOTES = (
    "For machines with trivial kinematics such as gantries: joint values are the axes, so the tools' offsets are in "
    "them (G49), and G54 is the board's origin. The header lists the outputs to wire; num_dio and num_aio may be few."
)
LONGEST_LINE = 200
"""The interpreter takes 255 characters (LINELEN)."""
CAPABILITY = Capability(
    controller_class=3,
    says="boundary",
    cycle_s=0.001,  # the servo thread of the sample configurations
    step_mm_s=0.1 / 60.0,
)
MOST_STEPS = 5000
"""Of a subroutine. Assumed, for previews and editors: the interpreter itself reads from disk, line by line."""
GROUP_BASE = 32
"""Groups are whole numbers on the analog outputs from this one on: LinuxCNC has no groups."""
_MOST_OUTPUTS = 64
_NAME = 40


def render(lowered: Lowered, installation: Installation) -> dict[str, str]:
    """Write a program: one file, or a file for each subroutine and one that calls them.

    Raises:
        ProgramError: the joint motion is not known, or there are more axes, boards or outputs than LinuxCNC has.
    """
    parts = divide(lowered.motion, MOST_STEPS)
    chapters = [part for part in parts if isinstance(part, Chapter)]
    name = make_name(lowered.motion.origin.board, _NAME).lower()
    writer = _Writer(make_machine(lowered.motion, installation), Names(_NAME, {name}))
    writer.names.reserve_calls(lowered.motion)
    routines = {writer.routine(chapter): list(_subroutine(writer, chapter)) for chapter in chapters}
    words = (*heading(lowered, installation, CAPABILITY, TITLE), *_legend(writer.machine), *_wiring(lowered.motion))
    head, main = [_comment(line) for line in words], list(_main(writer, parts))
    if sum(len(chapter.steps) for chapter in chapters) <= MOST_STEPS:
        return {f"{name}.ngc": _text([*head, *(line for lines in routines.values() for line in lines), *main])}
    files = {f"{name}.ngc": _text([*head, *main])}
    return files | {f"{routine}.ngc": _text([*lines, "M2"]) for routine, lines in routines.items()}


@dataclass(slots=True)
class _Writer:
    """The names given so far, and the coordinate system in use."""

    machine: Machine
    names: Names

    def name(self, kind: str, key: object, wanted: str) -> str:
        """Name a subroutine in lower case, as its file is looked up."""
        return self.names.give(kind, key, wanted).lower()

    def routine(self, chapter: Chapter) -> str:
        """Name the subroutine of a chapter."""
        return self.name("routine", chapter.number, f"{make_name(chapter.title, 20)}_{chapter.number:02d}")


def _subroutine(writer: _Writer, chapter: Chapter) -> Iterator[str]:
    """Write a chapter; it says all modes and axes it needs, so that it runs alone."""
    name = writer.routine(chapter)
    axes = AxisWriter(writer.machine)
    yield f"o<{name}> sub"
    if chapter.board is not None:
        yield axes.use(chapter.board)
    yield from tell_steps(
        chapter.steps, lambda maker: _comment(cut(maker, 100)), lambda step: _blocks(writer, axes, step)
    )
    yield f"o<{name}> endsub"
    yield ""


def _blocks(writer: _Writer, axes: AxisWriter, step: Step) -> Iterable[str]:
    """Write one step."""
    match step:
        case Line():
            yield from (
                _output(event.channel, event.value, "synchronised") for event in step.events if event.share < 1.0
            )
            yield from axes.blocks(step)
            then = "immediate" if step.blend_mm == 0.0 else "synchronised"
            yield from (_output(event.channel, event.value, then) for event in step.events if event.share == 1.0)
        case Reach():
            axes.axes = ()
            yield f"G0 {axes.words(step.joints)}"
        case Pause():
            yield f"G4 P{fixed(step.duration_s, 3)}"
        case Switch():
            yield _output(step.channel, step.value, "immediate")
        case UseTool():
            yield f"T{step.number} M6"
        case UseBoard():
            yield axes.use(step)
        case Call():
            yield f"o<{writer.name('call', step.name, step.name)}> call"
            axes.forget()
        case Note():
            yield _comment(cut(step.text, 100))
        case Repeat() | EndRepeat():
            raise AssertionError("loops are in main")


_FIRST_WORD = 100
"""O-words of loops are numbered from the next."""
_DIGITAL = {"synchronised": ("M63", "M62"), "immediate": ("M65", "M64")}
_ANALOG = {"synchronised": "M67", "immediate": "M68"}


def _output(channel: Channel, value: float, when: str) -> str:
    """Set an output with the next motion, or at once."""
    number = channel.number + (GROUP_BASE if channel.kind == "group" else 0)
    if not 0 <= number < _MOST_OUTPUTS:
        raise ProgramError(
            f"{channel.name} is {channel.kind} output {channel.number}; LinuxCNC has P0 to P63 and E0 to E63, "
            f"of which groups take E{GROUP_BASE} and up. Give it another number in the cell."
        )
    if channel.kind == "digital":
        return f"{_DIGITAL[when][int(value > 0.5)]} P{number}"
    return f"{_ANALOG[when]} E{number} Q{short(value, 6)}"


def _main(writer: _Writer, parts: tuple[Part, ...]) -> Iterator[str]:
    """Write what calls the subroutines."""
    yield "G21 G90 G17 G40 G49 G80"
    axes = writer.machine.letters
    for number, (system, offset) in enumerate(writer.machine.offsets.values(), start=1):
        words = " ".join(f"{letter}{short(value, 4)}" for letter, value in zip(axes, offset, strict=True))
        told = "origin of the board; leave this block out after touching off" if writer.machine.slides else "joint zero"
        yield _comment(f"{system}: {told}")
        yield f"G10 L2 P{number} {words} R0"
    home = list(_home(writer.machine))
    yield from home
    for indent, part in nest(parts):
        match part:
            case Chapter():
                yield f"{indent}o<{writer.routine(part)}> call"
            case Begin(number, loop):
                yield from (f"{indent}{line}" for line in _begin_loop(loop, _FIRST_WORD + number))
            case End(number, loop):
                yield from (f"{indent}{line}" for line in _end_loop(loop, _FIRST_WORD + number))
    yield from home
    yield "M2"


def _begin_loop(step: Repeat, number: int) -> list[str]:
    if step.sensor is None:
        return [f"o{number} repeat [{step.count}]"]
    said = f"until {cut(step.key, 40)} >= {short(step.least, 6)}: {step.count} times at most"
    return [_comment(said), f"#<loop{number}> = 0", f"o{number} do", f"  #<loop{number}> = [#<loop{number}> + 1]"]


def _end_loop(step: Repeat, number: int) -> list[str]:
    """Look at the analog input (``M66`` leaves it in #5399) after each turn."""
    if step.sensor is None:
        return [f"o{number} endrepeat"]
    reading = f"{short(step.sensor.scale, 6)} * #5399 + {short(step.sensor.offset, 6)}"
    goes_on = f"[#<loop{number}> LT {step.count}] AND [[{reading}] LT {short(step.least, 6)}]"
    return [f"  M66 E{step.sensor.number} L0", f"o{number} while [{goes_on}]"]


def _home(machine: Machine) -> Iterator[str]:
    """Go home in machine coordinates."""
    if machine.installation.home:
        yield f"G53 G0 {AxisWriter(machine).words(machine.installation.home)}"


def _legend(machine: Machine) -> tuple[str, ...]:
    """Say what the words mean."""
    axes = ", ".join(
        f"{letter} = {joint.name} ({'deg' if joint.kind == 'revolute' else 'mm'})"
        for letter, joint in zip(machine.letters, machine.installation.joints, strict=True)
    )
    speed = "G94 F: mm/min of the orifice; G93 F: 1/min of the block where turning axes move"
    return (f"Axes: {axes}", f"Joint values; each tool's offset is in them. {speed}")


def _wiring(motion: MotionProgram) -> Iterator[str]:
    """List the outputs by their HAL pins."""
    for channel in channels_of(motion):
        pin = f"digital-out-{channel.number:02d}"
        if channel.kind != "digital":
            pin = f"analog-out-{channel.number + (GROUP_BASE if channel.kind == 'group' else 0):02d}"
        yield f"Output {channel.name}: motion.{pin}" + (" (a whole number)" if channel.kind == "group" else "")


def _comment(text: str) -> str:
    """Write a comment, and none that is taken for (MSG,...) or (ABORT,...)."""
    inside = cut(text, LONGEST_LINE - 4).replace("(", "[").replace(")", "]")
    return "(" + re.sub(r"^( *[A-Za-z]+ *),", r"\1;", inside) + ")"


def _text(lines: Iterable[str]) -> str:
    return "".join(f"{line}\n" for line in lines)
