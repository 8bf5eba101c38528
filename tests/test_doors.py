"""The doors: product code opens, writes, renames and removes files by ``InputFile`` and ``OutputFile`` alone."""

import ast
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import get_args, get_type_hints

import pytest
from audited import WORDS, Audit
from typer import Typer

from commandline import arguments
from commandline.main import app
from commandline.process import PACKAGES

ROOT = Path(__file__).parents[1]
MODULES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))

DOORS = {"specs/input_file.py", "specs/output_file.py", "specs/temporary.py"}
_OF_PATHS = {
    "read_text",
    "read_bytes",
    "write_text",
    "write_bytes",
    "unlink",
    "touch",
    "mkdir",
    "rmdir",
    "chmod",
    "tofile",
    "symlink_to",
    "hardlink_to",
    "rename",
}
_OF_MODULES = {
    "os": {"open", "replace", "rename", "renames", "remove", "unlink", "mkdir", "makedirs", "rmdir", "removedirs",
           "link", "symlink", "mkfifo", "mknod", "truncate", "chmod"},
    "io": {"open", "open_code", "FileIO"},
    "np": {"load", "save", "savez", "savez_compressed", "loadtxt", "genfromtxt", "savetxt", "fromfile", "memmap"},
    "numpy": {"load", "save", "loadtxt", "genfromtxt", "savetxt", "fromfile", "memmap"},
    "trimesh": {"load", "load_mesh", "load_scene"},
    **{each: {"open"} for each in ("gzip", "bz2", "lzma", "codecs", "tarfile", "Image", "shelve", "dbm")},
    "zipfile": {"ZipFile"},
    "sqlite3": {"connect"},
    "h5py": {"File"},
    "ET": {"parse"},
    "etree": {"parse"},
    "shutil": {"copy", "copy2", "copyfile", "copytree", "move", "rmtree", "make_archive", "unpack_archive"},
    "tempfile": {"mkstemp", "mkdtemp", "NamedTemporaryFile", "TemporaryDirectory", "TemporaryFile"},
}  # fmt: skip
_NAMES = {"open", "ZipFile"}
"""Called by their name alone."""
_STREAMS = {"BytesIO", "StringIO"}
"""What may be opened in memory."""
PERMITTED = {
    ("boards/board.py", "rename"): "a name within a panel",
    ("boards/panel.py", "rename"): "a name within a panel",
    ("boards/sub_boards.py", "rename"): "a name within a panel",
    ("cleaning/verdicts/results.py", "rename"): "a name within a panel",
    ("rulesengine/planning/board_job.py", "rename"): "a name within a panel",
    ("rulesengine/planning/stroke_order.py", "rename"): "a name within a panel",
    ("webui/forms/entries.py", "rename"): "an entry of a recipe",
    ("boards/formats/archive.py", "ZipFile"): "over the stream of an InputFile",
    ("boards/formats/archive.py", "open"): "over the stream of an InputFile",
    ("webui/downloads/program_text.py", "ZipFile"): "over a stream in memory",
    ("commandline/errors.py", "open"): "/dev/null in the place of a stdout that takes no more",
}
"""Calls that are no opening of a path, with what they are."""


_SUSPECT = re.compile(
    rf"\b({'|'.join(f'{owner}[.]{name}' for owner, names in _OF_MODULES.items() for name in sorted(names))})\("
    rf"|\.({'|'.join(sorted(_OF_PATHS))}|savefig|open)\(|(?<![\w.])({'|'.join(_NAMES)})\(|\.replace\([^,\n]*(\)|$)",
    re.MULTILINE,
)
"""Few modules have any of these words, and only they are taken apart."""


def doors_cut(source: str) -> Iterator[tuple[int, str]]:
    """Lines of a module that open, write, rename or remove a file, with what they call."""
    if not _SUSPECT.search(source):
        return
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and not _in_memory(node) and (name := _door(node)):
            yield node.lineno, name


def _door(node: ast.Call) -> str:
    match node.func:
        case ast.Name(id=name) if name in _NAMES:
            return name
        case ast.Attribute(value=ast.Name(id=owner), attr=name) if owner in _OF_MODULES:
            return name if name in _OF_MODULES[owner] else ""
        case ast.Attribute(attr=name) if name in _OF_PATHS:
            return name
        case ast.Attribute(attr="replace") if len(node.args) == 1 and not node.keywords:
            return "replace"
        case ast.Attribute(attr="open") if _has_mode(node):
            return "open"
        case ast.Attribute(attr="savefig") if node.args and not _is_name_of_stream(node.args[0]):
            return "savefig"
        case _:
            pass
    return ""


def _has_mode(node: ast.Call) -> bool:
    """Whether a method ``open`` is that of a path: with a mode, an encoding or a buffering."""
    first = node.args[0] if node.args else None
    is_mode = isinstance(first, ast.Constant) and isinstance(first.value, str) and set(first.value) <= set("rwxabt+")
    return is_mode or bool(
        {each.arg for each in node.keywords} & {"mode", "encoding", "newline", "buffering", "errors"}
    )


def _is_name_of_stream(node: ast.expr) -> bool:
    return isinstance(node, ast.Name) and node.id in {"out", "stream", "buffer"}


def _in_memory(node: ast.Call) -> bool:
    """Whether the first argument is made as a stream in memory there and then, or bytes of one by name."""
    values = [*node.args[:1], *(each.value for each in node.keywords if each.arg == "fileobj")]
    return any(
        isinstance(each, ast.Call) and getattr(each.func, "attr", getattr(each.func, "id", "")) in _STREAMS
        for each in values
    )


@pytest.mark.parametrize(
    "line",
    [
        "open('x')", "Path('x').read_text()", "path.write_bytes(b'')", "os.replace(a, b)", "temporary.replace(target)",
        "np.load('x')", "Image.open(path)", "figure.savefig(path)", "ZipFile(path)", "zipfile.ZipFile(path)",
        "gzip.open(path)", "tarfile.open(path)", "path.open('rb')", "path.open(encoding='utf-8')", "path.unlink()",
        "shutil.rmtree(folder)", "tempfile.mkstemp()", "os.open(path, os.O_RDONLY)", "folder.mkdir(parents=True)",
    ],
)  # fmt: skip
def test_a_door_of_its_own_is_found(line: str) -> None:
    assert list(doors_cut(f"def read(path):\n    return {line}\n"))


@pytest.mark.parametrize(
    "line",
    [
        "Image.open(io.BytesIO(data))", "gzip.open(BytesIO(data))", "InputFile(path).read()", "text.replace('a', 'b')",
        "figure.savefig(out, format=kind)", "zipfile.ZipFile(io.BytesIO(content))", "self.open(item.jet, made_by)",
        "np.loadtxt(BytesIO(text))", "OutputFile(path).write(text)", "replace(spec, speed=3)",
    ],
)  # fmt: skip
def test_what_is_in_memory_or_by_the_types_is_none(line: str) -> None:
    assert not list(doors_cut(f"def read(path):\n    return {line}\n"))


@pytest.mark.slow
def test_files_are_opened_written_and_removed_by_the_two_types_alone() -> None:
    found: list[str] = []
    used: set[tuple[str, str]] = set()
    for path in MODULES:
        name = path.relative_to(ROOT).as_posix()
        if name in DOORS:
            continue
        for line, call in doors_cut(path.read_text("utf-8")):
            used.add((name, call))
            if (name, call) not in PERMITTED:
                found.append(f"{name}:{line}: {call}: read with InputFile, write with OutputFile of specs")
    assert found == []
    assert used == set(PERMITTED)


def commands(group: Typer = app, path: str = "") -> Iterator[tuple[str, Callable[..., object]]]:
    for each in group.registered_commands:
        assert each.callback is not None
        yield f"{path}{each.name or each.callback.__name__}", each.callback
    for inner in group.registered_groups:
        assert inner.typer_instance is not None
        yield from commands(inner.typer_instance, f"{path}{inner.name} ")


def test_every_parameter_that_is_a_file_is_read_by_a_parser_of_the_doors() -> None:
    found: list[str] = []
    for command, callback in commands():
        for name, hint in get_type_hints(callback, include_extras=True).items():
            kind, *about = (*get_args(hint), hint)
            if not about or not hasattr(about[0], "autocompletion"):
                continue
            is_library = "_completer" in getattr(about[0].autocompletion, "__qualname__", "")
            parser = getattr(about[0].parser, "__module__", None)
            if (is_library or "Path" in str(kind) or "Output" in str(kind)) and parser not in _PARSERS:
                found.append(f"{command}: {name}: give it a parser of commandline.arguments")
    assert found == []


_PARSERS = {arguments.__name__, "specs.output_file"}


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_no_command_touches_a_file_but_by_the_two_types(tmp_path: Path) -> None:
    assert {each.partition(" #")[0] for each in WORDS} | {"ui"} == {command for command, _ in commands()}
    support = Path(__file__).parent / "support"
    path = os.pathsep.join([str(ROOT), str(support)])
    run = [sys.executable, support / "audited.py", tmp_path]
    done = subprocess.run(run, capture_output=True, text=True, env=os.environ | {"PYTHONPATH": path}, check=False)
    assert done.returncode == 0, done.stderr
    heard = json.loads(done.stdout)
    assert {command: each["others"] for command, each in heard.items() if each["others"]} == {}
    assert {command: each["err"] for command, each in heard.items() if each["code"] not in (0, 1)} == {}
    silent = {command for command, each in heard.items() if not each["doors"]}
    assert silent == {command for command, words in WORDS.items() if not words}


def test_the_audit_hears_a_door_of_its_own(tmp_path: Path) -> None:
    audit = Audit()
    audit.folder = str(tmp_path)
    audit.hear("open", (str(tmp_path / "a"), "w", os.O_WRONLY))
    audit.hear("os.remove", (str(tmp_path / "a"), -1))
    audit.hear("open", (os.__file__, "r", os.O_RDONLY))
    assert len(audit.others) == 2
