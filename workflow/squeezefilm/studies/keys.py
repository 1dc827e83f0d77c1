"""The table of a study's keys in config/README.md, made from the schema: ``make keys``."""

import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from squeezefilm.io.errors import InputError
from squeezefilm.studies.config import SCHEMA_PATH

Schema = Mapping[str, Any]
BEGIN = "<!-- From squeezefilm/studies/config.schema.yaml by `make keys`: edit there. -->\n"
END = "<!-- End of the keys. -->\n"
HEAD = "| key | unit | allowed | meaning |\n| --- | --- | --- | --- |\n"


def with_key_table(text: str, schema: Schema) -> str:
    """A text with the table between its two marks made anew.

    Raises InputError when a mark is missing, or a key of the schema has no description.
    """
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise InputError(f"the table of keys belongs between the lines {BEGIN}and {END}")
    return before + BEGIN + "\n" + key_table(schema) + "\n" + END + after


def key_table(schema: Schema) -> str:
    """A row of Markdown for each key: its unit, the values it may have, and what it means."""
    return HEAD + "".join(
        f"| {_shown(path)} | {part.get('unit', '')} | {_allowed(part, schema)} "
        f"| {_meaning(path, part)} |\n"
        for path, part in _keys(schema)
    )


def _keys(part: Schema, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Schema]]:
    """Each key below a part of the schema with the names that lead to it."""
    for name, key in part.get("properties", {}).items():
        if key is not True:  # true: named again where a kind decides which others there are
            yield (*path, name), key
            yield from _keys(key, (*path, name))
    if isinstance(part.get("additionalProperties"), Mapping):
        yield from _keys(part["additionalProperties"], (*path, "NAME"))
    for choice in part.get("allOf", ()):
        ((_, chosen),) = choice["if"]["properties"].items()
        for place, key in _keys(choice["then"], path):
            meaning = key.get("description")
            yield place, {**key, "description": meaning and f"of `{chosen['const']}`: {meaning}"}


def _shown(path: tuple[str, ...]) -> str:
    """A section in bold; of other keys the names below their section."""
    return f"`{'.'.join(path[1:])}`" if len(path) > 1 else f"**`{path[0]}`**"


def _meaning(path: tuple[str, ...], part: Schema) -> str:
    if not part.get("description"):
        raise InputError(f"{SCHEMA_PATH}: {'.'.join(path)} has no description")
    return str(part["description"]).strip().replace("|", "\\|")


def _allowed(part: Schema, schema: Schema) -> str:
    """What the schema demands of a value, in words; nothing for a section."""
    if "$ref" in part:
        part = schema["$defs"][part["$ref"].rpartition("/")[2]]
        inner = part.get("properties", {})
        if inner:
            return "; ".join(f"`{name}` {_allowed(key, schema)}" for name, key in inner.items())
    if "enum" in part:
        return ", ".join(f"`{value}`" for value in part["enum"])
    if "items" in part:
        return f"a list: {_allowed(part['items'], schema)}"
    if "oneOf" in part:
        return " or ".join(_allowed(choice, schema) or "a mapping" for choice in part["oneOf"])
    if part.get("type") in ("number", "integer"):
        return _numbers(part)
    return {"string": "text", "boolean": "`true`, `false`"}.get(part.get("type", ""), "")


def _numbers(part: Schema) -> str:
    low = f"{_number(part['minimum'])} …" if "minimum" in part else "above 0, at most"
    return f"{low} {_number(part['maximum'])}{', whole' if part['type'] == 'integer' else ''}"


def _number(value: float) -> str:
    text = f"{value:.5g}".replace("e-0", "e-").replace("e+0", "e").replace("e+", "e")
    return text.replace("-", "−") if text.startswith("-") else text


def main(path: str) -> None:
    """Make the table in a file anew."""
    schema = yaml.safe_load(SCHEMA_PATH.read_text(encoding="utf-8"))
    file = Path(path)
    file.write_text(with_key_table(file.read_text(encoding="utf-8"), schema), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1])
