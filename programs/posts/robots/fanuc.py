"""FANUC TP programs (.ls): outputs so many hundredths of a second before the end of a motion, by ``TB``."""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import ClassVar

from programs.errors import ProgramError
from programs.motion.analog import Counting
from programs.motion.installation import Installation
from programs.motion.lower import Capability, Lowered
from programs.motion.steps import Line
from programs.motion.tracks import widest_zone
from programs.pose import Pose
from programs.posts.dialect import Dialect, FileForm, ProgramFiles, Task
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import Block, FormAction, Values, look_up, refusal, skip
from programs.posts.rebuilt import Due, ReadSignal
from programs.posts.robots.fanuc_text import (
    FIELDS,
    NOTES,
    hundredths,
    joints_text,
    pose_text,
    position_text,
    read_program,
    write_program,
)
from programs.posts.writing.angles import fixed_xyz, from_fixed_xyz
from programs.posts.writing.axes import as_controller_counts
from programs.posts.writing.chapters import Chapter, Placed, is_straight
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.forms import fill, pattern_of
from programs.posts.writing.joint_moves import CAUTIOUS, Pace
from programs.posts.writing.vocabulary import TP
from programs.posts.writing.wording import pose_words, split_wait
from programs.timing.controller import ARM

READING = 90
_COUNTER, POSITION = 91, 91
"""Registers: R[91] and up count loops, R[90] holds a reading; PR[91] is used by the program of frames. Assumed free."""
SLOW_CORNER_S = 0.05
"""At CNT100 a corner is rounded by about the way of half the time to brake; assumed 0.1 s."""
_READ = (f"R[{READING}]=AI[{{input}}]*{{scale}}", f"R[{READING}]=R[{READING}]+{{offset}}")
"""An analog input into the register that holds a reading."""
_STEP_MM_S = 1.0 / 6.0
"""1 cm/min: speeds are whole, in mm/sec or in cm/min."""


def percent_kept(line: Line, after: Line | None) -> int:
    """Give the number of CNT: how much of the speed is kept at the end of a line that is passed.

    Straight on, CNT100 leaves the path alone. Elsewhere the corner is cut no more than a zone may cut it; other than
    zones, the overlaps of two corners may meet, so that short lines limit none.
    """
    if is_straight(line, after):
        return 100
    way_mm = line.blend_mm if after is None else max(line.blend_mm, widest_zone(line, after))
    return min(max(math.floor(100.0 * way_mm / max(line.speed_mm_s * SLOW_CORNER_S, 0.1)), 1), 100)


class Tp(Syntax):
    """TP programs: numbered instructions, and positions in numbered frames."""

    mark = "!"
    longest_comment = 32
    call_form = "CALL {routine}"
    digital = "DO[{number}]={value}"
    group = "GO[{number}]={value}"
    analog = "AO[{number}]={value}"
    address_forms = ("DO[{number}]", "GO[{number}]", "AO[{number}]")
    contact_form, sensor_form = "DI[{number}]", "AI[{number}]"
    angles = ("W P R", "degrees about the fixed x, then y, then z axis", fixed_xyz)
    off_on = ("OFF", "ON")
    select_tool = ("UTOOL_NUM={slot}",)
    select_board = ("UFRAME_NUM={slot}",)
    payload_forms = ("PAYLOAD[{slot:0}]",)
    load_forms = (
        "$PLST_GRP1[{slot:0}].$PAYLOAD={mass:~3}",
        *(f"$PLST_GRP1[{{slot:0}}].$PAYLOAD_{axis.upper()}={{{axis}}}" for axis in "xyz"),
    )
    """Enter what a tool weighs in the schedule of its number: kg, and cm from the flange; assumed units."""
    move = "L {point} {speed:0}{unit} {ending}{ahead: TB {lead}sec,{output}}"
    pause_form = "WAIT {seconds}(sec)"
    longest_wait_s = 327.0  # of 327.67 s
    mount_forms = ("MESSAGE[{mount}]", "PAUSE")
    longest_call = 36
    by_joints = "J {point} {percent}% FINE"
    straight = "L {point} 100mm/sec FINE"
    enter_forms = (
        f"PR[{POSITION}]=LPOS",
        f"PR[{POSITION},{{axis:0}}]={{value}}",
        f"{{table}}[{{slot}}]=PR[{POSITION}]",
    )
    """Make the position register cartesian, enter a number of a frame, enter that in the controller's table."""
    background_forms = ("IF (!UO[3]),{shut}", "IF (DI[{input}]={other}),{shut}")
    counter = "R[{number}]"
    first_counter = _COUNTER
    loop_text = "until {key} >= {least}"
    loop_begin = ("{counter}=0", "LBL[{number}]", "{counter}={counter}+1")
    loop_end = ("IF {counter}<{count},JMP LBL[{number}]",)
    sensed_end = (*_READ, f"IF {{counter}}<{{count}} AND R[{READING}]<{{least}},JMP LBL[{{number}}]")
    brackets = "()"
    start = "R[89]"
    start_words = "enter its number in {start}"
    watch_note = ": the valves by itself, the robot as wired"
    states = ("OFF", "ON")
    part_form = ("IF {start}<={number},{call}",)
    enter_begin = ("IF {start}<>{number},JMP LBL[99]", "{start}=1")
    enter_end = ("LBL[99]",)
    guard = (
        "R[88]=$MCR.$GENOVERRIDE",
        "IF R[88]=100,JMP LBL[88]",
        "{fault}",
        "MESSAGE[OVERRIDE IS NOT 100]",
        "ABORT",
        "LBL[88]",
    )
    wait_contact = (
        "R[87]=$WAITTMOUT",
        "$WAITTMOUT={hundredths}",
        "WAIT DI[{input}]={state} TIMEOUT,LBL[{label}]",
        "JMP LBL[{ready}]",
        "LBL[{label}]",
        "$WAITTMOUT=R[87]",
        "{fault}",
        "MESSAGE[{message}]",
        "ABORT",
        "LBL[{ready}]",
        "$WAITTMOUT=R[87]",
    )
    wait_sensor = (
        *("R[88]=0", "LBL[{label}]", *_READ, f"IF R[{READING}]>={{least}},JMP LBL[{{ready}}]"),
        *("WAIT .10(sec)", "R[88]=R[88]+1", "IF R[88]<{tenths},JMP LBL[{label}]", *wait_contact[6:-1]),
    )
    await_forms = ("WAIT DI[{input}]={state}",)
    rise_forms = (
        "UFRAME_NUM=0",
        "UTOOL_NUM={tool}",
        f"PR[{POSITION}]=LPOS",
        f"R[88]=PR[{POSITION},3]",
        "IF R[88]>={height},JMP LBL[98]",
        f"PR[{POSITION},3]={{height}}",
        f"L PR[{POSITION}] 100mm/sec FINE",
        "LBL[98]",
    )
    longest_message = 24
    shared = "WB_SHUT and WB_BACK, the same in each; UFRAME, UTOOL by number: run the FR program when the board changes"
    name_case, name_link, names_parts_by_program = "upper", "", True
    shut_name, background_name = "WB_SHUT", "WB_BACK"
    """The same for all programs of a cell."""
    page = ".txt"
    vocabulary = TP
    indents_loops = False
    numbers_points_by_routine = True

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        super().__init__(dialect, lowered, installation)
        self.configuration = "N U T, 0, 0, 0"
        self.frames_name = self.names.give("frames", 0, f"{self.name}FR")

    def setup(self) -> Iterator[Task]:
        """State what the integrator has to set up."""
        yield Task(
            f"BG logic (mixed logic): run {self.background_name}, it shuts the valves while no program runs (UO[3])"
        )
        yield Task(
            f"run {self.frames_name} once, at low speed: it enters UTOOL, UFRAME and loads; or enter taught ones"
        )
        yield from self.watch_tasks("wire to UI[2] (*HOLD) too what BG logic watches", "DI[{input}] {name}: {words}")

    def remarks(self) -> Iterator[str]:
        """State what the program uses, and what has to hold when it is started."""
        yield f"{self.start} is the part to start at; R[87], R[88], R[{READING}] are used; after a stop run main again"
        yield f"W, P, R turn about the fixed x, then y, then z axis; points are in {self.cad_frame}"
        yield from NOTES

    def background(self) -> Iterator[str]:
        """Write the BG logic: it shuts the valves while no program runs, or without what is watched."""
        for shut in (line.replace("OFF", "(OFF)") for line in self.shut()):
            yield from (form.replace("{shut}", shut) for form in self.background_forms[:1])
            yield from self.watched_lines(self.background_forms[1].replace("{shut}", shut))

    def comment(self, text: str, longest: int = 0) -> str:
        """Write a remark; a semicolon would end it."""
        return super().comment(text, longest).replace(";", ",")

    def number(self, value: float) -> str:
        """Write the value of an output; a negative one stands in brackets."""
        return self.operand(value)

    def chapter(self, chapter: Chapter) -> Iterator[str]:
        """Write a program; its first remark is its title."""
        yield self.comment(chapter.title)
        yield from super().chapter(chapter)

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Write a motion with at most one output."""
        turns, event = line.turns_on_the_spot, self.only_event(line)
        words = {"ahead": event is not None}
        if event is not None:
            output = self.output(event.channel, event.value)
            words |= {"lead": hundredths(-event.offset_s), "output": output}
        speed, unit = line.speed_mm_s, "mm/sec"
        if turns:
            speed, unit = max(math.floor(math.degrees(line.turn_rad_s) + 0.3), 1), "deg/sec"
        elif abs(speed - round(speed)) > 0.5 * _STEP_MM_S:
            speed, unit = speed / _STEP_MM_S, "cm/min"
        yield fill(
            self.move,
            point=self.point(line.target),
            speed=speed,
            unit=unit,
            ending=self.termination(line),
            **words,
        )

    def termination(self, line: Line) -> str:
        """FINE stops, CNT passes."""
        if line.blend_mm == 0.0:
            return "FINE"
        return f"CNT{percent_kept(line, self.following.get(id(line)))}"

    def pause(self, seconds: float) -> Iterator[str]:
        """Write as many waits as it takes."""
        waits = split_wait(seconds, self.longest_wait_s, 2)
        yield from (fill(self.pause_form, seconds=hundredths(each)) for each in waits)

    def point(self, pose: Pose) -> str:
        """Declare a position in the frames in use."""
        return self.declare(pose_text(pose, self.configuration))

    def height(self, millimetres: float) -> str:
        """Write a height; a negative one stands in brackets."""
        return self.operand(millimetres)

    def joint_move(self, joints: tuple[float, ...], pace: Pace = CAUTIOUS) -> str:
        """Move to joint values, and declare them."""
        values = as_controller_counts(joints, self.installation)
        kinds = self.installation.joint_kinds(len(joints))
        if kinds[:3] == ["revolute"] * 3:
            turns = [math.floor((value + 180.0) / 360.0) for value in (values[0], *values[3:6:2])]
            flip = "F" if len(values) > 4 and values[4] > 0.0 else "N"
            branch = self.installation.branch(joints)
            arm = f"{'U' if branch.is_above else 'D'} {'T' if branch.is_front else 'B'}"
            self.configuration = f"{flip} {arm}, {', '.join(str(turn) for turn in [*turns, 0, 0, 0][:3])}"
        return fill(self.by_joints, point=self.declare(joints_text(values, kinds)), percent=pace.percent)

    def declare(self, what: str) -> str:
        """Declare a position."""
        self.points += 1
        self.data.append(position_text(self.points, self.slots.board, self.slots.tool, what))
        return f"P[{self.points}]"

    def home(self) -> Iterator[str]:
        """Go home with the first tool."""
        if self.installation.home:
            self.slots.board, self.slots.tool = 1, next(iter(self.slots.tools), 1)
            yield fill(self.select_board[0], slot=self.slots.board)
            yield fill(self.select_tool[0], slot=self.slots.tool)
            yield self.joint_move(self.installation.home)

    def entries(self) -> Iterator[str]:
        """Enter the cell's frames in the controller's tables; the position register is made cartesian first."""
        begin, number, enter = self.enter_forms
        yield self.comment("Enter the frames of the cell")
        yield begin
        for kind, slot, _, pose in self.slots.entries(self.installation):
            for axis, word in enumerate(pose_words(pose, fixed_xyz), start=1):
                yield fill(number, axis=axis, value=self.operand(float(word)))
            yield fill(enter, table="UTOOL" if kind == "tool" else "UFRAME", slot=slot)
        for number, slot in self.slots.tools.items():
            tool = self.installation.tool(number)
            words: dict[str, object] = dict(
                zip("xyz", (self.operand(0.1 * each, 3) for each in tool.centre_mm), strict=True)
            )
            forms = self.load_forms if tool.payload.is_stated else ()
            yield from (fill(form, slot=slot, mass=tool.payload.mass_kg, **words) for form in forms)

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write main, a program for each routine, one that enters the frames, and a page for the integrator."""
        files = {f"{each.name}.ls": write_program(each.name, each.body, each.data) for each in (main, *routines)}
        own = {self.frames_name: self.entries(), self.shut_name: self.shut(), self.background_name: self.background()}
        files |= {f"{name}.ls": write_program(name, list(body), []) for name, body in own.items()}
        return {**files, **self.sheet(next(iter(files)))}


class TpReader(Reader):
    """All programs with their positions, and the controller's tables."""

    syntax, shut_name = Tp, Tp.shut_name
    handlers, load_forms = frozenset({"main", "BG logic"}), Tp.load_forms
    texts: ClassVar[Mapping[str, str]] = FIELDS

    def __init__(self) -> None:
        super().__init__()
        self.positions = self.declares("position")
        """User frame, tool, and pose or joint values, by program and number."""
        self.tables: dict[tuple[str, str], Pose] = {}
        self.register = [""] * 6
        self.loads: dict[str, tuple[float, ...]] = {}
        self.frames: dict[str, str] = {}

    @classmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give the share of CNT, and whole degrees a second."""
        turns = line.turns_on_the_spot
        rate = max(math.floor(math.degrees(line.turn_rad_s) + 0.3), 1) if turns else None
        return Due(0.01 * percent_kept(line, after), rate)

    def load(self, files: ProgramFiles) -> str:
        """Read the programs; the first is the main one, which begins when that of the frames has been run."""
        programs = {file.removesuffix(".ls"): text for file, text in files.items() if file.endswith(".ls")}
        for name, text in programs.items():
            self.routines[name], positions = read_program(name, text)
            for number, position in positions.items():
                self.positions.add((name, number), position)
        enters = [name for name, text in programs.items() if re.search(pattern_of(Tp.enter_forms[2], FIELDS), text)]
        self.routines["(all)"] = [*(f"CALL {name}" for name in enters), f"CALL {next(iter(programs), '')}"]
        return "(all)"

    def blocks(self) -> Iterator[Block]:
        """List the instructions of forms."""
        yield [Tp.move], self.move
        yield from super().blocks()
        yield Tp.load_forms, self.enter_load
        actions: tuple[FormAction, ...] = (skip, self.enter_value, self.enter_frame)
        yield from (([form], action) for form, action in zip(Tp.enter_forms, actions, strict=True))

    def read_shut(self) -> tuple[str, ...]:
        """Give the outputs that the fault routine shuts; the BG logic has to shut the same, under each condition.

        Raises:
            ProgramError: it does not, or does something else.
        """
        self.called.add(Tp.background_name)
        stopped: dict[str, set[str]] = {"!UO[3]": set()}
        for statement in self.routines.get(Tp.background_name, []):
            found = re.fullmatch(r"IF \((!UO\[3\]|DI\[(\d+)\]=(ON|OFF))\),DO\[(\d+)\]=\(OFF\)", statement)
            if found is None:
                raise refusal(statement, "does not belong to the BG logic")
            stopped.setdefault(found[1], set()).add(f"digital {found[4]}")
            if found[2] and (found[2], found[3] == "OFF") not in self.watched:
                self.watched.append((found[2], found[3] == "OFF"))
        self.shut_by.add("BG logic")
        shut = super().read_shut()
        self.watches_inputs = bool(shut)  # without a valve there is nothing to do when one leaves its state
        if wrong := next((condition for condition, each in stopped.items() if each != set(shut)), None):
            raise ProgramError(f"under {wrong} the BG logic shuts {sorted(stopped[wrong])}, not {sorted(shut)}.")
        return shut

    def enter_value(self, values: Values) -> None:
        """Enter a number into the position register, once for each frame."""
        at = int(values["axis"]) - 1
        if self.register[at]:
            raise ProgramError(f"number {at + 1} of a frame is entered twice.")
        self.register[at] = self.number(values["value"])

    def enter_frame(self, values: Values) -> None:
        """Enter the position register into a table."""
        key = values["table"], values["slot"]
        if key in self.tables or "" in self.register:
            raise ProgramError(f"{key[0]}[{key[1]}] is entered twice, or without all numbers.")
        self.tables[key] = read_pose(self.register, from_fixed_xyz)
        self.register = [""] * 6

    def enter_load(self, values: Values) -> None:
        """Enter what a tool weighs."""
        centre = (10.0 * float(self.number(values[axis])) for axis in "xyz")
        self.loads[values["slot"]] = (float(values["mass"]), *centre)

    def read_payload(self, values: Values) -> None:
        """Use what was entered."""
        self.weigh(look_up(self.loads, values["slot"], f"payload {values['slot']}"))

    def frame_of(self, kind: str, label: str) -> Pose:
        """Look up an entry of a table, and keep its number."""
        table = "UTOOL" if kind == "tool" else "UFRAME"
        self.frames[table] = label
        return look_up(self.tables, (table, label), f"{table}[{label}]")

    def use_first_tool(self, name: str) -> None:
        """Use the tool whose orifice is raised."""
        look_up(self.tables, ("UTOOL", name), f"UTOOL[{name}]")

    def place_of(self, point: str) -> Pose | tuple[float, ...]:
        """Look up a position, taught in the frames in use."""
        number = point[2:-1]
        frame, tool, pose = self.positions.use((self.routine, number))
        if (frame, tool) != (self.frames.get("UFRAME"), self.frames.get("UTOOL")):
            raise ProgramError(f"P[{number}] is of frame {frame} and tool {tool}, which are not in use.")
        return pose

    def move(self, values: Values) -> None:
        """Move in a line."""
        pose, speed, ending = self.pose_of(values["point"]), float(values["speed"]), values["ending"]
        signals = ()
        if "lead" in values:
            signals = (ReadSignal(*self.output_of(values["output"]), 1.0, -float(values["lead"])),)
        turns = values["unit"] == "deg/sec"
        speed *= _STEP_MM_S if values["unit"] == "cm/min" else 1.0
        zone = 0.0 if ending == "FINE" else 0.01 * float(ending.removeprefix("CNT"))
        self.state(zone=zone, turn_deg_s=speed if turns else None)
        self.line(pose, ending == "FINE", 0.0 if turns else speed, signals)


DIALECT = Dialect(
    title="FANUC TP",
    notes="ASCII programs for R-30iA and newer (option ASCII Upload). Run the program that ends in FR once, or enter "
    "your own UFRAME and UTOOL. Analog channels count 2000 at full scale.",
    capability=Capability(
        controller_class=1,
        timing="time",
        cycle_s=0.008,  # assumed: the interpolator's period of an R-30iB
        references=("end",),
        step_s=0.01,  # TB has two decimals
        step_mm_s=_STEP_MM_S,
        most_events=1,  # one TB on a motion
        # AI and AO are whole numbers: users cite the manual of the AAD04A, 2000 for 10 V; assumed of other modules.
        analog=Counting(full=2000.0, step=1.0),
    ),
    form=FileForm(".ls", several=(".ls", ".txt")),
    longest_line=120,
    most_steps=800,  # of a program, each motion an instruction and a position; assumed, the memory is the limit
    write=Tp.write,
    rebuild=TpReader.rebuild,
    controller=replace(
        ARM,
        blending="overlap",
        rise_s=0.03,
        least_line_s=0.016,
        most_positions=9_999,
        sources={"least_line_s": "two periods of the interpolator of 8 ms, assumed"},
    ),
    maker="fanuc",
)
