"""The keys of a study's sections: numbers with their unit and limits, texts, lists; their meaning.

A key's meaning stands under ``Attributes`` in the docstring of its section, from which the table in
the documentation and an editor's schema are made (config/keys.py). Names in Python have their unit
(``frequency_hz``); keys in a file have none (``frequency: 43.27 kHz``), and there a number is in SI
units, or degrees, and a text has its unit.

A section that is one of the film's own types is a frozen dataclass with ``__pydantic_config__``:
in a study its values are within limits, in Python they may be any. Others are a ``Section``.
"""

import re
from collections.abc import Hashable, Iterable
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
)
from pydantic.json_schema import PydanticOmit
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from squeezefilm.units import number_in_unit, split_unit

KeyPath = tuple[str | int, ...]
"""The keys, and numbers of a list's items, that lead to a value."""
ItemsT = TypeVar("ItemsT", bound=Iterable[Hashable])


def key_of_name(name: str) -> str:
    """The key in a file of what Python calls ``name``."""
    return split_unit(name)[0]


def error_at_key(
    text: str, *key_path: str, kind: Literal["relation", "missing"] = "relation"
) -> PydanticCustomError:
    """An error at a key further inside than where the validator is that raises it."""
    return PydanticCustomError(kind, "{text}", {"text": text, "place": key_path})


@dataclass(frozen=True)
class BoundedNumber:
    """A number within limits, in SI units or as a text with its unit.

    Attributes:
        unit: SI, or degrees; ``1`` for none.
        open: whether the lower limit itself is not allowed.
    """

    unit: str
    low: float
    high: float
    open: bool = False

    def __get_pydantic_core_schema__(self, source: Any, _: GetCoreSchemaHandler) -> CoreSchema:
        low: dict[str, Any] = {"gt" if self.open else "ge": self.low}
        number = core_schema.float_schema(strict=True, allow_inf_nan=False, le=self.high, **low)
        return core_schema.no_info_before_validator_function(self._value_in_si, number)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        text = {"type": ["number", "string"], "unit": self.unit}  # limits are a number's alone
        return handler(schema) | (text if self.unit != "1" else {})

    def _value_in_si(self, value: Any) -> Any:
        """The value in SI units; as it is where it is no number with such a unit."""
        number = number_in_unit(value, self.unit) if isinstance(value, str) else None
        return value if number is None else number


def _require_unique(values: ItemsT) -> ItemsT:
    if len(set(values)) < len(list(values)):
        raise error_at_key("a value stands twice")
    return values


Length = Annotated[float, BoundedNumber("m", 1e-6, 10)]
GapRise = Annotated[float, BoundedNumber("m", -1e-3, 1e-3)]
DirectionAngle = Annotated[float, BoundedNumber("°", -360, 360)]
Text = Annotated[str, Field(min_length=1, max_length=1000)]
UniqueItems = AfterValidator(_require_unique)
DERIVED_DEFAULT: Any = Field(default=None)
"""Of an optional key: ``default:`` in the docstring says what follows from others."""
NOT_GIVEN: Any = None
"""The same of one of the film's types."""
TermInclusion = Literal["none", "included", "auto"]


def add_key_meanings(schema: dict[str, Any], section: type) -> None:
    """Put what a docstring says of keys to these, in a section's JSON schema, in their order.

    The ``kind`` tells profiles apart, and is to be written.
    """
    keys, order = schema.get("properties", {}), list(map(key_of_name, section.__annotations__))
    if keys.keys() <= set(order):  # pydantic puts those last that Python takes by name alone
        schema["properties"] = {name: keys[name] for name in order if name in keys}
    if "kind" in keys:
        del keys["kind"]["default"]
        schema["required"] = ["kind", *schema.get("required", ())]
    about, _, attributes = schema.get("description", "").partition("\n\nAttributes:\n")
    schema["description"] = " ".join(about.partition("\n\n")[0].split())
    for name, meaning in re.findall(r"^    (\w+): (.*(?:\n {8}.*)*)", attributes, re.MULTILINE):
        key = schema["properties"][key_of_name(name)]
        key["description"], _, words = " ".join(meaning.split()).partition("; default: ")
        key |= {"derived": words} if words else {}


SECTION_CONFIG = ConfigDict(
    extra="forbid",
    alias_generator=key_of_name,
    defer_build=True,
    json_schema_extra=add_key_meanings,
)


class Section(BaseModel):
    model_config = SECTION_CONFIG


@dataclass(frozen=True)
class NotAKey:
    """Marks an attribute of one of the film's types that no file has."""

    def __get_pydantic_core_schema__(self, source: Any, _: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(_refuse_key)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        raise PydanticOmit


def _refuse_key(value: Any) -> Any:
    raise PydanticCustomError("extra_forbidden", "Extra inputs are not permitted")


ValueT = TypeVar("ValueT")
InternalAttribute = Annotated[ValueT, NotAKey(), Field(exclude=True)]
