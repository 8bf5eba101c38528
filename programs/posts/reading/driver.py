"""The skeleton of every reader: what the statements of all languages do to motion and outputs."""

import math
import re
from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from typing import ClassVar

from programs.errors import ProgramError
from programs.motion.installation import Installation
from programs.motion.steps import Line
from programs.pose import Pose, Quaternion, distance
from programs.posts.dialect import ProgramFiles
from programs.posts.reading.execution import Block, FormAction, Values, skip
from programs.posts.reading.frame import FrameReader, seconds_of
from programs.posts.rebuilt import (
    Axes,
    Due,
    ReadBoard,
    ReadCall,
    ReadHold,
    ReadHome,
    ReadLine,
    ReadMount,
    ReadPause,
    ReadReach,
    ReadSignal,
    ReadSwitch,
    ReadTool,
    Rebuilt,
)
from programs.posts.writing.forms import pattern_of
from programs.posts.writing.frame import MOUNT_ERROR

_SAME_PLACE_MM = 5e-4
"""Places nearer than this are written with the same three decimals."""

_MOST_DEGREES = 360.0
_UNIT = 3e-7
"""How far the length of a quaternion with seven decimals may be off."""


class Reader(FrameReader, ABC):
    """A controller while it executes one program; a language is a subclass with a grammar."""

    texts: ClassVar[Mapping[str, str]] = {}
    """Pattern of each text in the language's own forms, by the name of its field."""
    writes_lines: ClassVar[bool] = True
    """Whether a line of the plan is one motion, and not several of the axes."""
    load_forms: ClassVar[tuple[str, ...]] = ()
    """Of what tools weigh, where that is entered in a table."""
    goes_home: ClassVar[bool] = True
    """Whether the language can go to joint values, as those of home."""
    home_in_tool_points: ClassVar[bool] = True
    """Whether home is a tool point too, where the cell's controller takes those."""

    def __init__(self) -> None:
        super().__init__()
        self.homes: list[ReadHome] = []
        """Motions to joint values; those from which a pose is reached are taken out again."""
        self.rise_mm: float | None = None
        """Height to which the orifice is raised before anything else moves."""
        self.pose: Pose | None = None
        self.tool: ReadTool | None = None
        self.board: ReadBoard | None = None
        self.counted: tuple[float, ...] = ()
        """Joint values that it came to, as the controller counts them, degrees or mm: the next motion ends there.

        Empty where the last motion was no such one."""
        self.speed_share: float | None = None
        """Of joint motions, where their speed is modal or that of the last one to joint values."""
        self.lasts_s: float | None = None
        """Time that the last motion to joint values states."""
        self.modal = defaultdict[str, float](float)
        """Numbers of the modal statements in force, by the names of their fields; 0 of others."""
        self.terms = ReadLine(Axes(()), None, None)
        """Zone, turn rate and acceleration that are in force, or that the line to come states."""
        self.flags = ""
        """How the arm stands at the position that was read last."""
        self.slots = self.declares("frame")
        """Poses of tools and places of the board, by kind and slot."""
        self._used: tuple[ReadTool | None, ReadBoard | None] = (None, None)

    @classmethod
    def rebuild(cls, files: ProgramFiles) -> Rebuilt:
        """Execute a program's files, each loop once.

        Raises:
            ProgramError: a file is missing, or a statement is not as the writer writes it.
        """
        reader = cls.loaded(files)
        reader.run(reader.main)
        steps, places = tuple(reader.steps), tuple(reader.places)
        frame = reader.read_frame()
        reader.finish()
        return Rebuilt(
            steps,
            places=places,
            frame=frame,
            dues=cls.due if cls.writes_lines else None,
            arm_due=cls.arm_due,
            rise_mm=reader.rise_mm,
            homes=tuple(reader.homes) if cls.goes_home else None,
            home_in_tool_points=cls.home_in_tool_points,
            states_loads=any("{mass" in form for form in (*cls.syntax.payload_forms, *cls.load_forms)),
        )

    @classmethod
    @abstractmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give what the text of a line has to state; another line may come right after it."""

    @classmethod
    def arm_due(cls, joints: tuple[float, ...], installation: Installation) -> str | None:
        """Give what a position has to state of the arm at joints; ``None`` where that is not compared."""
        return None

    # Statements that many languages have

    def blocks(self) -> Iterator[Block]:
        """Give the forms of the frame, of outputs, motions and calls."""
        syntax = self.syntax
        yield from super().blocks()
        yield from (([form], self.read_switch) for form in self.output_forms() if form)
        yield from (([form], self.read_modal) for form in syntax.modal)
        motions: list[tuple[str, FormAction]] = [
            (syntax.pause_form, self.pause),
            (syntax.to_joints, self.move_joints),
            (syntax.by_joints, self.move_by_joints),
            (syntax.straight, self.go_straight),
            (syntax.declare_counter, lambda values: self.counters.add(values["counter"], 0, self.statement)),
            *((form, self.select_tool) for form in syntax.select_tool),
            *((form, self.select_board) for form in syntax.select_board),
            (syntax.set_tool, lambda values: self.set_slot("tool", values)),
            (syntax.set_board, lambda values: self.set_slot("board", values)),
        ]
        yield from (([form], action) for form, action in motions if form)
        yield from (([form], self.read_payload) for form in syntax.payload_forms)
        yield from (([form], skip) for form in syntax.begin)
        if mounts := self.nested(syntax.mount_forms):
            yield mounts, self.read_mount
        if holds := self.nested(syntax.hold_forms):
            yield holds, lambda values: self.steps.append(ReadHold())
        yield [syntax.their_call_form or syntax.call_form], self.read_call

    def fields(self) -> Mapping[str, str]:
        """Give the pattern of each field of the writer's forms."""
        fields = super().fields()
        outputs = dict.fromkeys(("group_value", "analog_value"), fields["least"])
        return {**fields, **outputs, "off_on": "|".join(self.syntax.off_on), "output": ".*", **self.texts}

    def output_forms(self) -> list[str]:
        """Give the forms of outputs, of each kind; their values are fields of the kind."""
        syntax = self.syntax
        names = {"digital": "off_on", "group": "group_value", "analog": "analog_value"}
        return [getattr(syntax, kind).replace("{value}", f"{{{name}}}") for kind, name in names.items()]

    def read_switch(self, values: Values) -> None:
        """Set an output."""
        self.switch(*self.switched(values))

    def switched(self, values: Values) -> tuple[str, float]:
        """Give the channel and the value of an output."""
        if "off_on" in values:
            kind, value = "digital", float(self.syntax.off_on.index(values["off_on"]))
        else:
            kind = "group" if "group_value" in values else "analog"
            value = float(self.number(values[f"{kind}_value"]))
        return values.get("name") or f"{kind} {values['number']}", value

    def output_of(self, text: str) -> tuple[str, float]:
        """Read an output that stands in another statement.

        Raises:
            ProgramError: it is none.
        """
        for form in self.output_forms():
            if match := re.fullmatch(pattern_of(form, self.fields()), text):
                return self.switched(match.groupdict())
        raise ProgramError(f"unknown statement {self.routines[self.routine][self.at]!r}.")

    def read_mount(self, values: Values) -> None:
        """Stop until a tool is mounted: that of the message, or of the error; or where the message names none."""
        number = values.get("mounted")
        if number or "error" in values:
            self.steps.append(ReadMount(int(number) if number else int(values["error"]) - MOUNT_ERROR))
        else:
            self.steps.append(ReadHold())

    def read_call(self, values: Values) -> None:
        """Call a routine by its name."""
        self.call(values["routine"])

    def call(self, name: str) -> None:
        """Call a routine: one of the program's, or one of the integrator's."""
        if name in self.routines:
            self.run(name)
        else:
            self.steps.append(ReadCall(name))

    def pause(self, values: Values) -> None:
        """Hold the pose; what follows a wait of the longest time that a statement takes belongs to it."""
        seconds, longest_s = seconds_of(values), self.syntax.longest_wait_s
        last = self.steps[-1] if self.steps else None
        waits = last.duration_s / longest_s if isinstance(last, ReadPause) and longest_s else 0.0
        if isinstance(last, ReadPause) and waits > 0.5 and abs(waits - round(waits)) < 1e-9:
            self.steps[-1] = ReadPause(last.duration_s + seconds)
        else:
            self.steps.append(ReadPause(seconds))

    def read_modal(self, values: Values) -> None:
        """Keep a number for the motions after this statement."""
        if "percent" in values:
            self.set_share(values["percent"])
        self.modal |= {name: float(value) for name, value in values.items()}

    def switch(self, channel: str, value: float) -> None:
        """Set an output."""
        self.steps.append(ReadSwitch(channel, value))

    def use_tool(self, label: str, T_flange_tcp: Pose | None) -> None:  # noqa: N803
        """Use another tool from now on; its pose is not known where it is in the controller's table."""
        self.tool = ReadTool(label, T_flange_tcp)

    def read_payload(self, values: Values) -> None:
        """State what the tool weighs, as far as the statement does."""
        centre = (1000.0 * float(values[axis]) for axis in "xyz" if axis in values)
        self.weigh((float(values["mass"]), *centre) if "mass" in values else ())

    def weigh(self, load: tuple[float, ...]) -> None:
        """Keep what the tool weighs: mass in kg, centre of gravity in mm.

        Raises:
            ProgramError: no tool is selected.
        """
        if self.tool is None:
            raise ProgramError("a load is stated before a tool is selected.")
        self.tool = replace(self.tool, load=load)

    def use_board(self, T_base_board: Pose | None) -> None:  # noqa: N803
        """Use another frame from now on."""
        self.board = ReadBoard(T_base_board)

    # Joint motions

    def move_joints(self, values: Values) -> None:
        """Come to joint values."""
        if "percent" in values:
            self.set_share(values["percent"])
        self.come_to(float(word) for word in values["joints"].split(","))

    def move_by_joints(self, values: Values) -> None:
        """Come to a place by a joint motion."""
        if "percent" in values:
            self.set_share(values["percent"])
        place = self.place_of(values["point"])
        if isinstance(place, Pose):
            self.reach(place)
        else:
            self.come_to(place)

    def go_straight(self, values: Values) -> None:
        """Come to a pose by the line that is left after its joint values."""
        self.reach(self.pose_of(values["point"]), self.counted)

    def place_of(self, point: str) -> Pose | tuple[float, ...]:
        """Give the pose, or the joint values, of a point."""
        raise NotImplementedError

    def pose_of(self, point: str) -> Pose:
        """Give the pose of a point.

        Raises:
            ProgramError: it has joint values.
        """
        pose = self.place_of(point)
        if not isinstance(pose, Pose):
            raise ProgramError(f"{point} is a joint position.")
        return pose

    def set_slot(self, kind: str, values: Values) -> None:
        """Set the frame of a slot."""
        self.slots.add((kind, values["slot"]), self.pose_of(values["frame"]), self.statement)

    def select_tool(self, values: Values) -> None:
        """Use another tool from now on: that of a slot, or of a name."""
        label = values.get("slot") or values["name"]
        self.use_tool(label, self.frame_of("tool", label))

    def select_board(self, values: Values) -> None:
        """Use another frame from now on: that of a slot, or of a name."""
        self.use_board(self.frame_of("board", values.get("slot") or values["name"]))

    def frame_of(self, kind: str, label: str) -> Pose:
        """Give the pose of a tool or a place of the board."""
        return self.slots.use((kind, label))

    def use_first_tool(self, name: str) -> None:
        """Use the tool whose orifice is raised."""
        if self.syntax.set_tool:
            self.slots.use(("tool", name))

    def set_share(self, percent: str) -> None:
        """Set the speed of joint motions.

        Raises:
            ProgramError: it is none.
        """
        self.speed_share = 0.01 * float(percent)
        if not 0.0 < self.speed_share <= 1.0:
            raise ProgramError(f"{percent} percent is no speed of a joint motion.")

    def come_to(self, counted: Iterable[float]) -> None:
        """Come to joint values, as the controller counts them."""
        self.counted = self.come_home(counted)

    def come_home(self, counted: Iterable[float]) -> tuple[float, ...]:
        """Come to joint values from which no pose is reached, and give them."""
        joints = tuple(counted)
        self.homes.append(ReadHome(len(self.steps), joints, self.speed_share))
        return joints

    def reach(self, pose: Pose, counted: tuple[float, ...] = ()) -> None:
        """Come to a pose by a joint motion: to joint values, or to the pose itself where there are none."""
        if counted:
            self.homes.pop()
        self._use_frames()
        self.steps.append(ReadReach(pose, counted, self.speed_share, self.lasts_s, self.flags))
        self.pose, self.counted, self.lasts_s = pose, (), None

    # Straight motions

    def raise_to(self, height_mm: float) -> None:
        """Raise the orifice to a height before anything else moves.

        Raises:
            ProgramError: something moved before.
        """
        moved = any(isinstance(step, ReadLine | ReadReach) for step in self.steps)
        if moved or self.homes or self.rise_mm is not None:
            raise ProgramError("the orifice is raised after other motions.")
        self.rise_mm = height_mm

    def line(self, pose: Pose, stops: bool, speed_mm_s: float, signals: tuple[ReadSignal, ...] = ()) -> None:
        """Go straight to a pose, under ``terms``; after joint values it is there already."""
        if self.counted or self.pose is None:
            self.reach(pose, self.counted)
            return
        self._use_frames()
        zone = 0.0 if stops else self.terms.zone
        terms = self.terms
        self.steps.append(
            ReadLine(
                target=pose,
                stops=stops,
                speed_mm_s=speed_mm_s,
                signals=signals,
                zone=zone,
                turn_deg_s=terms.turn_deg_s,
                duration_s=terms.duration_s,
                acceleration_mm_s2=terms.acceleration_mm_s2,
                turn_acceleration_deg_s2=terms.turn_acceleration_deg_s2,
                arm=self.flags,
            )
        )
        self.pose = pose

    def state(self, **terms: float | None) -> None:
        """Put terms of lines in force: ``zone``, ``turn_deg_s``, ``duration_s``, and accelerations."""
        if any(getattr(self.terms, name) != value for name, value in terms.items()):
            self.terms = replace(self.terms, **terms)  # pyright: ignore[reportArgumentType]

    def length_to(self, pose: Pose) -> float:
        """Millimetres to a pose; 0 where the tool only turns, and where the robot's own pose is not known."""
        length_mm = distance(self.pose, pose) if self.pose is not None else 0.0
        return length_mm if length_mm > _SAME_PLACE_MM else 0.0

    def _use_frames(self) -> None:
        self.check_watched()
        if self.tool is None or self.board is None:
            raise ProgramError("the program moves before it selects a tool and a frame.")
        if (self.tool, self.board) != self._used:
            self.steps += [self.tool, self.board]
            self._used = (self.tool, self.board)


def checked(quaternion: Quaternion) -> Quaternion:
    """Give a quaternion that is of unit length to its digits, as controllers demand it.

    Raises:
        ProgramError: it is not.
    """
    if abs(math.hypot(*quaternion) - 1.0) > _UNIT:
        raise ProgramError(f"the quaternion {quaternion} is not of unit length.")
    return quaternion


def read_pose(numbers: Iterable[str], orientation: Callable[[float, float, float], Quaternion]) -> Pose:
    """Read a pose: x, y, z in mm, then the angles of a maker."""
    x, y, z, a, b, c = map(float, numbers)
    if max(map(abs, (a, b, c))) > _MOST_DEGREES:
        raise ProgramError("an angle of a pose is more than a turn.")
    return Pose((x, y, z), orientation(a, b, c))
