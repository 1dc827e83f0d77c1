"""Studies with other values of some keys, profiles from keys."""

from typing import Any, TypeVar, get_args

from squeezefilm.config.film import FilmSections
from squeezefilm.config.loading import with_changed_keys
from squeezefilm.film.profiles import Profile, ProfileOfStudy
from squeezefilm.film.surfaces import Surface
from squeezefilm.sections import key_of_name

Sections = TypeVar("Sections", bound=FilmSections)


def changed(config: Sections, **sections: dict[str, Any]) -> Sections:
    """A study with other keys in sections, which may be named as Python does."""
    return with_changed_keys(
        config,
        {
            f"{section}.{key_of_name(name)}": in_file(value)
            for section, keys in sections.items()
            for name, value in keys.items()
        },
    )


def in_file(value: Any) -> Any:
    """A value with the keys that a file has."""
    if not isinstance(value, dict):
        return value
    return {key_of_name(name): in_file(inner) for name, inner in value.items()}


def made_profile(surface: Surface, *, kind: str, **settings: Any) -> Profile:
    """A profile on a surface from the values of a study's keys."""
    (made,) = (each for each in get_args(ProfileOfStudy) if each.kind == kind)
    return made(**settings).on_surface(surface)
