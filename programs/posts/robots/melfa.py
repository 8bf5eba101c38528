"""Mitsubishi MELFA-BASIC V and VI: outputs where a move begins, by ``Wth``."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import ClassVar

from programs.errors import ProgramError
from programs.motion.analog import Counting
from programs.motion.installation import Installation
from programs.motion.lower import Capability, Lowered
from programs.motion.steps import Line, Mount, Reach, UseBoard, UseTool
from programs.pose import Pose, inverse
from programs.posts.dialect import Dialect, FileForm, ProgramFiles, Task
from programs.posts.layout import Layout, words_of
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import Block, Values, located, refusal, skip, statements_of
from programs.posts.rebuilt import Due
from programs.posts.writing.angles import fixed_xyz, from_fixed_xyz
from programs.posts.writing.axes import as_controller_counts
from programs.posts.writing.chapters import Chapter, Placed
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.forms import NUMBER, POSE, fill, pattern_of
from programs.posts.writing.frame import MOUNT_ERROR, under_each
from programs.posts.writing.joint_moves import CAUTIOUS, Pace
from programs.posts.writing.vocabulary import MELFA
from programs.posts.writing.wording import join_lines, make_name, pose_words
from programs.timing.controller import ARM

_RIGHT, _ABOVE, _NOT_FLIPPED = 4, 2, 1
"""Bits of the structure flag."""
_ARM = 6


class MelfaBasic(Syntax):
    """MELFA-BASIC: programs of numbered steps, with their positions behind them."""

    mark = "' "
    longest_comment = longest_heading = 117
    call_form = 'CallP "{routine}"'
    pause_form = "Dly {seconds:3}"
    mount_forms = ("' error {error}: {mount}", "Error {error}", "Hlt")
    hold_forms = ("' {mount}", "Hlt")
    modal = ("JOvrd {percent:0}", "Spd {speed:~1}")
    turn_form = "Spd M_NSpd"
    """A turn on the spot has the controller's own rate."""
    pass_forms = ("Cnt 0", "Cnt 1,{zone:~2},{zone:~2}")
    move = "Mvs {point}{with_it: Wth {output}}"
    select_tool, select_board = ("Tool {name}",), ("Base {name}",)
    load_place = "parameter HNDDAT{tool}, before the size of the hand"
    payload_forms = ("LoadSet {slot:0},0",)
    begin = ("Ovrd 100", "Cnt 0")
    digital = "M_Out({number})={value}"
    group = "M_Outb({number})={value}"
    analog = "M_Outw({number})={value}"
    address_forms = ("M_Out({number})", "M_Outb({number})", "M_Outw({number})")
    contact_form, sensor_form = "M_In({number})", "M_Inw({number})"
    angles = ("A B C", "degrees about the fixed x, then y, then z axis", fixed_xyz)
    by_joints = "Mov {point}"
    straight = "Mvs {point}"
    start = "M_19"
    start_words = "enter its number in {start}"
    watch_note = ": the valves by itself, the robot as wired"
    part_form = ("If {start}<={number} Then {call}",)
    enter_begin = ("If {start}<>{number} Then GoTo *RUN", "{start}=1")
    enter_end = ("*RUN",)
    guard = (
        "' error 9100: the speed override is not 100 percent",
        "If M_OPovrd<>100 Then {fault}",
        "If M_OPovrd<>100 Then Error 9100",
    )
    wait_contact, wait_sensor = under_each(
        (
            "' error {error}: {message}",
            "M_Timer(1)=0",
            "*WAIT{index}",
            "If {condition} Then GoTo *READY{index}",
            "If M_Timer(1)<{ms} Then GoTo *WAIT{index}",
            "{fault}",
            "Error {error}",
            "*READY{index}",
        ),
        "M_In({input})={state}",
        "({reading})>={least}",
    )
    await_forms = ("Wait M_In({input})={state}",)
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
    shared = "WBSHUT and WBWATCH, the same in each; M_19"
    vocabulary = MELFA
    name_case, name_link, names_parts_by_program = "upper", "", True
    shut_name, watch_name = "WBSHUT", "WBWATCH"
    """The same for all programs of a cell."""
    indents_loops = False
    numbers_points_by_routine = True

    def spell_call(self, name: str) -> str:
        """Spell the name of a program of the integrator's: without underscores."""
        return make_name(name, 200).replace("_", "").upper()

    def initial_frames(self, chapter: Chapter) -> Sequence[UseTool | UseBoard | None]:
        """Select the tool, then the board."""
        return (chapter.tool, chapter.board)

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        super().__init__(dialect, lowered, installation)
        self.flag = _RIGHT + _ABOVE + _NOT_FLIPPED
        """Structure flag of the positions to come."""

    def stand(self, joints: tuple[float, ...]) -> None:
        """Take the structure flag of joints; where J5 is not negative the wrist is not flipped: assumed."""
        if len(joints) == _ARM:
            branch, counted = self.installation.branch(joints), as_controller_counts(joints, self.installation)
            self.flag = _RIGHT * branch.is_front + _ABOVE * branch.is_above + _NOT_FLIPPED * (counted[4] >= 0.0)

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Write a line; a move takes one output with it, others that begin there are set right before."""
        self.stand(line.joints)
        yield from self.stop_or_pass(line.blend_mm)
        if line.turns_on_the_spot:
            yield from self.set("speed", self.turn_form)
        else:
            yield from self.set_modal(speed=line.speed_mm_s)
        outputs = [self.output(event.channel, event.value) for event in placed.begins]
        yield from outputs[:-1]
        yield fill(self.move, point=self.point(line.target), with_it=outputs, output="".join(outputs[-1:]))
        yield from (self.output(event.channel, event.value) for event in placed.ends)

    def stop_or_pass(self, zone_mm: float) -> list[str]:
        """Have the motions to come stop, or be passed."""
        return self.set("passing", fill(self.pass_forms[zone_mm > 0.0], zone=zone_mm))

    def reach(self, reach: Reach) -> Iterator[str]:
        """Write a joint motion that stops."""
        self.stand(reach.joints)
        yield from self.stop_or_pass(0.0)
        yield from super().reach(reach)

    def joint_move(self, joints: tuple[float, ...], pace: Pace = CAUTIOUS) -> str:
        """Move to a joint position, and declare it."""
        self.points += 1
        self.data.append(f"J{self.points}=({','.join(self.joints(joints))})")
        return fill(self.by_joints, point=f"J{self.points}")

    def point(self, pose: Pose) -> str:
        """Declare a position."""
        self.points += 1
        self.data.append(f"P{self.points}={_components(pose)}({self.flag},0)")
        return f"P{self.points}"

    def use(self, step: UseTool | UseBoard) -> Iterator[str]:
        """Set tool or base; the base is the robot as seen from the board."""
        if isinstance(step, UseTool):
            name, pose = f"PTL{step.number}", self.installation.tool(step.number).T_flange_tcp
        else:
            places = ["", *self.installation.placements]
            number = places.index(step.placement) if step.placement in places else len(places)
            name, pose = f"PBS{number}", inverse(step.T_base_board)
        position = f"{name}={_components(pose)}(0,0)"
        if position not in self.data:
            self.data.append(position)
        yield fill((self.select_tool if isinstance(step, UseTool) else self.select_board)[0], name=name)
        if isinstance(step, UseTool) and self.installation.tool(step.number).payload.is_stated:
            yield from (fill(form, slot=step.number) for form in self.payload_forms)

    def rise(self) -> list[str]:
        """Raise the orifice of the first tool, as seen from the robot."""
        lines = super().rise()
        tool = next((step for step in self.motion.steps if isinstance(step, UseTool)), None)
        return ["Base P_NBase", *self.use(tool), *lines] if lines and tool is not None else []

    def setup(self) -> Iterator[Task]:
        """State what the integrator has to set up."""
        text = (
            f"{self.watch_name} in slot 2: shuts valves while slot 1 does not run, at errors, without what is watched"
        )
        watched = self.watched_lines("M_In({input}) {name}: wire it to stop the robot too: {words}")
        yield Task(text, (f"SLT2: {self.watch_name},REP,ALWAYS,1", *watched))
        mounts = {step.number: step for step in self.motion.steps if isinstance(step, Mount)}
        if mounts and not self.installation.tool_routine:
            texts = (f"{MOUNT_ERROR + number}: {step.words}" for number, step in mounts.items())
            yield Task("the texts of the errors that name the tools to mount (UER1 and up)", tuple(texts))

    def remarks(self) -> Iterator[str]:
        """State what the program uses, and what has to hold when it is started."""
        yield f"{self.start} is the part to start at; after a stop reset the program; errors 9100 up are used"

    def background(self) -> Iterator[str]:
        """Write the program of a slot that always runs: it shuts the valves."""
        lost = self.watched_lines("M_In({input})={other}")
        yield "*LOOP"
        for condition in ("M_Run(1)=0", "M_Err=1", *lost):
            yield from (f"If {condition} Then {line}" for line in self.shut())
        yield "GoTo *LOOP"

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write a file for each program: its steps by number, then its positions."""
        units = f"Units: mm, mm/s, degrees; positions in {self.cad_frame}, A B C about the fixed x, y, z"
        files: dict[str, str] = {}
        faults = [Routine(self.shut_name, 0, self.shut(), []), Routine(self.watch_name, 0, [*self.background()], [])]
        for each in (main, *routines, *faults):
            head = self.heading(units) if each is main else []
            steps = enumerate([*head, *each.body, "End"], start=1)
            files[f"{each.name}.prg"] = join_lines([*(f"{number} {step}" for number, step in steps), *each.data])
        return files


def _components(pose: Pose) -> str:
    return f"({','.join(pose_words(pose, fixed_xyz))})"


_POSITION = re.compile(pattern_of("{name}=({pose})({flag},0)", {"name": r"P\w+", "pose": POSE, "flag": "[0-7]"}))
_JOINTS = re.compile(pattern_of("{name}=({joints})", {"name": r"J\d+", "joints": rf"{NUMBER}(?:,{NUMBER})*"}))


class MelfaBasicReader(Reader):
    """All programs with their positions."""

    syntax, shut_name = MelfaBasic, MelfaBasic.shut_name
    handlers = frozenset({"main", "M_Run(1)=0", "M_Err=1"})
    texts: ClassVar[Mapping[str, str]] = {"point": r"[PJ]\d+", "name": r"P\w+"}

    def __init__(self) -> None:
        super().__init__()
        self.positions = self.declares("position")
        """Poses and joint values by program and name."""
        self.stops = True

    @classmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give the zone; turns on the spot have the controller's own rate."""
        return Due(line.blend_mm)

    def load(self, files: ProgramFiles) -> str:
        """Read steps, whose numbers grow, and positions."""
        for file, text in files.items():
            name = file.removesuffix(".prg")
            steps: list[str] = []
            last = 0
            for line in statements_of(file, text):
                number, _, statement = line.partition(" ")
                if not line:
                    continue
                if match := _POSITION.fullmatch(line):
                    self.positions.add((name, match[1]), read_pose(match[2].split(","), from_fixed_xyz), line)
                elif match := _JOINTS.fullmatch(line):
                    self.positions.add((name, match[1]), tuple(float(word) for word in match[2].split(",")), line)
                elif number.isdigit() and int(number) > last:
                    last = int(number)
                    step = line.become(statement.partition(" '")[0].strip())
                    steps += [] if not step or step.startswith("'") else [step]
                else:
                    raise refusal(line, f"is neither a step after {last} nor a position")
            if "End" not in steps or steps.index("End") != len(steps) - 1:
                raise ProgramError("the program does not end with End.", file=file, line=text.count("\n"))
            self.routines[name] = steps
        return next(iter(self.routines), "")

    def blocks(self) -> Iterator[Block]:
        """List the steps of forms."""
        yield [MelfaBasic.move], self.move
        yield [MelfaBasic.turn_form], lambda values: self.read_modal({"speed": "0"})
        yield from (([form], self.set_passing) for form in MelfaBasic.pass_forms)
        yield from (([form], skip) for form in (*MelfaBasic.last, "End"))
        yield from super().blocks()

    def read_shut(self) -> tuple[str, ...]:
        """Give the outputs that the fault routine shuts; the slot that always runs has to shut the same.

        Raises:
            ProgramError: it does not, or does something else.
        """
        self.called.add(MelfaBasic.watch_name)
        watching = self.routines.get(MelfaBasic.watch_name, [])
        if watching[:1] != ["*LOOP"] or watching[-2:] != ["GoTo *LOOP", "End"]:
            raise located("the slot that always runs does not go on and on.", next(iter(watching), ""))
        stopped: dict[str, set[str]] = {}
        for statement in watching[1:-2]:
            found = re.fullmatch(r"If (M_Run\(1\)=0|M_Err=1|M_In\((\d+)\)=([01])) Then M_Out\((\d+)\)=0", statement)
            if found is None:
                raise refusal(statement, "does not belong to the slot that always runs")
            stopped.setdefault(found[1], set()).add(f"digital {found[4]}")
            if found[2] and (found[2], found[3] == "0") not in self.watched:
                self.watched.append((found[2], found[3] == "0"))
        self.watches_inputs = any(each.startswith("M_Out") for each in self.routines.get(self.shut_name, []))
        self.shut_by |= set(stopped) if self.watches_inputs else self.handlers  # else there is no valve to shut
        shut = super().read_shut()
        if any(each != set(shut) for each in stopped.values()):
            raise located("the slot that always runs does not shut every valve.", watching[0])
        return shut

    def move(self, values: Values) -> None:
        """Move in a line; an output that goes with it is set where it begins."""
        if "output" in values:
            self.switch(*self.output_of(values["output"]))
        self.line(self.pose_of(values["point"]), self.stops, self.modal["speed"])

    def place_of(self, point: str) -> Pose | tuple[float, ...]:
        """Look up a position of the program that runs."""
        return self.positions.use((self.routine, point))

    def set_passing(self, values: Values) -> None:
        """Stop at the ends of lines, or pass them."""
        self.stops = "zone" not in values
        self.state(zone=float(values.get("zone", 0.0)))

    def frame_of(self, kind: str, label: str) -> Pose:
        """Look up a tool, or a base: the robot as seen from the board."""
        pose = self.pose_of(label)
        return pose if kind == "tool" else inverse(pose)


DIALECT = Dialect(
    title="Mitsubishi MELFA-BASIC",
    notes="For CR750, CR800 and the like; outputs by Wth at the beginning of a move. Base is the robot seen from the "
    "board; the controller keeps Base and Tool, so main ends with the defaults. Groups are M_Outb, analog channels "
    "M_Outw, 10000 at full scale. Where joints are not known structure flag 7 is assumed.",
    capability=Capability(
        controller_class=3,
        timing="boundary",
        cycle_s=0.0071,  # assumed: the motion cycle of CR750; CR800 has half of it
        step_mm_s=0.1,
        # Words of 16 bits; 10,000 at full scale is assumed: the module and its configuration decide.
        analog=Counting(full=10_000.0, step=1.0),
    ),
    layout=Layout(
        "'",
        comma=",",
        equals="=",
        single_blanks=True,
        leading_zero=True,
        powers=True,
        words=words_of(MelfaBasic, "End M_Err M_Run Wait Then And Error Z P# M# J# PBS# PTL# WAIT# READY# LOOP LOOP#"),
    ),
    form=FileForm(".prg", several=(".prg",)),
    longest_line=127,  # of a step (manual of CR1D)
    most_steps=2000,  # of a program: below 8,000 of the 32,767 step numbers; assumed
    write=MelfaBasic.write,
    rebuild=MelfaBasicReader.rebuild,
    controller=replace(
        ARM,
        turn_speed_deg_s=180.0,
        least_line_s=0.0071,
        most_lines=32_767,
        sources={"most_lines": "step numbers of a program (manual of CR1D)"},
    ),
    maker="mitsubishi",
)
