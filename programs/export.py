"""A timed program in the language of a robot."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches

import numpy as np

from programs.driven import drive_program
from programs.errors import ProgramError
from programs.motion.first_run import as_first_run
from programs.motion.installation import MAKER_NAMES, Installation, Maker
from programs.motion.layout import Tracking
from programs.motion.lower import EventError, Lowered, lower
from programs.motion.make_motion import make_motion
from programs.motion.steps import MotionProgram
from programs.posts.dialect import Handover, ProgramFiles
from programs.posts.dialects import DIALECTS, Dialect
from programs.posts.proving.agreement import Agreement
from programs.posts.proving.commanded import NEAR_MM, fit_times, place_signals
from programs.posts.proving.compare import prove
from programs.posts.proving.findings import check_dose, check_routines, check_short, check_size, check_time
from programs.posts.proving.predict import driven_times, predict, run_of
from programs.posts.rebuilt import Rebuilt
from programs.posts.writing.axes import in_tool_points
from programs.posts.writing.chapters import rest_within
from programs.program import TimedProgram
from programs.timing.controller import Controller
from programs.timing.forecast import Forecast
from specs.finding import Finding
from specs.finding_rules import WITHOUT_JOINTS
from specs.source import NO_SOURCE

_FITS = 2
"""Times at most that the lines' speeds are found anew: in some languages their zones change with them."""


@dataclass(frozen=True, slots=True)
class Variant:
    """Which of the programs that a language has for one motion."""

    without_joints: bool = False
    """Poses only, also for the controller of another maker than the robot's."""
    first_run: bool = False
    """Its first run: no valve opens, it is slow, and stops before each step of the sequence."""


AS_PLANNED = Variant()


@dataclass(frozen=True, slots=True)
class Exported:
    """The files of a robot program, and what has to be known about them."""

    language: Dialect
    files: Mapping[str, str]
    """Text by file name, the one to start with first; ASCII."""
    handover: Handover
    """What an integrator has to know of it, and to do for it."""
    findings: tuple[Finding, ...]
    """What the cell, the valves and the language did not allow."""
    error: EventError
    """The worst event error."""
    agreement: Agreement
    """How closely the text, read back, does what was planned."""
    forecast: Forecast | None
    """What the controller's model predicts of the text; ``None`` where the text states the time of every place."""
    motion: MotionProgram
    """What was written: in the controller's terms."""
    commanded: MotionProgram
    """The same before that: the motion that was planned, at the speeds that were found for its lines."""
    rebuilt: Rebuilt
    """What the reader found in the text."""
    installation: Installation
    """The cell that it was written for."""
    controller: Controller | None
    """The model of its controller; ``None`` where the text states the time of every place."""

    def drive(self, program: TimedProgram) -> TimedProgram:
        """Give the program that was exported as the controller drives it, by its model."""
        if self.controller is None:
            return program
        run = run_of(self.rebuilt, self.agreement, self.commanded, self.installation, self.controller)
        return drive_program(program, *driven_times(run))


def export(
    program: TimedProgram,
    installation: Installation,
    dialect: str,
    tracking: Tracking | None = None,
    variant: Variant = AS_PLANNED,
) -> Exported:
    """Write a program in a robot's language.

    Args:
        program: As the robot is to do it.
        installation: The cell.
        dialect: Its name in ``DIALECTS``.
        tracking: How the robot carries the program out; ``None`` if not known.
        variant: Which of its programs.

    Raises:
        ProgramError: there is no such dialect, the robot is of another maker than the language's, the program cannot be
            driven, the language needs the joint motion, or the text does not do what was planned.
    """
    language = find_dialect(dialect)
    found: tuple[Finding, ...] = ()
    if variant.without_joints:
        found = (_check_without_joints(language, dialect, installation),)
        installation = replace(installation, home=())
        tracking = tracking and replace(tracking, joints=np.empty((len(tracking.joints), 0)), share=None)
    else:
        check_maker(language, installation)
    if language.needs_joints and tracking is None:
        raise ProgramError(f"{dialect} is made of joint values; track the program in a cell first.")
    motion = make_motion(program, installation, tracking, switches_at_rest=language.capability.switches_at_rest)
    motion = replace(motion, findings=(*found, *motion.findings))
    if variant.first_run:  # which no line starts
        motion, installation = as_first_run(motion, installation), replace(installation, handshake=None)
    return write_motion(language, motion, installation)


def count_steps(program: TimedProgram, installation: Installation, language: Dialect) -> int:
    """Count the steps of a program as planned: a robot that carries it out needs these and its own."""
    return len(make_motion(program, installation, switches_at_rest=language.capability.switches_at_rest).steps)


def write_motion(language: Dialect, motion: MotionProgram, installation: Installation) -> Exported:
    """Write a motion, read it back, predict its time from what was read, and state that in its header.

    Raises:
        ProgramError: the language cannot express it, or the text does not do what was planned.
    """
    if language.takes_axes and installation.tool_point is not None:
        motion = in_tool_points(motion, installation)
    controller = controller_of(language, installation)
    language = replace(language, controller=controller)
    if controller is not None and 0 < controller.most_positions < language.most_steps:
        language = replace(language, most_steps=controller.most_positions)
    motion, stops = rest_within(motion, language.most_steps)
    lowered, (files, handover), rebuilt, agreement = _write(language, motion, installation)
    planned, stated, forecast, final = motion, lowered.motion, None, rebuilt
    if controller is not None:
        run = run_of(rebuilt, agreement, motion, installation, controller)
        for _ in range(_FITS):
            fitted = fit_times(run, planned)
            if fitted is motion:
                break
            motion = fitted
            lowered, (files, handover), rebuilt, agreement = _write(language, motion, installation)
            run = run_of(rebuilt, agreement, motion, installation, controller)
        forecast = predict(run)
        counts = language.capability.timing == "distance and time"  # such a controller does that itself
        if forecast.event_mm > NEAR_MM and not counts:
            motion = place_signals(run)
            lowered, (files, handover), rebuilt, agreement = _write(language, motion, installation)
            forecast = predict(run_of(rebuilt, agreement, motion, installation, controller))
        found = (
            *(() if motion.first_run else (*check_time(forecast, controller), *check_dose(forecast))),
            *check_short(forecast),
            *check_routines(stops, language.most_steps),
            *check_size(files, rebuilt, controller),
        )
        stated = replace(lowered.motion, findings=(*lowered.motion.findings, *found))
        files, handover = language.write(language, replace(lowered, motion=stated, forecast=forecast), installation)
        final = language.read(files)
        if final.steps != rebuilt.steps:  # only comments may differ
            raise ProgramError(f"the header of the {language.title} text changes what it does: nothing was written.")
    return Exported(
        language=language,
        files=files,
        handover=handover,
        findings=stated.findings,
        error=lowered.error,
        agreement=agreement,
        forecast=forecast,
        motion=stated,
        commanded=motion,
        rebuilt=final,
        installation=installation,
        controller=controller,
    )


def _write(
    language: Dialect, motion: MotionProgram, installation: Installation
) -> tuple[Lowered, tuple[ProgramFiles, Handover], Rebuilt, Agreement]:
    """Write a motion and read it back."""
    lowered = lower(motion, language.capability)
    files, handover = language.write(language, lowered, installation)
    return lowered, (files, handover), *prove(language, files, motion, installation, lowered.motion)


def controller_of(language: Dialect, installation: Installation) -> Controller | None:
    """Give the model that predicts the times of a language, with the numbers of a cell."""
    if language.controller is None:
        return None
    return language.controller.with_values(installation.controller, installation.controller_source)


def check_maker(language: Dialect, installation: Installation) -> None:
    """Make sure that the robot's controller executes a language: another maker's counts joints in another way.

    Raises:
        ProgramError: it does not, the robot's maker is not stated, or its controller takes no tool points.
    """
    if language.needs_tool_points and installation.tool_point is None:
        machine = "a machine with X, Y, Z and a head that turns about C and tilts about B"
        raise ProgramError(
            f"{language.title} is for {machine}, and cell {installation.cell} states none: a gantry's cell with "
            "kinematics: 5axiskins, or choose joint-table."
        )
    if language.maker is None or language.maker == installation.maker:
        return
    maker, robot = MAKER_NAMES[language.maker], f"robot {installation.robot} of cell {installation.cell}"
    ways = [f"a cell with a robot of {maker}"]
    if installation.maker is None:
        ways = ["state its maker and controller_joints beside its URDF", "choose joint-table"]
        why = "states no maker, and each maker's controllers count joints in their own way"
    else:
        own = _dialect_of(installation.maker) or "joint-table"
        why = f"is by {MAKER_NAMES[installation.maker]}, whose joint values are another pose there"
        ways = [f"choose {own}", *ways]
    ways += ["export --without-joints"] * bool(language.without_joints)
    raise ProgramError(f"{language.title} is for {maker}, and {robot} {why}: {', or '.join(ways)}.")


def _check_without_joints(language: Dialect, dialect: str, installation: Installation) -> Finding:
    """Give the finding that a program has no joint values.

    Raises:
        ProgramError: the language has no program without them.
    """
    if language.maker is None:
        raise ProgramError(f"{dialect} is made of joint values; leave out --without-joints.")
    if not language.without_joints:
        raise ProgramError(
            f"{language.title} states the arm's configuration with its positions, and only joint values give it: "
            f"choose a cell with a robot of {MAKER_NAMES[language.maker]}, and leave out --without-joints."
        )
    checked = f"Written without joint values. Reach, collisions and time were checked for {installation.robot} only."
    return Finding(WITHOUT_JOINTS, f"{checked} {language.without_joints} No home is written.", NO_SOURCE)


def own_dialect(installation: Installation) -> str:
    """Give the language of a robot's controller, by its name in ``DIALECTS``.

    Raises:
        ProgramError: its maker is not stated, or is none of those whose languages are written.
    """
    if own := _dialect_of(installation.maker):
        return own
    takes_points = installation.tool_point is not None
    fitting = [name for name, each in DIALECTS.items() if each.maker is None and takes_points >= each.needs_tool_points]
    open_to_all = ", ".join(fitting)
    raise ProgramError(
        f"robot {installation.robot} has no maker whose language is written; give --dialect. It can have {open_to_all}."
    )


def _dialect_of(maker: Maker | None) -> str | None:
    return next((name for name, each in DIALECTS.items() if maker is not None and each.maker == maker), None)


def find_dialect(name: str) -> Dialect:
    """Give a dialect by its name.

    Raises:
        ProgramError: there is none; the message names those that exist.
    """
    if name not in DIALECTS:
        nearest = get_close_matches(name.lower(), DIALECTS, n=1)
        hint = f"did you mean {nearest[0]}?" if nearest else f"there are {', '.join(DIALECTS)}."
        raise ProgramError(f"there is no dialect {name!r}; {hint}")
    return DIALECTS[name]
