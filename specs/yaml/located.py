"""YAML text as a tree in which every value knows the file and the line it stands on.

YAML 1.2 by ruamel: ``on`` is text, ``012`` is twelve and ``1e3`` a number. The tree is built from the composed
nodes rather than from the loaded values, because aliases and merge keys would hide where a value was written.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeAlias, cast

from ruamel.yaml import YAML
from ruamel.yaml.composer import Composer, ComposerError
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode
from ruamel.yaml.reader import ReaderError

from specs.errors import JobError
from specs.spec import Spec
from specs.yaml.file_kind import FORMAT, FileKind

Scalar: TypeAlias = str | int | float | bool | None
Key: TypeAlias = str | int
YamlPath: TypeAlias = tuple[Key, ...]

_LARGEST_TEXT = 1_000_000
_SHORT_TEXT = 8_000
"""Nodes take more than a hundred times the memory of their text: only short ones are remembered in number."""
_DEEPEST = 30
_MOST_VALUES = 20_000
_LONGEST_KEY = 200
_MOST_BITS = 1024
"""Of a whole number: more do not fit into any number of a model."""
_MOST_LETTERS = 2_000_000
"""Of all texts of a file, with those that aliases repeat."""
_HALF_PAIR = re.compile("[\ud800-\udfff]")
_TAG = "tag:yaml.org,2002:"
_TOO_MANY, _TWICE = "too many values", "key "
_HINTS = (
    (_TWICE, "{problem}"),
    (_TOO_MANY, f"more than {_MOST_VALUES:,} values; a {{noun}} needs far less"),
    ("maximum depth", f"nested more than {_DEEPEST} deep; a {{noun}} needs far less"),
    ("found character '\\t'", "a tab cannot be used here; indent with spaces"),
    ("found undefined alias", "{problem}; put text that begins with * in quotes"),
    ("but found another document", "a {noun} is one document; remove the line ---"),
    ("mapping values are not allowed here", "{problem}; quote text that holds a colon, or check the indentation"),
    ("could not determine a constructor", "tags are not allowed in a {noun}"),
)


@dataclass(frozen=True, slots=True)
class Mark:
    """Where a value stands."""

    file: str
    line: int
    """From 1."""


@dataclass(frozen=True, slots=True)
class Located:
    """A value of the YAML tree and where it was written: the line of its key, or its own in a list."""

    value: "Scalar | dict[str, Located] | list[Located]"
    mark: Mark
    removed: Mapping[str, Mark] = field(default_factory=dict[str, Mark])
    """Of a mapping: inherited keys that ``null`` removed, and where."""

    def at(self, path: YamlPath) -> "Located":
        """Value at a path, or the deepest one on the way there that exists."""
        node = self
        for key in path:
            inner = node.get(key)
            if inner is None:
                break
            node = inner
        return node

    def find(self, path: YamlPath) -> "Located | None":
        """Value at a path, ``None`` if there is none."""
        node: Located | None = self
        for key in path:
            node = None if node is None else node.get(key)
        return node

    def get(self, key: Key) -> "Located | None":
        """Value of a key or index, ``None`` if there is none."""
        if isinstance(self.value, dict):
            return self.value.get(str(key))
        if isinstance(self.value, list) and isinstance(key, int) and 0 <= key < len(self.value):
            return self.value[key]
        return None

    def plain(self) -> Any:
        """Plain values, as a YAML loader returns them."""
        if isinstance(self.value, dict):
            return {key: inner.plain() for key, inner in self.value.items()}
        if isinstance(self.value, list):
            return [inner.plain() for inner in self.value]
        return self.value


def spell_path(path: YamlPath) -> str:
    """Write a YAML path as in ``sequence[0].paths[2]``."""
    text = ""
    for key in path:
        text += f"[{key}]" if isinstance(key, int) else f".{key}" if text else key
    return text


def read_yaml(text: str, file: Path | str, kind: FileKind[Spec]) -> Located:
    """Read one YAML mapping as ``read_tree`` does, in the present format of its kind, without the key that states it.

    Raises:
        JobError: the kind's own: as ``read_tree``; or it is of a later format.
    """
    _, root = _present(text, file, kind)
    values = cast("dict[str, Located]", root.value)
    return Located({key: value for key, value in values.items() if key != FORMAT}, root.mark)


def present_text(text: str, file: Path | str, kind: FileKind[Spec]) -> str:
    """Convert a text of an older format to the present one of its kind; its comments stay.

    Raises:
        JobError: as ``read_yaml``.
    """
    return _present(text, file, kind)[0] if kind.converters else text


def _present(text: str, file: Path | str, kind: FileKind[Spec]) -> tuple[str, Located]:
    root = read_tree(text, file, kind)
    stated = root.get(FORMAT)
    version = 1 if stated is None or stated.value is None else stated.value
    problem = ""
    if not isinstance(version, int) or isinstance(version, bool) or version < 1:
        problem = f"must be a whole number from 1 to {kind.format}"
    elif version > kind.format:
        problem = (
            f"{version} is written for a later version of Washboard; install it, or write the {kind.noun} for format "
            f"{kind.format}"
        )
    if stated is not None and problem:
        raise kind.error(problem, path=FORMAT, file=file, line=stated.mark.line)
    older = range(cast(int, version), kind.format)
    for each in older:
        text = kind.converters[each](text)
    return text, read_tree(text, file, kind) if older else root


def read_tree(text: str, file: Path | str, kind: FileKind[Spec]) -> Located:
    """Read one YAML mapping as it stands.

    Args:
        text: YAML.
        file: What to call it in errors.
        kind: Kind of the file.

    Raises:
        JobError: the kind's own: not YAML, not a mapping, a key that stands twice, a tag, or a tree that is too
            large or too deep.
    """
    noun = kind.noun
    if len(text) > _LARGEST_TEXT:
        message = f"{len(text):,} characters are too many; a {noun} has at most {_LARGEST_TEXT:,}"
        raise kind.error(message, file=file)
    try:
        node = (_compose_short if len(text) <= _SHORT_TEXT else _compose_long)(text)
        root = None if node is None else _Tree(str(file), kind).build(node, Mark(str(file), _line(node)), 0)
    except ReaderError as error:
        line = text.count("\n", 0, cast(int, error.position)) + 1
        raise kind.error("a character that YAML does not allow; remove it", file=file, line=line) from None
    except MarkedYAMLError as error:
        raise _explain(error, file, kind) from None
    except RecursionError:
        raise kind.error(f"nested more than {_DEEPEST} deep; a {noun} needs far less", file=file) from None
    except (YAMLError, ValueError) as error:
        raise kind.error(f"not valid YAML: {error}", file=file) from None
    if root is None or root.value is None:
        raise kind.error(f"the file is empty; a {noun} begins with `{kind.first_line}`", file=file)
    if not isinstance(root.value, dict):
        message = f"a {noun} is a mapping of keys; it begins with `{kind.first_line}`"
        raise kind.error(message, file=file, line=root.mark.line)
    return root


class _Composer(Composer):
    """Composes nodes until a key stands twice or they are too many: a text of a megabyte would take half a minute."""

    count = 0

    def __init__(self, loader: Any = None) -> None:
        super().__init__(loader)
        self._lines: dict[int, dict[str, int]] = {}

    def compose_node(self, parent: Any, index: Any) -> Any:
        self.count += 1
        if self.count > 2 * _MOST_VALUES:  # keys are nodes too
            raise ComposerError(None, None, _TOO_MANY, self.parser.peek_event().start_mark)
        if isinstance(index, ScalarNode) and index.tag != _TAG + "merge":  # the key of a value to come
            lines, key = self._lines.setdefault(id(parent), {}), str(index.value)
            if key in lines:
                problem = f"{_TWICE}{key[:_LONGEST_KEY]!r} stands twice; line {lines[key]} has it too"
                raise ComposerError(None, None, problem, cast(Any, index).start_mark)
            lines[key] = _line(index)
        return super().compose_node(parent, index)


def _compose_anew(text: str) -> Node | None:
    yaml = YAML(typ="safe", pure=True)
    yaml.Composer = _Composer
    yaml.composer.warn_double_anchors = False  # YAML 1.2 allows an anchor to be set anew
    yaml.max_depth = _DEEPEST + 1
    return cast("Node | None", yaml.compose(text))


# Who writes a value reads the new text to check it, and again as a recipe. Files of the library and what a search tries
# in turn are short; the nodes are shared and not to be changed.
_compose_short = lru_cache(maxsize=64)(_compose_anew)
_compose_long = lru_cache(maxsize=2)(_compose_anew)


class _Tree:
    """Builds the tree of one file; it counts what it builds because aliases can multiply it without end."""

    def __init__(self, file: str, kind: FileKind[Spec]) -> None:
        self._constructor = YAML(typ="safe", pure=True).constructor
        self._file = file
        self._kind = kind
        self._count = 0
        self._letters = 0

    def build(self, node: Node, mark: Mark, depth: int) -> Located:
        self._count += 1
        if self._count > _MOST_VALUES:
            raise self._error(
                f"expands to more than {_MOST_VALUES:,} values; a {self._kind.noun} needs far less", mark.line
            )
        if depth > _DEEPEST:
            raise self._error(f"nested more than {_DEEPEST} deep; an alias may hold itself", mark.line)
        if isinstance(node, MappingNode) and node.tag == _TAG + "map":
            return Located(self._mapping(node, depth), mark)
        if isinstance(node, SequenceNode) and node.tag == _TAG + "seq":
            items = cast("list[Node]", node.value)
            return Located([self.build(item, self._mark(item), depth + 1) for item in items], mark)
        if isinstance(node, ScalarNode):
            return Located(self._scalar(node), mark)
        raise self._error(f"tag {node.tag} is not allowed in a {self._kind.noun}", _line(node))

    def _mapping(self, node: MappingNode, depth: int) -> dict[str, Located]:
        """Keys in the order of the file; what a merge key brings stands where the merge key stands."""
        pairs = cast("list[tuple[Node, Node]]", node.value)
        own: dict[str, Located] = {}
        for key_node, value_node in pairs:
            if key_node.tag == _TAG + "merge":
                continue
            own[self._key(key_node)] = self.build(value_node, self._mark(key_node), depth + 1)
        merged: dict[str, Located] = {}
        for key_node, value_node in pairs:
            if key_node.tag != _TAG + "merge":
                key = self._key(key_node)
                merged[key] = own[key]
                continue
            for source in self._merge_sources(value_node):
                inherited = self.build(source, self._mark(source), depth + 1).value
                for key, value in cast("dict[str, Located]", inherited).items():
                    if key not in own:
                        merged.setdefault(key, value)
        return merged

    def _merge_sources(self, node: Node) -> Iterator[Node]:
        sources = cast("list[Node]", node.value) if isinstance(node, SequenceNode) else [node]
        for source in sources:
            if not (isinstance(source, MappingNode) and source.tag == _TAG + "map"):
                raise self._error("<< merges a mapping or a list of mappings", _line(node))
            yield source

    def _key(self, node: Node) -> str:
        if not isinstance(node, ScalarNode):
            raise self._error("a key must be a word, not a list or a mapping", _line(node))
        key = self._text(str(node.value), node)
        if len(key) > _LONGEST_KEY:
            message = f"a key of {len(key):,} characters, {key[:40]!r}…, is too long; a key has at most {_LONGEST_KEY}"
            raise self._error(message, _line(node))
        if not key.isprintable():  # messages and reports quote keys, also those that are known nowhere
            raise self._error(f"key {key!r} holds a character that cannot be seen; remove it", _line(node))
        return key

    def _scalar(self, node: ScalarNode) -> Scalar:
        tag = str(node.tag).removeprefix(_TAG)
        if tag in ("null", "bool", "int", "float"):
            try:
                value: Scalar = self._constructor.construct_object(node)
                if isinstance(value, int) and value.bit_length() > _MOST_BITS:
                    raise ValueError
                return value
            except (ValueError, KeyError, IndexError):  # a tag such as !!bool on text that is none, or endless digits
                raise self._error(f"{str(node.value)[:40]!r} cannot be read as {tag}", _line(node)) from None
        if tag in ("str", "timestamp", "value", "merge"):
            return self._text(str(node.value), node)
        raise self._error(f"tag {node.tag} is not allowed in a {self._kind.noun}", _line(node))

    def _text(self, text: str, node: Node) -> str:
        self._letters += len(text)
        if self._letters > _MOST_LETTERS:
            raise self._error(
                f"expands to more than {_MOST_LETTERS:,} characters; a {self._kind.noun} needs far less", _line(node)
            )
        if _HALF_PAIR.search(text):
            raise self._error("half a surrogate pair is not a character; remove the escape", _line(node))
        return text

    def _mark(self, node: Node) -> Mark:
        return Mark(self._file, _line(node))

    def _error(self, message: str, line: int) -> JobError:
        return self._kind.error(message, file=self._file, line=line)


def _line(node: Node) -> int:
    return int(cast(Any, node).start_mark.line) + 1


def _explain(error: MarkedYAMLError, file: Path | str, kind: FileKind[Spec]) -> JobError:
    """Create the error of what ruamel found: one sentence, with what to do where it is known."""
    problem = str(error.problem or error.context or "it cannot be read")
    mark = error.problem_mark or error.context_mark
    line = None if mark is None else int(mark.line) + 1
    for start, hint in _HINTS:
        if problem.startswith(start):
            return kind.error(hint.format(problem=problem, noun=kind.noun), file=file, line=line)
    context = f", {error.context}" if error.context and error.problem else ""
    begin = error.context_mark
    begins = "" if not context or begin is None else f" that begins on line {int(begin.line) + 1}"
    return kind.error(f"not valid YAML: {problem}{context}{begins}", file=file, line=line)
