"""Every format of boards, parts and clouds of points: what its files are called, and what reads them."""

import pkgutil
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

from boards.errors import BoardError
from specs.input_file import InputFile

Use: TypeAlias = Literal["read", "tree", "points"]

HEAD = 20_000
"""Bytes in which the mark of a format stands."""
_FOLDER = "/"
ARCHIVES = (".zip", ".tgz", ".tar.gz")
_PACKED = (*ARCHIVES, _FOLDER)


@dataclass(frozen=True, slots=True)
class Format:
    """One format. Functions are named below ``boards``, and imported when they are needed."""

    name: str
    suffixes: tuple[str, ...]
    """What the name of a file ends with; ``/`` is that of a folder."""
    read: str = ""
    """Reads bodies of a board and findings from a path and from what ``takes`` names: the readers' one signature."""
    takes: tuple[Literal["progress", "given"], ...] = ()
    """A receiver of progress; what comes with the board, which is joined to the bodies otherwise."""
    mark: str = ""
    """Expression in the beginning of its files, by which they are found whatever they are called."""
    sniff: str = ""
    """Whether a path is of the format; called where a format below has the suffix as well."""
    panel: str = ""
    """Reads how a file repeats its board on a panel, ``None`` where it does not."""
    tree: str = ""
    """Reads a tree of triangles and findings from a path and a receiver of progress."""
    unit_mm: float = 1.0
    """Of the lengths in such a tree."""
    points: str = ""
    """Lays a surface through the points of a path, with the length of the file's unit and the smallest cell."""

    def function(self, which: Literal["read", "sniff", "panel", "tree", "points"]) -> Callable[..., Any]:
        """Import one of its functions."""
        return pkgutil.resolve_name(f"boards.{getattr(self, which)}")


_SCENE = "formats.scene:read_scene"

FORMATS = (
    Format("board-tri", (".tri", ".tri.gz"), "formats.tri.tri:read_tri"),
    Format("STEP", (".step", ".stp"), _SCENE, ("progress",), tree="formats.step:read_step", unit_mm=1000.0),
    Format("glTF", (".glb", ".gltf"), _SCENE, ("progress",), tree="formats.gltf:read_gltf", unit_mm=1000.0),
    Format("points", (".xyz", ".txt", ".ply"), sniff="part.cloud:is_cloud", points="part.cloud:read_cloud"),
    Format("mesh", (".stl", ".obj", ".ply"), _SCENE, ("progress",), tree="formats.tree:read_mesh"),
    Format("IDF", (".emn", ".emp", ".idf", ".brd"), "formats.idf.idf:read_idf", sniff="formats.idf.idf:is_idf"),
    Format("GenCAD", (".cad",), "formats.extracts.gencad:read_gencad", mark=r"^[ \t]*GENCAD[ \t]+\d"),
    Format("Allegro", (".fab", ".val"), "formats.extracts.allegro:read_allegro", mark=r"^A!\w+!"),
    Format("KiCad", (".kicad_pcb",), "formats.kicad.kicad:read_kicad"),
    Format("Eagle", (".brd",), "formats.eagle.eagle:read_eagle"),
    Format(
        "ODB++",
        _PACKED,
        "formats.odb.odb:read_odb",
        panel="formats.odb.odb:read_odb_panel",
    ),
    Format(
        "IPC-2581",
        (".xml", ".cvg"),
        "formats.ipc2581.ipc2581:read_ipc2581",
        panel="formats.ipc2581.ipc2581:read_ipc2581_panel",
    ),
    Format("Gerber", (".gbr", ".gm1", ".gko", *_PACKED), "parts_table.place:place_parts", ("given",)),
)
"""Every format. Of several with one suffix the first whose content fits is taken, and else the last."""


def suffixes_of(*uses: Use) -> tuple[str, ...]:
    """What the name of a file may end with that is read for one of these uses; folders are left out."""
    forms = (each for each in FORMATS if any(getattr(each, use) for use in uses))
    return tuple(dict.fromkeys(suffix for each in forms for suffix in each.suffixes if suffix != _FOLDER))


def marked_formats(head: bytes) -> list[Format]:
    """Formats whose mark is in the beginning of a file."""
    text = head.decode("latin-1")
    return [each for each in FORMATS if each.mark and re.search(each.mark, text, re.MULTILINE | re.IGNORECASE)]


def is_marked(file: Path) -> bool:
    """Whether the mark of a board's format is in the beginning of a file."""
    return bool(marked_formats(InputFile(file, BoardError, "board file").head(HEAD)))


def find_format(file: Path, *uses: Use) -> Format:
    """Return the format of a file: that of its suffix, and of its content where several have the suffix, or none.

    Raises:
        BoardError: No format for these uses has it, or its content is of none.
    """
    InputFile(file, BoardError, "board file").check_kind()
    name = file.name.lower() + (_FOLDER if file.is_dir() else "")
    forms = [each for each in FORMATS if name.endswith(each.suffixes) and any(getattr(each, use) for use in uses)]
    if not forms and file.is_file():
        forms = [each for each in marked_formats(InputFile(file, BoardError, "board file").head(HEAD)) if each.read]
    if not forms:
        raise BoardError(f"no reader for this kind of file. Known are {', '.join(suffixes_of(*uses))}.", file=file)
    return next((each for each in forms[:-1] if each.function("sniff")(file)), forms[-1])
