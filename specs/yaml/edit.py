"""Changing a recipe's text as its owner would: comments, order and every line that is not concerned stay.

The text is loaded and dumped by ruamel's round trip. What the dump alone would change, such as blanks in a line that
nobody edited, is left as it was: only lines that differ between the dumps before and after the change are replaced.
A number or word on the line of its key is replaced there without all that, as the round trip would have done it.
"""

import copy
import difflib
import io
import re
from collections.abc import Callable
from functools import lru_cache
from typing import Any, TypeAlias, cast

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap

from specs.errors import EditError
from specs.yaml.document import Document
from specs.yaml.located import Key, Located, YamlPath, read_yaml, spell_path
from specs.yaml.tree import Tree, drop, move_key, put, reach, styled

Change: TypeAlias = Callable[[Tree], None]

_TEXT = Document("file", "", "", EditError, dict)
_WIDE = 1_000_000  # lines are never folded
_IN_LINE = (
    r"""(?P<key>(?:[^#'"]*[ {{])?{key}: )(?P<old>[\w.+-]+)(?P<rest>[,}}][^#'"]*?)?(?P<gap> *)(?P<comment>\#.*)?"""
)
_NUMBER = re.compile(r"-?(0|[1-9]\d{0,8})(\.\d{1,8})?")
_WORD = re.compile(r"(?!(true|false|null|yes|no|on|off|y|n)$)[A-Za-z][A-Za-z0-9_-]*", re.IGNORECASE)


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
        if _says(candidate, expected):
            return candidate
    raise EditError("shared by an anchor with another place; change it in the text", path=spell_path(path))


def _replace_in_line(text: str, path: YamlPath, value: Tree) -> str | None:
    """Replace a number or word that stands on the line of its key; ``None`` where that cannot be done."""
    node: Located | None = own_tree(text)
    for key in path:
        node = None if node is None else node.get(key)
    new = _spell_simply(value)
    if node is None or new is None or isinstance(node.value, str) is not isinstance(value, str):
        return None
    lines = text.splitlines(keepends=True)
    line = lines[node.mark.line - 1]
    match = re.fullmatch(_IN_LINE.format(key=re.escape(str(path[-1]))), line.rstrip("\n"))
    if match is None or _spell_simply(node.value) is None or node.value == value:
        return None
    gap = match["gap"] and " " * max(1, len(match["old"] + match["gap"]) - len(new))
    comment = gap + match["comment"] if match["comment"] else ""
    lines[node.mark.line - 1] = match["key"] + new + (match["rest"] or "") + comment + line[len(line.rstrip("\n")) :]
    expected = own_tree(text).plain()
    put(reach(expected, path[:-1]), path[-1], value)
    candidate = "".join(lines)
    return candidate if _says(candidate, expected) else None


def _spell_simply(value: Tree) -> str | None:
    """Write what YAML writes as it is: a plain number or word."""
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
    return read_yaml(text, "<text>", _TEXT)


@lru_cache(maxsize=2)
def _open(text: str) -> tuple[Tree, str]:
    """Load a text for a round trip, and dump it again; the tree is to be copied before it is changed."""
    tree = _load(text)
    return copy.deepcopy(tree), _dump(tree)


def _load(text: str) -> Tree:
    return _round_trip().load(text)


def _dump(tree: Tree) -> str:
    stream = io.StringIO()
    _round_trip().dump(tree, stream)
    return stream.getvalue()


def _round_trip() -> YAML:
    yaml = YAML()
    yaml.preserve_quotes = True
    yaml.width = _WIDE
    yaml.indent(mapping=2, sequence=4, offset=2)
    return yaml


def _says(text: str, expected: Tree) -> bool:
    """Tell whether a text reads as expected, order of names included."""
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
    place = _places(lines, old)
    result: list[str] = []
    copied = 0
    for tag, first, last, begin, end in difflib.SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
        if tag == "equal":
            continue
        result += lines[copied : place[first]]
        result += new[begin:end]
        copied = place[last]
    return "".join([*result, *lines[copied:]])


def _places(lines: list[str], old: list[str]) -> list[int]:
    """For each line of a dump, and its end, the line of the text that says the same."""
    place = [0] * (len(old) + 1)
    matcher = difflib.SequenceMatcher(None, old, lines, autojunk=False)
    for _, first, last, begin, end in matcher.get_opcodes():
        for index in range(first, last):
            place[index] = min(begin + index - first, end)
    place[len(old)] = len(lines)
    return place
