from typing import Any

ua: Any
