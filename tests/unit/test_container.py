"""The container's file names what there is: targets of the Makefile, packages, nothing copied."""


def test_it_builds_and_runs_by_targets_of_the_makefile(repository):
    lines = (repository / "Containerfile").read_text().splitlines()
    targets = {line.split(" ")[0] for line in (repository / "Makefile").read_text().splitlines()}
    assert {"$(VENV)/.run:", "paper:"} <= targets
    assert lines[-3:] == ["RUN make .venv/.run", 'ENTRYPOINT ["make"]', 'CMD ["paper"]']
