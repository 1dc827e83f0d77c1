"""The documentation has a row for each key of a study."""

from squeezefilm.config.keys import key_table, schema


def test_every_key_has_a_row():
    table = key_table(schema())
    for key in ("| **`actuator`** |", "| `profile.wave_number` | 1/m |", "| `gap.tilt_x` | m |"):
        assert key in table
