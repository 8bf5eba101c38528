"""Where tuning works, for what, and what it began with."""

from collections.abc import Mapping
from dataclasses import dataclass

from recipes.located import YamlPath
from rulesengine.tuning.asked import Asked
from rulesengine.tuning.bench import Bench


@dataclass(frozen=True, slots=True, eq=False)
class Shop:
    """Where to try, for what, and where tuning began."""

    bench: Bench
    asked: Asked
    began: Mapping[YamlPath, float]
