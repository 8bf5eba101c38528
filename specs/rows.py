"""Rows of one type that show themselves as a table."""

from collections.abc import Iterable
from dataclasses import fields
from html import escape
from typing import Any, TypeVar

T = TypeVar("T")
_PLAIN = (str, int, float, bool, type(None))


class Rows(tuple[T, ...]):
    """A tuple of dataclass instances; a notebook shows it as a table of its plain values, without empty columns."""

    __slots__ = ()

    def __new__(cls, rows: Iterable[T] = ()) -> "Rows[T]":
        """Take rows of one dataclass."""
        return super().__new__(cls, rows)

    def records(self) -> list[dict[str, Any]]:
        """Rows as dictionaries of their plain values: numbers, texts, and objects of ours that have a text.

        A row with a method ``record`` states its own.
        """
        return [row.record() if hasattr(row, "record") else _record(row) for row in self]  # pyright: ignore

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
        names = [
            name for name in (records[0] if records else ()) if any(each[name] not in ("", None) for each in records)
        ]
        head = "".join(f"<th>{escape(name)}</th>" for name in names)

        def cell(value: object) -> str:
            text = f"{value:g}" if isinstance(value, float) else "" if value is None else str(value)
            return f"<td>{escape(text)}</td>"

        body = "".join("<tr>" + "".join(cell(each[name]) for name in names) + "</tr>" for each in records)
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"

    _repr_html_ = html


def _record(row: Any) -> dict[str, Any]:
    values = {each.name: getattr(row, each.name) for each in fields(row)}
    return {
        name: value if isinstance(value, _PLAIN) else str(value)
        for name, value in values.items()
        if isinstance(value, _PLAIN) or type(value).__module__.startswith("specs.")
    }
