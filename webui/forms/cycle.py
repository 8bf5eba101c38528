"""Going on and back through a list, around its end."""

from collections.abc import Sequence


def step_around(names: Sequence[str], now: str, steps: int) -> str:
    """Give the name ``steps`` after ``now`` (before it, if negative); the first or last where ``now`` is none of them.

    An empty list has nothing to give: ``""``.
    """
    if not names:
        return ""
    if now not in names:
        return names[0 if steps > 0 else -1]
    return names[(names.index(now) + steps) % len(names)]
