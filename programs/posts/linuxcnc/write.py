"""G-code for LinuxCNC: a gantry's axes from its joint motion, outputs in step with the motion by ``M62`` to ``M67``.

The machine has trivial kinematics: each axis is a joint. The orifice follows its line because blocks are short enough,
and keeps its speed because a block takes the time that the orifice needs: where only X, Y and Z move that is ``F`` in
mm/min, else inverse time (``G93``), whatever the turning axes do to the length of the way.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from math import degrees

from programs.errors import ProgramError
from programs.motion.installation import Channel, Installation, ToolPointMachine
from programs.motion.lower import Lowered
from programs.motion.steps import Line, MotionProgram, Reach, Repeat, UseBoard, UseTool
from programs.pose import Position
from programs.posts.dialect import Dialect, ProgramFiles
from programs.posts.writing.axes import SPOT_DEG, allowed_on, in_degrees_and_mm, needed_samples, units_of
from programs.posts.writing.chapters import Chapter
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.heading import channels_of
from programs.posts.writing.lines import Placed
from programs.posts.writing.naming import Names
from programs.posts.writing.tool_points import one_row
from programs.posts.writing.wording import cut, fixed, join_lines, short

GROUP_BASE = 32
"""Groups are whole numbers on the analog outputs from this one on: LinuxCNC has no groups."""
SYSTEMS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")
_MOST_OUTPUTS = 64
_LETTERS = "XYZABCUVW"
BLEND_MM = 0.05
"""How far ``G64`` may cut a corner; zones are planned for the same."""
_FINENESS = 0.7
"""Share of the allowed deviation that straight blocks may use; the rest is for rounding."""
_DIGITS = 4
_NO_JOINTS = "G-code is made of joint values; track the program in a cell first."
_FIRST_WORD = 100
"""O-words of loops are numbered from the next."""
_DIGITAL = {"synchronised": ("M63", "M62"), "immediate": ("M65", "M64")}
_ANALOG = {"synchronised": "M67", "immediate": "M68"}


class GCode(Syntax):
    """G-code of LinuxCNC: subroutines of blocks in the machine's axes."""

    call_form = "o<{}> call"
    pause_form = "G4 P{}"
    last = ("M2",)
    longest_name = 40
    start = "#<_start>"
    start_words = "write its number into the block {start} = 1"
    watch_note = ": to be wired, see below"
    part_form = ("o{label} if [{start} LE {number}]", "  {call}", "o{label} endif")
    enter_begin = ("o90 if [{start} EQ {number}]", "  {start} = 1")
    enter_end = ("o90 endif",)
    guard = ("M49",)
    states = ("L4", "L3")
    reading = "{scale} * #5399 + {offset}"
    wait_contact = (
        "M66 P{input} {state} Q{seconds}",
        "o{label} if [#5399 LT 0]",
        "  (ABORT,{message})",
        "o{label} endif",
    )
    wait_sensor = (
        "#<waited> = 0",
        "o{label} do",
        "  G4 P0.1",
        "  #<waited> = [#<waited> + 1]",
        "  M66 E{input} L0",
        "o{label} while [[#<waited> LT {tenths}] AND [[{reading}] LT {least}]]",
        "o{label}1 if [[{reading}] LT {least}]",
        "  (ABORT,{message})",
        "o{label}1 endif",
    )

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        super().__init__(dialect, lowered, installation)
        self.name = self.name.lower()
        self.letters = _name_axes(installation)
        kinds = {letter: joint.kind for letter, joint in zip(self.letters, installation.joints, strict=True)}
        self.slides = all(kinds.get(letter) == "prismatic" for letter in "XYZ")
        """Whether X, Y and Z are straight axes: then F in mm/min is the speed of an orifice that does not turn."""
        self.machine = installation.tool_point
        base = self.machine.base if self.machine is not None else (0.0, 0.0, 0.0)
        self.offsets = _offsets(self.motion, self.letters, base if self.slides else None)
        self.offset: tuple[float, ...] = ()
        self.written: tuple[str, ...] = ()
        """Axes as written last; empty where the next block has to write all."""

    def make_names(self) -> Names:
        """Name subroutines in lower case, as their files are looked up."""
        return Names(self.longest_name, {self.name.lower(), self.shut_name}, str.lower)

    def comment(self, text: str, longest: int = 0) -> str:
        """Write a comment, and none that is taken for (MSG,...) or (ABORT,...)."""
        inside = cut(text, longest or self.longest_comment).replace("(", "[").replace(")", "]")
        return "(" + re.sub(r"^( *[A-Za-z]+ *),", r"\1;", inside) + ")"

    def initial_frames(self, chapter: Chapter) -> Sequence[UseTool | UseBoard | None]:
        """Select the coordinate system; the tool is in the spindle."""
        return (chapter.board,)

    def entry_frames(self, chapter: Chapter) -> Sequence[UseTool | UseBoard]:
        """Change the tool: it is in the spindle otherwise."""
        return (chapter.tool,) if chapter.tool is not None else ()

    def chapter(self, chapter: Chapter) -> Iterator[str]:
        """Write a subroutine; its first blocks state all modes and axes, so that it runs alone."""
        self.offset = ()
        self.forget()
        yield from super().chapter(chapter)

    def forget(self) -> None:
        """Write modes and axes again."""
        super().forget()
        self.written = ()

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Write as many blocks as the axes need to follow a line, its outputs before the first or after the last."""
        for event in line.events:
            if event.share < 1.0:
                yield self.output(event.channel, event.value, "synchronised")
        yield from self.blocks(line)
        then = "immediate" if line.blend_mm == 0.0 else "synchronised"
        yield from (self.output(event.channel, event.value, then) for event in line.events if event.share == 1.0)

    def blocks(self, line: Line) -> Iterator[str]:
        """Write the motion of a line."""
        if not line.joints:
            raise ProgramError(_NO_JOINTS)
        done, before = 0.0, 0
        units, spot = units_of(self.installation), self.machine is not None and line.turns_on_the_spot
        allowed = allowed_on(line, units, self.installation)
        for sample in needed_samples(line.samples, units, _FINENESS, allowed):
            share = float(line.samples.shares[sample])
            moved = self.moved(line, before, sample)
            if not moved and share < 1.0:
                continue  # the next block takes its time too: a block that goes nowhere would stop the others
            words = self.axes(tuple(line.samples.joints[sample].tolist()), rests=spot)
            path = "G61.1" if share == 1.0 and line.blend_mm == 0.0 else f"G64 P{BLEND_MM:g} Q0"
            feed_mode, feed = self.feed(line, share - done, turns=not moved <= set("XYZ"))
            modes = [each for key, mode in (("path", path), ("feed", feed_mode)) for each in self.mode(key, mode)]
            yield f"{' '.join([*modes, 'G1'])} {words} F{feed}"
            done, before = share, sample

    def moved(self, line: Line, begin: int, end: int) -> set[str]:
        """Give the letters of the axes that are not the same at two samples of a line."""
        rows = (in_degrees_and_mm(tuple(line.samples.joints[at].tolist()), self.installation) for at in (begin, end))
        pairs = zip(self.letters, *rows, strict=True)
        return {letter for letter, a, b in pairs if fixed(a, _DIGITS) != fixed(b, _DIGITS)}

    def mode(self, group: str, word: str) -> list[str]:
        """Write a modal word of a group if another is in force."""
        return [word] if self.set(group, word) else []

    def feed(self, line: Line, share: float, *, turns: bool) -> tuple[str, str]:
        """Give the feed mode and ``F`` of a block that does this share of a line."""
        if line.speed_mm_s > 0.0 and (self.machine is not None or (self.slides and not turns)):
            return "G94", short(60.0 * line.speed_mm_s, 1)
        if self.machine is not None:
            return "G94", short(60.0 * degrees(line.turn_rad_s), 1)
        whole_s = line.duration_s
        if line.speed_mm_s > 0.0:
            whole_s = line.length_mm / line.speed_mm_s
        elif line.turn_rad_s > 0.0:
            whole_s = line.angle_rad / line.turn_rad_s
        return "G93", short(60.0 / (share * whole_s), 4)

    def axes(self, joints: tuple[float, ...], *, rests: bool = False) -> str:
        """Write the axes that change, at least one; none of X, Y and Z where the tool point rests.

        Raises:
            ProgramError: the joints are not known.
        """
        if not joints or len(joints) != len(self.letters):
            raise ProgramError(_NO_JOINTS)
        values = in_degrees_and_mm(joints, self.installation)
        offset = self.offset or tuple(0.0 for _ in values)
        words = tuple(
            f"{letter}{fixed(value - zero, _DIGITS)}"
            for letter, value, zero in zip(self.letters, values, offset, strict=True)
        )
        before = self.written or tuple("" for _ in words)
        if rests and self.written:
            words = tuple(then if then[0] in "XYZ" else now for now, then in zip(words, before, strict=True))
        changed = [now for now, then in zip(words, before, strict=True) if now != then]
        self.written = words
        return " ".join(changed or words[:1])

    def reach(self, reach: Reach) -> Iterator[str]:
        """Write a rapid in all axes."""
        self.written = ()
        yield f"G0 {self.axes(reach.joints)}"

    def use(self, step: UseTool | UseBoard) -> Iterator[str]:
        """Change the tool, or select the coordinate system of a placement."""
        if isinstance(step, UseTool):
            yield f"T{step.number} M6"
            return
        system, self.offset = self.offsets[step.placement]
        self.written = ()
        yield system

    def output(self, channel: Channel, value: float, when: str = "immediate") -> str:
        """Set an output with the next motion, or at once."""
        number = _number(channel)
        if not 0 <= number < _MOST_OUTPUTS:
            raise ProgramError(
                f"{channel.name} is {channel.kind} output {channel.number}; LinuxCNC has P0 to P63 and E0 to E63, "
                f"of which groups take E{GROUP_BASE} and up. Give it another number in the cell."
            )
        if channel.kind == "digital":
            return f"{_DIGITAL[when][int(value > 0.5)]} P{number}"
        return f"{_ANALOG[when]} E{number} Q{short(value, 6)}"

    def prepare(self) -> Iterator[str]:
        """Set the modes, and the zero of each coordinate system."""
        yield self.comment(f"the part to start at; 1 is the whole program of {len(self.chapters)}")
        yield f"{self.start} = 1"
        yield "G21 G90 G17 G40 G49 G80"
        zero = "origin of the board; leave this block out after touching off" if self.slides else "joint zero"
        for number, (system, offset) in enumerate(self.offsets.values(), start=1):
            words = " ".join(f"{letter}{short(value, 4)}" for letter, value in zip(self.letters, offset, strict=True))
            yield self.comment(f"{system}: {zero}")
            yield f"G10 L2 P{number} {words} R0"

    def rise(self) -> list[str]:
        """Raise Z to that of home before any other axis moves, where no line is higher."""
        home = self.installation.home
        if not (home and self.slides and self.installation.is_upright):
            return []
        z = self.letters.index("Z")
        if any(line.joints[z] > home[z] for line in self.motion.lines if line.joints):
            return []
        (block,) = self.home()
        self.written = ()
        return [f"G53 G0 {next(word for word in block.split() if word[0] == 'Z')}"]

    def home(self) -> Iterator[str]:
        """Go home in machine coordinates."""
        if self.installation.home:
            self.offset, self.written = (), ()
            home = self.installation.home
            yield f"G53 G0 {self.axes(home if self.machine is None else one_row(self.machine, home))}"

    def begin_loop(self, number: int, loop: Repeat) -> list[str]:
        """Write ``repeat``, or ``do`` where an input is read."""
        word, counter = f"o{_FIRST_WORD + number}", f"#<loop{_FIRST_WORD + number}>"
        if loop.sensor is None:
            return [f"{word} repeat [{loop.count}]"]
        text = f"until {cut(loop.key, 40)} >= {short(loop.least, 6)}: {loop.count} times at most"
        return [self.comment(text), f"{counter} = 0", f"{word} do", f"  {counter} = [{counter} + 1]"]

    def end_loop(self, number: int, loop: Repeat) -> list[str]:
        """Read the analog input (``M66`` leaves it in #5399) after each turn."""
        word, counter = f"o{_FIRST_WORD + number}", f"#<loop{_FIRST_WORD + number}>"
        if loop.sensor is None:
            return [f"{word} endrepeat"]
        condition = f"[{counter} LT {loop.count}] AND [[{self.quantity(loop.sensor)}] LT {short(loop.least, 6)}]"
        return [f"  M66 E{loop.sensor.number} L0", f"{word} while [{condition}]"]

    def legend(self) -> Iterator[str]:
        """Describe the words of a block, and list the outputs by their HAL pins."""
        axes = ", ".join(
            f"{letter} = {joint.name} ({'deg' if joint.kind == 'revolute' else 'mm'})"
            for letter, joint in zip(self.letters, self.installation.joints, strict=True)
        )
        yield f"Axes: {axes}"
        if self.machine is None:
            speed = "G94 F: mm/min of the orifice; G93 F: 1/min of the block where turning axes move"
            yield f"Joint values; each tool's offset is in them. {speed}"
        else:
            yield from _describe_machine(self.machine, self.letters)

    def signal_lines(self) -> Iterator[str]:
        """List outputs and inputs by their HAL pins."""
        for channel in channels_of(self.motion):
            pin = f"{'digital' if channel.kind == 'digital' else 'analog'}-out-{_number(channel):02d}"
            yield f"Output {channel.name}: motion.{pin}" + (" (a whole number)" if channel.kind == "group" else "")
        for wait in self.installation.waits:
            if wait.contact is not None:
                yield f"Input {wait.contact.name}: motion.digital-in-{wait.contact.number:02d}, {wait.words}"
            if wait.sensor is not None:
                yield f"Input {wait.sensor.name}: motion.analog-in-{wait.sensor.number:02d}, {wait.words}"

    def setup(self) -> Iterator[str]:
        """State what HAL and INI have to do, as G-code has no interrupts."""
        yield "motmod num_dio and num_aio above the numbers below; the INI's axes as the words of the blocks"
        yield f"[RS274NGC] ON_ABORT_COMMAND = O <{self.shut_name}> call, or an abort leaves the valves as they are"
        yield f"{self.shut_name}.ngc in SUBROUTINE_PATH with the subroutine of that name below, for that call"
        yield "HAL: and2 of each valve's pin with motion.motion-enabled, and for the case that the controller dies"
        for wait in self.installation.waits:
            if wait.watched and wait.contact is not None:
                yield f"HAL: {wait.contact.name} to halui.program.stop when it leaves its state: {wait.words}"

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write one file, or a file for each subroutine and one that calls them."""
        head = self.heading(*self.legend())
        named = {self.shut_name: self.shut(), **{each.name: each.body for each in routines}}
        bodies = {name: [f"o<{name}> sub", *body, f"o<{name}> endsub", ""] for name, body in named.items()}
        if self.fits_one_file:
            inside = [line for body in bodies.values() for line in body]
            return {f"{self.name}.ngc": join_lines([*head, *inside, *main.body])}
        files = {f"{self.name}.ngc": join_lines([*head, *main.body])}
        return files | {f"{name}.ngc": join_lines([*body, "M2"]) for name, body in bodies.items()}


def _describe_machine(machine: ToolPointMachine, letters: tuple[str, ...]) -> Iterator[str]:
    """Describe what the machine's configuration has to be."""
    yield f"Tool points: KINEMATICS = 5axiskins; pivot-length {short(machine.pivot_mm, 4)} with every tool, W at 0, G49"
    yield "Machine zero: X Y Z of the cell's joints where B is 0. F: mm/min of the orifice, deg/min on the spot"
    tilt = 7 - machine.swing
    zeros = (machine.swing_zero, machine.tilt_zero)
    for letter, sign, zero in zip((letters[machine.swing], letters[tilt]), machine.signs, zeros, strict=True):
        if sign < 0.0 or zero:
            plus = f", plus {short(degrees(zero), 4)} deg" if zero else ""
            yield f"{letter} counts {'against' if sign < 0.0 else 'as'} the cell's joint{plus}; B tilts to +X at C0"
    yield f"On the spot B and C go evenly: the jet may be up to {SPOT_DEG:g} deg off the shortest turn meanwhile"


def _name_axes(installation: Installation) -> tuple[str, ...]:
    """Name the axes as the joints are named if those are axes, else X, Y, Z, A, B, C, U, V, W in their order."""
    names = [joint.name.upper() for joint in installation.joints]
    if len(names) > len(_LETTERS):
        raise ProgramError(f"LinuxCNC has {len(_LETTERS)} axes; robot {installation.robot} has {len(names)} joints.")
    are_axes = len(set(names)) == len(names) and all(len(name) == 1 and name in _LETTERS for name in names)
    return tuple(names if are_axes else _LETTERS[: len(names)])


def _offsets(
    motion: MotionProgram, letters: tuple[str, ...], base: Position | None
) -> Mapping[str, tuple[str, tuple[float, ...]]]:
    """Coordinate system, and what it adds to each axis, by the placement of the board.

    Where X, Y and Z slide, assumed along the directions of the base frame, the board's origin is their zero; ``base``
    is then where the base's origin is in their coordinates.
    """
    places = {step.placement: step.T_base_board for step in motion.steps if isinstance(step, UseBoard)}
    if len(places) > len(SYSTEMS):
        raise ProgramError(f"LinuxCNC has {len(SYSTEMS)} coordinate systems; the board lies in {len(places)} places.")
    offsets: dict[str, tuple[str, tuple[float, ...]]] = {}
    for system, (placement, place) in zip(SYSTEMS, places.items(), strict=False):
        shifted = [] if base is None else [a + b for a, b in zip(place.position, base, strict=True)]
        origin = dict(zip("XYZ", shifted, strict=False))
        offsets[placement] = (system, tuple(round(origin.get(letter, 0.0), _DIGITS) for letter in letters))
    return offsets


def _number(channel: Channel) -> int:
    """Number of an output among the digital or the analog ones."""
    return channel.number + (GROUP_BASE if channel.kind == "group" else 0)
