from typing import Any

quaternion_matrix: Any
