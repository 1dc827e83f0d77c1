"""What a study's scan leaves open of its forces, as `squeezefilm profile` found it."""

from squeezefilm.config.loading import Config
from squeezefilm.io.errors import InputError
from squeezefilm.io.tables import read_json
from squeezefilm.models.fit_file import number


def scan_error_of(config: Config, summary: str | None) -> float:
    """The largest share of a force that the scan of the study's profile leaves open, 0 without one.

    Args:
        summary: the file that `squeezefilm profile` wrote.

    Raises InputError for a study with a scan and no summary, a summary and no scan, or a file that
    is none.
    """
    if config["actuator"]["profile"]["kind"] == "measured":
        if summary is None:
            raise InputError(
                f"{config.path}: its profile is measured; give --scan SUMMARY.json, which "
                "`squeezefilm profile` writes: what the scan leaves open is part of the fit's error"
            )
        return number(read_json(summary), "largest_force_error_share", summary)
    if summary is not None:
        raise InputError(f"--scan {summary}: the profile of {config.path} is not measured")
    return 0.0
