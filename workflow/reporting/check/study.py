"""All quantities of a finished study, in the order in which they are judged."""

from pathlib import Path

from reporting.check.designs import design_quantities
from reporting.check.figure_tables import figure_quantities, table_quantities
from reporting.check.pictures import picture_quantities
from reporting.check.quantities import Quantity
from reporting.check.results import (
    claim_quantities,
    fit_quantities,
    numerics_quantities,
    setting_quantities,
    simulation_quantities,
    validation_quantities,
)
from reporting.check.tolerances import Closeness
from squeezefilm.config.loading import Config


def study_quantities(results: Path, config: Config, reference: Path) -> list[Quantity]:
    """What the results in a folder are checked by; config has the sections that decide them.

    ``reference`` is the folder with the pictures to compare theirs with.
    """
    closeness = Closeness(solver=float(config["solver"]["tolerance"]))
    return [
        *setting_quantities(config),
        *figure_quantities(results, closeness),
        *(table_quantities(results, closeness) if config["paper"] else ()),
        *(claim_quantities(results, closeness) if config["paper"] else ()),
        *simulation_quantities(results, config, closeness),
        *fit_quantities(results, config, closeness),
        *design_quantities(results, config, closeness),
        *validation_quantities(results, config, closeness),
        *picture_quantities(results, reference),
        # A reference has a sample of the films; all of them take minutes.
        *(numerics_quantities(results) if config["numerics"]["extent"] == "sample" else ()),
    ]
