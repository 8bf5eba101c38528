"""The library of solutions, which recipes may name although their parameter set lacks them, and of liquid fluxes."""

from collections.abc import Iterable
from functools import cache
from pathlib import Path

from pydantic import Field

from cleaning.errors import CleaningError
from cleaning.parameters.model import Density, Liquid, Parameters, Provenance, Residue, Word
from specs.spec import Percent, Spec
from specs.yaml.file_kind import FileKind
from specs.yaml.load import parse_spec, read_text, resolve_text

_FILE = Path(__file__).parents[1] / "library" / "chemistries" / "chemistries.yaml"
_ALL = "all"
"""Key of the provenance of every value that has none of its own."""


class Chemistry(Spec):
    """A solution of the library."""

    description: str = Field(min_length=1, description="What it is, for the engineer who chooses it.")
    liquid: Liquid = Field(description="Its values.")
    provenance: dict[str, Provenance] = Field(description="Where each comes from, by key; all covers the others.")

    def known(self, key: str) -> Provenance:
        """Find where a value comes from."""
        return self.provenance.get(key, self.provenance[_ALL])


class Flux(Spec):
    """A liquid flux of the library."""

    description: str = Field(min_length=1, description="What it is.")
    kind: Residue = Field(description="Kind of flux: what solutions must dissolve.")
    solids_pct: Percent = Field(description="What does not evaporate, by weight.")
    density_kg_m3: Density = Field(description="As delivered.")
    provenance: dict[str, Provenance] = Field(description="Where each value comes from; all covers the others.")

    def known(self, key: str) -> Provenance:
        """Find where a value comes from."""
        return self.provenance.get(key, self.provenance[_ALL])

    def solids_g(self, millilitres: float) -> float:
        """Give what a volume of it leaves when it dries."""
        return 1e-5 * self.solids_pct * self.density_kg_m3 * millilitres


class Chemistries(Spec):
    """The library's solutions and fluxes."""

    chemistries: dict[Word, Chemistry] = Field(description="By the name that recipes use.")
    fluxes: dict[Word, Flux] = Field(description="By name.")


_KIND = FileKind(
    "library of chemistries",
    "chemistries:",
    "washboard parameters",
    CleaningError,
    Chemistries,
    dict[str, Path],
    named=frozenset({"chemistries", "fluxes"}),
)


def chemistries() -> dict[str, Chemistry]:
    """Give the library's solutions: name to chemistry, in its order."""
    return _library().chemistries


def fluxes() -> dict[str, Flux]:
    """Give the library's liquid fluxes: name to flux, in its order."""
    return _library().fluxes


@cache
def _library() -> Chemistries:
    return parse_spec(resolve_text(read_text(_FILE, _KIND), _FILE, _KIND), _KIND)


def with_chemistries(parameters: Parameters, solutions: Iterable[str]) -> Parameters:
    """Give the parameters with those solutions that they lack and the library has, each value with its provenance."""
    library = chemistries()
    lacking = {name: library[name] for name in solutions if name not in parameters.liquids and name in library}
    if not lacking:
        return parameters
    known = {
        f"liquids.{name}" if key == _ALL else f"liquids.{name}.{key}": entry
        for name, each in lacking.items()
        for key, entry in each.provenance.items()
    }
    liquids = {**parameters.liquids, **{name: each.liquid for name, each in lacking.items()}}
    return parameters.model_copy(update={"liquids": liquids, "provenance": {**parameters.provenance, **known}})
