"""Denso PacScript: outputs where a move has done so many percent, by ``Next`` and ``Arrive``."""

from collections.abc import Iterable, Iterator, Sequence

from programs.motion.steps import Line, UseBoard, UseTool
from programs.pose import Pose
from programs.posts.dialect import ProgramFiles
from programs.posts.writing.angles import fixed_xyz
from programs.posts.writing.chapters import Chapter
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.lines import Placed, degrees_per_s
from programs.posts.writing.wording import fixed, indent, join_lines, pose_words, short

SPEEDS = (
    "#Define PER_MM_S 0.1 ' percent of Speed for 1 mm/s, assumed: 100 / greatest CP speed of this arm",
    "#Define PER_DEG_S 0.2 ' percent of Speed for 1 deg/s, assumed: 100 / greatest turn of this arm",
)


class PacScript(Syntax):
    """PacScript: subprograms of moves to positions in a work."""

    mark = "' "
    longest_comment = longest_heading = 120
    call_form = "Call {routine}"
    digital = "{value} IO[{number}]"
    group = "IOB[{number}] = {value}"
    analog = "IOW[{number}] = {value}"
    off_on = ("Reset", "Set")
    pause_form = "Delay {ms}"
    select_tool = "ChangeTool {slot}"
    select_board = "ChangeWork {slot}"
    set_tool = "Tool {slot}, {frame}"
    set_board = "Work {slot}, {frame}"
    most_frames = 63
    move = "Move L, @{passing} {point}, Speed = {speed} * {unit}{goes_on}"
    wait_percent = "Arrive {percent}"
    wait_end = "WaitMotion 4, 0"
    """Until 0 ms before the end of a move: what follows is done at rest."""
    declare = "Dim {counter} As Integer"
    begin = ("On Error GoTo *Fault", "TakeArm Keep = 0", "Speed 100", "Accel 100, 100")
    to_joints = "Move P, @0 J({joints}), Speed = {percent}"
    by_joints = "Move P, @0 {point}, Speed = {percent}"
    straight = "Move L, @0 {point}, Speed = 10"
    home_comment = " ' home"
    start = "I[99]"
    start_words = "enter its number in {start}"
    watch_note = ": to be wired, see below"
    states = ("Off", "On")
    part_form = ("If {start} <= {number} Then {call}",)
    enter_begin = ("If {start} = {number} Then", "  {start} = 1")
    enter_end = ("End If",)
    guard = ('If CurExtSpd <> 100 Then Halt "speed is not 100 percent"',)
    wait_contact = ("Wait IO[{input}] = {state}, {ms}, I[98]", 'If I[98] = 0 Then Halt "{message}"')
    wait_sensor = ("Wait {reading} >= {least}, {ms}, I[98]", 'If I[98] = 0 Then Halt "{message}"')
    rise_forms = (
        "Dim pStart As Position",
        "ChangeWork 0",
        "ChangeTool {tool}",
        "pStart = CurPos",
        "If PosZ(pStart) < {height} Then",
        "  LetZ pStart = {height}",
        "  Move L, @0 pStart, Speed = 10",
        "End If",
    )
    loop_begin = ("For {counter} = 1 To {count}",)
    loop_end = ("{condition}", "Next {counter}")
    sensed = "  If {reading} >= {least} Then Exit For"
    reading = "{scale} * IOW[{input}] + {offset}"
    last = ("GiveArm", "Exit Sub", "*Fault:", "Call shut_valves", 'Halt "fault, valves shut"')
    rounds_groups = True
    reserved = frozenset({
        "main", "sub", "end", "move", "tool", "work", "call", "next", "arrive", "speed", "home", "loop", "set", "reset",
        "shut_valves", "fault",
    })  # fmt: skip
    longest_name = 32
    longest_title = 29

    def initial_frames(self, chapter: Chapter) -> Sequence[UseTool | UseBoard | None]:
        """Select the tool, then the board."""
        return (chapter.tool, chapter.board)

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Write a line; with ``Next`` the program goes on while the robot moves, to wait for the outputs' percents."""
        turns = line.turns_on_the_spot
        yield self.move.format(
            passing=max(int(line.blend_mm), 1) if line.blend_mm else 0,
            point=self.point(line.target),
            speed=fixed(degrees_per_s(line) if turns else line.speed_mm_s, 1),
            unit="PER_DEG_S" if turns else "PER_MM_S",
            goes_on=", Next" if placed.begins or placed.inside else "",
        )
        yield from (self.output(event.channel, event.value) for event in placed.begins)
        for event in placed.inside:
            yield self.wait_percent.format(percent=round(100.0 * event.share))
            yield self.output(event.channel, event.value)
        if (placed.begins or placed.inside) and line.blend_mm == 0.0:
            yield self.wait_end
        yield from (self.output(event.channel, event.value) for event in placed.ends)

    def point(self, pose: Pose) -> str:
        """Write a position of the arm; figure -1 keeps the one it has."""
        return f"{self.frame(pose)[:-1]}, -1)"

    def frame(self, pose: Pose) -> str:
        """Write a pose without an arm's figure."""
        return f"P({', '.join(pose_words(pose, fixed_xyz))})"

    def pause(self, seconds: float) -> list[str]:
        """Write a delay in milliseconds."""
        return [self.pause_form.format(ms=short(1e3 * seconds, 0))]

    def prepare(self) -> Iterator[str]:
        """Take the arm, and set speeds, tools and works."""
        yield from (self.declare.format(counter=self.counter.format(number=number)) for number in self.loops)
        yield from self.begin
        yield from self.slot_lines()

    def setup(self) -> Iterator[str]:
        """State what the integrator has to set up."""
        yield "supervisory task or PLC: shut the valves while no program runs; a stop keeps outputs"
        for wait in self.installation.waits:
            if wait.watched and wait.contact is not None:
                yield f"IO[{wait.contact.number}] to the PLC, which stops the robot: {wait.words}"
        yield "I[98] and I[99] are used; I[99] is the part to start at; percent of Speed in the two definitions below"
        yield "Tool and Work are set by Main under the numbers there: compare them with yours; ExtSpeed 100"

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write one file, or a file for each subprogram and one that calls them."""
        units = "Units: mm, degrees; positions in the board's CAD frame (Work), RX RY RZ about the fixed x, y, z."
        head = self.heading(units)
        top = [_title(self.name), *head, *SPEEDS, "", *_sub("Main", main.body), *_sub(self.shut_name, self.shut())]
        if self.fits_one_file:
            inside = [line for each in routines for line in _sub(each.name, each.body)]
            return {f"{self.name}.pcs": join_lines([*top, *inside])}
        files = {f"{self.name}.pcs": join_lines(top)}
        for each in routines:
            files[f"{each.name}.pcs"] = join_lines([_title(each.name), *SPEEDS, "", *_sub("Main", each.body)])
        return files


def _title(name: str) -> str:
    return f'\'!TITLE "{name}"'


def _sub(name: str, body: Iterable[str]) -> list[str]:
    return [f"Sub {name}", *indent(body), "End Sub", ""]
