"""Brings a text to the layout in which its language is written here: blanks, commas, equals signs, numbers, letters.

Makers' grammars leave these free, and who edits a program by hand, or an editor that saves it, changes them. Lines stay
where they are, so that what is refused is refused at its own line; texts in quotes and lines that are a comment stay as
they are. A comment after a statement is left out, but one in brackets: that may be a message.
"""

import re
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal

_QUOTED = re.compile(r'("[^"]*")')
_BLANKS = re.compile(r"(?<=\S)[ \t]+")
_EQUALS = re.compile(r" ?(?<![<>=!:])(:?=)(?!=) ?")
_COMMA = re.compile(r" ?, ?")
_POINT = re.compile(r"(?<![\w.)\]])\.(?=\d)")
_NO_DECIMALS = re.compile(r"(?<=\d)\.(?![\w.])")
_POWER = re.compile(r"(?<![\w.])(\d+(?:\.\d*)?)[Ee]([-+]?\d{1,2})(?![\w.])")
_NONE = "9E9"
"""RAPID's number for an axis that there is not."""
_WORD = re.compile(r"(?<![\w$])(?<!\d\.)[A-Za-z_$][\w$]*")
_ADDRESS = re.compile(r"(?<![\w<$])[A-Za-z](?=[-+.\d=\[#<])")
_FORM_WORD = re.compile(r"(?<![\w${])(?<!\d\.)([A-Za-z_$][\w$]*)(\{?)")
"""A word of a form, and whether a field makes it longer."""
_OPERATORS_TEXT = re.compile(r'"[^"]*"')


@dataclass(frozen=True, slots=True)
class Layout:
    """How a language is written here, where its grammar leaves that free; what is ``None`` is left as it is."""

    comments: str = ""
    """What begin a comment, to the end of the line, with blanks between them."""
    comma: str | None = None
    """A comma with its blanks."""
    equals: str | None = None
    """An equals sign, ``=`` or ``:=``, is written for the ``=`` in it."""
    single_blanks: bool = False
    """Whether words have one blank between them."""
    leading_zero: bool = False
    """Whether a number has a digit before its point, and one after it where it has a point."""
    powers: bool = False
    """Whether numbers may have powers of ten, which are written out here."""
    words: Mapping[str, Collection[str]] = field(default_factory=dict[str, Collection[str]], hash=False)
    """Spellings of its words by their small letters, where letters may be large or small; of ``words_of``.

    Names have the spelling in which they come first."""
    addresses: str = ""
    """Letters before a number that stay small, in languages that have such: all others are large."""


AS_IT_IS = Layout()


def words_of(syntax: type, more: str = "") -> Mapping[str, Collection[str]]:
    """Give the words of a writer's forms, and more of them: their spellings by their small letters.

    Args:
        syntax: The writer; its forms are texts and tuples of texts.
        more: With blanks between them; these have no other spelling. ``n#`` begins words that end in digits.
    """
    found = defaultdict[str, dict[str, None]](dict)
    texts = (text for name in dir(syntax) if name[:2] != "__" for text in _texts_in(getattr(syntax, name)))
    for text in texts:
        for word, is_begin in _FORM_WORD.findall(_OPERATORS_TEXT.sub(" ", text)):
            if len(word) > 1 or is_begin:
                found[f"{word.lower()}{'#' * bool(is_begin)}"][word] = None
    stated = {word.lower(): (word.rstrip("#"),) for word in more.split()}
    return {small: tuple(spellings) for small, spellings in found.items()} | stated


def _texts_in(value: object) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, tuple):
        for each in value:  # type: ignore[reportUnknownVariableType]
            yield from _texts_in(each)  # type: ignore[reportUnknownArgumentType]


def tidy(files: Mapping[str, str], layout: Layout) -> Mapping[str, str]:
    """Give the files of a program in the layout of a language, without empty lines at their ends."""
    spellings = {**{stem.lower(): (stem,) for name in files if (stem := name.partition(".")[0])}, **layout.words}
    return {
        name: "\n".join(_tidy_line(line, layout, spellings) for line in text.rstrip().split("\n")) + "\n"
        for name, text in files.items()
    }


def _tidy_line(line: str, layout: Layout, spellings: dict[str, Collection[str]]) -> str:
    """Give a line without blanks at its end, or its statement in the layout."""
    line = line.rstrip()
    stripped = line.lstrip()
    at = _comment_at(stripped, layout.comments.split())
    code, comment = stripped[:at], stripped[at:]
    if not code or layout is AS_IT_IS:
        return line
    if not comment.startswith("("):  # which may be a message
        code, comment = code.rstrip(), ""
    parts = _QUOTED.split(code)
    parts[::2] = [_tidy_code(part, layout, spellings) for part in parts[::2]]
    return line[: len(line) - len(stripped)] + "".join(parts) + comment


def _comment_at(line: str, marks: Sequence[str]) -> int:
    """Find where the comment of a line begins, which is not within a text in quotes; the line's end if it has none."""
    is_text = False
    for match in re.finditer("|".join(map(re.escape, ('"', *marks))), line):
        if match[0] == '"':
            is_text = not is_text
        elif not is_text:
            return match.start()
    return len(line)


def _tidy_code(code: str, layout: Layout, spellings: dict[str, Collection[str]]) -> str:
    if layout.single_blanks:
        code = _BLANKS.sub(" ", code)
    if layout.comma is not None:
        code = _COMMA.sub(layout.comma, code)
    if (equals := layout.equals) is not None:
        code = _EQUALS.sub(lambda match: equals.replace("=", match[1]), code)
    if layout.leading_zero:
        code = _NO_DECIMALS.sub("", _POINT.sub("0.", code))
    if layout.powers:
        code = _POWER.sub(lambda match: _written_out(match[0]), code)
    if layout.addresses:
        code = _ADDRESS.sub(lambda match: _in_case(match[0], layout.addresses), code)
    if layout.words:
        code = _WORD.sub(lambda match: _spelled(match[0], spellings), code)
    return code


def _written_out(number: str) -> str:
    """Write a number without a power of ten."""
    return _NONE if Decimal(number) == Decimal(_NONE) else f"{Decimal(number):f}"


def _in_case(letter: str, small: str) -> str:
    return letter.lower() if letter.lower() in small else letter.upper()


def _spelled(word: str, spellings: dict[str, Collection[str]]) -> str:
    """Spell a word as it is spelled here, or as it was spelled first."""
    small = word.lower()
    if small not in spellings:
        begin = small.rstrip("0123456789")
        begins = spellings.get(f"{begin}#", ()) if begin != small else ()
        spellings[small] = tuple(f"{each}{small[len(begin) :]}" for each in begins) or (word,)
    known = spellings[small]
    return word if word in known else next(iter(known))
