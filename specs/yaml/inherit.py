"""What a recipe, or a parameter set, inherits: every key of the one it extends, unless it says otherwise."""

from collections.abc import Callable
from typing import TypeAlias

from specs.yaml.document import Document
from specs.yaml.keys import name_nearest
from specs.yaml.located import Located, YamlPath, spell_path

_NAMED = ("functions", "nozzles", "classes", "templates", "liquids", "provenance")
_KINDS = {"templates": "path", "nozzles": "pattern"}
_LONGEST_CHAIN = 20

Find: TypeAlias = Callable[[str, Located], Located]
"""Gives the tree that an ``extends`` of a recipe means; the second argument is the value of that key."""


def inherit(root: Located, find: Find, document: Document) -> Located:
    """Merge a recipe, or another kind of document, over all that it extends, directly or by way of others.

    Mappings merge key by key; lists and single values replace; ``null`` removes what was inherited. A template with
    another ``path`` and a nozzle with another ``pattern`` replace the inherited one whole.

    Raises:
        JobError: the document's own: an ``extends`` that is not text, goes in a circle or cannot be found; a ``null``
            for a name that was not inherited.
    """
    chain = [root]
    files = [root.mark.file]
    while (extends := chain[-1].get("extends")) is not None and extends.value is not None:
        mark = extends.mark
        if not isinstance(extends.value, str):
            message = f"names one {document.noun}: a library name or a file"
            raise document.error(message, path="extends", file=mark.file, line=mark.line)
        base = find(extends.value, extends)
        if base.mark.file in files or len(files) >= _LONGEST_CHAIN:
            circle = " -> ".join([*files, base.mark.file])
            raise document.error(f"goes in a circle: {circle}", path="extends", file=mark.file, line=mark.line)
        chain.append(base)
        files.append(base.mark.file)
    merged = chain.pop()
    while chain:
        merged = _merge(merged, chain.pop(), (), document)
    return Located(merged.value, root.mark)


def _merge(base: Located, child: Located, path: YamlPath, document: Document) -> Located:
    if not (isinstance(base.value, dict) and isinstance(child.value, dict)) or _is_other_kind(base, child, path):
        return child
    merged = dict(base.value)
    for key, value in child.value.items():
        inherited = base.value.get(key)
        if inherited is None:
            if value.value is None and path and path[0] in _NAMED and len(path) == 1:
                message = f"nothing of this name is inherited, so null removes nothing; {name_nearest(key, base.value)}"
                where = spell_path((*path, key))
                raise document.error(message, path=where, file=value.mark.file, line=value.mark.line)
            merged[key] = value
        elif value.value is None:
            del merged[key]
        else:
            merged[key] = _merge(inherited, value, (*path, key), document)
    if path == ("classes",) and base.value.keys() <= child.value.keys():
        merged = {key: merged[key] for key in child.value if key in merged}
    return Located(merged, child.mark)


def _is_other_kind(base: Located, child: Located, path: YamlPath) -> bool:
    """Tell whether a template or nozzle is overridden by one of another class, whose keys differ."""
    if len(path) != 2 or path[0] not in _KINDS:
        return False
    ours, theirs = child.get(_KINDS[str(path[0])]), base.get(_KINDS[str(path[0])])
    return ours is not None and theirs is not None and ours.value != theirs.value
