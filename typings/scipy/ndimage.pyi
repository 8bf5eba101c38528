from typing import Any

label: Any
uniform_filter1d: Any
binary_dilation: Any
maximum_filter: Any
minimum_filter: Any
uniform_filter: Any
