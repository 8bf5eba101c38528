from typing import Any

expm: Any
solveh_banded: Any
cho_factor: Any
cho_solve: Any
