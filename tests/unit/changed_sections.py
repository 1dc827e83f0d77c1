"""Studies with other values of some keys."""

from typing import Any, TypeVar

from squeezefilm.config.film import FilmSections, key_of
from squeezefilm.config.loading import with_changes

Sections = TypeVar("Sections", bound=FilmSections)


def changed(config: Sections, **sections: dict[str, Any]) -> Sections:
    """A study with other keys in sections, which may be named as Python does."""
    return with_changes(
        config,
        {
            f"{section}.{key_of(name)}": in_file(value)
            for section, keys in sections.items()
            for name, value in keys.items()
        },
    )


def in_file(value: Any) -> Any:
    """A value with the keys that a file has."""
    if not isinstance(value, dict):
        return value
    return {key_of(name): in_file(inner) for name, inner in value.items()}
