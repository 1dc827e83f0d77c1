"""Whether there is a film at all: a gap that stays open, under a finger on the actuator."""

from math import isfinite

import numpy as np

from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.io.errors import InputError

GAPS_M = (1e-9, 1e-3)
SLACK = 1e-9


def check_scenes(scenes: Scenes) -> None:
    """Refuse scenes as ``check_scene`` does, the first of them that has no solution."""
    columns = (scenes.h0_m, scenes.hv_m, scenes.x_m, scenes.y_m)
    sound = np.isfinite(np.stack(columns)).all(axis=0)
    sound &= (GAPS_M[0] <= scenes.h0_m) & (scenes.h0_m <= GAPS_M[1])
    sound &= (scenes.hv_m >= 0) & (scenes.hv_m < scenes.h0_m)
    for film, rows, some in scenes.of_each_film():
        outline = np.array(film.finger.outline())
        x_m, y_m = (np.add.outer(at, outline[:, k]) for k, at in enumerate((some.x_m, some.y_m)))
        sound[rows] &= (film.actuator.surface.reach(x_m, y_m) <= 1 + SLACK).all(axis=1)
    if sound.all():
        sound &= scenes.closure < 1
    for row in np.flatnonzero(~sound).tolist():
        check_scene(scenes[row])


def check_scene(scene: Scene) -> None:
    """Refuse a scene that has no solution or lies off the actuator.

    Raises InputError naming the point, the factor and what is allowed.
    """
    for name in ("h0_m", "hv_m", "x_m", "y_m"):
        if not isfinite(getattr(scene, name)):
            raise InputError(f"point {scene.point_id}: {name} is not a finite number")
    if not GAPS_M[0] <= scene.h0_m <= GAPS_M[1]:
        raise InputError(
            f"point {scene.point_id}: h0_m = {scene.h0_m:g} must lie between {GAPS_M[0]:g} and "
            f"{GAPS_M[1]:g} m: thinner, there is no film of gas, thicker, it is none"
        )
    if scene.hv_m < 0:
        raise InputError(f"point {scene.point_id}: hv_m = {scene.hv_m:g} must not be negative")
    if scene.hv_m >= scene.h0_m:
        raise InputError(
            f"point {scene.point_id}: hv_m = {scene.hv_m:g} reaches h0_m = {scene.h0_m:g}: "
            "surface and finger touch; the amplitude must stay below the mean gap"
        )
    surface, outline = scene.actuator.surface, np.array(scene.finger.outline())
    x_m, y_m = scene.x_m + outline[:, 0], scene.y_m + outline[:, 1]
    reach = surface.reach(x_m, y_m)
    farthest = int(np.argmax(reach))
    if reach[farthest] > 1 + SLACK:
        part = "a corner" if scene.finger.shape == "rectangle" else "the rim"
        raise InputError(
            f"point {scene.point_id}: with its centre at x = {scene.x_m * 1e3:.2f} mm, "
            f"y = {scene.y_m * 1e3:.2f} mm {part} of the finger lies "
            f"{surface.where(x_m[farthest], y_m[farthest])}, off the actuator's {surface.text}"
        )
    if scene.finger.gap.flat and scene.closure() >= 1:
        raise InputError(
            f"point {scene.point_id}: hv_m = {scene.hv_m:g} is so near h0_m = {scene.h0_m:g} that "
            "surface and finger touch within the noise of the measured profile"
        )
    if scene.closure() >= 1:
        raise InputError(
            f"point {scene.point_id}: at h0_m = {scene.h0_m:g}, hv_m = {scene.hv_m:g} the tilted "
            "or bulging finger touches the surface; finger.gap leaves too little there"
        )
