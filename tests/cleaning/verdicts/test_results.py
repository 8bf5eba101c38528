import pytest

from cleaning.verdicts.results import two_digits


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"), (3e-5, "0"), (0.00012, "0.00012"), (0.0531, "0.053"), (1.05, "1.1"), (9.96, "10"), (99.6, "100"),
        (142.3, "142"), (12345.6, "12346"), (3e7, "30000000"),
    ],
)  # fmt: skip
def test_numbers_in_sentences_have_two_digits_and_no_exponent(value: float, text: str) -> None:
    assert two_digits(value) == text
