"""Changing a tree of mappings and lists, plain or as ruamel's round trip loads it."""

from typing import Any, TypeAlias, cast

from ruamel.yaml.comments import CommentedMap, CommentedSeq

from specs.yaml.located import Key, YamlPath

Tree: TypeAlias = Any
"""Nested dicts, lists and scalars."""
_ONE_LINE = frozenset({"path", "pattern", "function", "solution"})
"""Entries that have one of these are written one key a line."""


def reach(root: Tree, path: YamlPath) -> Tree:
    """Give what stands at a path; mappings on the way there are made."""
    node = root
    for name in path:
        key = name
        if isinstance(node, dict):
            entries = cast("dict[Key, Tree]", node)
            key = next((own for own in entries if str(own) == name), name)  # ruamel reads the key 1 as a number
            if entries.get(key) is None:
                node[key] = CommentedMap() if isinstance(node, CommentedMap) else {}
        node = node[key]
    return node


def put(parent: Tree, key: Key, value: Tree) -> None:
    """Write a value into a mapping or list; what is the same stays as it is written."""
    old = parent[key] if isinstance(key, int) or key in parent else None
    if isinstance(old, dict) and isinstance(value, dict):
        entries, new = cast("dict[Key, Tree]", old), cast("dict[Key, Tree]", value)
        for name in [name for name in entries if name not in new]:
            del entries[name]
        for name, inner in new.items():
            put(entries, name, inner)
    elif isinstance(old, list) and isinstance(value, list):
        items = cast("list[Tree]", old)
        del items[len(cast("list[Tree]", value)) :]
        for index, item in enumerate(cast("list[Tree]", value)):
            if index < len(items):
                put(items, index, item)
            else:
                items.append(styled(item))
    elif old is None or type(old) is bool or type(value) is bool or old != value:
        parent[key] = styled(value)


def drop(root: Tree, path: YamlPath) -> None:
    """Take out what stands at a path; a key that is only inherited gets ``None``, which removes it too."""
    parent, key = reach(root, path[:-1]), path[-1]
    if isinstance(parent, dict) and key not in parent:
        parent[key] = None
    else:
        del parent[key]


def move_key(entries: dict[Key, Tree], key: Key, to: int) -> None:
    """Move a key to another place among its neighbours, counted without it."""
    value = entries.pop(key)
    if isinstance(entries, CommentedMap):
        cast(Any, entries).insert(to, key, value)
        return
    rest = list(entries.items())
    entries.clear()
    entries.update([*rest[:to], (key, value), *rest[to:]])


def styled(value: Tree) -> Tree:
    """Write new lists and small mappings on one line, whole numbers without a point."""
    if isinstance(value, dict):
        entries = cast("dict[Key, Tree]", value)
        mapping = CommentedMap((key, styled(inner)) for key, inner in entries.items())
        if not any(isinstance(inner, dict) for inner in entries.values()) and _ONE_LINE.isdisjoint(entries):
            cast(Any, mapping).fa.set_flow_style()
        return mapping
    if isinstance(value, list | tuple):
        items = [styled(item) for item in cast("list[Tree]", value)]
        sequence = CommentedSeq(items)
        if not any(isinstance(item, dict) for item in items):
            cast(Any, sequence).fa.set_flow_style()
        return sequence
    return int(value) if isinstance(value, float) and value.is_integer() else value
