"""Reads a program in a robot's language as a timed program, so that it can be shown like a native one."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import ceil, degrees, hypot
from pathlib import Path
from typing import TypeAlias

import numpy as np

from programs.errors import ProgramError
from programs.motion.installation import Installation
from programs.plan import Origin
from programs.pose import Pose, angle, compose, distance, inverse
from programs.posts.dialects import DIALECTS, Dialect
from programs.posts.rebuilt import (
    Axes,
    ReadCall,
    ReadEndRepeat,
    ReadLine,
    ReadPause,
    ReadReach,
    ReadRepeat,
    ReadStep,
    ReadSwitch,
    ReadTool,
    Rebuilt,
)
from programs.posts.writing.axes import units_of
from programs.posts.writing.wording import make_name
from programs.program import MOST_MOVES, Command, Instruction, MoveTo, SetNozzle, TimedProgram, Totals, Wait
from specs.input_file import InputFile
from specs.source import NO_SOURCE

_REACH_MM_S, _TURN_DEG_S = 100.0, 90.0
"""Of joint motions, and of turns whose rate the text does not state: assumed."""
_PART_DEG = 5.0
"""Axes that turn by more than this move in several parts."""
_MOST_DEG = 50_000.0
"""That an axis is turned to, in one of two directions: 139 turns."""
_LARGEST_TEXT = 50_000_000
"""Bytes of all files of a program."""
_LONGEST_S = 1e7
_FARTHEST_MM = 1e6
_TOO_FAR = f"this statement leads more than {_FARTHEST_MM / 1000:,.0f} m away; no robot's program does."
_ORIGIN = {
    what: re.compile(rf"\b(?:{words}) +(\S.{{0,999}}?)  sha256 (\w+)")
    for what, words in (("Board", "Board|Part"), ("Recipe", "Recipe"))
}
_CELL = re.compile(r"\bCell +(\S.{0,999}?)  robot ")


Flange: TypeAlias = Callable[[tuple[float, ...]], Pose]
"""Forward kinematics: the flange seen from the base, by joints in radians or mm."""


def is_foreign(path: Path) -> bool:
    """Whether a path is that of a program in a robot's language: by its suffix, or a folder."""
    return path.is_dir() or path.suffix.lower() in suffixes()


def read_files(path: Path) -> tuple[str, Mapping[str, str]]:
    """Read the files of a program, the one to start with first, and give its language.

    Args:
        path: A file, with which others of its name or project are read, or the folder of all.

    Raises:
        ProgramError: a file cannot be read, or there is none in a known language.
    """
    inside = sorted(path.iterdir()) if path.is_dir() else []
    if len(inside) == 1 and inside[0].is_dir():  # a project has a folder of its name
        path = inside[0]
    folder = path if path.is_dir() else path.parent
    places = sorted(each for each in folder.iterdir() if each.is_file()) if folder.is_dir() else []
    first = path if not path.is_dir() else next((each for each in places if is_foreign(each)), path)
    if first.is_dir():
        raise ProgramError("there is no program in a robot's language in this folder.", file=path)
    text = _read_text(first)
    suffix = first.suffix.lower()
    names = [name for name, language in DIALECTS.items() if suffix in _suffixes(language)]
    if not names:
        raise ProgramError(f"{suffix or 'no suffix'} is not that of a robot's language.")
    name = names[0]
    if name == "abb":
        name = "abb-paint" if re.search(r"^[ \t]*PaintL ", text, re.MULTILINE) else "abb"
    elif "melfa" in names:
        name = "melfa" if text.startswith("1 ") else "epson"
    language = DIALECTS[name]
    kept = [each for each in places if each.suffix.lower() in _suffixes(language)]
    if not path.is_dir() and not language.form.several:
        kept = [each for each in kept if each.stem.startswith(path.stem) or each == path]
    files: dict[str, str] = {}
    for each in kept or [first]:
        files[each.name] = _read_text(each)
        if sum(map(len, files.values())) > _LARGEST_TEXT:
            raise ProgramError(
                f"more than {_LARGEST_TEXT:,} bytes in its files; no robot's program has so many.", file=path
            )
    return name, _in_order(language, files)


def suffixes() -> frozenset[str]:
    """Give the suffixes, in small letters, of files in robots' languages."""
    return frozenset(each for language in DIALECTS.values() for each in _suffixes(language))


def _suffixes(language: Dialect) -> set[str]:
    form = language.form
    return {each.lower() for each in (form.suffix, *form.several, *form.beside, *form.also)}


def _read_text(path: Path) -> str:
    file = InputFile(path, ProgramError, "robot program", _LARGEST_TEXT)
    return file.text("this is not the ASCII text of a robot program.", "ascii").replace("\r\n", "\n")


def _in_order(language: Dialect, files: Mapping[str, str]) -> Mapping[str, str]:
    """Put the file to start with first: the list of modules, or the one whose name no other mentions."""
    listing = next((name for name in files if name.endswith(".pgf")), None)
    if listing is not None:
        modules = [name for name in re.findall(r"<Module>([^<]*)</Module>", files[listing]) if name in files]
        return {name: files[name] for name in (listing, *modules)}

    stems = {Path(name).stem for name in files}
    several = {stem: re.compile(rf"\b{re.escape(stem)}\b") for stem in stems if not re.fullmatch(r"\w+", stem)}
    found = {
        name: (stems.intersection(re.findall(r"\w+", text)) | {stem for stem in several if several[stem].search(text)})
        - {Path(name).stem}
        for name, text in files.items()
    }
    mentioned = frozenset[str]().union(*found.values())

    def rank(name: str) -> tuple[bool, bool, bool, int, str]:
        is_apart = not found[name]  # as what runs beside the program
        is_other = not name.lower().endswith(language.form.suffix.lower())
        return is_other, Path(name).stem in mentioned, is_apart, len(name), name

    main = min(files, key=rank)
    return {name: files[name] for name in (main, *(each for each in files if each != main))}


def named_cell(files: Mapping[str, str]) -> str:
    """Give the cell that the header names; empty if there is none."""
    found = next((match for text in files.values() if (match := _CELL.search(text))), None)
    return found[1] if found else ""


def rebuild_program(
    dialect: str, files: Mapping[str, str], installation: Installation, flange: Flange | None = None
) -> TimedProgram:
    """Execute the text of a program, each loop once, and time it by the speeds that it states.

    Args:
        dialect: A name in ``DIALECTS``.
        files: Text by file name, the one to start with first.
        installation: The cell, which states the valves of its nozzles and their lags.
        flange: The kinematics of its robot, for languages that state axes instead of poses.

    Raises:
        ProgramError: the reader does not understand a line, or the text moves axes and there are no kinematics, or
            those of another number of joints, or a motion is larger or longer than any of a robot.
    """
    rebuilt = DIALECTS[dialect].read_edited(files)
    playing = _Playing(rebuilt, installation, flange, installation.T_base_board)
    for at, step in enumerate(rebuilt.steps):
        playing.play(at, step)
        playing.check(at)
    instructions = tuple(sorted(playing.instructions, key=lambda item: item.time_s))
    sprayed, opened = 0.0, None
    for item in instructions:
        if isinstance(item, SetNozzle):
            sprayed += item.time_s - opened if opened is not None else 0.0
            opened = item.time_s if item.spraying else None
    moves = sum(isinstance(item, MoveTo) for item in instructions)
    named = _origin_of(files)
    board, recipe = named["Board"] or (Path(next(iter(files))).stem, "0"), named["Recipe"] or ("unknown", "0")
    return TimedProgram(Origin(*board, *recipe), Totals(playing.now, sprayed, playing.way_mm, moves, ()), instructions)


def check_origin(files: Mapping[str, str]) -> None:
    """Make sure that a text names what it was made from, as a native program does.

    Raises:
        ProgramError: it does not.
    """
    if lacking := next((what for what, found in _origin_of(files).items() if found is None), None):
        raise ProgramError(
            f"the text does not name its {lacking.lower()} with the fingerprint, so no .wash can be made of it; show "
            "it without --output, or export it anew.",
            file=next(iter(files)),
        )


def _origin_of(files: Mapping[str, str]) -> dict[str, tuple[str, str] | None]:
    """Give name and fingerprint of the board and of the recipe, as far as a text has them."""
    found = {what: [pattern.search(text) for text in files.values()] for what, pattern in _ORIGIN.items()}
    return {what: next(((each[1], each[2]) for each in matches if each), None) for what, matches in found.items()}


@dataclass(slots=True)
class _Playing:
    """A program while it is executed."""

    rebuilt: Rebuilt
    installation: Installation
    flange: Flange | None
    T_base_board: Pose
    tool: int = 0
    nozzle: str = ""
    """The one whose jet was on last, of the tool that is mounted; empty before."""
    axes: tuple[float, ...] = ()
    """Where the last motion of axes ended: degrees and mm."""
    now: float = 0.0
    way_mm: float = 0.0
    pose: Pose | None = None
    spraying: bool = False
    instructions: list[Instruction] = field(default_factory=list[Instruction])

    def play(self, at: int, step: ReadStep) -> None:
        """Execute one step."""
        match step:
            case ReadReach() | ReadLine():
                self.move(at, step)
            case ReadPause():
                self.instructions.append(Wait(self.now, step.duration_s, NO_SOURCE))
                self.now += step.duration_s
            case ReadSwitch():
                self.switch(step.channel, step.value, self.now)
            case ReadTool():
                self.mount(step)
            case ReadCall():
                self.command("CALL", step.label)
                moved = {make_name(name, 40).lower(): place for name, place in self.installation.placements.items()}
                self.T_base_board = moved.get(step.label.lower(), self.T_base_board)
            case ReadRepeat():
                channel = f"input_{step.channel}" if step.channel.isdigit() else step.channel or "count"
                self.command("REPEAT", str(step.count), "UNTIL", channel, ">=", f"{step.least or 0:g}")
            case ReadEndRepeat():
                self.command("ENDREPEAT")
            case _:
                pass

    def check(self, at: int) -> None:
        """Refuse a program that is longer than any, or leaves the space of any robot.

        Raises:
            ProgramError: it is.
        """
        far = self.pose is not None and not all(abs(each) <= _FARTHEST_MM for each in self.pose.position)
        if far:
            raise self.error(at, _TOO_FAR)
        if not self.now <= _LONGEST_S:
            raise self.error(at, f"this statement ends after {self.now:,.0f} s; no robot's program does.")

    def error(self, at: int, message: str) -> ProgramError:
        """Give an error at the place of a step."""
        place = self.rebuilt.place(at)
        return ProgramError(message, file=place and place.file, line=place and place.line)

    def command(self, keyword: str, *words: str) -> None:
        """Add a command to the cell."""
        self.instructions.append(Command(self.now, keyword, words, NO_SOURCE))

    def mount(self, step: ReadTool) -> None:
        """Name the nozzle of a tool: the cell's with that pose, or that number, or the only one."""
        tools = self.installation.tools
        place = step.T_flange_tcp
        fitting = [n for n, tool in tools.items() if place is not None and distance(tool.T_flange_tcp, place) <= 0.01]
        numbered = [int(word) for word in re.findall(r"(?<!\d)\d{1,9}(?!\d)", step.label) if int(word) in tools]
        self.tool, self.nozzle = next(iter([*fitting, *numbered, *tools]), 0), ""
        self.command("NOZZLE", self.installation.tool(self.tool).name, "TOOL", str(self.tool))

    def move(self, at: int, step: ReadReach | ReadLine) -> None:
        """Move to a pose at the speed that is stated."""
        target = step.target
        if isinstance(target, Axes):
            self.move_axes(at, step, target.values)
            return
        way = distance(self.pose, target) if self.pose is not None else 0.0
        turn = degrees(angle(self.pose, target)) if self.pose is not None else 0.0
        lasts_s = max(way / _REACH_MM_S, turn / _TURN_DEG_S)
        if isinstance(step, ReadLine):
            rate = step.turn_deg_s or _TURN_DEG_S
            lasts_s = way / step.speed_mm_s if step.speed_mm_s and way else turn / rate
            lasts_s = step.duration_s if step.duration_s is not None else lasts_s
            for signal in step.signals:
                leaves_s = min(max(signal.share * lasts_s + signal.offset_s, 0.0), lasts_s)
                self.switch(signal.channel, signal.value, self.now + leaves_s)
        self.arrive(target, way, lasts_s)

    def arrive(self, target: Pose, way: float, lasts_s: float) -> None:
        """Be at a pose after so many mm and seconds."""
        self.now += lasts_s
        self.way_mm += way
        speed = way / lasts_s if lasts_s else 0.0
        self.instructions.append(MoveTo(self.now, target.position, target.quaternion, speed, NO_SOURCE))
        self.pose = target

    def move_axes(self, at: int, step: ReadReach | ReadLine, values: tuple[float, ...]) -> None:
        """Move axes evenly, in parts between which the tool turns little.

        Raises:
            ProgramError: their poses are not known.
        """
        if self.flange is None or len(values) != len(self.installation.joints):
            joints = len(self.installation.joints)
            why = "whose poses the kinematics of its cell give" if self.flange is None else f"and the cell has {joints}"
            raise self.error(
                at, f"this program moves {len(values)} axes, {why}; read it in the cell that it was made for."
            )
        revolute = np.array([joint.kind == "revolute" for joint in self.installation.joints])
        begin, end = np.array(self.axes or values), np.array(values)
        if not np.all(np.abs(end[revolute]) <= _MOST_DEG):
            raise self.error(at, f"an axis turns to more than {_MOST_DEG:,.0f} degrees; no robot's does.")
        if not np.all(np.abs(end[~revolute]) <= _FARTHEST_MM):
            raise self.error(at, _TOO_FAR)
        count = max(ceil(float(np.max(np.abs(end - begin)[revolute], initial=0.0)) / _PART_DEG), 1)
        if len(self.instructions) + count > MOST_MOVES:
            raise self.error(
                at, f"up to this statement there are more than {MOST_MOVES:,} moves; no program has so many."
            )
        rows = begin + np.arange(1, count + 1)[:, None] / count * (end - begin)
        poses = [self.pose_of(tuple(row)) for row in rows.tolist()]
        before = [self.pose or poses[0], *poses]
        ways = [distance(a, b) for a, b in zip(before, poses, strict=False)]
        lasts_s = self.lasting(step, tuple(rows[-1].tolist()), sum(ways))
        self.axes = values
        for pose, way in zip(poses, ways, strict=True):
            self.arrive(pose, way, lasts_s / len(poses))

    def joints_of(self, axes: tuple[float, ...]) -> tuple[float, ...]:
        """Give joints in radians and mm of axes in degrees and mm: those themselves, or tool points and two angles."""
        row, machine = np.array([axes]) * units_of(self.installation), self.installation.tool_point
        return tuple((row if machine is None else machine.joints(row))[0].tolist())

    def pose_of(self, axes: tuple[float, ...]) -> Pose:
        """Give where the orifice is, seen from the board."""
        assert self.flange is not None
        tip = compose(self.flange(self.joints_of(axes)), self.installation.tool(self.tool).T_flange_tcp)
        return compose(inverse(self.T_base_board), tip)

    def lasting(self, step: ReadReach | ReadLine, values: tuple[float, ...], way: float) -> float:
        """Give the time of a motion of axes: as the text states it, or at the greatest speed of the joints."""
        begin = self.axes or values
        if isinstance(step, ReadReach):
            far = np.abs(np.subtract(self.joints_of(values), self.joints_of(begin)))
            return float(np.max(far / [joint.speed for joint in self.installation.joints], initial=0.0))
        if step.duration_s is not None:
            return step.duration_s
        if step.speed_mm_s:
            return way / step.speed_mm_s
        turns = np.subtract(values, begin)[[joint.kind == "revolute" for joint in self.installation.joints]]
        return hypot(*turns.tolist()) / (step.turn_deg_s or _TURN_DEG_S)

    def switch(self, label: str, value: float, at_s: float) -> None:
        """Begin or end the jet of a valve after its lag; any other output is not shown."""
        for name, valve in self.installation.valves.items():
            channel = valve.channel
            on = value > 0.5
            if channel.is_called(label) and on != self.spraying:
                lag = valve.open_lag_s if on else valve.close_lag_s
                self.spraying = on
                if on and name != self.nozzle:
                    self.nozzle = name
                    self.instructions.append(Command(at_s, "NOZZLE", (name, "TOOL", str(self.tool)), NO_SOURCE))
                self.instructions.append(SetNozzle(at_s + lag, on, NO_SOURCE))
                return
