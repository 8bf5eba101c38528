"""KUKA KRL: outputs on the path by ``TRIGGER``, timed by the controller itself."""

from collections.abc import Iterable, Iterator, Sequence

from programs.motion.installation import Installation
from programs.motion.lower import Lowered
from programs.motion.steps import Line, Reach, UseBoard, UseTool
from programs.pose import IDENTITY, Pose
from programs.posts.dialect import Dialect, ProgramFiles, Task
from programs.posts.writing.angles import moving_zyx
from programs.posts.writing.chapters import Placed, turn_limit
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.forms import fill, fixed, short
from programs.posts.writing.frame import INTERRUPT, under_each
from programs.posts.writing.joint_moves import CAUTIOUS
from programs.posts.writing.vocabulary import KRL
from programs.posts.writing.wording import indent, join_lines, pose_words

ORI_DEG_S = 200.0
"""Of lines that hardly turn."""
TURN_DEG_S2 = 1000
"""Greatest acceleration of a turn that controllers take, assumed: that of BAS(#INITMOV) is a tenth of it."""
HEAD = ("&ACCESS RVP", "&REL 1")


class Krl(Syntax):
    """KRL: a ``.src`` with motions by the name of their points, and a ``.dat`` with the points."""

    mark = "; "
    call_form = "{routine}( )"
    pause_form = "WAIT SEC {seconds:3}"
    mount_forms = ('MsgNotify("{mount}")', "HALT")
    modal = (
        *("$VEL.CP={speed:~6}", "$VEL.ORI1={turn:~1}", "$VEL.ORI2={second_turn:~1}", "$APO.CDIS={zone:~3}"),
        "BAS(#VEL_PTP,{percent:0})",
    )
    move = "LIN {point}{passes: C_DIS}"
    straight, by_joints, to_joints = "LIN {point}", "PTP {point}", "PTP {axes}"
    triggers = (
        "TRIGGER WHEN PATH={place:-2} DELAY={delay:-0} DO {output}",
        "TRIGGER WHEN DISTANCE=1 DELAY={delay:-0} DO {output}",
    )
    """On a line, by millimetres from its end, and where the tool turns on the spot."""
    select_tool, select_board = ("$TOOL={name}",), ("$BASE=$ROBROOT:{name}",)
    load_form = "$LOAD={load}"
    go_home = "PTP HOME_POSITION"
    begin = (
        *("BAS(#INITMOV,0)", "BAS(#ACC_PTP,100)", f"$ACC.ORI1={TURN_DEG_S2}", f"$ACC.ORI2={TURN_DEG_S2}"),
        *("$ORI_TYPE=#VAR", "PTP $AXIS_ACT"),
    )
    fault_forms = ("INTERRUPT DECL {interrupt} WHEN $STOPMESS==TRUE DO on_fault( )", "INTERRUPT ON {interrupt}")
    fault_body = (
        *("{fault}", "BRAKE F", "shut_valves( )", 'MsgNotify("fault, valves shut: reset the program")'),
        *("LOOP", "  HALT", "ENDLOOP"),
    )
    routine_form = ("DEF {routine}( )", "END")
    digital = "$OUT[{number}]={value}"
    group = "{name}={value}"
    analog = "$ANOUT[{number}]={value}"
    address_forms = ("$OUT[{number}]", "signal {name}", "$ANOUT[{number}]")
    contact_form, sensor_form = "$IN[{number}]", "$ANIN[{number}]"
    angles = ("A B C", "degrees about z, y', x''", moving_zyx)
    off_on = ("FALSE", "TRUE")
    states = ("FALSE", "TRUE")
    part_form = ("IF {start}<={number} THEN", "  {call}", "ENDIF")
    enter_begin = ("IF {start}=={number} THEN", "  {start}=1")
    enter_end = ("ENDIF",)
    guard = (
        "IF $OV_PRO<>100 THEN",
        "  {fault}",
        '  MsgNotify("speed override is not 100 percent")',
        "  RETURN",
        "ENDIF",
    )
    wait_contact, wait_sensor = under_each(
        (
            "nWait=0",
            "WHILE ({condition}) AND (nWait<{tenths})",
            "  WAIT SEC 0.1",
            "  nWait=nWait+1",
            "ENDWHILE",
            "IF {condition} THEN",
            "  {fault}",
            '  MsgNotify("{message}")',
            "  RETURN",
            "ENDIF",
        ),
        "$IN[{input}]<>{state}",
        "{reading}<{least}",
    )
    watch = ("INTERRUPT DECL {interrupt} WHEN $IN[{input}]=={other} DO on_fault( )", "INTERRUPT ON {interrupt}")
    await_contact = ("WAIT FOR $IN[{input}]=={state}",)
    watch_again = ("INTERRUPT ON {interrupt}",)
    """In a subprogram a declaration would end with it: that of main stays."""
    end_watch, last = ("INTERRUPT OFF {interrupt}",), (f"INTERRUPT OFF {INTERRUPT}",)
    loop_begin = ("{counter}=0", "REPEAT", "  {counter}={counter}+1")
    loop_end = ("UNTIL {condition}",)
    counted = "{counter}>={count}"
    sensed = "({counter}>={count}) OR ({reading}>={least})"
    reading = "{scale}*$ANIN[{input}]+{offset}"
    brackets = "()"
    rise_forms = (
        "PTP $AXIS_ACT",
        "$TOOL={tool}",
        "$BASE=$NULLFRAME",
        "xStart=$POS_ACT",
        "IF xStart.Z<{height} THEN",
        "  xStart.Z={height}",
        "  $VEL.CP=0.1",
        "  LIN xStart",
        "ENDIF",
    )
    vocabulary, names_parts_by_program, named_channels = KRL, True, frozenset({"group"})

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        super().__init__(dialect, lowered, installation)
        self.prefix = self.name_program(10)
        """Of global names."""
        self.start = self.names.give("start", 0, f"{self.prefix}_start")
        self.frame_prefixes = (f"{self.prefix}_t_", f"{self.prefix}_b_")

    def begin_production(self) -> Iterator[str]:
        """Declare the fault routine as interrupt too."""
        yield from super().begin_production()
        yield from (fill(form, interrupt=INTERRUPT) for form in self.fault_forms)

    def begin_watches(self) -> Iterator[str]:
        """Switch the interrupts on again."""
        return self.of_watched(self.watch_again)

    def setup(self) -> Iterator[Task]:
        """State what the integrator has to set up."""
        text = (
            "SPS.SUB shuts the valves where $PRO_ACT is FALSE: a program that is cancelled or deselected runs no line"
        )
        yield Task(text, ("; in the user part of SPS.SUB", "IF NOT $PRO_ACT THEN", *indent(self.shut()), "ENDIF"))
        rows = (*self.installation.functions.values(), *self.installation.solutions.values())
        sent = [each for row in rows for each in row if each.channel.kind == "group"]
        bits = {
            name: max(int(each.value).bit_length() for each in sent if each.channel.name == name)
            for name in dict.fromkeys(each.channel.name for each in sent)
        }
        signals = [f"GLOBAL SIGNAL {name} $OUT[n] TO $OUT[n+{max(most - 1, 0)}]" for name, most in bits.items()]
        if signals:
            yield Task("$config.dat: groups as signals, on your bits from n on", tuple(signals))

    def remarks(self) -> Iterator[str]:
        """State what the program uses, and what has to hold when it is started."""
        last = INTERRUPT + len(self.installation.waits)
        yield f"Interrupts {INTERRUPT} to {last} are used; {self.start} is in the .dat"
        yield "Mode AUT or EXT at 100 %: T1 is limited to 250 mm/s; MsgNotify of the message library of KSS 8"
        yield "$TOOL, $LOAD and $BASE are set from the .dat: compare them with yours"

    def faults(self) -> list[str]:
        """Write the routines that shut the valves; after a fault the program goes on only when it is reset."""
        return [
            "",
            f"DEF {self.shut_name}( )",
            *self.shut(),
            "END",
            "",
            "DEF on_fault( )",
            *self.with_fault(self.fault_body),
            "END",
        ]

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Write speeds, each where it matters, the triggers of the motion, and ``LIN``."""
        spot, turn, passes = line.turns_on_the_spot, turn_limit(line), line.blend_mm > 0.0
        if not spot:
            yield from self.set_modal(speed=line.speed_mm_s / 1000.0)
        rate = ORI_DEG_S if turn is None else turn
        yield from self.set_modal(turn=rate, second_turn=rate)
        for event in line.events:
            words = {"place": event.offset_mm, "delay": 1000.0 * event.offset_s}
            yield fill(self.triggers[spot], **words, output=self.output(event.channel, event.value))
        if passes:
            yield from self.set_modal(zone=line.blend_mm)
        yield fill(self.move, point=self.point(line.target), passes=passes)

    def reach(self, reach: Reach) -> Iterator[str]:
        """Write ``PTP``, to joint values and then the line that is left, or to the pose."""
        yield from self.slow_down(self.pace(reach))
        if reach.joints:
            yield fill(self.to_joints, axes=self.axes(reach.joints))
            yield from self.set_modal(speed=0.1)
        yield fill(self.straight if reach.joints else self.by_joints, point=self.point(reach.target))

    def use(self, step: UseTool | UseBoard) -> Iterator[str]:
        """Set ``$TOOL`` and its load, or ``$BASE``."""
        yield from super().use(step)
        if isinstance(step, UseTool):
            yield fill(self.load_form, load=self.load(self.tool_name))

    def load(self, tool: str) -> str:
        """Name the load of a tool."""
        return self.names.give("load", tool, f"{self.prefix}_l_{self.tools[tool].name}")

    def forget(self) -> None:
        """Keep the speeds: assumed that an integrator's routine leaves ``$VEL`` and ``$APO`` as they are."""

    def point(self, pose: Pose) -> str:
        """Declare a point."""
        self.points += 1
        self.data.append(f"DECL FRAME P{self.points}={_frame(pose)}")
        return f"P{self.points}"

    def axes(self, joints: tuple[float, ...]) -> str:
        """Write joint values; up to six joints are the robot's, what follows are external axes."""
        names = [f"{letter}{number}" for letter in "AE" for number in range(1, 7)]
        return f"{{{','.join(f'{n} {v}' for n, v in zip(names, self.joints(joints), strict=False))}}}"

    def prepare(self) -> Iterator[str]:
        """Set the controller's defaults and a slow ``PTP``; without a home the motion begins where the robot is."""
        yield "; the controller's own defaults; axes and turns that speed up as fast as $ACC_MA allows"
        yield from self.begin if not self.installation.home else self.begin[:-1]

    def home(self) -> list[str]:
        """Go to ``HOME_POSITION``."""
        return [*self.slow_down(CAUTIOUS), self.go_home] if self.installation.home else []

    def declarations(self) -> Iterator[str]:
        """Declare tools, loads, boards, home and counters."""
        for name, tool in self.tools.items():
            x, y, z = (fixed(value, 1) for value in tool.centre_mm)
            centre = f"{{X {x},Y {y},Z {z},A 0.0,B 0.0,C 0.0}}"
            about = (short(value, 6) if value else "0.0" for value in tool.payload.inertia_kg_m2)
            inertia = ",".join(f"{letter} {value}" for letter, value in zip("XYZ", about, strict=True))
            yield f"DECL GLOBAL FRAME {name}={_frame(tool.T_flange_tcp)}"
            load = f"{{M {fixed(tool.payload.mass_kg, 3)},CM {centre},J {{{inertia}}}}}"
            yield f"DECL GLOBAL LOAD {self.load(name)}={load}"
        yield from (f"DECL GLOBAL FRAME {name}={_frame(place)}" for name, place in self.boards.items())
        if self.rises:
            yield f"DECL FRAME xStart={_frame(IDENTITY)}"
        if self.installation.home:
            yield f"DECL E6AXIS HOME_POSITION={self.axes(self.installation.home)}"
        yield f"DECL GLOBAL INT {self.start}=1"
        yield "DECL INT nWait=0"
        yield from (f"DECL INT nLoop{number}=0" for number in self.loops)

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write one module, or a module for each routine and one that calls them."""
        units = f"Units: mm, degrees (A, B, C about z, y', x''), m/s, ms; points in {self.cad_frame}."
        body, data = [*self.heading(units), *main.body], list(self.declarations())
        if self.fits_one_file:
            data += [point for routine in routines for point in routine.data]
            after = [line for each in routines for line in ["", f"DEF {each.name}( )", *each.body, "END"]]
            return _module(self.name, [*body, "END", *self.faults(), *after], data)
        files = _module(self.name, [*body, "END", *self.faults()], data)
        for each in routines:
            files |= _module(each.name, [*each.body, "END"], each.data)
        return files


def _frame(pose: Pose) -> str:
    """Write a frame; A, B, C turn about z, the new y, the new x."""
    words = zip("XYZABC", pose_words(pose, moving_zyx), strict=True)
    return "{" + ",".join(f"{name} {number}" for name, number in words) + "}"


def _module(name: str, source: Iterable[str], data: Iterable[str]) -> dict[str, str]:
    return {
        f"{name}.src": join_lines([*HEAD, f"DEF {name}( )", *source]),
        f"{name}.dat": join_lines([*HEAD, f"DEFDAT {name} PUBLIC", *data, "ENDDAT"]),
    }
