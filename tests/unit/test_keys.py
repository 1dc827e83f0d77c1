"""The table of keys in config/README.md says what the models say."""

from squeezefilm.config.keys import with_key_table


def test_the_table_is_what_the_models_make_it(repository):
    text = (repository / "config" / "README.md").read_text(encoding="utf-8")
    assert with_key_table(text) == text, "config/README.md: `make keys` makes it anew"
