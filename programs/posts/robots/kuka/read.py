"""Reads KRL back, as a controller would execute it, and describes the language."""

import re
from collections.abc import Iterator, Mapping
from typing import ClassVar

from programs.errors import ProgramError
from programs.motion.analog import Counting
from programs.motion.lower import Capability
from programs.motion.steps import Line
from programs.pose import Pose
from programs.posts.dialect import Dialect, FileForm, ProgramFiles
from programs.posts.layout import Layout, words_of
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import Block, N, Values, refusal, statements_of
from programs.posts.rebuilt import Due, ReadSignal
from programs.posts.robots.kuka.write import HEAD, ORI_DEG_S, TURN_DEG_S2, Krl
from programs.posts.writing.angles import from_moving_zyx
from programs.posts.writing.chapters import turn_limit
from programs.posts.writing.forms import NUMBER
from programs.posts.writing.frame import INTERRUPT
from programs.timing.controller import Controller

_FRAME = re.compile(rf"\{{X {N},Y {N},Z {N},A {N},B {N},C {N}\}}")
_AXES = rf"\{{A1 {N}(?:,[AE]\d {N})*\}}"
_LOAD = re.compile(rf"\{{M {N},CM {_FRAME.pattern},J \{{X {N},Y {N},Z {N}\}}\}}")
_SHAPES = {"FRAME": _FRAME, "E6AXIS": re.compile(_AXES), "LOAD": _LOAD, "INT": re.compile("[01]")}
_WORDS = """
    ACCESS RVP REL UNTIL F DEFDAT ENDDAT PUBLIC GLOBAL FRAME E6AXIS LOAD INT M CM J X Y Z A B C C_DIS CP ORI1 ORI2
    A1 A2 A3 A4 A5 A6 E1 E2 E3 E4 E5 E6
"""
"""Words that no form of statements has."""
_DECLARATION = re.compile(r"DECL (?:GLOBAL )?(FRAME|E6AXIS|LOAD|INT) (\w+)=(.*)")


class KrlReader(Reader):
    """Declarations and routines of all modules."""

    syntax = Krl
    handlers = frozenset({"main", "interrupt"})
    texts: ClassVar[Mapping[str, str]] = {
        **{"start": r"\w+_(?i:start)", "name": r"(?!nWait)[A-Za-z]\w*", "axes": _AXES, "point": r"\w+", "load": r"\w+"},
        "group_value": rf"TRUE|FALSE|{NUMBER}",
    }

    def __init__(self) -> None:
        super().__init__()
        self.modules: dict[str, str] = {}
        """Module by the routine's name."""
        self.values = self.declares("data")
        """Declared values by module and name; global ones have no module."""
        self.triggers: list[tuple[float, float, str, float]] = []
        """Place in mm from the end, seconds, channel and value: for the next motion."""

    @classmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give the zone, and a rate of turn a little above the planned one."""
        rate = turn_limit(line)
        return Due(line.blend_mm, ORI_DEG_S if rate is None else rate)

    def load(self, files: ProgramFiles) -> str:
        """Read sources and data lists; the first file's first routine is the main one."""
        for file, text in files.items():
            module, _, kind = file.rpartition(".")
            if f"{module}.{'dat' if kind == 'src' else 'src'}" not in files:
                raise ProgramError("a .src and a .dat belong together.", file=file)
            known = len(self.routines)
            for line in self.sort(statements_of(file, text, ";"), Krl.routine_form):
                if match := _DECLARATION.fullmatch(line):
                    if not _SHAPES[match[1]].fullmatch(match[3]):
                        raise refusal(line, f"has no {match[1]}")
                    key = ("" if "GLOBAL" in line else module, match[2])
                    self.values.add(key, match[3], line)
                    if match[2] == "nWait":
                        self.values.used.add(key)  # by waits alone, which a program need not have
                elif line not in HEAD and line not in (f"DEFDAT {module} PUBLIC", "ENDDAT"):
                    raise refusal(line, "is unknown there")
            self.modules |= dict.fromkeys(list(self.routines)[known:], module)
        return next(iter(self.routines), "")

    def blocks(self) -> Iterator[Block]:
        """List the statements of forms."""
        yield [Krl.move], self.move
        yield from (([form], self.define_trigger) for form in Krl.triggers)
        yield [Krl.go_home], lambda values: self.come_home(_axes(self.value("HOME_POSITION")))
        yield [Krl.to_joints], lambda values: self.come_to(_axes(values["axes"]))
        yield [Krl.begin[2]], lambda values: self.state(turn_acceleration_deg_s2=TURN_DEG_S2)
        yield from super().blocks()
        yield Krl.fault_forms, self.read_stop
        yield [*Krl.last], lambda values: self.acting.discard(str(INTERRUPT))
        yield [*Krl.watch_again], self.watch_again
        yield [Krl.load_form], lambda values: self.value(values["load"])

    def use_variable(self, name: str) -> None:
        """Use a declared value."""
        self.value(name)

    def use_wait(self) -> None:
        """Use the counter of waits."""
        self.value("nWait")

    def use_first_tool(self, name: str) -> None:
        """Use the tool whose orifice is raised."""
        self.frame("xStart")
        self.use_tool(name, self.frame(name))

    def read_fault(self) -> None:
        """Read what interrupts lead to."""
        self.expect("on_fault", Krl.fault_body)

    def read_stop(self, values: Values) -> None:
        """Have the fault routine run at a stop."""
        self.read_fault()
        self.shut_by.add("interrupt")
        self.acting.add(values["interrupt"])

    def read_watch(self, values: Values) -> None:
        """Have the fault routine run when an input leaves its state."""
        self.read_fault()
        super().read_watch(values)

    def watch_again(self, values: Values) -> None:
        """Switch on an interrupt that was switched off.

        Raises:
            ProgramError: it was not.
        """
        self.suspended.remove(values["interrupt"])
        self.acting.add(values["interrupt"])

    def switched(self, values: Values) -> tuple[str, float]:
        """Give the channel and the value of an output; that of a group may be one of a single signal."""
        truth = {"TRUE": "1", "FALSE": "0"}.get(values.get("group_value", ""))
        return super().switched(values if truth is None else {**values, "group_value": truth})

    def frame(self, name: str) -> Pose:
        """Give a declared frame: of the module that runs, or a global one."""
        if match := _FRAME.fullmatch(self.value(name)):
            return read_pose(match.groups(), from_moving_zyx)
        raise ProgramError(f"{name} is not declared as FRAME.")

    def value(self, name: str) -> str:
        """Give a declared value: of the module that runs, or a global one."""
        key = (self.modules[self.routine], name)
        return self.values.use(key if key in self.values.values else ("", name))

    def place_of(self, point: str) -> Pose:
        """Give a declared frame."""
        return self.frame(point)

    def frame_of(self, kind: str, label: str) -> Pose:
        """Give a declared frame."""
        return self.frame(label)

    def define_trigger(self, values: Values) -> None:
        """Set an output with the next motion."""
        place, delay = float(values.get("place", 0.0)), float(values["delay"])
        self.triggers.append((place, delay / 1000.0, *self.output_of(values["output"])))

    def move(self, values: Values) -> None:
        """Move in a line; the triggers before it are this motion's."""
        pose, turn = self.frame(values["point"]), self.modal.get("turn")
        length_mm = self.length_to(pose)
        if not self.counted and self.modal.get("second_turn") != turn:
            raise ProgramError("$VEL.ORI2 is not as $VEL.ORI1.")
        signals = tuple(
            ReadSignal(channel, value, 1.0 + place / (length_mm or 1.0), seconds)
            for place, seconds, channel, value in self.triggers
        )
        self.triggers = []
        self.state(zone=self.modal["zone"], turn_deg_s=turn)
        speed_mm_s = 1000.0 * self.modal["speed"] if length_mm else 0.0
        self.line(pose, "passes" not in values, speed_mm_s, signals)


def _axes(text: str) -> list[float]:
    """Give the joint values of an E6AXIS."""
    return [float(word) for word in re.findall(rf"[AE]\d {N}", text)]


DIALECT = Dialect(
    title="KUKA KRL",
    notes="A .src and a .dat for KSS 8; outputs by TRIGGER WHEN PATH. Groups are SIGNALs of $config.dat, $ANOUT counts "
    "from -1 to 1. LIN keeps the configuration of the first PTP.",
    capability=Capability(
        controller_class=1,
        timing="distance and time",
        cycle_s=0.004,  # assumed: the interpolation cycle of a KR C4; integrators report 1 ms for triggers
        references=("end",),  # PATH counts from the end point; ONSTART needs a newer KSS
        step_mm=0.01,
        step_mm_s=0.1,
        most_events=8,  # integrators report eight triggers at work at once
        analog=Counting(full=1.0),  # $ANOUT and $ANIN count from -1 to 1 of full scale
    ),
    layout=Layout(
        ";", comma=",", equals="=", single_blanks=True, leading_zero=True, powers=True, words=words_of(Krl, _WORDS)
    ),
    form=FileForm(".src", several=(".src", ".dat")),
    longest_line=200,
    most_steps=1500,  # of a module: about 4,500 lines of .src; assumed, nobody states a limit
    write=Krl.write,
    rebuild=KrlReader.rebuild,
    controller=Controller(
        blending="zone",
        acceleration_mm_s2=2300.0,
        turn_speed_deg_s=200.0,
        turn_acceleration_deg_s2=1000.0,
        joint_speed_share=0.1,
        settle_s=0.05,
        look_ahead=3,
        least_line_s=0.012,
        most_lines=20_000,
        sources={
            "turn_acceleration_deg_s2": "$ACC.ORI1 of the program's text",
            "look_ahead": "$ADVANCE = 3, which BAS(#INITMOV) sets",
            "least_line_s": "interpolation cycle of 12 ms (RRS interface of KUKA)",
        },
    ),
    maker="kuka",
    without_joints="Stand the arm in the configuration that it is to keep: PTP without S and T keeps it.",
)
