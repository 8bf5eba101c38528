"""Steps of a program in one language: its words and limits, the names in use, and how each kind is written."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping
from collections.abc import Set as AbstractSet
from typing import ClassVar, Literal

from programs.errors import ProgramError
from programs.motion.installation import Channel, ChannelKind, Installation, Sensor, Tool
from programs.motion.lower import Lowered
from programs.motion.steps import (
    Await,
    Call,
    EndRepeat,
    Event,
    Hold,
    Line,
    Mount,
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
from programs.posts.dialect import Dialect
from programs.posts.writing.axes import as_controller_counts
from programs.posts.writing.chapters import Chapter, Part, Placed, divide, follow
from programs.posts.writing.entries import find_entries
from programs.posts.writing.forms import fill, fixed, short
from programs.posts.writing.frame import MOUNT_ERROR, ProductionFrame
from programs.posts.writing.handover import channels_of
from programs.posts.writing.joint_moves import CAUTIOUS, Pace, pace_moves
from programs.posts.writing.vocabulary import Vocabulary
from programs.posts.writing.wording import Names, cut, make_name, name_motion, number_slots, split_wait

_SPELLING: Mapping[str, Callable[[str], str]] = {"as they are": str, "upper": str.upper, "lower": str.lower}


class StepSyntax(ProductionFrame, ABC):
    """How the steps of one program are written in one language.

    The class attributes hold what is a word or a limit. The methods write one kind of step each; those without a body
    here differ too much between languages to have a common form.
    """

    mark: ClassVar[str] = ""
    """Before a comment, with its space; empty where that stands in brackets."""
    longest_comment: ClassVar[int] = 100
    """Characters of a comment in a routine."""
    call_form: ClassVar[str]
    """Of a ``routine``: ours or the integrator's."""
    their_call_form: ClassVar[str] = ""
    """Of the integrator's, where that is another."""
    pause_form: ClassVar[str] = ""
    """Of a pause of ``seconds`` or ``ms``."""
    longest_wait_s: ClassVar[float] = 0.0
    """Of one such statement; 0 where it takes any."""
    digital: ClassVar[str] = ""
    group: ClassVar[str] = ""
    analog: ClassVar[str] = ""
    """Forms that set an output of each kind, of its ``name``, ``number`` and ``value``."""
    off_on: ClassVar[tuple[str, str]] = ("0", "1")
    """Values of a digital output."""
    to_joints: ClassVar[str] = ""
    """Of a motion to ``joints``, with commas between them, at a ``percent`` of their speeds."""
    by_joints: ClassVar[str] = ""
    """Of a motion by joints to a ``point``, likewise."""
    straight: ClassVar[str] = ""
    """Of the line to a ``point`` that is left after its joint values."""
    reading: ClassVar[str] = ""
    """Of the quantity that an input shows: ``scale``, ``name`` or number of the ``input``, ``offset``."""
    reading_digits: ClassVar[int] = 9
    select_tool: ClassVar[tuple[str, ...]] = ()
    select_board: ClassVar[tuple[str, ...]] = ()
    """Of another tool or frame from now on, by its ``slot`` or its ``name``; none where it stands with the points."""
    payload_forms: ClassVar[tuple[str, ...]] = ()
    """Of what a tool weighs, by its ``slot``, ``mass`` in kg, and centre of gravity ``x``, ``y``, ``z`` in metres."""
    needs_payload: ClassVar[bool] = False
    """Whether they are written where the cell does not state it too."""
    frame_prefixes: tuple[str, str] = ("", "")
    """Before the names of tools and of frames, in languages that name them."""
    flange_names: ClassVar[tuple[str, str]] = ("", "")
    """Of the flange as a tool and of the base as a frame: in use before others are."""
    mounted_name: ClassVar[str] = "board"
    """Of the board where it lies first."""
    set_tool: ClassVar[str] = ""
    set_board: ClassVar[str] = ""
    """Of the ``frame`` of a ``slot``, in languages whose programs set them."""
    most_frames: ClassVar[int | None] = None
    """Numbers of tools, and of frames, from 1; ``None`` where tools have any number."""
    rounds_groups: ClassVar[bool] = False
    """Whether a group takes whole numbers only."""
    vocabulary: ClassVar[Vocabulary]
    """Names that it takes, and its words."""
    name_case: ClassVar[Literal["as they are", "upper", "lower"]] = "as they are"
    """Of names."""
    name_link: ClassVar[str] = "_"
    """Character between the parts of a name; empty where names are short or have none."""
    named_channels: ClassVar[AbstractSet[ChannelKind | Literal["input", "sensor"]]] = frozenset()
    """Outputs and inputs that are written by the names that they have in the controller."""
    mount_forms: ClassVar[tuple[str, ...]] = ()
    """Stop until a person has mounted the tool of a ``mount``, the message, or an ``error``; and goes on there."""
    hold_forms: ClassVar[tuple[str, ...]] = ()
    """The same before a step of a first run, in languages that have no forms for tools, or others."""
    longest_call: ClassVar[int] = 0
    """Characters of the name of an integrator's routine, where it may have more than others."""
    modal: ClassVar[tuple[str, ...]] = ()
    """Forms of statements that set a number, by the name of its field, for the lines and joint motions after them."""

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        super().__init__(dialect, lowered, installation)
        self.parts = self.divide()
        self.part_entries = find_entries(self.parts, installation, self.motion.is_clear)
        self.digits = max(len(str(sum(isinstance(part, Chapter) for part in self.parts))), 2)
        """Of the numbers of parts in names."""
        self.name = self.name_program(self.vocabulary.longest - len(self.name_link) - self.digits)
        taken = {self.name.lower(), *self.controller_names()}
        self.names = Names(self.vocabulary, taken, _SPELLING[self.name_case], self.name_link or "X")
        for step in self.motion.steps:  # only the integrator's routines have names that are known outside the program
            if isinstance(step, Call):
                self.call_name(step.name)
            elif isinstance(step, Mount) and installation.tool_routine:
                self.names.taken.add(self.mount_name(step.number).lower())
        self.following = follow(self.motion.steps)
        """The line right after each line that is passed, by its identity."""
        self.slots = number_slots(self.motion, self.most_frames)
        self.tools: dict[str, Tool] = {}
        self.boards: dict[str, Pose] = {}
        self.poses: dict[str, Pose] = {}
        """Of tools and places of the board by their names, in the order of use."""
        self.tool_name, self.board_name = self.flange_names
        """Those in use."""
        self.paces: dict[int, Pace] = {}
        """Of the joint motions that take their planned times, by their identity."""
        if dialect.controller is not None:
            self.paces = pace_moves(self.motion.steps, installation, dialect.controller)
        self.points = 0
        """How many points have been numbered."""
        self.data: list[str] = []
        """Declarations of the routine that is being written."""
        self.settings: dict[str, str] = {}
        """Modal words in force in that routine."""

    def divide(self) -> tuple[Part, ...]:
        """Divide the program into what main calls and repeats."""
        return divide(self.motion, self.dialect.most_steps)

    # Steps

    def statements(self, step: Step, placed: Placed) -> Iterable[str]:
        """Write one step."""
        match step:
            case Line():
                yield from self.line(step, placed)
            case Reach():
                yield from self.reach(step)
            case Pause():
                yield from self.pause(step.duration_s)
            case Switch():
                yield self.output(step.channel, step.value)
            case UseTool() | UseBoard():
                yield from self.use(step)
            case Call():
                call = (self.their_call_form or self.call_form).format(routine=self.call_name(step.name))
                yield from self.attended([call])
                self.forget()
            case Mount() | Hold():
                yield from self.attended(self.stop(step))
                self.forget()
            case Note():
                yield self.comment(step.text)
            case Await() | Repeat() | EndRepeat():
                raise AssertionError("these stand between routines")

    def stop(self, step: Mount | Hold) -> Iterable[str]:
        """Call the routine that mounts a tool, or stop with a message until a person has it go on."""
        forms, words = self.mount_forms, {"mount": self.message(step.words)}
        if isinstance(step, Hold):
            forms = self.hold_forms or forms
        elif self.installation.tool_routine:
            return [(self.their_call_form or self.call_form).format(routine=self.mount_name(step.number))]
        else:
            words["error"] = str(MOUNT_ERROR + step.number)
        return [form.format(**words) for form in forms]

    def only_event(self, line: Line) -> Event | None:
        """Give the output that changes on a line, in languages that time one on a motion.

        Raises:
            ProgramError: there are several.
        """
        if len(line.events) > 1:
            language = self.vocabulary.language
            raise ProgramError(
                f"{line.made_by}: two outputs change at one moment, and {language} times one on a motion. "
                "Give the valve a shortest pulse, or part the two."
            )
        return next(iter(line.events), None)

    @abstractmethod
    def line(self, line: Line, placed: Placed) -> Iterable[str]:
        """Write a line, and the outputs that change on it."""

    def reach(self, reach: Reach) -> Iterable[str]:
        """Write a joint motion to a pose: to joint values and along the line that is left, or to the pose alone."""
        pace = self.pace(reach)
        yield from self.slow_down(pace)
        if reach.joints:
            yield self.joint_move(reach.joints, pace)
        form = self.straight if reach.joints else self.by_joints
        yield fill(form, point=self.point(reach.target), percent=pace.percent)

    def pace(self, reach: Reach) -> Pace:
        """Give the speed of a joint motion: a cautious one where it is not planned where it begins."""
        return self.paces.get(id(reach), CAUTIOUS)

    def slow_down(self, pace: Pace) -> Iterable[str]:
        """Write the speed of the joint motions that follow, in languages in which it is modal."""
        return self.set_modal(percent=pace.percent) if any("{percent" in form for form in self.modal) else ()

    def joint_move(self, joints: tuple[float, ...], pace: Pace = CAUTIOUS) -> str:
        """Write a motion to joint values."""
        return fill(self.to_joints, joints=", ".join(self.joints(joints)), percent=pace.percent)

    def point(self, pose: Pose) -> str:
        """Write or declare a point on the board."""
        raise NotImplementedError

    def use(self, step: UseTool | UseBoard) -> Iterable[str]:
        """Use another tool or place of the board from now on."""
        self.slots.use(step)
        words: dict[str, object] = {}
        tool, board = self.frame_prefixes
        if isinstance(step, UseTool):
            nozzle = self.installation.tool(step.number)
            if tool:
                self.tool_name = words["name"] = self.names.give("tool", step.number, f"{tool}{nozzle.name}")
                self.tools[self.tool_name], self.poses[self.tool_name] = nozzle, nozzle.T_flange_tcp
            payload = self.payload_forms if nozzle.payload.is_stated or self.needs_payload else ()
            words |= {"mass": nozzle.payload.mass_kg}
            words |= {axis: value / 1000.0 for axis, value in zip("xyz", nozzle.centre_mm, strict=True)}
            return [fill(form, slot=self.slots.tool, **words) for form in (*self.select_tool, *payload)]
        if board:
            name = self.names.give("board", step.placement, f"{board}{step.placement or self.mounted_name}")
            self.boards[name] = self.poses[name] = step.T_base_board
            self.board_name = words["name"] = name
        return [fill(form, slot=self.slots.board, **words) for form in self.select_board]

    def frame_name(self, kind: str, key: object) -> str:
        """Name of a tool or a place of the board in the program; empty where it has only a number."""
        return self.names.given.get((kind, key), "")

    def slot_lines(self) -> Iterator[str]:
        """Write the frames of all slots."""
        for kind, slot, name, pose in self.slots.entries(self.installation):
            form = self.set_tool if kind == "tool" else self.set_board
            yield f"{form.format(slot=slot, frame=self.frame(pose))} {self.mark}{cut(name, 40)}"

    def frame(self, pose: Pose) -> str:
        """Write the pose of a tool or of a place of the board."""
        raise NotImplementedError

    def pause(self, seconds: float) -> Iterable[str]:
        """Hold the pose, by several statements where one does not hold it for so long."""
        parts = split_wait(seconds, self.longest_wait_s, 2) if self.longest_wait_s else [seconds]
        return [fill(self.pause_form, seconds=each, ms=1e3 * each) for each in parts]

    def output(self, channel: Channel, value: float) -> str:
        """Set an output."""
        match channel.kind:
            case "digital":
                form, word = self.digital, self.off_on[value > 0.5]
            case "group":
                form, word = self.group, self.number(round(value) if self.rounds_groups else value)
            case "analog":
                count = self.dialect.capability.analog.count(channel, value)
                form, word = self.analog, self.number(count)
        return form.format(name=channel.name, number=channel.number, value=word)

    def number(self, value: float) -> str:
        """Write the value of an output that is not digital."""
        return short(value, 6)

    def quantity(self, sensor: Sensor) -> str:
        """Write the quantity that an input shows."""
        scale, offset = (
            self.operand(value, self.reading_digits) for value in self.dialect.capability.analog.reading(sensor)
        )
        number = sensor.number + self.sensor_base
        return self.reading.format(scale=scale, name=sensor.name, input=number, offset=offset)

    def call(self, name: str) -> str:
        """Call a routine."""
        return self.call_form.format(routine=name)

    def forget(self) -> None:
        """Write modal words again: an integrator's routine may have changed what they set."""
        self.settings.clear()

    def comment(self, text: str, longest: int = 0) -> str:
        """Write a comment."""
        return f"{self.mark}{cut(text, longest or self.longest_comment)}"

    # Words and names

    def joints(self, joints: tuple[float, ...], digits: int = 4) -> list[str]:
        """Write joint values as the controller counts them: degrees and mm."""
        return [fixed(value, digits) for value in as_controller_counts(joints, self.installation)]

    def set(self, group: str, text: str) -> list[str]:
        """Write what is modal in a group of words, if another is in force."""
        if self.settings.get(group) == text:
            return []
        self.settings[group] = text
        return [text]

    def set_modal(self, **values: float) -> Iterator[str]:
        """Write the modal statements of some numbers, where others are in force."""
        for name, value in values.items():
            form = next(form for form in self.modal if f"{{{name}" in form)
            yield from self.set(name, fill(form, **{name: value}))

    def name_program(self, longest: int) -> str:
        """Name the program by its board and its recipe."""
        return _SPELLING[self.name_case](name_motion(self.motion, longest, self.name_link))

    def controller_names(self) -> Iterator[str]:
        """Give the names in the controller that the program uses, in small letters.

        Raises:
            ProgramError: the language does not take one of them, or two are one name to it.
        """
        named, waits = self.named_channels, self.installation.waits
        sensors = [step.sensor for step in self.motion.steps if isinstance(step, Repeat)]
        outputs = (*channels_of(self.motion), *self.line_outputs)
        places = {f"io.outputs.{each.name}": each.name for each in outputs if each.kind in named}
        if "input" in named:
            places |= {f"io.inputs.{each.name}": each.name for each in self.contacts}
        if "sensor" in named:
            sensors += [wait.sensor for wait in waits]
            places |= {f"io.sensors, input {each.name}": each.name for each in sensors if each is not None}
        known: dict[str, str] = {}
        for place, name in places.items():
            small = self.vocabulary.check(place, name).lower()
            if (other := known.setdefault(small, place)) != place:
                language = self.vocabulary.language
                raise ProgramError(
                    f"{place}: {language}: {other} has this name too, in large or small letters; rename one."
                )
            yield small

    def spell_call(self, name: str) -> str:
        """Spell the name of a routine of the integrator's."""
        return _SPELLING[self.name_case](make_name(name, len(name)))

    def call_name(self, name: str) -> str:
        """Name a routine of the integrator's."""
        return self.names.give("call", name, self.spell_call(name), self.longest_call)

    def mount_name(self, tool: int) -> str:
        """Name the integrator's routine that mounts a tool.

        Raises:
            ProgramError: the language does not take the name.
        """
        name = self.spell_call(f"{self.installation.tool_routine}_{tool}")
        return self.vocabulary.check("at_tool_change.routine", name, self.longest_call)
