"""XML text as a tree in which every element knows its line."""

from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from robotcell.errors import CellError

_LARGEST_TEXT = 5_000_000
_DEEPEST = 100


@dataclass(frozen=True, slots=True, eq=False)
class Element:
    """One element of an XML file."""

    tag: str
    attributes: dict[str, str]
    file: Path
    line: int
    children: "list[Element]" = field(default_factory=list["Element"])

    def all(self, tag: str) -> "list[Element]":
        """Give the children with a tag, in the order of the file."""
        return [child for child in self.children if child.tag == tag]

    def first(self, tag: str) -> "Element | None":
        """Give the first child with a tag, ``None`` if there is none."""
        return next(iter(self.all(tag)), None)

    def need(self, tag: str) -> "Element":
        """Give the first child with a tag.

        Raises:
            CellError: there is none.
        """
        child = self.first(tag)
        if child is None:
            raise self.error(f"has no <{tag}>; add one")
        return child

    def text(self, name: str) -> str:
        """Give an attribute.

        Raises:
            CellError: it is missing.
        """
        if name not in self.attributes:
            raise self.error(f"has no {name}; add {name}=...")
        return self.attributes[name]

    def error(self, message: str) -> CellError:
        """Say what is wrong with this element."""
        named = self.attributes.get("name")
        label = f"<{self.tag} name={named!r}>" if named else f"<{self.tag}>"
        return CellError(f"{label} {message}", file=self.file, line=self.line)


def read_xml(text: bytes, file: Path) -> Element:
    """Read an XML text; a document type, and with it every entity, is refused.

    Raises:
        CellError: it is too large, too deep or no XML.
    """
    if len(text) > _LARGEST_TEXT:
        raise CellError(f"{len(text):,} bytes are too many; at most {_LARGEST_TEXT:,}", file=file)
    parser = expat.ParserCreate()
    top = Element("", {}, file, 1)
    opened = [top]

    def begin(tag: str, attributes: dict[str, str]) -> None:
        if len(opened) > _DEEPEST:
            raise CellError(f"nested more than {_DEEPEST} deep", file=file, line=parser.CurrentLineNumber)
        element = Element(tag, attributes, file, parser.CurrentLineNumber)
        opened[-1].children.append(element)
        opened.append(element)

    def end(_: str) -> None:
        opened.pop()

    def refuse(*_: object) -> None:
        raise CellError("a <!DOCTYPE ...> is not allowed; remove it", file=file, line=parser.CurrentLineNumber)

    parser.StartElementHandler, parser.EndElementHandler, parser.StartDoctypeDeclHandler = begin, end, refuse
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise CellError(f"not valid XML: {expat.errors.messages[error.code]}", file=file, line=error.lineno) from None
    return top.children[0]
