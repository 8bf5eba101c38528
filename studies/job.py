"""Jobs of a study, one board with one recipe at one point, by names and hashes; and what comes out of them."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from sys import intern
from typing import Any, Literal

from specs.json import Json, content_sha256
from specs.yaml.located import YamlPath, spell_path
from studies.fingerprint import program_version
from studies.study import Deviation, Scalar

_RESULT = 1
"""Version of a job's result: another one is computed anew."""


@dataclass(frozen=True, slots=True)
class Input:
    """A file that a job reads: where, and what is in it."""

    name: str
    """As the study has it."""
    file: str
    """Absolute path."""
    sha256: str
    """Of its content, however it is written; checked where the job is done."""
    parts: str = ""
    """Of a board: absolute path of the table that is joined to it."""
    is_part: bool = False
    """Of a workpiece: whether it is read as a part, whose faces are judged."""


@dataclass(frozen=True, slots=True)
class Job:
    """What one task computes. All of it is short text: boards are read where the job is done."""

    board: Input
    recipe: Input
    parameters: Input
    cell: Input | None
    edits: tuple[tuple[YamlPath, Scalar], ...]
    """Values of the recipe that differ from its own."""
    effort: Literal["fast", "full"]
    deviation: Deviation = ()
    version: str = field(default_factory=program_version)
    """Of the program: what another one computed is computed anew."""

    @property
    def key(self) -> str:
        """Hash of all that the result depends on: equal jobs have equal keys, wherever their files are."""
        edits: list[Json] = [
            [spell_path(path), value] for path, value in sorted(self.edits, key=lambda edit: spell_path(edit[0]))
        ]
        deviation: list[Json] = [[name, value] for name, value in self.deviation if value]
        return content_sha256({
            "result": _RESULT,
            "version": self.version,
            "board": [Path(self.board.file).name, self.board.sha256, self.board.is_part],
            "recipe": self.recipe.sha256,
            "edits": edits,
            "parameters": self.parameters.sha256,
            "cell": "" if self.cell is None else self.cell.sha256,
            "effort": self.effort,
            "deviation": deviation,
        })  # fmt: skip


@dataclass(frozen=True, slots=True)
class CellResult:
    """What the robot of a cell does with the program."""

    possible: bool
    seconds: float
    """Of the robot's program, from home to home; 0 where there is none."""
    errors: tuple[str, ...]
    """Rules of the findings that forbid it."""


@dataclass(frozen=True, slots=True)
class JobResult:
    """What came out of a job, as it is kept."""

    job: str
    """Its key."""
    error: str = ""
    """Why there is nothing else, such as a value that the recipe refuses."""
    seconds: float = 0.0
    litres: float = 0.0
    verdict: str = ""
    """On board and process, by all rules but drying."""
    components: Mapping[str, str] = field(default_factory=dict[str, str])
    """Verdict on each component that no mask avoids, by all rules but drying; of a part on each face."""
    stay_wet: int = 0
    program_sha256: str = ""
    """Of the file that ``washboard plan -o`` writes; empty with deviations."""
    analysis_sha256: str = ""
    """Of the file that ``washboard analyse --json`` writes; empty with deviations, and of a part."""
    cell: CellResult | None = None

    def data(self) -> dict[str, Any]:
        """Give it as plain data."""
        return asdict(self)

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> "JobResult":
        """Read what ``data`` gave.

        Raises:
            TypeError, KeyError: it is something else.
        """
        cell = data["cell"]
        known = None if cell is None else CellResult(cell["possible"], cell["seconds"], tuple(cell["errors"]))
        components = {intern(name): intern(verdict) for name, verdict in data["components"].items()}
        fields: dict[str, Any] = {**data, "components": components, "cell": known}
        return cls(**fields)
