"""Points of a scan on its surface: off it, beyond its edge, about another centre."""

from __future__ import annotations

import difflib
import re
from dataclasses import replace
from decimal import Decimal
from pathlib import Path

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.film.measured.centre import centre_of_symmetry
from squeezefilm.film.measured.mode_fit import ScanPoints, best_mode_fit
from squeezefilm.film.measured.read import read_scan
from squeezefilm.film.measured.scan import (
    SAME_POSITION_DISTANCE_M,
    PointRemedies,
    Scan,
    average_repeated_points,
    limit_point_count,
    turned_to_main_phase,
)
from squeezefilm.film.profiles import ScanFile
from squeezefilm.film.surfaces import Disc, Rectangle, Surface

UNSIGNED_PROBLEM = (
    "the amplitudes have no phase and no sign: across a node line they would be those of another "
    "surface. Give a column phase_deg or sign, or say actuator.profile.sign: unknown if the "
    "surface has no node line"
)
SIGN_COLUMNS = ("phase_deg", "phase_rad", "sign")
# A scan of a smaller share of its surface's radius or half side has another unit, if it fits then;
# and by how much points may miss a surface that is only to be told.
MIN_SCAN_EXTENT_FRACTION, EXTENT_TOLERANCE_FRACTION = 0.1, 0.03
# Points on the edge may lie beyond it by so much, or by the last digit of coordinates up to more.
EDGE_TOLERANCE_FRACTION, MAX_EDGE_TOLERANCE_FRACTION = 1e-3, 0.01
ROUND_OFF_FRACTION = 1e-6
# Digits of a coordinate that are not of its conversion to metres, and the points looked at.
COORDINATE_DIGITS, MAX_POINTS_FOR_DIGITS = 12, 2000
# Origins are proposed in steps of so much.
ORIGIN_STEP_M = 1e-6
# About the middle of their extents, which may be off by half their distance, they miss it by more.
MIDDLE_TOLERANCE_FRACTION = 0.1
# An origin is doubted that is so much further from the shape's centre than this may be off.
MIN_ORIGIN_OFFSET_FRACTION = 0.005


def read_scan_on_surface(
    path: Path, settings: ScanFile, surface: Surface, *, frequency_hz: float
) -> Scan:
    """The points of a scan's file, of which the settings may make a profile.

    Raises InputError naming all that the file or the settings need for it.
    """
    scan = read_scan(
        path,
        frequency_hz=frequency_hz,
        rows=settings.rows,
        origin_m=settings.origin_m,
        remedies=point_remedies(settings, surface),
    )
    check_points(scan, settings, surface)
    return scan


def point_remedies(settings: ScanFile, surface: Surface) -> PointRemedies:
    """Return the texts on what a study must settle about points, "" where it has."""
    settled = settings.axisymmetric or bool(settings.along)
    return PointRemedies(
        on_line=surface.line_scan_problem * (not settled),
        on_one_side=(
            "its points lie on one side of x = 0 or y = 0: if they are a part of the surface, "
            f"{surface.whole_of_part}; if they are all of it, say where its centre is by "
            "actuator.profile.origin"
        )
        * (not settled and settings.origin_m == (0.0, 0.0)),
        unsigned=UNSIGNED_PROBLEM * (settings.sign != "unknown"),
    )


def check_points(scan: Scan, settings: ScanFile, surface: Surface) -> None:
    """Reject a scan with a point off the surface, or whose coordinates or signs are too few."""
    reach = surface.relative_distance(scan.x_m, scan.y_m)
    remedies, along = point_remedies(settings, surface), settings.along
    problems = [remedies.unsigned * (not scan.has_phase_or_sign)]
    problems[0] += _ignored_columns_text(scan) * bool(problems[0])
    at_m = {"x": scan.x_m, "y": scan.y_m}
    on_line = scan.is_radial or (
        isinstance(surface, Rectangle)
        and min(map(np.ptp, at_m.values())) < SAME_POSITION_DISTANCE_M
    )
    problems += [remedies.on_line * bool(on_line)]
    problems += [
        f"the points do not lie along {along} (actuator.profile.along); name their column {along}"
    ] * bool(along and not np.ptp(at_m[along]) > SAME_POSITION_DISTANCE_M)
    problems += [
        f"line {scan.lines[row]}: the point lies "
        f"{surface.position_text(scan.x_m[row], scan.y_m[row])}, off the actuator's "
        f"{surface.text} ({surface.config_key}){_fitting_origin_or_unit_note(scan, surface)}"
        for row in [np.argmax(reach)]
        if reach[row] > 1 + edge_tolerance(scan, surface)
    ]
    if any(problems):
        raise InputError(f"{scan.path}: {'; and '.join(filter(None, problems))}")
    if (
        hint := _fitting_origin_or_unit_note(scan, surface)
        if reach.max() < MIN_SCAN_EXTENT_FRACTION
        else ""
    ):
        raise InputError(
            f"{scan.path}: all points lie at the centre of the {surface.text} "
            f"({surface.config_key}){hint}"
        )


def _ignored_columns_text(scan: Scan) -> str:
    """Columns of the file that were ignored, and which of them may be the phase or the sign."""
    ignored = [note for note in scan.notes if note.startswith("ignored columns")]
    meant = {
        name: near[0]
        for note in ignored
        for name in re.findall("'(.*?)'", note)
        if (near := difflib.get_close_matches(name.lower(), SIGN_COLUMNS, n=1))
    }
    hints = [f"did you mean {column} by {name!r}?" for name, column in meant.items()]
    return "".join(f"; {text}" for text in (*ignored, *hints))


def edge_tolerance(scan: Scan, surface: Surface) -> float:
    """Relative distance by which points on the edge may lie beyond it: by their last digit."""
    drawn, last_digit_m = slice(None, None, -(-len(scan.x_m) // MAX_POINTS_FOR_DIGITS)), 0.0
    for at_m in (scan.x_m + scan.origin_m[0], scan.y_m + scan.origin_m[1]):
        largest = Decimal(np.abs(at_m).max()).adjusted() if np.any(at_m) else -np.inf
        written = [Decimal(f"{value:.{COORDINATE_DIGITS}g}").normalize() for value in at_m[drawn]]
        # The largest has as many digits as any: zeros at the end are not always written.
        digit_count = max(len(value.as_tuple().digits) for value in written)
        last_digit_m = max(last_digit_m, 10.0 ** (largest - digit_count + 1))
    own = last_digit_m / min(surface.half_extents_m)
    return min(max(own, EDGE_TOLERANCE_FRACTION), MAX_EDGE_TOLERANCE_FRACTION)


def edge_note(scan: Scan, surface: Surface) -> list[str]:
    """A note on points beyond the edge, by no more than ``edge_tolerance``."""
    beyond = surface.relative_distance(scan.x_m, scan.y_m) - 1
    count, most_um = int(np.sum(beyond > ROUND_OFF_FRACTION)), 1e6 * min(surface.half_extents_m)
    return [
        f"{count} points up to {most_um * beyond.max():.2g} µm beyond the edge "
        f"({surface.config_key}) are taken for rounded ones on it"
    ] * bool(count)


def origin_note(scan: Scan, surface: Surface) -> list[str]:
    """A note where the shape is symmetric about another position than the origin given."""
    if scan.origin_m == (0.0, 0.0) or not (
        centre := _centre_of_symmetry(scan, np.zeros(2), surface)
    ):
        return []
    offset_m, error_m = centre
    distance_m = float(np.hypot(*offset_m))
    reach = surface.relative_distance(scan.x_m - offset_m[0], scan.y_m - offset_m[1]).max()
    least_m = error_m + MIN_ORIGIN_OFFSET_FRACTION * surface.half_extents_m[0]
    if distance_m <= least_m or reach > 1 + EXTENT_TOLERANCE_FRACTION:
        return []
    x_mm, y_mm = 1e3 * (offset_m + scan.origin_m)
    return [
        f"the shape is symmetric about [{x_mm:.2f} mm, {y_mm:.2f} mm] (± {1e3 * error_m:.1g} mm), "
        f"{1e3 * distance_m:.2f} mm from actuator.profile.origin: if the actuator's centre is "
        "there, write it; no error here contains this"
    ]


def _fitting_origin_or_unit_note(scan: Scan, surface: Surface) -> str:
    """The origin or the unit of positions by which a scan would cover its surface, if any."""
    reach = float(surface.relative_distance(scan.x_m, scan.y_m).max())
    if reach > 1 and (note := _fitting_origin_note(scan, surface)):
        return note
    for factor, text in ((1e3, "1000 times larger"), (1e-3, "1000 times smaller")):
        if MIN_SCAN_EXTENT_FRACTION < factor * reach <= 1 + EXTENT_TOLERANCE_FRACTION:
            return (
                f"; they fit with positions {text}: give their unit as it is (in the header; in a "
                "universal file by data set 164, without which it is m)"
            )
    return ""


def _fitting_origin_note(scan: Scan, surface: Surface) -> str:
    """The origin with which all points lie on the surface: the shape's centre or their middle."""
    positions_m = np.stack([scan.x_m, scan.y_m])
    middle_m = (positions_m.min(axis=1) + positions_m.max(axis=1)) / 2
    half_extents_m = np.ptp(positions_m, axis=1) / 2
    margin_m = float(np.max((surface.half_extents_m - half_extents_m)[half_extents_m > 0]))
    origins = [(middle_m, "the middle of their extents")]
    if margin_m >= ORIGIN_STEP_M:
        doubt = f", which may be {1e3 * margin_m:.2g} mm off: write the actuator's true centre"
        origins = [(middle_m, origins[0][1] + doubt)]
    centre = _centre_of_symmetry(scan, middle_m, surface)
    if centre and centre[1] < margin_m / 2:
        offset_m, error_m = centre
        text = f"where the shape is symmetric (± {max(1e3 * error_m, 1e-3):.1g} mm)"
        origins.insert(0, (middle_m + offset_m, text))
    for position_m, text in origins:
        origin_m = ORIGIN_STEP_M * np.round((position_m + scan.origin_m) / ORIGIN_STEP_M) + 0.0
        x_m, y_m = origin_m - scan.origin_m
        beyond = surface.relative_distance(scan.x_m - x_m, scan.y_m - y_m).max() - 1
        origin_text = "[" + ", ".join(f"{1e3 * each:.6g} mm" for each in origin_m) + "]"
        if beyond <= edge_tolerance(scan, surface):
            return f"; all lie on it with actuator.profile.origin: {origin_text}, {text}"
    own_beyond = surface.relative_distance(scan.x_m, scan.y_m).max() - 1
    if own_beyond <= min(MIDDLE_TOLERANCE_FRACTION, beyond + EXTENT_TOLERANCE_FRACTION):
        return f"; if it ends there, say {surface.enclosing_text(scan.x_m, scan.y_m)}"
    if beyond <= EXTENT_TOLERANCE_FRACTION:
        return (
            f"; about the middle of their extents, {origin_text}, they reach beyond it by "
            f"{beyond:.1%}: say {surface.enclosing_text(scan.x_m - x_m, scan.y_m - y_m)} too"
        )
    exchanged = surface.relative_distance(scan.y_m - y_m, scan.x_m - x_m).max() - 1
    return "; they fit with x and y exchanged" * bool(exchanged <= EXTENT_TOLERANCE_FRACTION)


def _centre_of_symmetry(
    scan: Scan, start_m: np.ndarray, surface: Surface
) -> tuple[np.ndarray, float] | None:
    """The shape's centre of symmetry from a position in the scan, and its error, if it has one."""
    x_m, y_m = scan.x_m - start_m[0], scan.y_m - start_m[1]
    if surface.relative_distance(x_m, y_m).max() > 1 + MIDDLE_TOLERANCE_FRACTION:
        return None
    scan = limit_point_count(average_repeated_points(replace(scan, x_m=x_m, y_m=y_m)))
    measured = turned_to_main_phase(scan.amplitude_m).real
    try:
        of_radius = scan.is_radial and isinstance(surface, Disc)
        points = ScanPoints(surface, "r" * of_radius, scan.x_m, scan.y_m)
        fit = best_mode_fit(points, measured)
    except InputError:
        return None
    return centre_of_symmetry(scan.x_m, scan.y_m, measured, surface, fit.orders)
