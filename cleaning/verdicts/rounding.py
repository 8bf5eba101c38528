"""Numbers as the sentences of judgements have them."""

_LEAST = 1e-4
"""Below it a number would be written with an exponent, and nothing in a sentence is told so finely."""


def two_digits(value: float) -> str:
    """Write two digits of a number from 0 on, all before the point, and never an exponent."""
    if value < _LEAST:
        return "0"
    return f"{value:.0f}" if value >= 10.0 else f"{value:.2g}"
