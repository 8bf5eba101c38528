"""Commands under an audit hook: which files they open, rename and remove, and by which module of the product.

A script: ``python audited.py FOLDER`` makes the inputs there, runs every command once, and prints as JSON by command
what was done to files other than by ``InputFile`` and ``OutputFile``, and how often it was by them.
"""

import json
import os
import sys
from collections.abc import Callable
from inspect import currentframe
from pathlib import Path
from types import FrameType
from typing import Any

ROOT = Path(__file__).parents[2]
DOORS = {"specs/input_file.py", "specs/output_file.py", "specs/temporary.py"}
_CHANGES = {"os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.link", "os.symlink", "os.truncate", "os.chmod"}
_WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
_LIBRARIES = ("/dev/", "/proc/", "/sys/", "/etc/", "/usr/", "/var/cache/", "/root/.")
WORDS: dict[str, tuple[str, ...]] = {
    "plan": ("small.tri", "brief.yaml", "-o", "x.wash", "--report", "x.json", "--picture", "x.svg",
             "--parts", "table.csv"),
    "show": ("board.wash", "--board", "small.tri", "--picture", "show.png"),
    "classify": ("small.tri", "brief.yaml"),
    "check": ("board.wash", "gantry", "--board", "small.tri", "--report", "check.json", "-o", "checked.wash"),
    "export": ("board.wash", "--cell", "gantry", "--dialect", "joint-table", "--board", "small.tri", "-o", "job.csv"),
    "operate": ("job.csv", "--cell", "gantry", "--dry", "--log", "run.csv"),
    "operate #hal": ("--cell", "gantry", "--hal", "x.hal"),
    "operate #replay": ("--replay", "run.csv"),
    "analyse": ("board.wash", "small.tri", "--json", "a.json", "--html", "a.html", "--results", "measured.csv"),
    "bath": ("board.wash", "small.tri", "--boards", "1", "--json", "b.json"),
    "compare": ("small.tri", "brief.yaml", "brief-2.yaml", "--json", "c.json", "--html", "c.html"),
    "results": ("board.wash", "measured.csv", "small.tri", "--json", "r.json", "--html", "r.html"),
    "tune": ("small.tri", "brief.yaml", "--analyses", "2", "-o", "t.yaml", "--report", "t.json", "--front", "front"),
    "study": ("study.yaml", "-o", "studied", "--workers", "1"),
    "validate": ("blow-off", "--json", "v.json", "--picture", "v.svg", "--document", "v.md"),
    "level": ("small.tri", "brief.yaml", "-o", "levelled.wash"),
    "spacing": ("coat.yaml", "fan", "--film-um", "20", "--picture", "spacing.svg"),
    "demo": ("--into", "deep/demo", "--board", "tiny", "--recipe", "brief.yaml"),
    "board import": ("small.tri", "-o", "y.tri.gz"),
    "board show": ("two.yaml", "--picture", "board.svg"),
    "board list": (),
    "part show": ("plate.yaml", "--recipe", "faces.yaml", "--picture", "part.svg"),
    "part import": ("points.xyz", "-o", "z.tri"),
    "part scan": ("disc.png", "disc.png", "--mm-per-pixel", "0.5", "-o", "ball.tri", "--picture", "ball.png"),
    "part list": (),
    "recipe list": (), "recipe new": ("smt-aqueous", "-o", "new.yaml"), "recipe check": ("brief.yaml",),
    "recipe show": ("brief.yaml",), "recipe schema": (), "recipe keys": (),
    "cell place": ("plate.yaml", "gantry", "--points", "20", "--report", "p.json", "-o", "moved.yaml"),
    "cell list": (), "cell show": ("gantry", "--board", "small.tri"), "cell schema": (), "cell keys": (),
    "cell interview": ("gantry", "--dialect", "linuxcnc", "--answer", "base.xyz_mm: [0, 0, 10]", "-o", "mine.yaml"),
    "cell edit": ("gantry", "base.xyz_mm: [0, 0, 10]", "-o", "edited.yaml"),
    "controller map": ("gantry", "--link", "opcua", "-o", "nodes.xml"),
    "parameters list": (), "parameters show": ("own.yaml",), "parameters schema": (), "parameters keys": (),
    "calibrate ring": ("ring.csv", "--recipe", "brief.yaml", "-o", "ringed.yaml", "--picture", "ring.svg"),
    "calibrate pattern": ("pattern.csv", "--picture", "pattern.svg"),
    "calibrate gap": ("coupons.csv", "--recipe", "brief.yaml", "-o", "set.yaml"),
}  # fmt: skip
"""Of every command an argument for each kind of file; ``ui`` is called without a browser, and those that simulate
and check a controller have none to end with: they touch no file."""
STUDY = "study: s\nboards: [small.tri]\nrecipes: [brief.yaml]\n"


class Audit:
    """What a command does to files: counts by the module of the product that does it."""

    def __init__(self) -> None:
        """Watch nothing until a command begins."""
        self.folder: str | None = None
        self.by_doors = 0
        self.others: list[str] = []

    def hear(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Take an event of the interpreter."""
        if self.folder is None or (event != "open" and event not in _CHANGES):
            return
        place, flags = arguments[0], arguments[2] if event == "open" else _WRITES
        if not isinstance(place, str | bytes | os.PathLike):
            return
        path = os.path.normpath(Path(os.fsdecode(place)).absolute())
        is_users = path.startswith(self.folder)
        if not is_users and (not flags & _WRITES or self._is_librarys(path)):
            return
        module = _module(currentframe())
        if module in DOORS:
            self.by_doors += 1
        elif "/.washboard-" not in path:  # a library, such as Dask, in a temporary folder of ours
            self.others.append(f"{event} {path} by {module}")

    def _is_librarys(self, path: str) -> bool:
        return path.startswith((*_LIBRARIES, str(ROOT), sys.prefix, sys.base_prefix)) or "__pycache__" in path


def _module(frame: FrameType | None) -> str:
    """The innermost module of the product."""
    packages = tuple(f"{ROOT / each}/" for each in (*_packages(), ""))[:-1]
    while frame is not None:
        name = frame.f_code.co_filename
        if name.startswith(packages):
            return str(Path(name).relative_to(ROOT))
        frame = frame.f_back
    return "no module of the product"


def _packages() -> tuple[str, ...]:
    from commandline.process import PACKAGES

    return PACKAGES


def prepare(folder: Path) -> None:
    """Write every input of the commands into a folder."""
    from each_workpiece import make_inputs

    make_inputs(folder)
    (folder / "study.yaml").write_text(STUDY, "utf-8")
    (folder / "own.yaml").write_text("parameters: own\nextends: default\n", "utf-8")


def run_all(folder: Path, washboard: Callable[..., Any]) -> dict[str, Any]:
    """Run every command in a folder with its inputs."""
    audit, found = Audit(), dict[str, Any]()
    os.chdir(folder)
    sys.addaudithook(audit.hear)
    for command, words in WORDS.items():
        audit.by_doors, audit.others = 0, []
        audit.folder = f"{folder}/"
        outcome = washboard(*command.partition("#")[0].split(), *words)
        audit.folder = None
        found[command] = {
            "code": outcome.code,
            "err": outcome.err[-300:],
            "doors": audit.by_doors,
            "others": audit.others,
        }
    board = (folder / "small.tri").read_bytes()
    audit.by_doors, audit.others, audit.folder = 0, [], f"{folder}/"
    _save_in_page(folder, board)
    audit.folder = None
    return found | {"ui": {"code": 0, "err": "", "doors": audit.by_doors, "others": audit.others}}


def _save_in_page(folder: Path, board: bytes) -> None:
    """What the page does to files: an upload, a recipe saved and saved again, an unsaved text."""
    from webui.page.document import open_document
    from webui.page.page import BrowserIdentity
    from webui.page.project import open_project, uploaded_table
    from webui.panels.recipe.text import Drafts

    project = open_project(folder)
    project.discard(project.store("uploaded.tri", board).name)
    document = open_document(folder / "brief.yaml").save_as(folder / "saved.yaml")
    document.edited(f"{document.text}\n").save()
    identity, drafts = BrowserIdentity("browser", "tab"), Drafts(project.folder)
    drafts.keep(identity, document.file, "text")
    drafts.forget(identity, document.file)
    with uploaded_table("table.csv", b"a,b\n", "table.csv", "tables"):
        pass


if __name__ == "__main__":
    from command import washboard as run

    place = Path(sys.argv[1]).resolve()
    prepare(place)
    sys.stdout.write(json.dumps(run_all(place, run)))
