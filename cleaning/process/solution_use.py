"""Which liquid or gas a step sprays, and what it is for."""

from cleaning.parameters.model import Liquid, Parameters
from recipes.nozzles import Nozzle
from recipes.recipe import Function, use_of


def choose_liquid(name: str, function: Function, nozzle: Nozzle, parameters: Parameters) -> tuple[Liquid, str]:
    """Look a function's solution up by its name; an unknown one is taken for the first known one of the same use.

    Gases dry. What has ``rinse`` or ``water`` in the name of its function or solution rinses; all else washes.

    Args:
        name: Of the function.
        function: Names its solution.
        nozzle: An air knife sprays gas unless the function says otherwise.
        parameters: Hold the known liquids.

    Returns:
        The liquid, and a sentence on what was assumed; empty if nothing was.
    """
    if function.solution in parameters.liquids:
        return parameters.liquids[function.solution], ""
    use = use_of(name, function, nozzle)
    like = next((known for known, liquid in parameters.liquids.items() if liquid.use == use), "")
    values = f"the values of {like}" if like else "the values of air" if use == "dry" else "the values of pure water"
    known = ", ".join(parameters.liquids)
    return (
        parameters.liquids[like] if like else Liquid(use=use, density_kg_m3=1.0 if use == "dry" else 1000.0),
        f"{function.solution} is not in the parameter set {parameters.parameters}, so that it counts as a liquid for "
        f"{use} with {values}. Add it under liquids, or use one of {known}.",
    )
