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
    "os": {"open", "fdopen", "replace", "rename", "renames", "remove", "unlink", "mkdir", "makedirs", "rmdir",
           "removedirs", "link", "symlink", "mkfifo", "mknod", "truncate", "chmod", "system", "popen", "posix_spawn",
           "posix_spawnp", "execv", "execvp", "spawnv", "spawnvp"},
    "builtins": {"open"},
    "subprocess": {"run", "Popen", "call", "check_call", "check_output"},
    "logging": {"FileHandler", "basicConfig"},
    "asyncio": {"create_subprocess_exec", "create_subprocess_shell"},
    "minidom": {"parse"},
    "sax": {"parse"},
    "fileinput": {"input", "FileInput"},
    "linecache": {"getline", "getlines"},
    "tokenize": {"open"},
    "Path": {*_OF_PATHS, "open", "replace"},
    "resources": {"read_text", "read_binary", "open_text", "open_binary"},
    "request": {"urlopen", "urlretrieve"},
    "mmap": {"mmap"},
    "configparser": {"ConfigParser", "RawConfigParser"},
    **{each: {"read_csv", "read_table", "read_xml", "read_hdf", "read_json", "read_pickle", "read_excel"}
       for each in ("pd", "pandas")},
    "plt": {"imread", "imsave"},
    "io": {"open", "open_code", "FileIO"},
    "np": {"load", "save", "savez", "savez_compressed", "loadtxt", "genfromtxt", "savetxt", "fromfile", "memmap"},
    "numpy": {"load", "save", "savez", "savez_compressed", "loadtxt", "genfromtxt", "savetxt", "fromfile", "memmap"},
    "trimesh": {"load", "load_mesh", "load_scene", "load_path", "load_remote"},
    **{each: {"open"} for each in ("codecs", "Image", "shelve", "dbm")},
    "gzip": {"open", "GzipFile"},
    "bz2": {"open", "BZ2File"},
    "lzma": {"open", "LZMAFile"},
    "tarfile": {"open", "TarFile"},
    "zipfile": {"ZipFile", "Path"},
    "click": {"File", "edit", "open_file"},
    "csv": {"read_csv", "write_csv"},
    "sqlite3": {"connect"},
    "h5py": {"File"},
    **{each: {"parse", "iterparse", "ElementTree"} for each in ("ET", "etree", "ElementTree")},
    "shutil": {"copy", "copy2", "copyfile", "copytree", "move", "rmtree", "make_archive", "unpack_archive"},
    "objectify": {"parse"},
    "wavfile": {"read", "write"},
    "load": {"load", "load_mesh", "load_scene", "load_path"},
    "tempfile": {"mkstemp", "mkdtemp", "NamedTemporaryFile", "TemporaryDirectory", "TemporaryFile"},
}  # fmt: skip
_NAMES = {"open"}
"""By their name alone, as a function."""
_BY_NAME = {*_OF_PATHS, *_NAMES}
_ANYWHERE = {
    "imread", "imsave", "open_memmap", "loadmat", "savemat", "read_feather", "read_parquet", "write_parquet",
    "to_feather", "write_table", "read_excel", "step_to_glb", "export_mesh", "export_scene", "load_mesh", "run_path",
    "FileIO", "open_code", "open_file", "RotatingFileHandler", "TimedRotatingFileHandler", "WatchedFileHandler",
    "PyZipFile", "MeshLoader", "utime", "chown", "lchown", "extractall", "truetype", "imwrite", "OSFile",
    "ParquetFile", "HDFStore", "ExcelWriter", "read_fwf", "to_pickle", "to_hdf", "to_markdown", "mmread", "mmwrite",
    "load_npz", "save_npz", "fromregex", "getoutput", "getstatusoutput", "execl", "execle", "execlp", "execlpe",
    "execve", "execvpe", "spawnl", "spawnle", "spawnlp", "spawnlpe", "spawnve", "spawnvpe", "copymode", "copystat",
    "fchmod", "setxattr", "copy_file_range", "sendfile", "spec_from_file_location", "get_data", "buildModelFromUrdf",
    "buildModelsFromUrdf", "save_html", "save_text", "save_svg", "FileText", "FileTextWrite", "FileBinaryRead",
    "FileBinaryWrite", "fileConfig", "dictConfig", "CDLL",
}  # fmt: skip
"""By their name, whoever has it."""
_HARMLESS = {"typing", "collections"}
_OPENED = {"FileText", "FileTextWrite", "FileBinaryRead", "FileBinaryWrite"}
"""Types of parameters that typer opens."""
_FOREIGN_NAMES = re.compile(r"(?:load|open|read|save|write|dump|export)(?:_\w+)?")
"""Functions of other libraries that are imported by their name."""
_WRITERS = {
    "save",
    "savefig",
    "export",
    "to_csv",
    "to_json",
    "to_parquet",
    "to_excel",
    "to_html",
    "write_html",
    "write_image",
}
"""Methods of libraries that write into a file by its path, or into a stream."""
_PLACES = {"fname", "fp", "file_obj", "path", "path_or_buf"}
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
    ("studies/results/tables.py", "write_table"): "into a stream in memory",
    ("boards/formats/archive.py", "ZipFile"): "over the stream of an InputFile",
    ("boards/formats/archive.py", "open"): "over the stream of an InputFile",
    ("boards/formats/archive.py", "GzipFile"): "over the stream of an InputFile",
    ("boards/child.py", "Popen"): "a reader of ours in a process of its own, over streams",
    ("boards/child.py", "fdopen"): "a file in memory",
    ("boards/child_start.py", "fdopen"): "the pipe to the process that started it",
    ("boards/child_start.py", "getattr"): "a reader of ours, which the process that started it names",
    ("boards/formats/kicad/convert.py", "run"): "kicad-cli, on files in a temporary folder of ours",
    ("boards/formats/kicad/convert.py", "fdopen"): "a file in memory",
    ("robotcell/operate/links/linuxcnc.py", "Popen"): "the agent in LinuxCNC's Python, over pipes",
    **{(file, "CDLL"): "prctl" for file in ("boards/child_start.py", "boards/formats/kicad/convert.py")},
    ("commandline/process.py", "CDLL"): "mallopt",
    ("boards/formats/step_child.py", "load"): "bytes that stdin brought",
    ("boards/packages/families.py", "load"): "YAML as text",
    ("specs/yaml/edit.py", "load"): "YAML as text",
    ("specs/yaml/edit.py", "dump"): "into a stream in memory",
    ("reports/files/write_run.py", "dump"): "into a stream in memory",
    ("reports/pictures/placement_picture.py", "export_glb"): "bytes of a scene",
    **{
        (file, "write"): "a program of a language as text"
        for file in ("programs/export.py", "programs/posts/dialect.py")
    },
    ("programs/posts/reading/execution.py", "load"): "a program's files as texts",
    ("robotcell/operate/reference/servers.py", "open"): "whether the valve is open",
    ("webui/panels/results/playback.py", "load"): "a player",
    ("webui/server/server.py", "open"): "a page",
    ("webui/page/read_back.py", "open"): "a member of an archive in memory",
    ("webui/panels/robot/program.py", "open"): "a preview",
    ("commandline/errors.py", "open"): "/dev/null in the place of a stdout that takes no more",
}
"""Calls that are no opening of a path, with what they are."""


def doors_cut(source: str) -> Iterator[tuple[int, str]]:
    """Lines of a module that open, write, rename or remove a file, or hand on what does, with its name."""
    tree = ast.parse(source)
    modules, names = _imported(tree)
    called = {id(node.func): node for node in ast.walk(tree) if isinstance(node, ast.Call)}
    handed, streams = _handed_on(tree), _streams(tree)
    looked_up = called.keys() | _called_later(tree)
    own = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
    bases = {id(base) for node in ast.walk(tree) if isinstance(node, ast.ClassDef) for base in node.bases}
    for node in ast.walk(tree):
        if isinstance(node, ast.Name | ast.Attribute):
            call = called.get(id(node))
            is_base = id(node) in bases
            name = _door(node, call, modules, names, is_base, own)
            if name and not (call is not None and _in_memory(call, streams)):
                yield node.lineno, name
            elif (
                isinstance(node, ast.Attribute)
                and node.attr in {"open", "replace"}
                and call is None
                and id(node) in handed
            ):
                yield node.lineno, node.attr
        elif isinstance(node, ast.Constant) and node.value in _BY_NAME and id(node) in _named(tree):
            yield node.lineno, str(node.value)
        elif isinstance(node, ast.Call) and id(node) in looked_up and _looks_up(node):
            yield node.lineno, "getattr"
        elif isinstance(node, ast.ImportFrom) and (node.module or "").rpartition(".")[2] in _OF_MODULES:
            yield from ((node.lineno, "*") for each in node.names if each.name == "*")


def _imported(tree: ast.Module) -> tuple[dict[str, str], dict[str, str]]:
    """Modules by the names they have here, and what is imported of them, by its name here."""
    modules, names = {each: each for each in _OF_MODULES}, dict[str, str]()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            modules |= {each.asname: each.name.rpartition(".")[2] for each in node.names if each.asname}
        elif isinstance(node, ast.ImportFrom):
            owner = (node.module or "").rpartition(".")[2]
            found = {each.asname or each.name: each.name for each in node.names}
            names |= {here: name for here, name in found.items() if name in {*_OF_MODULES.get(owner, ()), *_ANYWHERE}}
            if not node.level and (node.module or "").partition(".")[0] not in {*PACKAGES, *_HARMLESS}:
                names |= {here: name for here, name in found.items() if _FOREIGN_NAMES.fullmatch(name)}
            modules |= {here: name for here, name in found.items() if name in _OF_MODULES}
    return modules, names


def _handed_on(tree: ast.Module) -> set[int]:
    """What is given to a function, kept under a name or given back, alone or in a tuple: somebody may call it."""
    left: list[ast.AST] = []
    for node in ast.walk(tree):
        match node:
            case ast.Call():
                left += [*node.args, *(each.value for each in node.keywords)]
            case (
                ast.Assign(value=value)
                | ast.AnnAssign(value=value)
                | ast.NamedExpr(value=value)
                | ast.Return(value=value)
            ):
                left += [value] if value is not None else []
            case ast.IfExp():
                left += [node.body, node.orelse]
            case _:
                pass
    found = set[int]()
    for node in left:
        found |= {id(each) for each in (node.elts if isinstance(node, ast.Tuple | ast.List) else [node])}
    return found


def _called_later(tree: ast.Module) -> set[int]:
    """What is kept under a name that is called."""
    names = {node.func.id for node in ast.walk(tree) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)}
    return {
        id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Assign)
        and names & {each.id for each in node.targets if isinstance(each, ast.Name)}
    }  # fmt: skip


def _named(tree: ast.Module) -> set[int]:
    """What ``getattr`` and ``methodcaller`` are given as a name."""
    calls = [(node, getattr(node.func, "id", getattr(node.func, "attr", ""))) for node in ast.walk(tree)
             if isinstance(node, ast.Call)]  # fmt: skip
    places = {"getattr": 1, "methodcaller": 0, "attrgetter": 0}
    return {id(node.args[places[name]]) for node, name in calls if name in places and len(node.args) > places[name]}


def _looks_up(node: ast.Call) -> bool:
    """Whether a call is ``getattr`` with a name that only the run knows."""
    return isinstance(node.func, ast.Name) and node.func.id == "getattr" and not isinstance(node.args[1], ast.Constant)


def _door(
    node: ast.Name | ast.Attribute, call: ast.Call | None, modules: dict[str, str], names: dict[str, str],
    is_base: bool, own: set[str],
) -> str:  # fmt: skip
    """Name of what opens or changes a file, called or handed on; empty for anything else."""
    match node:
        case ast.Name(id=name) | ast.Attribute(attr=name) if name[0].isupper() and call is None and not is_base:
            return name if name in _OPENED else ""  # a class that is named as a type
        case ast.Name(id=name, ctx=ast.Load()):
            return name if name in _NAMES | _ANYWHERE else names.get(name, "")
        case ast.Attribute(attr=name) if name in _ANYWHERE:
            return name
        case ast.Attribute(value=ast.Name(id=owner) | ast.Attribute(attr=owner), attr=name) if name in _OF_MODULES.get(
            modules.get(owner, ""), ()
        ):
            return name
        case ast.Attribute(value=ast.Name(id=owner), attr="open" | "replace" | "rename") if owner in modules:
            return ""
        case ast.Attribute(attr=name) if name in _OF_PATHS:
            return name
        case _ if call is not None and isinstance(node, ast.Attribute):
            is_own = getattr(node.value, "id", "") == "self" and node.attr in own
            return "" if is_own else _by_arguments(node.attr, call)
        case _:
            return ""


def _by_arguments(name: str, call: ast.Call) -> str:
    """The same of methods whose names alone say nothing."""
    keywords = {each.arg for each in call.keywords}
    is_one = len(call.args) + len(call.keywords) == 1
    match name:
        case "dump" if call.args:
            return name
        case "replace" if is_one and (call.args or keywords == {"target"}):
            return name
        case "open":
            return name
        case "load" if call.args and isinstance(call.args[0], ast.Name | ast.Attribute | ast.Call):
            return name
        case "extract" if call.args:
            return name
        case "write" | "add" if keywords & {"arcname", "path"}:
            return name
        case "write" if len(call.args) > 1 and getattr(call.func.value, "id", "") != "os":  # type: ignore[attr-defined]
            return name
        case _ if name in _WRITERS and (keywords & _PLACES or call.args):
            return name
        case _:
            return ""


def _streams(tree: ast.Module) -> set[int]:
    """Where a function names a stream that it has made in memory."""
    found = set[int]()
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef):
            inside = list(ast.walk(function))
            made = {each.id for node in inside if isinstance(node, ast.Assign) and _makes_stream(node.value)
                    for each in node.targets if isinstance(each, ast.Name)}  # fmt: skip
            found |= {id(each) for each in inside if isinstance(each, ast.Name) and each.id in made}
    return found


def _makes_stream(node: ast.expr) -> bool:
    return isinstance(node, ast.Call) and getattr(node.func, "attr", getattr(node.func, "id", "")) in _STREAMS


def _in_memory(node: ast.Call, streams: set[int]) -> bool:
    """Whether the first argument is a stream in memory, made there and then or before."""
    values = [*node.args[:1], *(each.value for each in node.keywords if each.arg == "fileobj")]
    return any(_makes_stream(each) or id(each) in streams for each in values)


@pytest.mark.parametrize(
    "line",
    [
        "open('x')", "Path('x').read_text()", "path.write_bytes(b'')", "os.replace(a, b)", "temporary.replace(target)",
        "np.load('x')", "Image.open(path)", "figure.savefig(path)", "image.save(path, 'PNG')", "mesh.export(path)",
        "image.save(fp=path)", "table.to_csv(path)", "zipfile.ZipFile(path)",
        "gzip.open(path)", "tarfile.open(path)", "path.open('rb')", "path.open(encoding='utf-8')", "path.unlink()",
        "path.open()", "Path.open(path)", "map(open, paths)", "map(Path.read_bytes, paths)", "partial(open, path)()",
        "getattr(path, 'read_bytes')()", "PIL.Image.open(path)", "xml.etree.ElementTree.parse(path)",
        "gzip.GzipFile(path)", "figure.savefig(fname=path)", "subprocess.run(['cp', path])", "a.replace(target=b)",
        "Path.replace(a, b)", "builtins.open(path)", "logging.FileHandler(path)",
        "shutil.rmtree(folder)", "tempfile.mkstemp()", "path.open(mode)", "path.open(*('rb',))",
        "map(path.open, modes)",
        "methodcaller('unlink')(path)", "xml.dom.minidom.parse(path)", "fileinput.input(path)",
        "linecache.getline(path, 1)", "asyncio.create_subprocess_exec('cp', path)", "getattr(path, 'open')()",
        "importlib.resources.read_text(p, n)", "urllib.request.urlopen(path)", "numpy.savez(path, a)",
        "os.fdopen(number)", "image.save(out)", "matplotlib.image.imread(path)", "np.lib.format.open_memmap(path)",
        "scipy.io.loadmat(path)", "pyarrow.parquet.write_table(table, path)", "pl.read_parquet(path)",
        "ET.ElementTree(file=path)", "cascadio.step_to_glb(path, path)",
        "coal.MeshLoader().load(path)", "trimesh.exchange.export.export_mesh(mesh, path)", "runpy.run_path(path)",
        "_io.FileIO(path)", "array.dump(path)", "RotatingFileHandler(path)", "zipfile.PyZipFile(path)",
        "attrgetter('read_text')(path)()", "os.utime(path)", "anyio.open_file(path)",
        "YAML().load(path)", "YAML().dump(data, path)", "archive.extractall(folder)", "archive.extract(name, folder)",
        "archive.write(path, name)", "zipfile.Path(path)", "plt.savefig(path)", "np.fromregex(path)", "URDF.load(path)",
        "buildModelFromUrdf(path)", "imageio.imwrite(path, a)", "ImageFont.truetype(path)", "objectify.parse(path)",
        "pq.ParquetFile(path)", "pa.OSFile(path)", "pd.HDFStore(path)", "pd.read_fwf(path)",
        "table.to_pickle(path)",
        "scipy.io.wavfile.read(path)", "scipy.sparse.load_npz(path)", "atexit.register(path.replace, target)",
        "Thread(target=path.replace, args=[target])", "Timer(1, path.replace, [target])",
        "asyncio.to_thread(path.open)", "executor.submit(fn=path.replace)", "map(paths[0].rename, names)",
        "(path.replace if a else path.rename)(b)",
        "click.File('w')", "console.save_html(path)", "subprocess.getoutput('cat x')", "os.execl(path)",
        "shutil.copymode(a, b)", "importlib.util.spec_from_file_location('x', path)", "pkgutil.get_data('a', path)",
        "ctypes.CDLL(None).renameat2(1)", "logging.config.fileConfig(path)",
        "os.open(path, os.O_RDONLY)", "folder.mkdir(parents=True)", "[each for each in map(path.replace, places)]",
    ],
)  # fmt: skip
def test_a_door_of_its_own_is_found(line: str) -> None:
    assert list(doors_cut(f"def read(path):\n    return {line}\n"))


@pytest.mark.parametrize(
    ("imported", "line"),
    [
        ("from numpy import loadtxt", "loadtxt(path)"), ("from shutil import copyfile as c", "c(path, other)"),
        ("from io import FileIO", "FileIO(path)"), ("import zipfile as zf", "zf.ZipFile(path)"),
        ("from zipfile import ZipFile", "ZipFile(path)"), ("import PIL.Image as pictures", "pictures.open(path)"),
        ("from tempfile import NamedTemporaryFile", "NamedTemporaryFile()"),
        ("from PIL import Image as I", "I.open(path)"), ("from os import *", "path"),
        ("def f(file):\n    opener = file.open\n    return opener('rb')", "f(path)"),
        ("from pathlib import Path as P", "map(P.open, paths)"),
        ("import zipfile\nclass Mine(zipfile.ZipFile):\n    pass", "Mine(path)"),
        ("from gzip import GzipFile\nclass Mine(GzipFile):\n    pass", "Mine(path)"),
        ("from configparser import ConfigParser", "ConfigParser().read(path)"),
        ("from trimesh.exchange.load import load", "load(path)"),
        ("import trimesh.exchange.load as tl", "tl.load(path)"),
        ("from pyarrow import csv as c", "c.read_csv(path)"), ("def f(path):\n    o: object = path.open", "f"),
        ("def f(path):\n    a, b = path.open, 1", "f"), ("def f(path):\n    if (o := path.open):\n        o()", "f"),
        ("def f(path):\n    return path.open", "f"), ("class A:\n    def f(self):\n        self.open(path)", "A"),
        ("class A:\n    def f(self, path):\n        self.o = path.open", "A"),
        ("from click import open_file as o", "o(path)"),
        ("from logging.handlers import RotatingFileHandler as R", "R(path)"), ("def f(x: typer.FileText): pass", "f"),
        ("from rich.progress import open as o", "o(path)"),
        ("name = 'unlink'", "getattr(path, name)()"), ("def f(path, name):\n    m = getattr(path, name)\n    m()", "f"),
    ],
)  # fmt: skip
def test_a_door_is_found_by_whatever_name(imported: str, line: str) -> None:
    assert list(doors_cut(f"{imported}\ndef read(path):\n    return {line}\n"))


@pytest.mark.parametrize(
    "line",
    [
        "Image.open(io.BytesIO(data))", "gzip.open(BytesIO(data))", "InputFile(path).read()", "text.replace('a', 'b')",
        "document.save()",
        "zipfile.ZipFile(io.BytesIO(content))",
        "np.loadtxt(BytesIO(text))", "OutputFile(path).write(text)", "replace(spec, speed=3)",
    ],
)  # fmt: skip
def test_what_is_in_memory_or_by_the_types_is_none(line: str) -> None:
    assert not list(doors_cut(f"def read(path):\n    return {line}\n"))


def test_a_method_of_its_own_is_none() -> None:
    assert not list(doors_cut("class A:\n    def open(self, jet):\n        return self.open(jet)\n"))


def test_a_stream_is_known_by_what_made_it() -> None:
    function = "def draw(figure, {}):\n    {} = BytesIO()\n    figure.savefig(out, format='png')\n"
    assert not list(doors_cut(function.format("stream", "out")))
    assert list(doors_cut(function.format("out", "stream")))


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


def test_no_command_makes_a_file_of_a_parameter_that_is_text() -> None:
    source = "def write(place: str, done: OutputFile, about: 'Annotated[str, option]'):\n    OutputFile(Path({}))\n"
    assert [bool(list(files_of_text(source.format(each)))) for each in ("place", "done.path", "about")] == [
        True, False, True]  # fmt: skip
    for path in (ROOT / "commandline").rglob("*.py"):
        if path.name != "arguments.py":
            assert list(files_of_text(path.read_text("utf-8"))) == [], path


def files_of_text(source: str) -> Iterator[int]:
    """Lines that make an output of a parameter which no parser of the doors has read."""
    for function in ast.walk(ast.parse(source)):
        if isinstance(function, ast.FunctionDef):
            text = {each.arg for each in function.args.args if each.annotation and "str" in ast.dump(each.annotation)}
            for node in ast.walk(function):
                if isinstance(node, ast.Call) and getattr(node.func, "id", "") in {"OutputFile", "OutputFolder"}:
                    value = node.args[0] if node.args else node.keywords[0].value
                    value = value.args[0] if isinstance(value, ast.Call) and value.args else value
                    if isinstance(value, ast.Name) and value.id in text:
                        yield node.lineno


_PARSERS = {arguments.__name__, "specs.output_file"}


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.timeout(900)
def test_no_command_touches_a_file_but_by_the_two_types(tmp_path: Path) -> None:
    apart = {"ui", "controller simulate", "controller check"}
    assert {each.partition(" #")[0] for each in WORDS} | apart == {command for command, _ in commands()}
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
