"""What a study may say, with which defaults: config.schema.yaml, read by all.

Besides JSON Schema's words a key may have a ``unit``, and ``derived``: from what its value follows
where it is not written (derived.py).
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml

Part = Mapping[str, Any]

SCHEMA_PATH = Path(__file__).with_name("config.schema.yaml")
SUFFIXES = {
    "m": "_m",
    "Hz": "_hz",
    "N": "_n",
    "°": "_deg",
    "Pa": "_pa",
    "Pa s": "_pa_s",
    "kg/m³": "_kg_per_m3",
    "m/s": "_m_per_s",
    "1/m": "_per_m",
    "rad/m": "_rad_per_m",
}
"""How a key's name ends by its unit; without it where the value has the unit."""


@lru_cache(maxsize=1)
def raw_schema() -> Part:
    """The schema as it is written, with references to shared parts."""
    # By libyaml, where PyYAML has it: in Python alone it takes as long as all else here.
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    raw: Part = yaml.load(SCHEMA_PATH.read_text(encoding="utf-8"), Loader=loader)
    return raw


@lru_cache(maxsize=1)
def schema() -> Part:
    """The schema with shared parts put in where they are named."""
    raw = raw_schema()

    def inlined(part: Any) -> Any:
        if isinstance(part, list):
            return [inlined(each) for each in part]
        if not isinstance(part, dict):
            return part
        if "$ref" in part:
            part = {**raw["$defs"][part["$ref"].rpartition("/")[2]], **part}
            del part["$ref"]
        return {name: inlined(each) for name, each in part.items()}

    whole: Part = inlined({name: part for name, part in raw.items() if name != "$defs"})
    return whole


def part_for(part: Part, values: Any) -> Part:
    """A part of the schema as it is for some values: their kind decides which keys there are."""
    for choice in part.get("allOf", ()):
        ((name, chosen),) = choice["if"]["properties"].items()
        if isinstance(values, Mapping) and values.get(name) == chosen["const"]:
            keys = {**choice["then"]["properties"], name: part["properties"][name]}
            return {**choice["then"], "properties": keys}
    return part


def part_at(place: tuple[Any, ...], values: Any) -> Part:
    """The part of the schema for a place in some values; empty where there is none."""
    part = schema()
    for name in place:
        part = part_for(part, values)
        inner = part.get("properties", {}).get(name, part.get("additionalProperties"))
        part = part["items"] if isinstance(name, int) and "items" in part else inner
        if not isinstance(part, Mapping):
            return {}
        try:
            values = values[name]
        except (KeyError, IndexError, TypeError):
            values = None
    return part_for(part, values)


def in_si(values: Any, part: Part) -> Any:
    """The values with every number that has its unit, ``15 mm``, in the unit of its key.

    A key may be without its unit, ``length_x: 15 mm``, where each number but zero has its own. What
    is no number with a unit of the right dimension stays as it is, for the schema to refuse.
    """
    part = part_for(part, values)
    if isinstance(values, Mapping):
        keys = part.get("properties", {})
        result = {}
        for name, value in values.items():
            long = next((key for key in keys if short(key, keys[key]) == name), name)
            if name not in keys and long in keys and long not in values:
                converted = in_si(value, keys[long])
                if _all_have_units(value, keys[long]) and not _text_in(converted):
                    result[long] = converted
                    continue
            result[name] = in_si(value, keys[name]) if name in keys else value
        return result
    if isinstance(values, list):
        return [in_si(value, _item(part)) for value in values]
    if isinstance(values, str) and "unit" in part:
        from squeezefilm.io.typed_units import in_unit  # loads NumPy, which a dry run need not

        value = in_unit(values, part["unit"])
        return values if value is None else value
    return values


def short(key: str, part: Any) -> str | None:
    """A key without its unit."""
    suffix = SUFFIXES.get(part.get("unit", ""), "") if isinstance(part, Mapping) else ""
    return key.removesuffix(suffix) if suffix and key.endswith(suffix) else None


def _item(part: Part) -> Part:
    """The part for an item of a list, in the list's unit."""
    own = part.get("items", {})
    return {**own, "unit": part["unit"]} if "unit" in part else own


def _all_have_units(value: Any, part: Part) -> bool:
    """Whether each number that has a unit is written with one, or is zero."""
    if isinstance(value, Mapping):
        keys = part.get("properties", {})
        return all(_all_have_units(each, keys.get(name, {})) for name, each in value.items())
    if isinstance(value, list):
        return all(_all_have_units(each, _item(part)) for each in value)
    return "unit" not in part or isinstance(value, str) or value == 0


def _text_in(value: Any) -> bool:
    """Whether texts are among some values."""
    if isinstance(value, Mapping):
        return any(map(_text_in, value.values()))
    return any(map(_text_in, value)) if isinstance(value, list) else isinstance(value, str)


def filled(values: Any, part: Part) -> Any:
    """Valid values with the schema's defaults put in for what they lack, in the schema's order."""
    part = part_for(part, values)
    if not isinstance(values, Mapping) or "properties" not in part:
        return values
    result = {}
    for name, key in part["properties"].items():
        if name in values:
            result[name] = filled(values[name], key)
        elif "default" in key:
            result[name] = copy.deepcopy(key["default"])
        elif "properties" in key and "required" not in key:
            result[name] = filled({}, key)
    return result


def allowed(part: Part) -> str:
    """What the schema demands of a value, in words; nothing for a section."""
    inner = part.get("properties", {})
    if inner and "levels" in inner:
        return "; ".join(f"`{name}` {allowed(key)}" for name, key in inner.items())
    if "enum" in part:
        return ", ".join(f"`{value}`" for value in part["enum"])
    if "items" in part:
        return f"a list: {allowed(part['items'])}"
    if "oneOf" in part:
        return " or ".join(allowed(choice) or "a mapping" for choice in part["oneOf"])
    if part.get("type") in ("number", "integer"):
        low = f"{shown(part['minimum'])} …" if "minimum" in part else "above 0, at most"
        return f"{low} {shown(part['maximum'])}{', whole' if part['type'] == 'integer' else ''}"
    return {"string": "text", "boolean": "`true`, `false`"}.get(part.get("type", ""), "")


def shown(value: float, *, digits: int = 5) -> str:
    """A limit or a default as it is written in texts."""
    text = f"{value:.{digits}g}".replace("e-0", "e-").replace("e+0", "e").replace("e+", "e")
    return text.replace("-", "−") if text.startswith("-") else text
