"""Reads a program in a robot's language as a timed program, so that it can be shown like a native one."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import degrees
from pathlib import Path

from programs.errors import ProgramError
from programs.motion.installation import Installation
from programs.plan import Origin
from programs.pose import Pose, angle, distance
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
from programs.program import Command, Instruction, MoveTo, SetNozzle, TimedProgram, Totals, Wait
from programs.soundness import LARGEST_BYTES
from specs.read_file import read_file
from specs.source import NO_SOURCE

_REACH_MM_S, _TURN_DEG_S = 100.0, 90.0
"""Of joint motions, and of turns whose rate the text does not state: assumed."""
_ORIGIN = {what: re.compile(rf"\b{what} +(\S.*?)  sha256 (\S+)") for what in ("Board", "Recipe")}
_CELL = re.compile(r"\bCell +(\S.*?)  robot ")


def is_foreign(path: Path) -> bool:
    """Whether a path is that of a program in a robot's language: by its suffix, or a folder."""
    return path.is_dir() or path.suffix.lower() in {each for form in DIALECTS.values() for each in _suffixes(form)}


def read_files(path: Path) -> tuple[str, Mapping[str, str]]:
    """Read the files of a program, the one to start with first, and give its language.

    Args:
        path: A file, with which others of its name or project are read, or the folder of all.

    Raises:
        ProgramError: a file cannot be read, or there is none in a known language.
    """
    folder = path if path.is_dir() else path.parent
    inside = sorted(folder.iterdir()) if path.is_dir() else []
    if len(inside) == 1 and inside[0].is_dir():  # a project has a folder of its name
        return read_files(inside[0])
    places = sorted(each for each in folder.iterdir() if each.is_file()) if folder.is_dir() else []
    first = path if not path.is_dir() else next((each for each in places if is_foreign(each)), path)
    if first.is_dir():
        raise ProgramError("there is no program in a robot's language in this folder.", file=path)
    text = _read_text(first)
    name = _recognise(first.suffix.lower(), text)
    language = DIALECTS[name]
    kept = [each for each in places if each.suffix.lower() in _suffixes(language)]
    if not path.is_dir() and not language.form.several:
        kept = [each for each in kept if each.stem.startswith(path.stem) or each == path]
    files = {each.name: _read_text(each) for each in kept or [first]}
    return name, _in_order(language, files)


def _suffixes(language: Dialect) -> set[str]:
    form = language.form
    return {each.lower() for each in (form.suffix, *form.several, *form.beside, *form.also)}


def _read_text(path: Path) -> str:
    data = read_file(path, ProgramError, "robot program", LARGEST_BYTES)
    try:
        return data.decode("ascii").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ProgramError("this is not the ASCII text of a robot program.", file=path, line=line) from None


def _recognise(suffix: str, text: str) -> str:
    names = [name for name, language in DIALECTS.items() if suffix in _suffixes(language)]
    if "abb" in names:
        return "abb-paint" if re.search(r"^\s*PaintL ", text, re.MULTILINE) else "abb"
    if "melfa" in names:
        return "melfa" if text.startswith("1 ") else "epson"
    if not names:
        raise ProgramError(f"{suffix or 'no suffix'} is not that of a robot's language.")
    return names[0]


def _in_order(language: Dialect, files: Mapping[str, str]) -> Mapping[str, str]:
    """Put the file to start with first: the list of modules, or the one whose name no other mentions."""
    listing = next((name for name in files if name.endswith(".pgf")), None)
    if listing is not None:
        modules = [name for name in re.findall(r"<Module>(.*)</Module>", files[listing]) if name in files]
        return {name: files[name] for name in (listing, *modules)}

    def rank(name: str) -> tuple[bool, bool, int, str]:
        stem = Path(name).stem
        others = (text for other, text in files.items() if Path(other).stem != stem)
        mentioned = any(re.search(rf"\b{re.escape(stem)}\b", text) for text in others)
        return not name.lower().endswith(language.form.suffix.lower()), mentioned, len(name), name

    main = min(files, key=rank)
    return {name: files[name] for name in (main, *(each for each in files if each != main))}


def named_cell(files: Mapping[str, str]) -> str:
    """Give the cell that the header names; empty if there is none."""
    found = next((match for text in files.values() if (match := _CELL.search(text))), None)
    return found[1] if found else ""


def rebuild_program(dialect: str, files: Mapping[str, str], installation: Installation) -> TimedProgram:
    """Execute the text of a program, each loop once, and time it by the speeds that it states.

    Args:
        dialect: A name in ``DIALECTS``.
        files: Text by file name, the one to start with first.
        installation: The cell, which states the valves of its nozzles and their lags.

    Raises:
        ProgramError: the reader does not understand a line, or the text states axes instead of poses.
    """
    rebuilt = DIALECTS[dialect].read(files)
    playing = _Playing(rebuilt, installation)
    for at, step in enumerate(rebuilt.steps):
        playing.play(at, step)
    instructions = tuple(sorted(playing.instructions, key=lambda item: item.time_s))
    sprayed, opened = 0.0, None
    for item in instructions:
        if isinstance(item, SetNozzle):
            sprayed += item.time_s - opened if opened is not None else 0.0
            opened = item.time_s if item.spraying else None
    moves = sum(isinstance(item, MoveTo) for item in instructions)
    return TimedProgram(_origin(files), Totals(playing.now, sprayed, playing.way_mm, moves, ()), instructions)


def _origin(files: Mapping[str, str]) -> Origin:
    found = {
        what: next((match.groups() for text in files.values() if (match := pattern.search(text))), None)
        for what, pattern in _ORIGIN.items()
    }
    board, recipe = found["Board"] or (Path(next(iter(files))).stem, "0"), found["Recipe"] or ("unknown", "0")
    return Origin(board[0], board[1], recipe[0], recipe[1])


@dataclass(slots=True)
class _Playing:
    """A program while it is executed."""

    rebuilt: Rebuilt
    installation: Installation
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
            case ReadRepeat():
                channel = f"input_{step.channel}" if step.channel.isdigit() else step.channel or "count"
                self.command("REPEAT", str(step.count), "UNTIL", channel, ">=", f"{step.least or 0:g}")
            case ReadEndRepeat():
                self.command("ENDREPEAT")
            case _:
                pass

    def command(self, keyword: str, *words: str) -> None:
        """Add a command to the cell."""
        self.instructions.append(Command(self.now, keyword, words, NO_SOURCE))

    def mount(self, step: ReadTool) -> None:
        """Name the nozzle of a tool: the cell's with that pose, or that number, or the only one."""
        tools = self.installation.tools
        place = step.T_flange_tcp
        fitting = [n for n, tool in tools.items() if place is not None and distance(tool.T_flange_tcp, place) <= 0.01]
        numbered = [int(word) for word in re.findall(r"\d+", step.label) if int(word) in tools]
        number = next(iter([*fitting, *numbered, *tools]), 0)
        self.command("NOZZLE", self.installation.tool(number).name, "TOOL", str(number))

    def move(self, at: int, step: ReadReach | ReadLine) -> None:
        """Move to a pose at the speed that is stated."""
        target = step.target
        if isinstance(target, Axes):
            place = self.rebuilt.place(at)
            message = "this program moves axes, whose poses the cell's kinematics give; show the .wash instead."
            raise ProgramError(message, file=place and place.file, line=place and place.line)
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
        self.now += lasts_s
        self.way_mm += way
        speed = way / lasts_s if lasts_s else 0.0
        self.instructions.append(MoveTo(self.now, target.position, target.quaternion, speed, NO_SOURCE))
        self.pose = target

    def switch(self, label: str, value: float, at_s: float) -> None:
        """Begin or end the jet of a valve after its lag; any other output is not shown."""
        for valve in self.installation.valves.values():
            channel = valve.channel
            on = value > 0.5
            if label in (channel.name, f"{channel.kind} {channel.number}") and on != self.spraying:
                lag = valve.open_lag_s if on else valve.close_lag_s
                self.spraying = on
                self.instructions.append(SetNozzle(at_s + lag, on, NO_SOURCE))
                return
