"""Where tuning works, for what, and what it began with."""

from collections.abc import Mapping
from dataclasses import dataclass

from rulesengine.tuning.trial.request import Asked
from rulesengine.tuning.trial.trial_runner import Bench
from specs.yaml.located import YamlPath


@dataclass(frozen=True, slots=True, eq=False)
class Shop:
    """Where to try, for what, and where tuning began."""

    bench: Bench
    asked: Asked
    began: Mapping[YamlPath, float]
