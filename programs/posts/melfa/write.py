"""Mitsubishi MELFA-BASIC V and VI: outputs where a move begins, by ``Wth``."""

from collections.abc import Iterator, Sequence

from programs.motion.steps import Line, Reach, UseBoard, UseTool
from programs.pose import Pose, inverse
from programs.posts.dialect import ProgramFiles
from programs.posts.writing.angles import fixed_xyz
from programs.posts.writing.chapters import Chapter
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.joint_moves import CAUTIOUS, Pace
from programs.posts.writing.lines import Placed
from programs.posts.writing.naming import Names
from programs.posts.writing.wording import join_lines, make_name, pose_words, short


class MelfaBasic(Syntax):
    """MELFA-BASIC: programs of numbered steps, with their positions behind them."""

    mark = "' "
    longest_comment = longest_heading = 117
    call_form = 'CallP "{routine}"'
    pause_form = "Dly {seconds}"
    digital = "M_Out({number})={value}"
    group = "M_Outb({number})={value}"
    analog = "M_Outw({number})={value}"
    by_joints = "Mov {point}"
    straight = "Mvs {point}"
    start = "M_19"
    start_words = "enter its number in {start}"
    watch_note = ": the valves by itself, the robot as wired, see below"
    part_form = ("If {start}<={number} Then {call}",)
    enter_begin = ("If {start}<>{number} Then GoTo *RUN", "{start}=1")
    enter_end = ("*RUN",)
    guard = ("' error 9100: the speed override is not 100 percent", "If M_OPovrd<>100 Then Error 9100")
    wait_contact = (
        "' error {error}: {message}",
        "M_Timer(1)=0",
        "*WAIT{index}",
        "If M_In({input})={state} Then GoTo *READY{index}",
        "If M_Timer(1)<{ms} Then GoTo *WAIT{index}",
        "Error {error}",
        "*READY{index}",
    )
    wait_sensor = (
        "' error {error}: {message}",
        "M_Timer(1)=0",
        "*WAIT{index}",
        "If ({reading})>={least} Then GoTo *READY{index}",
        "If M_Timer(1)<{ms} Then GoTo *WAIT{index}",
        "Error {error}",
        "*READY{index}",
    )
    rise_forms = (
        "PSTART=P_Curr",
        "If PSTART.Z>={height} Then GoTo *HIGH",
        "PSTART.Z={height}",
        "Spd 100",
        "Mvs PSTART",
        "*HIGH",
    )
    counter = "M{number}"
    loop_begin = ("{counter}=0", "*LOOP{number}", "{counter}={counter}+1")
    loop_end = ("If {condition} Then GoTo *LOOP{number}",)
    counted = "{counter}<{count}"
    sensed = "{counter}<{count} And ({reading})<{least}"
    reading = "{scale}*M_Inw({input})+{offset}"
    last = ("Base P_NBase", "Tool P_NTool")
    rounds_groups = True
    longest_name = 12  # of a program, in capital letters and digits
    indents_loops = False
    numbers_points_by_routine = True

    def make_names(self) -> Names:
        """Begin the list of names with the program's own."""
        names = Names(self.longest_name, set(), str.upper, link="X")
        self.name = names.give("main", 0, _plain(self.motion.origin.board))
        self.shut_name = names.give("shut", 0, f"{self.name[:7]}SHUT")
        self.watch_name = names.give("watch", 0, f"{self.name[:7]}WATCH")
        return names

    def call_name(self, name: str) -> str:
        """Name a program of the integrator's."""
        return self.names.give("call", name, _plain(name))

    def routine_name(self, chapter: Chapter) -> str:
        """Name the program of a chapter."""
        title = _plain(chapter.title)[: self.longest_name - 3]
        return self.names.give("routine", chapter.number, f"{title}{chapter.number:02d}")

    def initial_frames(self, chapter: Chapter) -> Sequence[UseTool | UseBoard | None]:
        """Select the tool, then the board."""
        return (chapter.tool, chapter.board)

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Write a line; a move takes one output with it, others that begin there are set right before."""
        near = short(line.blend_mm, 2)
        yield from self.set("Cnt", "0" if line.blend_mm == 0.0 else f"1,{near},{near}")
        yield from self.set("Spd", "M_NSpd" if line.turns_on_the_spot else short(line.speed_mm_s, 1))
        outputs = [self.output(event.channel, event.value) for event in placed.begins]
        yield from outputs[:-1]
        yield f"Mvs {self.point(line.target)}{f' Wth {outputs[-1]}' if outputs else ''}"
        yield from (self.output(event.channel, event.value) for event in placed.ends)

    def reach(self, reach: Reach) -> Iterator[str]:
        """Write a joint motion that stops."""
        yield from self.set("Cnt", "0")
        yield from super().reach(reach)

    def slow_down(self, pace: Pace) -> list[str]:
        """Set the override of joint motions."""
        return self.set("JOvrd", str(pace.percent))

    def joint_move(self, joints: tuple[float, ...], pace: Pace = CAUTIOUS) -> str:
        """Move to a joint position, and declare it."""
        self.points += 1
        self.data.append(f"J{self.points}=({','.join(self.joints(joints))})")
        return f"Mov J{self.points}"

    def point(self, pose: Pose) -> str:
        """Declare a position."""
        self.points += 1
        self.data.append(f"P{self.points}={_components(pose)}(7,0)")
        return f"P{self.points}"

    def use(self, step: UseTool | UseBoard) -> Iterator[str]:
        """Set tool or base; the base is the robot as seen from the board."""
        if isinstance(step, UseTool):
            word, name, pose = "Tool", f"PTL{step.number}", self.installation.tool(step.number).T_flange_tcp
        else:
            places = ["", *self.installation.placements]
            number = places.index(step.placement) if step.placement in places else len(places)
            word, name, pose = "Base", f"PBS{number}", inverse(step.T_base_board)
        position = f"{name}={_components(pose)}(0,0)"
        if position not in self.data:
            self.data.append(position)
        yield f"{word} {name}"

    def prepare(self) -> list[str]:
        """Set the overrides."""
        return ["Ovrd 100", "Cnt 0"]

    def rise(self) -> list[str]:
        """Raise the orifice of the first tool, as seen from the robot."""
        lines = super().rise()
        tool = next((step for step in self.motion.steps if isinstance(step, UseTool)), None)
        return ["Base P_NBase", *self.use(tool), *lines] if lines and tool is not None else []

    def setup(self) -> Iterator[str]:
        """State what the integrator has to set up."""
        yield f"{self.watch_name} in slot 2 (SLT2: {self.watch_name},REP,ALWAYS,1): shuts valves while slot 1 does not"
        yield "run, after an error, and without what is watched; wire that to stop the robot too"
        yield f"{self.start} is the part to start at; after a stop reset the program; errors 9100 up are used"

    def background(self) -> Iterator[str]:
        """Write the program of a slot that always runs: it shuts the valves."""
        lost = [
            f"M_In({wait.contact.number})={self.states[not wait.state]}"
            for wait in self.installation.waits
            if wait.watched and wait.contact is not None
        ]
        yield "*LOOP"
        for condition in ("M_Run(1)=0", "M_Err=1", *lost):
            yield from (f"If {condition} Then {line}" for line in self.shut())
        yield "GoTo *LOOP"

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write a file for each program: its steps by number, then its positions."""
        units = "Units: mm, mm/s, degrees; positions in the board's CAD frame, A B C about the fixed x, y, z"
        files: dict[str, str] = {}
        faults = [Routine(self.shut_name, 0, self.shut(), []), Routine(self.watch_name, 0, [*self.background()], [])]
        for each in (main, *routines, *faults):
            head = self.heading(units) if each is main else []
            steps = enumerate([*head, *each.body, "End"], start=1)
            files[f"{each.name}.prg"] = join_lines([*(f"{number} {step}" for number, step in steps), *each.data])
        return files


def _plain(text: str) -> str:
    return make_name(text, 200).replace("_", "")


def _components(pose: Pose) -> str:
    return f"({','.join(pose_words(pose, fixed_xyz))})"
