"""The table of a study's keys in config/README.md, made from the schema: ``make keys``."""

import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

import yaml

from squeezefilm.io.errors import InputError
from squeezefilm.studies.schema import SCHEMA_PATH, Part, allowed, schema, shown

BEGIN = "<!-- From squeezefilm/studies/config.schema.yaml by `make keys`: edit there. -->\n"
END = "<!-- End of the keys. -->\n"
HEAD = "| key | unit | allowed | default | meaning |\n| --- | --- | --- | --- | --- |\n"


def with_key_table(text: str, whole: Part) -> str:
    """A text with the table between its two marks made anew.

    Raises InputError when a mark is missing, or a key of the schema has no description.
    """
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise InputError(f"the table of keys belongs between the lines {BEGIN}and {END}")
    return before + BEGIN + "\n" + key_table(whole) + "\n" + END + after


def key_table(whole: Part) -> str:
    """A row of Markdown for each key: its unit, values, default, and what it means."""
    return HEAD + "".join(
        f"| {_shown(path)} | {part.get('unit', '')} | {allowed(part)} | {_default(part)} "
        f"| {_meaning(path, part)} |\n"
        for path, part in _keys(whole)
    )


def _keys(part: Part, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Part]]:
    """Each key below a part of the schema with the names that lead to it."""
    for name, key in part.get("properties", {}).items():
        if key is not True:  # true: named again where a kind decides which others there are
            yield (*path, name), {"required": [], **key, "needed": name in part.get("required", ())}
            if "unit" not in key:  # ranges, whose keys stand in their row
                yield from _keys(key, (*path, name))
    if isinstance(part.get("additionalProperties"), Mapping):
        yield from _keys(part["additionalProperties"], (*path, "NAME"))
    for choice in part.get("allOf", ()):
        ((_, chosen),) = choice["if"]["properties"].items()
        for place, key in _keys(choice["then"], path):
            meaning = key.get("description")
            yield place, {**key, "description": meaning and f"of `{chosen['const']}`: {meaning}"}


def _default(part: Part) -> str:
    """What a key is where it is not written; that it must be."""
    if "derived" in part:
        return str(part["derived"])
    if "default" in part:
        value = part["default"]
        number = isinstance(value, (int, float)) and not isinstance(value, bool)
        text = shown(value, digits=12) if number else yaml.safe_dump(value, default_flow_style=True)
        return f"`{text.removesuffix('...' + chr(10)).strip()}`"
    inner = part.get("properties", {})
    if "levels" in inner:
        keys = {name: {**key, "needed": name in part["required"]} for name, key in inner.items()}
        return "; ".join(f"`{name}` {_default(key)}" for name, key in keys.items())
    return "to be written" if part.get("needed") else ""


def _shown(path: tuple[str, ...]) -> str:
    """A section in bold; of other keys the names below their section."""
    return f"`{'.'.join(path[1:])}`" if len(path) > 1 else f"**`{path[0]}`**"


def _meaning(path: tuple[str, ...], part: Part) -> str:
    if not part.get("description"):
        raise InputError(f"{SCHEMA_PATH}: {'.'.join(path)} has no description")
    return str(part["description"]).strip().replace("|", "\\|")


def main(path: str) -> None:
    """Make the table in a file anew."""
    file = Path(path)
    file.write_text(with_key_table(file.read_text(encoding="utf-8"), schema()), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1])
