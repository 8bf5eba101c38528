from typing import Any

brentq: Any
least_squares: Any
linprog: Any
minimize_scalar: Any
nnls: Any
