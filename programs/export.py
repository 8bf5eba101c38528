"""A timed program in the language of a robot."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches

import numpy as np

from programs.errors import ProgramError
from programs.motion.installation import MAKER_NAMES, Installation, Maker
from programs.motion.layout import Tracking
from programs.motion.lower import EventError, lower
from programs.motion.make_motion import make_motion
from programs.motion.steps import MotionProgram
from programs.posts.dialects import DIALECTS, Dialect
from programs.posts.proving.agreement import Agreement
from programs.posts.proving.compare import prove
from programs.posts.proving.findings import check_routines, check_short, check_size, check_time
from programs.posts.proving.predict import predict
from programs.posts.rebuilt import Rebuilt
from programs.posts.writing.axes import in_tool_points
from programs.posts.writing.chapters import rest_within
from programs.program import TimedProgram
from programs.timing.controller import Controller
from programs.timing.forecast import Forecast
from specs.finding import Finding
from specs.finding_rules import WITHOUT_JOINTS
from specs.source import NO_SOURCE


@dataclass(frozen=True, slots=True)
class Exported:
    """The files of a robot program, and what has to be known about them."""

    files: Mapping[str, str]
    """Text by file name, the one to start with first; ASCII."""
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
    rebuilt: Rebuilt
    """What the reader found in the text."""


def export(
    program: TimedProgram,
    installation: Installation,
    dialect: str,
    tracking: Tracking | None = None,
    *,
    without_joints: bool = False,
) -> Exported:
    """Write a program in a robot's language.

    Args:
        program: As the robot is to do it.
        installation: The cell.
        dialect: Its name in ``DIALECTS``.
        tracking: How the robot carries the program out; ``None`` if not known.
        without_joints: Write poses only, also for the controller of another maker than the robot's.

    Raises:
        ProgramError: there is no such dialect, the robot is of another maker than the language's, the program cannot be
            driven, the language needs the joint motion, or the text does not do what was planned.
    """
    language = find_dialect(dialect)
    found: tuple[Finding, ...] = ()
    if without_joints:
        found = (_check_without_joints(language, dialect, installation),)
        installation = replace(installation, home=())
        tracking = tracking and replace(tracking, joints=np.empty((len(tracking.joints), 0)))
    else:
        check_maker(language, installation)
    if language.needs_joints and tracking is None:
        raise ProgramError(f"{dialect} is made of joint values; track the program in a cell first.")
    motion = make_motion(program, installation, tracking, switches_at_rest=language.capability.switches_at_rest)
    return write_motion(language, replace(motion, findings=(*found, *motion.findings)), installation)


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
    lowered = lower(motion, language.capability)
    files = language.render(lowered, installation)
    rebuilt, agreement = prove(language, files, motion, installation)
    if controller is None:
        return Exported(files, lowered.motion.findings, lowered.error, agreement, None, lowered.motion, rebuilt)
    forecast = predict(rebuilt, agreement, motion, installation, controller)
    found = (
        *check_time(forecast, controller),
        *check_short(forecast),
        *check_routines(stops, language.most_steps),
        *check_size(files, rebuilt, controller),
    )
    stated = replace(lowered.motion, findings=(*lowered.motion.findings, *found))
    files = language.render(replace(lowered, motion=stated, forecast=forecast), installation)
    final = language.read(files)
    if final.steps != rebuilt.steps:  # only comments may differ
        raise ProgramError(f"the header of the {language.title} text changes what it does: nothing was written.")
    return Exported(files, stated.findings, lowered.error, agreement, forecast, stated, final)


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
