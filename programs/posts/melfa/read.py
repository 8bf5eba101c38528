"""Reads MELFA-BASIC back, as a controller would execute it."""

import re
from collections.abc import Iterator, Mapping

from programs.errors import ProgramError
from programs.motion.steps import Line
from programs.pose import Pose, inverse
from programs.posts.dialect import ProgramFiles
from programs.posts.melfa.write import MelfaBasic
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import Action, skip
from programs.posts.reading.forms import Block
from programs.posts.reading.statements import NUMBER, U, refusal, statements_of
from programs.posts.rebuilt import Due
from programs.posts.writing.angles import from_fixed_xyz

_POSITION = re.compile(rf"(P\w+)=\(((?:{NUMBER},){{5}}{NUMBER})\)\([07],0\)")
_JOINTS = re.compile(rf"(J\d+)=\(({NUMBER}(?:,{NUMBER})*)\)")


class MelfaBasicReader(Reader):
    """All programs with their positions."""

    syntax = MelfaBasic
    handlers = frozenset({"main", "M_Run(1)=0", "M_Err=1"})

    def __init__(self) -> None:
        super().__init__()
        self.positions = self.declares("position")
        """Poses and joint values by program and name."""
        self.watch_name = ""
        """Name of the program of the slot that always runs."""
        self.speed_mm_s = 0.0
        self.stops = True

    @classmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give the zone; turns on the spot have the controller's own rate."""
        return Due(line.blend_mm)

    def load(self, files: ProgramFiles) -> str:
        """Read steps, numbered from 1, and positions."""
        for file, text in files.items():
            name = file.removesuffix(".prg")
            steps: list[str] = []
            for number, line in enumerate(statements_of(file, text), start=1):
                if match := _POSITION.fullmatch(line):
                    self.positions.add((name, match[1]), read_pose(match[2].split(","), from_fixed_xyz), line)
                elif match := _JOINTS.fullmatch(line):
                    self.positions.add((name, match[1]), tuple(float(word) for word in match[2].split(",")), line)
                elif line.startswith(f"{number} "):
                    steps.append(line.become(line.removeprefix(f"{number} ")))
                else:
                    raise refusal(line, f"is neither step {number} nor a position")
            if "End" not in steps or steps.index("End") != len(steps) - 1:
                raise ProgramError("the program does not end with End.", file=file)
            self.routines[name] = steps
        main, *others = [*self.routines] or [""]  # which may be called like one of these itself
        self.shut_name = next((name for name in others if name.endswith("SHUT")), self.shut_name)
        self.watch_name = next((name for name in others if name.endswith("WATCH")), "")
        return main

    def fields(self) -> Mapping[str, str]:
        """Give the pattern of each field of the writer's forms."""
        return {**super().fields(), "point": r"[PJ]\d+"}

    def blocks(self) -> Iterator[Block]:
        """List the steps of forms."""
        yield from super().blocks()
        yield ["*RUN"], skip

    def grammar(self) -> dict[str, Action]:
        """List the other steps."""
        return {
            r"Mvs (P\d+)(?: Wth (.*))?": self.move,
            rf"Spd (?:{U}|M_NSpd)": self.set_speed,
            rf"Cnt (?:0|1,{U},\1)": self.set_passing,
            r"(Tool|Base) P_N\1": skip,
            r"(Tool|Base) (P\w+)": self.use_frame,
            r"JOvrd (\d+)": lambda match: self.set_share(match[1]),
            r"'.*|Ovrd 100|End": skip,
        }

    def read_shut(self) -> tuple[str, ...]:
        """Give the outputs that the fault routine shuts; the slot that always runs has to shut the same.

        Raises:
            ProgramError: it does not, or does something else.
        """
        self.called.add(self.watch_name)
        watching = self.routines.get(self.watch_name, [])
        if watching[:1] != ["*LOOP"] or watching[-2:] != ["GoTo *LOOP", "End"]:
            raise ProgramError("the slot that always runs does not go on and on.")
        stopped: dict[str, set[str]] = {}
        for statement in watching[1:-2]:
            found = re.fullmatch(r"If (M_Run\(1\)=0|M_Err=1|M_In\((\d+)\)=([01])) Then M_Out\((\d+)\)=0", statement)
            if found is None:
                raise refusal(statement, "does not belong to the slot that always runs")
            stopped.setdefault(found[1], set()).add(f"digital {found[4]}")
            if found[2] and (found[2], found[3] == "0") not in self.watched:
                self.watched.append((found[2], found[3] == "0"))
        self.watches_inputs = any(each.startswith("M_Out") for each in self.routines.get(self.shut_name, []))
        self.shut_by |= set(stopped) if self.watches_inputs else self.handlers  # else there is no valve to shut
        shut = super().read_shut()
        if any(each != set(shut) for each in stopped.values()):
            raise ProgramError("the slot that always runs does not shut every valve.")
        return shut

    def move(self, match: re.Match[str]) -> None:
        """Move in a line; an output that goes with it is set where it begins."""
        if match[2]:
            self.switch(*self.output_of(match[2]))
        self.line(self.pose_of(match[1]), self.stops, self.speed_mm_s)

    def place_of(self, point: str) -> Pose | tuple[float, ...]:
        """Look up a position of the program that runs."""
        return self.positions.use((self.routine, point))

    def pose_of(self, point: str) -> Pose:
        """Look up a position that is a pose."""
        pose = self.place_of(point)
        if not isinstance(pose, Pose):
            raise ProgramError(f"{point} is a joint position.")
        return pose

    def set_speed(self, match: re.Match[str]) -> None:
        """Set the speed of the TCP; that of a turn on the spot is the controller's own."""
        self.speed_mm_s = float(match[1] or 0.0)

    def set_passing(self, match: re.Match[str]) -> None:
        """Stop at the ends of lines, or pass them."""
        self.stops = match[1] is None
        self.state(zone=float(match[1] or 0.0))

    def use_frame(self, match: re.Match[str]) -> None:
        """Use another tool or base from now on."""
        pose = self.pose_of(match[2])
        if match[1] == "Tool":
            self.use_tool(match[2], pose)
        else:
            self.use_board(inverse(pose))
