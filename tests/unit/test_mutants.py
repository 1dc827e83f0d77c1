"""The formulas of `make mutants` stand where it makes them wrong, and their tests are there."""

import runpy


def test_every_formula_and_its_tests_are_there(repository):
    mutations = runpy.run_path(str(repository / "tests/mutants.py"))["MUTATIONS"]
    assert len(mutations) == 13
    for name, mutation in mutations.items():
        source = repository / "workflow/squeezefilm" / mutation.file
        assert source.read_text(encoding="utf-8").count(mutation.sound) == 1, name
        for test in mutation.tests:
            file, _, function = test.partition("::")
            text = (repository / file).read_text(encoding="utf-8")
            assert f"def {function.partition('[')[0]}" in text, test
