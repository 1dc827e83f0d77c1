"""What is found by being in a package: commands, figures, tables, other people's methods."""

import importlib
import pkgutil


def modules_in(package: str) -> dict[str, str]:
    """The dotted names of a package's modules by their own, in order; none of them is imported."""
    path = importlib.import_module(package).__path__
    found = (each.name for each in pkgutil.iter_modules(path) if not each.ispkg)
    return {name: f"{package}.{name}" for name in found}
