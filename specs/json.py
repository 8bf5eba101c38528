"""JSON values: their type, the hash of their content, and results as such."""

import hashlib
import json
import math
from typing import TypeAlias, cast

Json: TypeAlias = "dict[str, Json] | list[Json] | str | int | float | bool | None"


def content_sha256(content: Json) -> str:
    """Hash a value in hexadecimal digits, whatever the order of its keys; the order of lists counts."""
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(canonical.encode()).hexdigest()


def plain_data(value: object, digits: int = 6) -> Json:
    """Give results as JSON has them: floats rounded to so many significant digits; of infinities it has none."""
    if isinstance(value, float):
        return float(f"{value:.{digits}g}") if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: plain_data(inner, digits) for key, inner in cast("dict[str, object]", value).items()}
    if isinstance(value, tuple | list):
        return [plain_data(inner, digits) for inner in cast("list[object]", value)]
    return cast(Json, value)
