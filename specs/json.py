"""JSON values: their type, and the hash of their content."""

import hashlib
import json
from typing import TypeAlias

Json: TypeAlias = "dict[str, Json] | list[Json] | str | int | float | bool | None"


def content_sha256(content: Json) -> str:
    """Hash a value in hexadecimal digits, whatever the order of its keys; the order of lists counts."""
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(canonical.encode()).hexdigest()
