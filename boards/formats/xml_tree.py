"""XML files as trees of the elements that matter, each with its line; what does not matter is never kept."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, Self, TypeVar
from xml.parsers import expat

from boards.bounds import FARTHEST_MM, number_within
from boards.errors import Line

_LONGEST_MARK = 16_000_000
"""Bytes of one tag or text: expat keeps it as a whole until it ends."""


@dataclass(frozen=True, slots=True)
class XmlWords:
    """How a format is called in messages, and what its files may hold."""

    noun: str
    """Such as ``Eagle board``."""
    again: str
    """What to do about a damaged file, as a sentence."""
    skipped: frozenset[str]
    """Tags that are left out with all that is inside."""
    deepest: int
    most_elements: int
    most_kept: int
    kept_texts: frozenset[str] = frozenset()
    """Tags whose text is kept."""
    hollow: frozenset[str] = frozenset()
    """Tags that are left out if nothing inside was kept."""


@dataclass(frozen=True, slots=True)
class XmlElement(Line):
    """One element: its line, tag and attributes, its text, and the elements inside it."""

    tag: str
    attributes: dict[str, str]
    known_as: XmlWords
    children: list[Self] = field(default_factory=list[Any])
    words: list[str] = field(default_factory=list[str])

    def all(self, *tags: str) -> Iterator[Self]:
        """Yield the children with one of these tags, in file order."""
        return (child for child in self.children if child.tag in tags)

    def first(self, tag: str) -> Self | None:
        """Return the first child with a tag, if there is one."""
        return next(self.all(tag), None)

    def inside(self, *tags: str) -> Iterator[Self]:
        """Yield what is inside the children along a path of tags, such as ``libraries``, ``library``."""
        if not tags:
            yield from self.children
            return
        for child in self.all(tags[0]):
            yield from child.inside(*tags[1:])

    def below(self) -> Iterator[Self]:
        """Yield every element inside, in file order."""
        for child in self.children:
            yield child
            yield from child.below()

    def word(self, name: str) -> str:
        """Return an attribute without blanks around it; empty if there is none."""
        return self.attributes.get(name, "").strip()

    def number(self, name: str, bound: float = FARTHEST_MM, scale: float = 1.0) -> float:
        """Return an attribute as a number, scaled.

        Raises:
            BoardError: It is missing, no number, or beyond the bound after it was scaled.
        """
        value = number_within(self.attributes.get(name, ""), bound, scale)
        if not math.isfinite(value):
            stated, most = self.attributes.get(name, "nothing"), bound / scale
            raise self.error(
                f"{name} of <{self.tag}> must be a number from {-most:g} to {most:g}, not {stated[:40]!r}. "
                f"{self.known_as.again}"
            )
        return value


E = TypeVar("E", bound=XmlElement)


class _Builder(Generic[E]):
    """The tree of a file as its parser goes through it; what is skipped is counted and forgotten."""

    def __init__(
        self,
        path: Path,
        words: XmlWords,
        kind: type[E],
        taken: Mapping[str, Callable[[E], None]],
        is_kept: Callable[[str, Sequence[E]], bool],
    ) -> None:
        self.parser = expat.ParserCreate()
        self.top = kind(path, 1, "", {}, words)
        self._kind, self._words, self._taken, self._is_kept = kind, words, taken, is_kept
        self._opened = [self.top]
        self._skipped = self._count = self._kept = 0
        self.parser.StartElementHandler = self._begin
        self.parser.EndElementHandler = self._end
        if words.kept_texts:
            self.parser.CharacterDataHandler = self._text
        self.parser.EntityDeclHandler = self.parser.ExternalEntityRefHandler = self._refuse

    def here(self) -> Line:
        return Line(self.top.file, self.parser.CurrentLineNumber)

    def _begin(self, tag: str, attributes: dict[str, str]) -> None:
        words = self._words
        self._count += 1
        if len(self._opened) + self._skipped > words.deepest:
            raise self.here().error(f"elements are nested more than {words.deepest} deep. That is no {words.noun}.")
        if self._count > words.most_elements:
            raise self.here().error(f"more than {words.most_elements:,} elements. That is no {words.noun}.")
        tag = tag.rpartition(":")[2]
        if self._skipped or (tag in words.skipped and not self._is_kept(tag, self._opened)):
            self._skipped += 1
            return
        self._kept += 1
        if self._kept > words.most_kept:
            raise self.here().error(f"more than {words.most_kept:,} elements of a board. That is no {words.noun}.")
        element = self._kind(self.top.file, self.parser.CurrentLineNumber, tag, attributes, words)
        self._opened[-1].children.append(element)
        self._opened.append(element)

    def _end(self, _: str) -> None:
        if self._skipped:
            self._skipped -= 1
            return
        element = self._opened.pop()
        take = self._taken.get(element.tag)
        if take is not None:
            take(element)
        if take is not None or (element.tag in self._words.hollow and not element.children):
            self._opened[-1].children.pop()
            self._kept -= 1 + sum(1 for _ in element.below())

    def _text(self, words: str) -> None:
        if not self._skipped and self._opened[-1].tag in self._words.kept_texts:
            self._opened[-1].words.append(words)

    def _refuse(self, *_: object) -> int:
        words = self._words
        raise self.here().error(f"declares entities, which no {words.noun} does. {words.again}")


def read_xml(
    chunks: Iterable[bytes],
    path: Path,
    words: XmlWords,
    kind: type[E],
    taken: Mapping[str, Callable[[E], None]] | None = None,
    is_kept: Callable[[str, Sequence[E]], bool] = lambda _tag, _around: False,
) -> E:
    """Read a tree from pieces of a file; entities are never expanded, nothing else is opened.

    Args:
        chunks: Of the file, in order.
        path: For the messages.
        words: What is kept, and what the format is called.
        kind: Class of the elements.
        taken: By tag, what receives each such element when it ends; it does not stay in the tree.
        is_kept: Whether an element of a skipped tag is kept, by the elements around it, the outermost first.

    Returns:
        The outermost element.

    Raises:
        BoardError: It is no XML, declares entities, or holds more than a board's file does.
    """
    builder = _Builder(path, words, kind, taken or {}, is_kept)
    parser, fed = builder.parser, 0
    try:
        for chunk in chunks:
            parser.Parse(chunk, False)
            fed += len(chunk)
            if fed - parser.CurrentByteIndex > _LONGEST_MARK:
                raise builder.here().error(f"one tag or text of more than 16 MB. That is no {words.noun}.")
        parser.Parse(b"", True)
    except expat.ExpatError as error:
        message = f"not valid XML: {expat.errors.messages[error.code]}. {words.again}"
        raise Line(path, error.lineno).error(message) from None
    except (LookupError, ValueError):  # the encoding that it states is unknown to Python, or of several bytes
        raise Line(path, 1).error(f"is in an encoding that is not read. {words.again}") from None
    return builder.top.children[0]
