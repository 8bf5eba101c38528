"""G-code for LinuxCNC: a gantry's axes from its joint motion, outputs in step with the motion by ``M62`` to ``M67``.

The machine has trivial kinematics: each axis is a joint. The orifice follows its line because blocks are short enough,
and keeps its speed because a block takes the time that the orifice needs: where only X, Y and Z move that is ``F`` in
mm/min, else inverse time (``G93``), whatever the turning axes do to the length of the way.
"""

import re
from collections.abc import Iterator, Sequence

from programs.errors import ProgramError
from programs.motion.installation import Channel, Installation
from programs.motion.lower import Lowered
from programs.motion.steps import Line, UseBoard, UseTool
from programs.posts.dialect import Dialect, ProgramFiles
from programs.posts.writing.blocks import BLEND_MM, AxisSyntax
from programs.posts.writing.driver import Routine
from programs.posts.writing.naming import Names
from programs.posts.writing.tool_points import one_row
from programs.posts.writing.wording import cut, join_lines, short

GROUP_BASE = 32
"""Groups are whole numbers on the analog outputs from this one on: LinuxCNC has no groups."""
SYSTEMS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")
_MOST_OUTPUTS = 64
_FIRST_WORD = 100
"""O-words of loops are numbered from the next."""
_DIGITAL = {"synchronised": ("M63", "M62"), "immediate": ("M65", "M64")}
_ANALOG = {"synchronised": "M67", "immediate": "M68"}


class GCode(AxisSyntax):
    """G-code of LinuxCNC: subroutines of blocks in the machine's axes."""

    systems = SYSTEMS
    controller_name = "LinuxCNC"
    call_form = "o<{routine}> call"
    pause_form = "G4 P{seconds}"
    modes = ("G21 G90 G17 G40 G49 G80",)
    zero_form = "G10 L2 P{number} {axes} R0"
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
    counter = "#<loop{number}>"
    first_counter = _FIRST_WORD + 1
    loop_label = _FIRST_WORD
    loop_text = "until {key} >= {least}: {count} times at most"
    comments_counting = False
    loop_begin = ("o{label} repeat [{count}]",)
    loop_end = ("o{label} endrepeat",)
    sensed_begin = ("{counter} = 0", "o{label} do", "  {counter} = [{counter} + 1]")
    sensed_end = (
        "  M66 E{input} L0",
        "o{label} while [[{counter} LT {count}] AND [[{reading}] LT {least}]]",
    )
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

    def make_names(self) -> Names:
        """Name subroutines in lower case, as their files are looked up."""
        return Names(self.longest_name, {self.name.lower(), self.shut_name}, str.lower)

    def comment(self, text: str, longest: int = 0) -> str:
        """Write a comment, and none that is taken for (MSG,...) or (ABORT,...)."""
        inside = cut(text, longest or self.longest_comment).replace("(", "[").replace(")", "]")
        return "(" + re.sub(r"^( *[A-Za-z]+ *),", r"\1;", inside) + ")"

    def block(self, line: Line, words: str, share: float, *, stops: bool, turns: bool) -> Iterator[str]:
        """Write a block with the modes that change."""
        path = "G61.1" if stops else f"G64 P{BLEND_MM:g} Q0"
        feed_mode, feed = self.feed(line, share, turns=turns)
        modes = [each for key, mode in (("path", path), ("feed", feed_mode)) for each in self.mode(key, mode)]
        yield f"{' '.join([*modes, 'G1'])} {words} F{feed}"

    def feed(self, line: Line, share: float, *, turns: bool) -> tuple[str, str]:
        """Give the feed mode and ``F`` of a block that does this share of a line."""
        if self.machine is not None or (line.speed_mm_s > 0.0 and self.slides and not turns):
            return "G94", self.tool_point_feed(line)
        whole_s = line.duration_s
        if line.speed_mm_s > 0.0:
            whole_s = line.length_mm / line.speed_mm_s
        elif line.turn_rad_s > 0.0:
            whole_s = line.angle_rad / line.turn_rad_s
        return "G93", short(60.0 / (share * whole_s), 4)

    def use(self, step: UseTool | UseBoard) -> Iterator[str]:
        """Change the tool, or select the coordinate system of a placement."""
        if isinstance(step, UseTool):
            yield self.change_form.format(tool=step.number)
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

    def zero_note(self) -> str:
        """Describe the zero of a coordinate system."""
        return super().zero_note() if self.slides else "joint zero"

    def rise(self) -> list[str]:
        """Raise Z to that of home before any other axis moves, where no line is higher."""
        if self.rising_z() is None:
            return []
        (block,) = self.home()
        self.written = ()
        return [self.home_form.format(axes=next(word for word in block.split() if word[0] == "Z"))]

    def home(self) -> Iterator[str]:
        """Go home in machine coordinates."""
        if self.installation.home:
            self.offset, self.written = (), ()
            home = self.installation.home
            axes = self.axes(home if self.machine is None else one_row(self.machine, home))
            yield self.home_form.format(axes=axes)

    def legend(self) -> Iterator[str]:
        """Describe the words of a block, and list the outputs by their HAL pins."""
        yield from self.axis_lines()
        if self.machine is None:
            speed = "G94 F: mm/min of the orifice; G93 F: 1/min of the block where turning axes move"
            yield f"Joint values; each tool's offset is in them. {speed}"
        else:
            pivot = f"pivot-length {short(self.machine.pivot_mm, 4)} with every tool, W at 0, G49"
            yield f"Tool points: KINEMATICS = 5axiskins; {pivot}"
            yield "Machine zero: X Y Z of the cell's joints where B is 0. F: mm/min of the orifice, deg/min on the spot"
            yield from self.sign_lines()
            yield self.spot_line()

    def output_words(self, channel: Channel) -> str:
        """Give the HAL pin of an output."""
        pin = f"motion.{'digital' if channel.kind == 'digital' else 'analog'}-out-{_number(channel):02d}"
        return pin + (" (a whole number)" if channel.kind == "group" else "")

    def contact_words(self, number: int) -> str:
        """Give the HAL pin of a digital input."""
        return f"motion.digital-in-{number:02d}"

    def sensor_words(self, number: int) -> str:
        """Give the HAL pin of an analog input."""
        return f"motion.analog-in-{number:02d}"

    def setup(self) -> Iterator[str]:
        """State what HAL and INI have to do, as G-code has no interrupts."""
        yield "motmod num_dio and num_aio above the numbers below; the INI's axes as the words of the blocks"
        yield f"[RS274NGC] ON_ABORT_COMMAND = O <{self.shut_name}> call, or an abort leaves the valves as they are"
        yield f"{self.shut_name}.ngc in SUBROUTINE_PATH with the subroutine of that name below, for that call"
        yield "HAL: and2 of each valve's pin with motion.motion-enabled, for an emergency stop"
        yield "HAL: a watchdog of milltask to motion.enable, for the case that it is killed: docs/robot-programs.md"
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


def _number(channel: Channel) -> int:
    """Number of an output among the digital or the analog ones."""
    return channel.number + (GROUP_BASE if channel.kind == "group" else 0)
