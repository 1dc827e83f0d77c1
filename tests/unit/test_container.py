"""The container's file names what there is: targets of the Makefile, packages, nothing copied."""

import re


def test_it_builds_and_runs_by_targets_of_the_makefile(repository):
    lines = (repository / "Containerfile").read_text().splitlines()
    targets = {line.split(" ")[0] for line in (repository / "Makefile").read_text().splitlines()}
    assert {"$(VENV)/.run:", "paper:"} <= targets
    assert lines[-3:] == ["RUN make .venv/.run", 'ENTRYPOINT ["make"]', 'CMD ["paper"]']


def test_readme_names_the_packages_that_it_installs(repository):
    """A network's certificates come with any Debian that has a terminal."""
    container, readme = (
        (repository / name).read_text(encoding="utf-8") for name in ("Containerfile", "README.md")
    )
    installed = re.search(r"--no-install-recommends (.*) \\\n", container)[1].split()
    named = re.search(r"`apt install (.*?)`", readme)[1].split()
    assert {*installed} == {*named, "ca-certificates"}
