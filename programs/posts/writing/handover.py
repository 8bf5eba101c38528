"""What an integrator has to know of a program, and to do for it, as the language states it."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import ClassVar

from programs.motion.installation import USUAL_WAITS, Channel, ChannelKind, Contact, Installation, Sensor, Tool, Wait
from programs.motion.lower import Lowered
from programs.motion.steps import Call, Line, MotionProgram, Mount, Repeat, Switch, UseTool
from programs.pose import Pose, Quaternion
from programs.posts.dialect import Dialect, Frame, Handover, Signal, Task
from programs.posts.writing.angles import fixed_xyz
from programs.posts.writing.axes import as_controller_counts
from programs.posts.writing.chapters import Chapter, Part
from programs.posts.writing.entries import Entry
from programs.posts.writing.forms import fixed, short
from programs.posts.writing.wording import Slots, number_slots, plain, pose_words

_UNITS = {"bar": "bar", "c": "deg C", "mohm_cm": "MOhm cm", "us_cm": "uS/cm", "l_min": "l/min", "percent": "%"}
"""Units of quantities by the end of their key."""


def channels_of(motion: MotionProgram) -> list[Channel]:
    """Give the outputs that a program sets, by kind and number."""
    used: dict[Channel, None] = {}
    for step in motion.steps:
        if isinstance(step, Switch):
            used[step.channel] = None
        elif isinstance(step, Line):
            used |= {event.channel: None for event in step.events}
    return sorted(used, key=lambda channel: (channel.kind, channel.number))


def describe_tool_change(tools: Mapping[str, str], routine: str, *, changes_tools: bool) -> str:
    """Describe who changes the tools of a program.

    Args:
        tools: The nozzle of each, by its number.
        routine: Beginning of the names of the routines that mount them; empty where a person does.
        changes_tools: Whether the language's own word has them changed.
    """
    how = "a person mounts them: the program stops with a message for each; start it when that is done"
    if changes_tools:
        how = "the program names each, and goes on when it is mounted"
    elif routine:
        how = f"{' and '.join(f'{routine}_{each}' for each in tools)} are yours: each returns when its tool is mounted"
    return f"Tools {' and '.join(f'{number} ({nozzle})' for number, nozzle in tools.items())}: {how}"


class HandedOver:
    """The facts of one program in one language; ``Syntax`` is made of it.

    ``setup`` states what the integrator has to provide for what a program in the language cannot do by itself.
    """

    start: str = "nStart"
    """Variable that names the part to start at; 0 or 1 for the whole program."""
    contact_base: ClassVar[int] = 0
    sensor_base: ClassVar[int] = 0
    """Added to the numbers of digital and of analog inputs."""
    contact_form: ClassVar[str] = "digital input {number}"
    sensor_form: ClassVar[str] = "analog input {number}"
    """What an input is in the controller, by its ``number`` or its ``name``."""
    address_forms: ClassVar[tuple[str, str, str]] = (
        "digital output {number}",
        "group output {number}",
        "analog output {number}",
    )
    """The same of an output: a digital one, a group, an analog one."""
    wait_sensor: ClassVar[tuple[str, ...]] = ()
    """Wait for a quantity; empty where the language reads no analog input."""
    load_place: ClassVar[str] = ""
    """Where the load of a ``tool`` is entered by hand; empty where a program states it, or nothing takes it."""
    watch_note: ClassVar[str] = ""
    """What of a watched input the program leaves to the integrator."""
    shared: ClassVar[str] = ""
    """What the program has in common with the other programs of its cell on one controller; empty for nothing."""
    start_words: ClassVar[str] = "set {start} to its number"
    """How the operator chooses the part to start at."""
    angles: ClassVar[tuple[str, str, Callable[[Quaternion], Sequence[float]]]] = (
        "Rx Ry Rz",
        "degrees about the fixed x, then y, then z axis",
        fixed_xyz,
    )
    """Names of the angles of a frame, what they are, and how they are had of a quaternion."""

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        self.dialect, self.lowered, self.installation = dialect, lowered, installation
        self.motion = lowered.motion
        self.parts: tuple[Part, ...] = ()
        self.part_entries: Mapping[int, Entry] = {}
        """What a part other than the first does if the program starts there."""
        self.slots: Slots = number_slots(self.motion)
        """Tools and places of the board by numbers, for languages that number them."""

    def handover(self) -> Handover:
        """Give the facts of the program."""
        home = self.installation.home
        return Handover(
            tasks=(*self.routines(), *self.chores()),
            work=tuple(self.work_lines()),
            shared=self.shared,
            remarks=tuple(self.remarks()),
            signals=tuple(self.signal_table()),
            angles=self.angles[:2],
            frames=tuple(self.frame_table()),
            home=", ".join(fixed(value, 2) for value in as_controller_counts(home, self.installation)) if home else "",
        )

    # What the language adds

    def call_name(self, name: str) -> str:
        """Name in the language of a routine that a ``CALL`` names."""
        return name

    def frame_name(self, kind: str, key: object) -> str:
        """Name of a tool or a place of the board in the program; empty where it has only a number."""
        return ""

    def setup(self) -> Iterator[Task]:
        """State what the integrator has to set up in the controller."""
        return iter(())

    @property
    def cad_frame(self) -> str:
        """The frame that points are in, in words."""
        return f"the {self.installation.workpiece}'s CAD frame"

    def remarks(self) -> Iterator[str]:
        """State what the program uses of the controller, and what has to hold when it is started."""
        return iter(())

    # What is left to do

    @property
    def tools_used(self) -> dict[str, str]:
        """The nozzle of each tool, by its number."""
        return {str(step.number): step.nozzle for step in self.motion.steps if isinstance(step, UseTool)}

    @property
    def mounts_tools(self) -> bool:
        """Whether tools are mounted in the program."""
        return len(self.tools_used) > 1 or any(isinstance(step, Mount) for step in self.motion.steps)

    def routines(self) -> Iterator[Task]:
        """List the routines that the integrator provides."""
        for name in dict.fromkeys(step.name for step in self.motion.steps if isinstance(step, Call)):
            turned = f"the {self.installation.workpiece} is turned over and held"
            done = turned if name.startswith("flip") else "its work is done"
            yield Task(f"You provide {self.call_name(name)}: it returns when {done}")
        if self.mounts_tools and self.installation.tool_routine and not self.dialect.capability.changes_tools:
            yield Task(self.tool_words())

    def chores(self) -> Iterator[Task]:
        """List what is to be set up in the controller; loads to be entered there too."""
        yield from self.setup()
        if loads := tuple(self.load_lines()):
            yield Task("loads of the tools", loads)

    def tool_words(self) -> str:
        """Describe who changes the tools."""
        capability = self.dialect.capability
        return describe_tool_change(
            self.tools_used, self.installation.tool_routine, changes_tools=capability.changes_tools
        )

    def load_lines(self) -> list[str]:
        """Describe the loads of the tools where the cell states them, and they are entered by hand."""
        tools = self.tools_used if self.load_place else ()
        loads = {number: load_words(self.installation.tool(int(number))) for number in tools}
        return [f"{self.load_place.format(tool=number)}: {load}" for number, load in loads.items() if load]

    def watched_lines(self, *forms: str) -> Iterator[str]:
        """Fill in forms for each watched contact, by ``input``, ``name``, ``words``, ``state`` and ``other``."""
        for wait in self.installation.waits:
            if wait.watched and wait.contact is not None:
                words = {"input": wait.contact.number, "name": wait.contact.name, "words": wait.words}
                words |= {"state": self.state_words(wait.state), "other": self.state_words(not wait.state)}
                yield from (form.format(**words, message=self.message(wait.shown)) for form in forms)

    def state_words(self, state: bool) -> str:
        """Write the state of a contact."""
        return "01"[state]

    def message(self, text: str) -> str:
        """Give a message of the controller."""
        return plain(text)

    def watch_tasks(self, text: str, form: str) -> Iterator[Task]:
        """State what is to be done for the watched contacts, each by a line; nothing where none is watched."""
        if lines := tuple(self.watched_lines(form)):
            yield Task(text, lines)

    # What it does

    def work_lines(self) -> Iterator[str]:
        """State who changes tools, what is waited for and what is not, and where the program may start."""
        if self.mounts_tools and (self.dialect.capability.changes_tools or not self.installation.tool_routine):
            yield self.tool_words()
        if not self.chapters:
            return
        waits = [wait for wait in self.installation.waits if wait.contact or self.wait_sensor]
        known = {wait.name for wait in self.installation.waits}
        if unread := [wait.words for wait in self.installation.waits if wait not in waits]:
            yield f"Does not wait for {', '.join(unread)}: this language reads no analog input"
        if waits:
            yield f"Waits for {', '.join(map(_describe, waits))}"
        if lacking := [name.replace("_", " ") for name in USUAL_WAITS if name not in known]:
            yield f"Does not wait for {', '.join(lacking)}: the cell maps no such input"
        if watched := [wait.words for wait in waits if wait.watched]:
            yield f"Stops, valves shut, without {', '.join(watched)}{self.watch_note}"
        yield f"Parts: {', '.join(f'{part.number} {part.title}' for part in self.chapters)}"
        if (last := len(self.chapters)) > 1:
            chosen = self.start_words.format(start=self.start)
            yield f"To finish a stopped board from part 2 to {last}: {chosen}{self.ways_from_home()}"
        if left := [channel.name for channel in channels_of(self.motion) if channel not in self.valves]:
            yield f"Outputs left as they are at the end: {', '.join(left)}"

    def ways_from_home(self) -> str:
        """State which of the joint motions from home to a later part are clear."""
        if all(entry.is_clear is None for entry in self.part_entries.values()):
            return "; its way from home was not checked"
        blocked = [str(number) for number, entry in self.part_entries.items() if entry.is_clear is False]
        clear = "; the ways from home were checked"
        return clear if not blocked else f"{clear}, and none is clear to part {', '.join(blocked)}: do not start there"

    @property
    def chapters(self) -> list[Chapter]:
        """Parts of main without its loops."""
        return [part for part in self.parts if isinstance(part, Chapter)]

    # Signals

    @property
    def valves(self) -> list[Channel]:
        """Outputs of all valves of the cell, by their numbers."""
        valves = {valve.channel for valve in self.installation.valves.values()}
        return sorted(valves, key=lambda channel: (channel.kind, channel.number))

    @property
    def line_outputs(self) -> dict[Channel, str]:
        """Outputs to the line, with what they mean."""
        line = self.installation.handshake
        if line is None:
            return {}
        removed = " until the part has been removed" if line.present is not None else ""
        words = ((line.busy, "on while busy"), (line.done, f"on when done{removed}"), (line.fault, "on at a fault"))
        return {channel: each for channel, each in words if channel is not None}

    @property
    def contacts(self) -> list[Contact]:
        """Inputs that the program waits for: at its start, and of the line."""
        line = self.installation.handshake
        found = [*(wait.contact for wait in self.installation.waits), line.start if line is not None else None]
        return [each for each in found if each is not None]

    def signal_table(self) -> Iterator[Signal]:
        """List outputs and inputs with what they are for."""
        to_line = self.line_outputs
        for channel in dict.fromkeys((*channels_of(self.motion), *to_line)):
            uses = [*_uses(channel, self.installation), *([to_line[channel]] if channel in to_line else [])]
            yield Signal(channel.name, self.address(channel), ", ".join(uses))
        line, base = self.installation.handshake, self.contact_base
        if line is not None and line.start is not None:
            yield self.input(line.start, self.contact_form, base, "starts a cycle")
        for wait in self.installation.waits:
            if wait.contact is not None:
                watched = ", watched" if wait.watched else ""
                use = f"{wait.words} when {'on' if wait.state else 'off'}{watched}"
                yield self.input(wait.contact, self.contact_form, base, use)
            elif wait.sensor is not None and self.wait_sensor:
                use = f"{wait.words}, {_formula(wait.quantity, wait.sensor)}"
                yield self.input(wait.sensor, self.sensor_form, self.sensor_base, use)
        loops = (step for step in self.motion.steps if isinstance(step, Repeat))
        for key, sensor in {loop.key: loop.sensor for loop in loops if loop.sensor is not None}.items():
            yield self.input(sensor, self.sensor_form, self.sensor_base, f"ends loops, {_formula(key, sensor)}")

    def input(self, each: Contact | Sensor, form: str, base: int, use: str) -> Signal:
        """Describe an input."""
        return Signal(each.name, form.format(number=each.number + base, name=each.name), use, is_input=True)

    def address(self, channel: Channel) -> str:
        """Give what an output is in the controller."""
        kinds: tuple[ChannelKind, ...] = ("digital", "group", "analog")
        return self.address_forms[kinds.index(channel.kind)].format(number=channel.number, name=channel.name)

    def signal_lines(self) -> Iterator[str]:
        """Write the signals for a header."""
        for each in self.signal_table():
            use = f", {each.use}" if each.use else ""
            yield f"{'Input' if each.is_input else 'Output'} {each.name}: {each.address}{use}"

    # Frames

    def frame_table(self) -> Iterator[Frame]:
        """List the tools and the places of the board."""
        for number, slot in self.slots.tools.items():
            tool = self.installation.tool(number)
            yield self.frame_of("tool", slot, number, tool.name, tool.T_flange_tcp, load_words(tool))
        for placement, (slot, place) in self.slots.boards.items():
            yield self.frame_of("board", slot, placement, placement or "as mounted", place)

    def frame_of(self, kind: str, slot: int, key: object, name: str, pose: Pose, load: str = "") -> Frame:
        """Describe a tool or a place of the board."""
        known = [plain(each) for each in (name, self.frame_name(kind, key)) if each]
        return Frame(kind, slot, ", ".join(dict.fromkeys(known)), tuple(pose_words(pose, self.angles[2])), load)

    def frame_lines(self) -> Iterator[str]:
        """Write for a header what is left to do, what the program does, and what it uses."""
        yield from (task.text for task in self.routines())
        yield from self.work_lines()
        if self.shared:
            yield f"Shared with other programs of this cell: {self.shared}"
        yield from (f"Set up: {task.text}" for task in self.chores())
        yield from self.load_lines()
        yield from self.remarks()


def load_words(tool: Tool) -> str:
    """Describe the load of a tool; empty where the cell does not state it."""
    if not tool.payload.is_stated:
        return ""
    centre = ", ".join(short(value, 1) for value in tool.centre_mm)
    inertia = ", ".join(short(value, 6) for value in tool.payload.inertia_kg_m2)
    about = f", inertia {inertia} kg m2" if any(tool.payload.inertia_kg_m2) else ""
    return f"{short(tool.payload.mass_kg, 3)} kg, centre of gravity {centre} mm on the flange{about}"


def _uses(channel: Channel, installation: Installation) -> Iterator[str]:
    """Describe what a program sets an output for."""
    opens = [nozzle for nozzle, valve in installation.valves.items() if valve.channel == channel]
    yield from ([f"opens {' or '.join(opens)}"] if opens else [])
    grips = {f"gripper {name}": row for name, row in installation.grips.items()}
    for table in (installation.functions, installation.solutions, grips):
        sent = {name: each.value for name, row in table.items() for each in row if each.channel == channel}
        on = [name for name, value in sent.items() if value]
        if on and channel.kind == "digital":
            yield f"on for {', '.join(on)}"
        elif on:
            yield ", ".join(f"{short(sent[name], 6)} for {name}" for name in on)
    for key, setting in installation.settings.items():
        if setting.channel == channel:
            unit = f" in {channel.unit}" if channel.kind == "analog" else ""
            yield f"{_linear(setting.scale, key, setting.offset)}{unit}"
    if channel == installation.lamp:
        yield "lamp of first runs"


def _formula(key: str, sensor: Sensor) -> str:
    return f"{key} = {_linear(sensor.scale, 'reading', sensor.offset)}"


def _linear(scale: float, what: str, offset: float) -> str:
    scaled = what if scale == 1.0 else f"{short(scale, 6)} * {what}"
    return f"{scaled} {'-' if offset < 0.0 else '+'} {short(abs(offset), 6)}" if offset else scaled


def _describe(wait: Wait) -> str:
    least = ""
    if wait.sensor is not None:
        unit = next((unit for end, unit in _UNITS.items() if wait.quantity.endswith(f"_{end}")), wait.quantity)
        least = f" at least {short(wait.least, 6)}{f' {unit}' if unit else ''}"
    return f"{wait.words}{least} ({short(wait.timeout_s, 1)} s)"
