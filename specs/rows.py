"""Rows of one type that show themselves as a table."""

from collections.abc import Iterable
from dataclasses import fields, is_dataclass
from html import escape
from typing import Any, TypeVar

T = TypeVar("T")
_PLAIN = (str, int, float, bool, type(None))


class Rows(tuple[T, ...]):
    """A tuple of dataclass instances; a notebook shows it as a table of its plain values."""

    __slots__ = ()

    def __new__(cls, rows: Iterable[T] = ()) -> "Rows[T]":
        """Take rows of one dataclass."""
        return super().__new__(cls, rows)

    def records(self) -> list[dict[str, Any]]:
        """Rows as dictionaries of their plain values: numbers, texts, and objects of ours that have a text."""
        return [
            {
                each.name: value if isinstance(value, _PLAIN) else str(value)
                for each in fields(row)
                if isinstance(value := getattr(row, each.name), _PLAIN) or type(value).__module__.startswith("specs.")
            }
            for row in self
            if is_dataclass(row)
        ]

    def to_frame(self) -> Any:
        """Rows as a pandas data frame.

        Raises:
            ModuleNotFoundError: pandas is not installed.
        """
        import pandas as pd  # pyright: ignore[reportMissingImports]

        return pd.DataFrame.from_records(self.records())

    def __repr__(self) -> str:
        kinds = " and ".join(dict.fromkeys(type(each).__name__ for each in self))
        return f"<{len(self)} rows{f' of {kinds}' if kinds else ''}>"

    def html(self) -> str:
        """Rows as a table of HTML."""
        records = self.records()
        head = "".join(f"<th>{escape(name)}</th>" for name in (records[0] if records else ()))
        body = "".join(
            "<tr>" + "".join(f"<td>{escape(_text(value))}</td>" for value in row.values()) + "</tr>" for row in records
        )
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"

    _repr_html_ = html


def _text(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else "" if value is None else str(value)
