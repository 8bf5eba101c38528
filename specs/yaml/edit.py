"""Edits of YAML text that keep comments, order and every line that is not concerned.

The text is loaded and dumped by ruamel's round trip. What the dump alone would change, such as blanks in a line that
nobody edited, is left as it was: only lines that differ between the dumps before and after the change are replaced.
A number or word on the line of its key is replaced there without all that, as the round trip would have done it.
"""

import copy
import difflib
import io
import re
from collections.abc import Callable, Generator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeAlias, cast

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap

from specs.errors import EditError, LocatedError, printable
from specs.spec import Spec
from specs.yaml.file_kind import FileKind
from specs.yaml.located import Key, Located, YamlPath, read_tree, spell_path
from specs.yaml.tree import Tree, drop, move_key, put, reach, styled

Change: TypeAlias = Callable[[Tree], None]

_TEXT = FileKind("file", "", "", EditError, Spec, dict[str, Path])
_WIDE = 1_000_000  # lines are never folded
_IN_LINE = (
    r"""(?P<key>(?:[^#'"]*[ {{])?{key}: )(?P<old>[\w.+-]+)(?P<rest>[,}}][^#'"]*?)?(?P<gap> *)(?P<comment>\#.*)?"""
)
_NUMBER = re.compile(r"-?(0|[1-9]\d{0,8})(\.\d{1,8})?")
_WORD = re.compile(r"(?!(true|false|null|yes|no|on|off|y|n)$)[A-Za-z][A-Za-z0-9_-]*", re.IGNORECASE)


@contextmanager
def edited_text(file: Path) -> Generator[None]:
    """Read a text that was edited and stands in no file: errors name the file it came from, but none of its lines.

    Raises:
        LocatedError: what is raised inside, of its type.
    """
    try:
        yield
    except LocatedError as error:
        name = printable(str(file))
        message = re.sub(
            rf"^( *){re.escape(name)}:\d+: ", lambda at: f"{at[1]}{name} as edited: ", str(error), flags=re.M
        )
        moved = type(error)(message)
        moved.path, moved.file = error.path, error.file
        raise moved from None


def set_value(text: str, path: YamlPath, value: Tree) -> str:
    """Write a value at a path; mappings on the way there are made.

    Raises:
        EditError: there is no such list item, or the text cannot be changed there.
    """
    replaced = _replace_in_line(text, path, value)
    if replaced is not None:
        return replaced
    return _edit(text, lambda root: put(reach(root, path[:-1]), path[-1], value), path)


def remove_value(text: str, path: YamlPath) -> str:
    """Take a key or list item out; a key that is only inherited gets ``null``, which removes it too.

    Raises:
        EditError: the text cannot be changed there.
    """
    return _edit(text, lambda root: drop(root, path), path)


def insert_value(text: str, path: YamlPath, value: Tree) -> str:
    """Insert an item into a list before the index the path ends with.

    Raises:
        EditError: the text cannot be changed there.
    """

    def change(root: Tree) -> None:
        reach(root, path[:-1]).insert(path[-1], styled(value))

    return _edit(text, change, path)


def move_value(text: str, path: YamlPath, to: int) -> str:
    """Move a list item or a named entry to another place among its neighbours, counted without it.

    Raises:
        EditError: the text cannot be changed there.
    """

    def change(root: Tree) -> None:
        parent, key = reach(root, path[:-1]), path[-1]
        if isinstance(parent, list):
            items = cast("list[Tree]", parent)
            items.insert(to, items.pop(cast(int, key)))
        else:
            move_key(cast("dict[Key, Tree]", parent), key, to)

    return _edit(text, change, path)


def rename_key(text: str, path: YamlPath, name: str) -> str:
    """Give a named entry another name; it keeps its place and its comments.

    Raises:
        EditError: the name is taken, or the text cannot be changed there.
    """

    def change(root: Tree) -> None:
        entries = cast("dict[Key, Tree]", reach(root, path[:-1]))
        if name in entries:
            raise EditError(f"{name!r} is there already; choose another name", path=spell_path(path[:-1]))
        place = list(entries).index(path[-1])
        value = entries.pop(path[-1])
        if isinstance(entries, CommentedMap):
            comments = cast("dict[Key, Any]", cast(Any, entries).ca.items)
            if path[-1] in comments:
                comments[name] = comments.pop(path[-1])
        entries[name] = value
        move_key(entries, name, place)

    return _edit(text, change, path)


def _edit(text: str, change: Change, path: YamlPath) -> str:
    expected = own_tree(text).plain()
    loaded, before = _open(text)
    tree = copy.deepcopy(loaded)
    try:
        change(expected)
        change(tree)
    except (KeyError, IndexError, ValueError, TypeError, AttributeError):
        raise EditError("there is nothing of this name to change in this file", path=spell_path(path)) from None
    after = _dump(tree)
    merged = _carry_over(text, before, after)
    for candidate in (merged, after):
        if _reads_as(candidate, expected):
            return candidate
    raise EditError("shared by an anchor with another place; change it in the text", path=spell_path(path))


def _replace_in_line(text: str, path: YamlPath, value: Tree) -> str | None:
    """Replace a number or word that stands on the line of its key; ``None`` where that cannot be done."""
    node = own_tree(text).find(path)
    new = _plain_scalar(value)
    if node is None or new is None or isinstance(node.value, str) is not isinstance(value, str):
        return None
    lines = text.splitlines(keepends=True)
    line = lines[node.mark.line - 1]
    match = re.fullmatch(_IN_LINE.format(key=re.escape(str(path[-1]))), line.rstrip("\n"))
    if match is None or _plain_scalar(node.value) is None or node.value == value:
        return None
    gap = match["gap"] and " " * max(1, len(match["old"] + match["gap"]) - len(new))
    comment = gap + match["comment"] if match["comment"] else ""
    lines[node.mark.line - 1] = match["key"] + new + (match["rest"] or "") + comment + line[len(line.rstrip("\n")) :]
    expected = own_tree(text).plain()
    put(reach(expected, path[:-1]), path[-1], value)
    candidate = "".join(lines)
    return candidate if _reads_as(candidate, expected) else None


def _plain_scalar(value: Tree) -> str | None:
    """Write a number or word that YAML writes as it is; ``None`` for other values."""
    plain = styled(value)
    if isinstance(plain, str):
        return plain if _WORD.fullmatch(plain) else None
    spelt = str(plain)
    return spelt if not isinstance(plain, bool) and _NUMBER.fullmatch(spelt) else None


@lru_cache(maxsize=4)
def own_tree(text: str) -> Located:
    """Read a text as it stands, without what it inherits; the last few are remembered.

    Raises:
        EditError: it is not YAML.
    """
    return read_tree(text, "<text>", _TEXT)


@lru_cache(maxsize=2)
def _open(text: str) -> tuple[Tree, str]:
    """Load a text for a round trip, and dump it again; the tree is to be copied before it is changed."""
    tree = _round_trip().load(text)
    return copy.deepcopy(tree), _dump(tree)


def _round_trip() -> YAML:
    yaml = YAML()
    yaml.preserve_quotes = True
    yaml.width = _WIDE
    yaml.indent(mapping=2, sequence=4, offset=2)
    return yaml


def _dump(tree: Tree) -> str:
    stream = io.StringIO()
    _round_trip().dump(tree, stream)
    return stream.getvalue()


def _reads_as(text: str, expected: Tree) -> bool:
    """Whether a text reads as expected, order of names included."""
    try:
        return _ordered(own_tree(text).plain()) == _ordered(expected)
    except EditError:
        return False


def _ordered(value: Tree) -> Tree:
    if isinstance(value, dict):
        return [(key, _ordered(inner)) for key, inner in cast("dict[str, Tree]", value).items()]
    return [_ordered(item) for item in cast("list[Tree]", value)] if isinstance(value, list) else value


def _carry_over(text: str, before: str, after: str) -> str:
    """Apply the lines that differ between two dumps to the text that the first one is a dump of."""
    lines, old, new = text.splitlines(keepends=True), before.splitlines(keepends=True), after.splitlines(keepends=True)
    if lines == old:
        return after
    place = [0] * len(old) + [len(lines)]  # for each line of the old dump, and its end, the line of the text
    for _, first, last, begin, end in difflib.SequenceMatcher(None, old, lines, autojunk=False).get_opcodes():
        for index in range(first, last):
            place[index] = min(begin + index - first, end)
    result: list[str] = []
    copied = 0
    for tag, first, last, begin, end in difflib.SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
        if tag == "equal":
            continue
        result += lines[copied : place[first]]
        result += new[begin:end]
        copied = place[last]
    return "".join([*result, *lines[copied:]])
