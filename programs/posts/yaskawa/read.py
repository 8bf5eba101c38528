"""Reads INFORM jobs back, as a controller would execute them."""

import math
import re
from collections.abc import Iterable

from programs.errors import ProgramError
from programs.motion.steps import Line
from programs.pose import Pose
from programs.posts.dialect import ProgramFiles
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import Action, skip
from programs.posts.reading.statements import N, Statement, U, look_up, refusal, statements_of
from programs.posts.rebuilt import Due, ReadSignal
from programs.posts.writing.angles import from_fixed_xyz
from programs.posts.writing.lines import is_straight
from programs.posts.yaskawa.write import LONGEST_WAIT_S, PASSING_MM, Inform

_POINT = re.compile(rf"(C\d{{5}})={N},{N},{N},{N},{N},{N}")
_HEADS = (r"USER (\d+)", r"TOOL (\d+)", r"POSTYPE USER()", r"RECTAN()", r"RCONF 1,0,0,([01],[01],[01]),0,0")
"""Headings of positions in their order."""
_TABLE = re.compile(rf"(TOOL|USER) (\d+) = X {N} Y {N} Z {N} Rx {N} Ry {N} Rz {N}  .*")


class InformReader(Reader):
    """All jobs with their positions."""

    syntax = Inform
    handlers = frozenset({"main"})
    height_unit_mm = 0.001
    reads_sensors = watches_inputs = False
    goes_home = False

    def __init__(self) -> None:
        super().__init__()
        self.guards_override = None
        self.positions = self.declares("position")
        """User frame, tool and pose by job and name."""
        self.tables: dict[tuple[str, str], Pose] = {}
        """Tools and user frames that are to be entered, where the page is at hand."""

    @classmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give the corner radius in tenths, or what PL=1 passes by, and the rate of a turn on the spot."""
        tenths = math.floor(10.0 * line.blend_mm)
        zone = PASSING_MM if tenths < 10 or is_straight(line, after) else 0.1 * tenths
        rate = max(math.degrees(line.turn_rad_s), 0.1) if line.turns_on_the_spot else None
        return Due(zone, rate)

    def load(self, files: ProgramFiles) -> str:
        """Read the jobs; the first is the main one."""
        for file, text in files.items():
            if not file.endswith(".JBI"):
                self.load_page(file, text)
                continue
            name = file.removesuffix(".JBI")
            head, found, body = text.partition("\nNOP\n")
            points, also, attributes = head.partition("//INST\n")
            begin = f"/JOB\n//NAME {name}\n//POS\n"
            if not (found and also and points.startswith(begin) and body.endswith("END\n")):
                raise ProgramError(f"{name} is no job.", file=file)
            frames = self.load_positions(name, [*statements_of(file, points)][begin.count("\n") :])
            relative = f",RJ\n////FRAME USER {next(iter(frames), '')}" if frames else ""
            shown = re.sub(r"///DATE [\d/ :]+\n", "", attributes, count=1)
            if len(frames) > 1 or shown != f"///COMM Washboard\n///ATTR SC,RW{relative}\n///GROUP1 RB1":
                raise ProgramError("a relative job has one user frame, and names it.", file=file)
            self.routines[name] = [*statements_of(file, text)][head.count("\n") + 2 : -1]
        main, *others = [*self.routines] or [""]  # which may be called like the other itself
        self.shut_name = next((name for name in others if name.endswith("_SH")), self.shut_name)
        return main

    def load_positions(self, job: str, lines: Iterable[Statement]) -> set[str]:
        """Read positions under their headings, each group of them whole, and give their user frames."""
        heads: list[str] = []
        stated, frames, count = "", set[str](), 0
        for line in lines:
            if match := _POINT.fullmatch(line):
                if len(heads) != len(_HEADS) or match[1] != f"C{count:05d}":
                    raise refusal(line, "does not follow its headings, or the position before it")
                pose = read_pose(match.groups()[1:], from_fixed_xyz)
                self.positions.add((job, match[1]), (heads[0], heads[1], pose), line)
                frames.add(heads[0])
                count += 1
            elif match := re.fullmatch(r"///NPOS (\d+),0,0,0,0,0", line):
                stated += match[1]
            else:
                heads = [] if len(heads) == len(_HEADS) else heads
                match = re.fullmatch(f"///{_HEADS[len(heads)]}", line)
                if match is None:
                    raise refusal(line, "is no heading, or not the next one")
                heads.append(match[1])
        if stated != str(count) or (heads and len(heads) != len(_HEADS)):
            raise ProgramError(f"job {job}: NPOS states {stated} positions, there are {count}.")
        return frames

    def load_page(self, file: str, text: str) -> None:
        """Read the tools and user frames that the integrator is to enter."""
        for line in statements_of(file, text):
            if match := _TABLE.fullmatch(line):
                if (match[1], match[2]) in self.tables:
                    raise refusal(line, "is there twice")
                self.tables[match[1], match[2]] = read_pose(match.groups()[2:], from_fixed_xyz)

    def grammar(self) -> dict[str, Action]:
        """List the other instructions."""
        return {
            rf"MOVL (C\d{{5}}) (VR?)={U} (PL=[01]|CR=\d+\.\d)(?: ENWAIT T={U})?": self.move,
            rf"MOVJ (C\d{{5}}) VJ={U} PL=0": self.reach_position,
            rf"TIMER T={U}": lambda match: self.hold(float(match[1]), LONGEST_WAIT_S),
            r"\*RUN|'.*|NOP": skip,
        }

    def position(self, name: str) -> Pose:
        """Look up a position, and use its frames."""
        user, tool, pose = self.positions.use((self.routine, name))
        if self.tables:
            self.use_tool(tool, look_up(self.tables, ("TOOL", tool), f"TOOL {tool}"))
            self.use_board(look_up(self.tables, ("USER", user), f"USER {user}"))
        else:
            self.use_tool(tool, None)
            self.use_board(None)
        return pose

    def reach_position(self, match: re.Match[str]) -> None:
        """Come to a position by joints."""
        self.set_share(match[2])
        self.reach(self.position(match[1]))

    def move(self, match: re.Match[str]) -> None:
        """Move in a line; the output that goes ahead is the instruction after it, which is not executed again."""
        name, unit, speed, level, ahead = match.groups()
        pose, signals = self.position(name), ()
        if ahead is not None:
            self.at += 1
            statements = self.routines[self.routine]
            if self.at == len(statements):
                raise ProgramError(f"no output follows {match[0]!r}.")
            signals = (ReadSignal(*self.output_of(statements[self.at]), 1.0, -float(ahead)),)
        turns = unit == "VR"
        zone = float(level.removeprefix("CR=")) if level.startswith("CR") else PASSING_MM
        self.state(zone=zone, turn_deg_s=float(speed) if turns else None)
        self.line(pose, level == "PL=0", 0.0 if turns else float(speed), signals)
