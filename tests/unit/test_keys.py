"""Each key of a study has a row in the documentation, and its schema takes what a study may."""

from jsonschema import Draft202012Validator

from squeezefilm.config.keys import key_table, schema


def test_every_key_has_a_row():
    for key in ("| **`actuator`** |", "| `profile.wave_number` | 1/m |", "| `gap.tilt_x` | m |"):
        assert key in key_table(schema())


def test_a_circle_has_a_diameter_instead_of_lengths():
    pad, circle = Draft202012Validator(schema()["properties"]["pad"]), {"shape": "circle"}
    assert [pad.is_valid(circle | more) for more in ({"diameter": "30 mm"}, {})] == [True, False]
