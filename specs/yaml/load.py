"""Reading YAML files: from a library by name or by path, with what they extend, into their model."""

import difflib
import json
import os
from pathlib import Path

from pydantic import ValidationError

from specs.errors import JobError, printable
from specs.input_file import InputFile
from specs.spec import Spec
from specs.yaml.file_kind import FileKind, S_co
from specs.yaml.located import Located, YamlPath, present_text, read_yaml, spell_path
from specs.yaml.problems import raise_problems, translate
from specs.yaml.schema import name_nearest

_LARGEST_FILE = 1_000_000
_LONGEST_CHAIN = 20


def find_file(source: str | Path, kind: FileKind[Spec]) -> Path:
    """Find a file: a library name first, then a path.

    Raises:
        JobError: the kind's own: a bare name that is neither in the library nor a file.
    """
    library = kind.library()
    if isinstance(source, str) and source in library:
        return library[source]
    path = Path(source)
    if is_bare(str(source)) and not os.path.lexists(path):
        near = difflib.get_close_matches(str(source), library, n=1)
        hint = f" Did you mean {near[0]!r}?" if near else ""
        names = ", ".join(library)
        raise kind.error(f"no {kind.noun} {str(source)!r}.{hint} The library has {names}; or give the path of a file.")
    return path


def is_bare(name: str) -> bool:
    """Whether a source is a name rather than a path."""
    return bool(name) and "\0" not in name and not Path(name).suffix and name == Path(name).name


def read_text(path: Path, kind: FileKind[Spec]) -> str:
    """Read a UTF-8 file of a sensible size, as a text of the present format of its kind.

    Raises:
        JobError: the kind's own: it cannot be read as text, or is of a later format.
    """
    missing = f"`{kind.command} list` shows the library"
    return present_text(InputFile(path, kind.error, kind.noun, _LARGEST_FILE, missing).text(), path, kind)


def parse_spec(root: Located, kind: FileKind[S_co]) -> S_co:
    """Validate a tree as the model of its kind.

    Raises:
        JobError: the kind's own: the values do not fit the model.
    """
    try:
        # JSON is what makes pydantic strict about types (no "60", no true for 1) while lists still become tuples.
        return kind.model.model_validate_json(json.dumps(root.plain()), strict=True)
    except ValidationError as error:
        raise_problems(translate(error, root, kind), root, kind)
        raise AssertionError(f"a refused {kind.noun} has a problem") from error


def resolve_text(text: str, file: Path | str, kind: FileKind[Spec]) -> Located:
    """Merge a file's text over all that it extends, directly or by way of others; it need not fit the model.

    Mappings merge key by key; lists and single values replace; ``null`` removes what was inherited. An entry of
    another variant, such as a template with another ``path``, replaces the inherited one whole.

    Args:
        text: YAML.
        file: Its name in errors; a relative path that it extends starts at its folder.
        kind: Kind of the file.

    Raises:
        JobError: the kind's own: not YAML; an ``extends`` that is not text, goes in a circle or cannot be read; a
            ``null`` for a name that was not inherited.
    """
    root = read_yaml(text, file, kind)
    chain = [root]
    files = [root.mark.file]
    while (extends := chain[-1].get("extends")) is not None and extends.value is not None:
        mark = extends.mark
        if not isinstance(extends.value, str):
            message = f"names one {kind.noun}: a library name or a file"
            raise kind.error(message, path="extends", file=mark.file, line=mark.line)
        base = _read_extended(extends.value, extends, kind)
        if base.mark.file in files or len(files) >= _LONGEST_CHAIN:
            circle = " -> ".join(map(printable, [*files, base.mark.file]))
            raise kind.error(f"goes in a circle: {circle}", path="extends", file=mark.file, line=mark.line)
        chain.append(base)
        files.append(base.mark.file)
    merged = chain.pop()
    while chain:
        merged = _merge(merged, chain.pop(), (), kind)
    return Located(merged.value, root.mark, merged.removed)


def _read_extended(name: str, extends: Located, kind: FileKind[Spec]) -> Located:
    """Read the tree of an extended file; a relative path starts at the folder of the file that extends it."""
    mark = extends.mark
    try:
        path = kind.library().get(name)
        if path is None and is_bare(name):
            find_file(name, kind)
        path = path or Path(os.path.normpath(Path(mark.file).parent / name))
        return read_yaml(read_text(path, kind), path, kind)
    except JobError as error:
        raise kind.error(str(error), path="extends", file=mark.file, line=mark.line) from None


def _merge(base: Located, child: Located, path: YamlPath, kind: FileKind[Spec]) -> Located:
    if not (isinstance(base.value, dict) and isinstance(child.value, dict)):
        return child
    if len(path) == 2 and path[0] in kind.variants:
        key = kind.variants[str(path[0])]
        ours, theirs = child.get(key), base.get(key)
        if ours is not None and theirs is not None and ours.value != theirs.value:
            return child
    merged, removed = dict(base.value), dict(base.removed)
    for key, value in child.value.items():
        inherited = base.value.get(key)
        if inherited is None:
            if value.value is None and len(path) == 1 and path[0] in kind.named:
                message = f"nothing of this name is inherited, so null removes nothing; {name_nearest(key, base.value)}"
                where = spell_path((*path, key))
                raise kind.error(message, path=where, file=value.mark.file, line=value.mark.line)
            merged[key] = value
        elif value.value is None:
            del merged[key]
            removed[key] = value.mark
        else:
            merged[key] = _merge(inherited, value, (*path, key), kind)
    if len(path) == 1 and path[0] in kind.ordered and base.value.keys() <= child.value.keys():
        merged = {key: merged[key] for key in child.value if key in merged}
    return Located(merged, child.mark, removed)
