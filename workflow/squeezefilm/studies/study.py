"""Film, scenes and symmetry of a study's configuration."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from math import atan2, degrees, hypot
from typing import TYPE_CHECKING, Any

import numpy as np

from squeezefilm.config.film import FilmSections
from squeezefilm.errors import InputError, point_text, prefix_errors, raise_row_problems
from squeezefilm.film.positions import POLAR_COLUMNS, cartesian_from_polar, columns_in_table_form
from squeezefilm.film.profiles import Profile
from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.film.symmetry import DirectionSector
from squeezefilm.film.validity import check_pad_fits, check_scene, check_scenes
from squeezefilm.lazy import pd
from squeezefilm.tables import FACTOR_COLUMNS, read_measurements

if TYPE_CHECKING:
    from squeezefilm.config.study import Study


def film_values(config: FilmSections, *, absent_terms: Iterable[str]) -> dict[str, Any]:
    """The study's film as far as limits of validity and the pad's room go, for a fit's file.

    Args:
        absent_terms: of the simulations, a text each; a term that is ``auto`` is included where
            one of them has it.
    """
    gas, solved = asdict(config.gas), list(absent_terms)
    for term in ("inertia", "thermal"):
        if gas[term] == "auto":
            gas[term] = (
                "none" if all(term in terms_absent for terms_absent in solved) else "included"
            )
    pad = config.pad
    return {
        "gas": gas,
        "frequency_hz": config.actuator.frequency_hz,
        "surface": asdict(config.actuator.surface),
        "pad": {
            "length_x_m": pad.length_x_m,
            "length_y_m": pad.length_y_m,
            "gap": asdict(pad.gap),
            "edge_points_m": pad.edge_points_m().tolist(),
        },
    }


def scenes_of_table(
    table: pd.DataFrame | Mapping[str, Sequence[float]],
    config: FilmSections,
    *,
    profile: Profile | None = None,
) -> Scenes:
    """The scenes of a table on the study's film.

    Args:
        table: ``h0_m``, ``hv_m`` and a position in polar or Cartesian form, at the centre where it
            has none; ``point_id``, or else rows are numbered from 1.
        profile: stands in for the study's own.

    Raises InputError naming the points and the factors that have no physical meaning.
    """
    if missing := [name for name in FACTOR_COLUMNS[:2] if name not in table]:
        raise InputError(f"points need the column {missing[0]!r}")
    names, centre = columns_in_table_form(FACTOR_COLUMNS, table), np.zeros(len(table["h0_m"]))
    h0_m, hv_m, x_m, y_m = (np.asarray(table.get(name, centre), dtype=float) for name in names)
    numbered = table.get("point_id", np.arange(1, len(centre) + 1))
    point_id = np.array(list(map(str, numbered)), dtype=object)
    if POLAR_COLUMNS[0] in names:
        raise_row_problems(
            [
                f"{point_text(point_id[row])}: phi_r_m = {x_m[row]:g} must not be negative"
                for row in np.flatnonzero(x_m < 0)
            ]
        )
        x_m, y_m = cartesian_from_polar(x_m, y_m).values()
    scenes = config.read_film(profile=profile).scenes(h0_m, hv_m, x_m, y_m)
    scenes = replace(scenes, point_id=point_id)
    check_scenes(scenes)
    return scenes


def scene_of_study(
    config: FilmSections, h0_m: float, hv_m: float, *, x_m: float = 0.0, y_m: float = 0.0
) -> Scene:
    """One scene on the study's film.

    Raises InputError as ``scenes_of_table`` does.
    """
    scene = config.read_film().scene(h0_m, hv_m, x_m=x_m, y_m=y_m)
    check_scene(scene)
    return scene


def check_film(config: FilmSections) -> Profile:
    """Check pad, surface and mode shape; return the mode shape as far as plans need it.

    Of a scan the points: the rule `smooth` reports an invalid smooth profile through them.

    Raises InputError naming the section that is invalid.
    """
    with prefix_errors(config.path):
        check_pad_fits(config.read_pad(), config.actuator.surface)
        if path := config.scan_path:
            from squeezefilm.film.measured.placement import read_scan_on_surface

            read_scan_on_surface(path, **config.smoothing_arguments)
        return config.profile_for_planning()


def check_study(config: Study) -> Study:
    """Check every pad position and film of a study before anything is simulated.

    Raises InputError naming the section and the point that has no physical meaning.
    """
    profile = check_film(config)
    if config.measurements:
        measured_force_table(config, profile=profile)
    for section, points in _extreme_points_by_section(config):
        with prefix_errors(f"{config.path}: {section}"):
            scenes_of_table(points, config, profile=profile)
    return config


def measured_force_table(config: Study, *, profile: Profile | None = None) -> pd.DataFrame:
    """Return the table of measured forces of a study that has one.

    Args:
        profile: stands in for the study's own where the points are checked.

    Raises InputError for a study without one, a wrong table, and for a point that is no film within
    its uncertainties.
    """
    if not config.measurements:
        raise InputError(f"{config.path}: there is no section measurements: {{file: TABLE.csv}}")
    path = config.path.parent / config.measurements.file
    table = read_measurements(path)
    for sign, within in zip((0, -1, 1), ("", *[" with its uncertainties"] * 2), strict=True):
        h0_m = table["h0_m"] + sign * table["h0_uncertainty_m"]
        hv_m = table["hv_m"] - sign * table["hv_uncertainty_m"]
        ends = table.assign(h0_m=h0_m, hv_m=hv_m, point_id=table["point_id"] + within)
        with prefix_errors(path):
            scenes_of_table(ends, config, profile=profile)
    return table


def _extreme_points_by_section(config: Study) -> Iterator[tuple[str, pd.DataFrame]]:
    """The points of a study at which a film may fail to exist, by section."""
    screen, extrapolation = config.screen, config.extrapolation
    closest = {"h0_m": screen.h0_m.start, "hv_m": screen.hv_m.stop}
    yield "screen", pd.DataFrame([{"point_id": "smallest gap, largest amplitude", **closest}])
    beyond = extrapolation.model_dump(include={"h0_m", "hv_m"})
    yield "extrapolation", pd.DataFrame([{"point_id": "wanted", **beyond}])
    symmetry, positions = config.symmetry(), config.positions
    pad_positions = symmetry.pad_positions(positions)
    if isinstance(symmetry, DirectionSector):
        # Designs and control points may lie between the directions given: also where the pad's
        # farthest point is farthest out.
        x_m, y_m = max(config.read_pad().edge_points_m().tolist(), key=lambda point: hypot(*point))
        farthest = float(symmetry.fold_directions(degrees(atan2(y_m, x_m))))
        pad_positions += [(radius, farthest) for radius in positions.phi_r_m]
    first, second = symmetry.position_columns
    names = [f"({first} = {one:g}, {second} = {other:g})" for one, other in pad_positions]
    table = pd.DataFrame(pad_positions, columns=[first, second])
    yield "positions", table.assign(point_id=names, **closest)
