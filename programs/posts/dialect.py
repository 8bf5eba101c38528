"""One language in which programs are exported: what it can express, how it is written, how it is read back."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

from programs.errors import ProgramError
from programs.motion.installation import Installation, Maker
from programs.motion.lower import Capability, Lowered
from programs.posts.layout import AS_IT_IS, Layout, tidy
from programs.posts.rebuilt import Rebuilt
from programs.timing.controller import Controller

ProgramFiles: TypeAlias = Mapping[str, str]
"""Text by file name, the one to start with first."""
PAGE_ENDING = ".commissioning.md"
"""Of the page beside a program, after the name of the file to start with: no two programs have one of a name."""


@dataclass(frozen=True, slots=True)
class FileForm:
    """The files of a program as the maker's tools take them."""

    suffix: str
    """Of the file to start with, such as ``.ngc``."""
    several: tuple[str, ...] = ()
    """Suffixes of all files where even the shortest program has several; empty where it is one file."""
    beside: tuple[str, ...] = ()
    """Suffixes of further files that a long program has."""
    also: tuple[str, ...] = ()
    """Other suffixes under which the tools take the one file."""
    is_project: bool = False
    """Whether the files go into a folder of the program's name."""

    def describe(self, most_steps: int) -> str:
        """Describe in a few words what is written, for a program of routines of so many steps at most."""
        if self.several:
            return f"Several files ({' '.join(self.several)}){', in a folder of the project name' * self.is_project}."
        longer = f"; several{''.join(f' and a {each}' for each in self.beside)} from {most_steps} steps on"
        return f"One {self.suffix} file{longer if most_steps else ''}."


@dataclass(frozen=True, slots=True)
class Task:
    """What a program leaves to be done by hand in the controller, once."""

    text: str
    lines: tuple[str, ...] = ()
    """To be entered there, as its files or its logic have them."""


@dataclass(frozen=True, slots=True)
class Signal:
    """An output that a program sets, or an input that it reads."""

    name: str
    """In the cell."""
    address: str
    """In the controller."""
    use: str
    """What it is for; empty where the cell does not state it."""
    is_input: bool = False


@dataclass(frozen=True, slots=True)
class Frame:
    """A tool, or a place of the board, as the controller has it."""

    kind: str
    number: int
    name: str
    """In the cell, and in the program where that has names."""
    words: tuple[str, ...]
    """Position in mm and angles, as the language counts them."""
    load: str
    """Of a tool; empty where nothing is stated."""


@dataclass(frozen=True, slots=True)
class Handover:
    """What an integrator has to know of a program, and to do for it: the header states it, and a page beside it."""

    tasks: tuple[Task, ...]
    """Left to do by hand: routines to provide, and what is to be set up in the controller."""
    work: tuple[str, ...]
    """What the program waits for, its parts, and what it leaves behind."""
    shared: str
    """What it has in common with the other programs of its cell on one controller; empty for nothing."""
    remarks: tuple[str, ...]
    """What it uses of the controller, and what has to hold when it is started."""
    signals: tuple[Signal, ...]
    angles: tuple[str, str]
    """Of frames: their names, with spaces between them, and what they are."""
    frames: tuple[Frame, ...]
    home: str
    """Joint values as the controller counts them, degrees and mm; empty where there is none."""


@dataclass(frozen=True, slots=True)
class Dialect:
    """One controller's language. A room exports its own as ``DIALECT``."""

    title: str
    notes: str
    """Conditions for the integrator, one or two sentences."""
    capability: Capability
    form: FileForm
    longest_line: int
    """Characters; a test holds every program to it."""
    write: "Callable[[Dialect, Lowered, Installation], tuple[ProgramFiles, Handover]]"
    """Pure: the same motion and cell give the same bytes."""
    rebuild: Callable[[ProgramFiles], Rebuilt]
    """Executes a program's text."""
    most_steps: int = 0
    """Of one routine; 0 where the language has no routines."""
    needs_joints: bool = False
    """Whether the joint motion has to be known."""
    takes_axes: bool = False
    """Whether it is written in axes: tool points and angles where the machine's controller takes those."""
    needs_tool_points: bool = False
    """Whether it is for machines whose controller takes tool points, and no others."""
    maker: Maker | None = None
    """Whose robots it is for: joint values are written as that maker's controllers count them; ``None`` for any."""
    without_joints: str = ""
    """What the integrator has to do where no joint values are written; empty where each position states the arm's
    configuration, which only joint values give."""
    controller: Controller | None = None
    """The model that predicts the time of a program; ``None`` where the text states the time of every place."""

    layout: Layout = AS_IT_IS
    """Of its text, where the grammar leaves that free."""

    writes_joints: bool = True
    """Whether a joint motion is written with joint values, where they are known."""

    def folder(self, files: ProgramFiles) -> str:
        """Name the folder that the files of a program have to be in; empty where any will do."""
        return next(iter(files)).removesuffix(self.form.suffix) if self.form.is_project else ""

    def render(self, lowered: Lowered, installation: Installation) -> ProgramFiles:
        """Write a program."""
        return self.write(self, lowered, installation)[0]

    def read_edited(self, files: ProgramFiles) -> Rebuilt:
        """Rebuild what a program does that somebody may have edited: blanks and numbers may be written otherwise.

        Raises:
            ProgramError: as ``read``.
        """
        return self.read(tidy(files, self.layout))

    def read(self, files: ProgramFiles) -> Rebuilt:
        """Rebuild what a program does.

        Raises:
            ProgramError: a file is missing, or holds a statement that this language's writer does not write; where no
                one file is at fault, it names the one to start with.
        """
        try:
            rebuilt = self.rebuild(files)
        except ProgramError as error:
            raise error if error.file is not None else ProgramError(str(error), file=next(iter(files), None)) from None
        return replace(rebuilt, capability=self.capability, has_joints=self.writes_joints, controller=self.controller)
