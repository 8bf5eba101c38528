"""The axes of a LinuxCNC machine: their letters, where zero is, and how fast a block goes."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from programs.errors import ProgramError
from programs.motion.installation import Installation
from programs.motion.steps_of_robot import Line, MotionProgram, UseBoard
from programs.posts.writing.axes import in_controller_units, needed_samples, units_of
from programs.posts.writing.wording import fixed, short

BLEND_MM = 0.05
"""How far ``G64`` may cut a corner; zones are planned for the same."""
SYSTEMS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")
_LETTERS = "XYZABCUVW"
_FINENESS = 0.7
"""Share of the allowed deviation that straight blocks may use; the rest is for rounding."""
_DIGITS = 4


@dataclass(frozen=True, slots=True)
class Machine:
    """What the words of a block mean."""

    installation: Installation
    letters: tuple[str, ...]
    """Of the joints, in their order."""
    slides: bool
    """Whether X, Y and Z are straight axes: then F in mm/min is the speed of an orifice that does not turn."""
    offsets: dict[str, tuple[str, tuple[float, ...]]]
    """Coordinate system, and what it adds to each axis, by the placement of the board."""


def make_machine(motion: MotionProgram, installation: Installation) -> Machine:
    """Name the axes as the joints are named if those are axes, else X, Y, Z, A, B, C, U, V, W in their order.

    Where X, Y and Z slide, assumed along the directions of the base frame, the board's origin is their zero.

    Raises:
        ProgramError: there are more axes or places of the board than LinuxCNC has.
    """
    names = [joint.name.upper() for joint in installation.joints]
    if len(names) > len(_LETTERS):
        raise ProgramError(f"LinuxCNC has {len(_LETTERS)} axes; robot {installation.robot} has {len(names)} joints.")
    are_axes = len(set(names)) == len(names) and all(len(name) == 1 and name in _LETTERS for name in names)
    letters = tuple(names if are_axes else _LETTERS[: len(names)])
    kinds = {letter: joint.kind for letter, joint in zip(letters, installation.joints, strict=True)}
    slides = all(kinds.get(letter) == "prismatic" for letter in "XYZ")
    places = {step.placement: step.T_base_board for step in motion.steps if isinstance(step, UseBoard)}
    if len(places) > len(SYSTEMS):
        raise ProgramError(f"LinuxCNC has {len(SYSTEMS)} coordinate systems; the board lies in {len(places)} places.")
    offsets: dict[str, tuple[str, tuple[float, ...]]] = {}
    for system, (placement, place) in zip(SYSTEMS, places.items(), strict=False):
        origin = dict(zip("XYZ", place.position, strict=True)) if slides else {}
        offsets[placement] = (system, tuple(round(origin.get(letter, 0.0), _DIGITS) for letter in letters))
    return Machine(installation, letters, slides, offsets)


@dataclass(slots=True)
class AxisWriter:
    """Where the axes are, and the modes in force, at the end of what is written."""

    machine: Machine
    offset: tuple[float, ...] = ()
    axes: tuple[str, ...] = ()
    """As written last; empty where the next block has to say all."""
    modes: tuple[str, str] = ("", "")
    """Path control, and feed mode."""
    turning: bool = field(default=True)
    """Whether another axis than X, Y and Z moves in the block written last."""

    def use(self, board: UseBoard) -> str:
        """Use the coordinate system of a placement from now on."""
        system, self.offset = self.machine.offsets[board.placement]
        self.axes = ()
        return system

    def forget(self) -> None:
        """Say everything again: what runs before is not known."""
        self.axes, self.modes = (), ("", "")

    def words(self, joints: tuple[float, ...]) -> str:
        """Write the axes that change, at least one.

        Raises:
            ProgramError: the joints are not known.
        """
        if not joints or len(joints) != len(self.machine.letters):
            raise ProgramError("G-code is made of joint values; track the program in a cell first.")
        values = in_controller_units(joints, self.machine.installation)
        offset = self.offset or tuple(0.0 for _ in values)
        axes = tuple(
            f"{letter}{fixed(value - zero, _DIGITS)}"
            for letter, value, zero in zip(self.machine.letters, values, offset, strict=True)
        )
        before = self.axes or tuple("" for _ in axes)
        changed = [now for now, then in zip(axes, before, strict=True) if now != then]
        self.turning = any(word[0] not in "XYZ" for word in changed)
        self.axes = axes
        return " ".join(changed or axes[:1])

    def blocks(self, line: Line) -> Iterator[str]:
        """Write a line: as many blocks as its axes need to follow it."""
        if not line.joints:
            raise ProgramError("G-code is made of joint values; track the program in a cell first.")
        done = 0.0
        for sample in needed_samples(line.course, units_of(self.machine.installation), _FINENESS):
            share = float(line.course.shares[sample])
            words = self.words(tuple(line.course.joints[sample].tolist()))
            path = "G61.1" if share == 1.0 and line.blend_mm == 0.0 else f"G64 P{BLEND_MM:g} Q0"
            feed_mode, feed = self._feed(line, share - done)
            new = [now for now, then in zip((path, feed_mode), self.modes, strict=True) if now != then]
            self.modes = (path, feed_mode)
            yield f"{' '.join([*new, 'G1'])} {words} F{feed}"
            done = share

    def _feed(self, line: Line, share: float) -> tuple[str, str]:
        """Give the feed mode and ``F`` of a block that does this share of a line."""
        if self.machine.slides and line.speed_mm_s > 0.0 and not self.turning:
            return "G94", short(60.0 * line.speed_mm_s, 1)
        whole_s = line.duration_s
        if line.speed_mm_s > 0.0:
            whole_s = line.length_mm / line.speed_mm_s
        elif line.turn_rad_s > 0.0:
            whole_s = line.angle_rad / line.turn_rad_s
        return "G93", short(60.0 / (share * whole_s), 4)
