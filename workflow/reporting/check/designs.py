"""Designs, judged by what they are worth and not by where their points lie."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from reporting.check.quantities import Quantity, guarded, text_of
from reporting.check.tolerances import AtMost, Cells, Close, Closeness, Worst
from squeezefilm.config.loading import Config
from squeezefilm.designs.box import coordinates, pair_distances
from squeezefilm.designs.paper_design import d_efficiency
from squeezefilm.io.errors import InputError
from squeezefilm.io.tables import read_design, read_json
from squeezefilm.models.fitted import read_fit
from squeezefilm.models.force_model import get_model
from squeezefilm.studies.plans import box_of

DESIGNS = "designs"
FIT_OF_DESIGN = {
    "two_factor": "screen",
    "four_factor": "four_factor",
    "four_factor_distinct": "four_factor",
}
ROUNDING = 1e-9
LOSS = 1e-3
LETTERS = "ABCDE"
"""Patterns whose searches are counted."""


@dataclass(frozen=True)
class Efficient:
    """Designs that teach as much: D-efficiency beside the reference's, in the reference's model.

    Cells are the parameters (``theta0``) and the points (``point 1 h0_m``).
    """

    model: str
    loss: float = LOSS

    def __str__(self) -> str:
        return f"D-efficiency at least {1 - self.loss:g} of the reference's"

    def efficiency(self, expected: Cells, got: Cells) -> float:
        """(det F′F of one design over that of the other) to the 1/p (see d_efficiency)."""
        model = get_model(self.model)
        theta = [float(expected[name]) for name in model.parameter_names]

        def derivatives(cells: Cells) -> np.ndarray:
            return model.gradient(theta, model.factors(_points(cells, model.factor_names)))

        return d_efficiency(derivatives(got), derivatives(expected))

    def worst(self, expected: Cells, got: Cells) -> Worst:
        """The loss of efficiency; a gain is none."""
        try:
            efficiency = self.efficiency(expected, got)
        except (InputError, ValueError) as error:
            return Worst("D-efficiency", math.inf, ("1", str(error)))
        return Worst(
            "D-efficiency", max(0.0, 1 - efficiency) / self.loss, ("1", f"{efficiency:.6f}")
        )


def _points(cells: Cells, factors: tuple[str, ...]) -> np.ndarray:
    numbers = sorted({int(name.split()[1]) for name in cells if name.startswith("point ")})
    return np.array(
        [[float(cells[f"point {number} {factor}"]) for factor in factors] for number in numbers]
    )


def design_quantities(results: Path, config: Config, closeness: Closeness) -> Iterator[Quantity]:
    """Every design's worth and place in the space, and the patterns that the searches found."""
    for name in FIT_OF_DESIGN:
        yield from guarded(DESIGNS, name, partial(_design, results, name, config))
    yield from guarded(
        DESIGNS, "two-factor searches", partial(_patterns, results / "designs", closeness)
    )


def _design(results: Path, name: str, config: Config) -> Iterator[Quantity]:
    design = read_design(results / "designs" / f"{name}.csv")
    fit = read_fit(results / "fits" / f"{FIT_OF_DESIGN[name]}.json")
    model = get_model(fit.model)
    box = box_of(config, centred=model.is_centred)
    cells = dict(zip(model.parameter_names, map(text_of, fit.theta), strict=True))
    for number, point in enumerate(design.to_dict("records"), start=1):
        cells |= {f"point {number} {factor}": text_of(point[factor]) for factor in box.names}
    yield Quantity(DESIGNS, name, "D-efficiency", cells, Efficient(fit.model))
    points = design[list(box.names)].to_numpy()
    outside = float(np.max(np.abs(box.to_unit(points) - 0.5)) - 0.5)
    yield Quantity(
        DESIGNS,
        name,
        "outside the space",
        {"largest, as a share of the space": f"{max(0.0, outside):.3g}"},
        AtMost(ROUNDING),
    )
    if name == "four_factor_distinct":
        wanted = config["four_factor_design"]["separation"]
        least = float(pair_distances(coordinates("scene", box)(points)).min())
        share = wanted / least if least else math.inf
        yield Quantity(
            DESIGNS,
            name,
            "nearer than wanted",
            {"wanted least distance over that found": f"{share:.9g}"},
            AtMost(1 + ROUNDING),
        )


def _patterns(folder: Path, closeness: Closeness) -> Iterator[Quantity]:
    path = folder / "two_factor.json"
    summary: dict[str, Any] = read_json(path)
    try:
        for scaling, patterns in sorted(summary["scalings"].items()):
            item = f"two-factor searches, {scaling}"
            best = {"least": text_of(patterns[0]["objective"])}
            yield Quantity(DESIGNS, item, "criterion (12)", best, closeness.parameters)
            # Which search ends in which pattern is chance, a rare one may not be met at all: three
            # standard deviations of the difference of two counts, of a share that is never nought.
            searches = summary["searches"]
            found = {pattern["pattern"]: pattern["count"] for pattern in patterns}
            shares = [(count + 1) / (searches + 2) for count in found.values()]
            apart = 3 * max(math.sqrt(2 * searches * share * (1 - share)) for share in shares)
            counts = {letter: str(found.get(letter, 0)) for letter in LETTERS}
            yield Quantity(DESIGNS, item, "searches", counts, Close(absolute=round(apart, 1)))
    except (IndexError, KeyError, TypeError):
        raise InputError(f"{path}: not a summary of two-factor searches") from None
