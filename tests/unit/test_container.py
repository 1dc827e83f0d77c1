"""The container's file names what there is: targets of the Makefile, packages, nothing copied."""

import re


def test_it_builds_and_runs_by_targets_of_the_makefile(repository):
    lines = (repository / "Containerfile").read_text().splitlines()
    makefile = (repository / "Makefile").read_text()
    made = re.search(r"^RUN make (\S+)$", "\n".join(lines), re.MULTILINE)
    assert made
    assert re.search(rf"^{re.escape(made[1].replace('.venv', '$(VENV)'))}:", makefile, re.MULTILINE)
    assert lines[-2:] == ['ENTRYPOINT ["make"]', 'CMD ["paper"]']
    assert re.search(r"^paper:", makefile, re.MULTILINE)
