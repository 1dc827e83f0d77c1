"""A job as Snakemake hands it to a script, so that the script can be stepped through."""

from types import SimpleNamespace
from typing import Any

from snakemake.iocontainers import InputFiles, OutputFiles, Params, Wildcards


def mock_snakemake(
    *,
    output: dict[str, Any],
    input: dict[str, Any] | None = None,
    params: dict[str, Any] | None = None,
    threads: int = 1,
    **wildcards: str,
) -> SimpleNamespace:
    """Return a job with the inputs, outputs and parameters of a rule, by their names.

    ``main(mock_snakemake(output={"scenes": "scenes.csv"}, plan="screen"), load_config(STUDY))``
    runs the ``main`` of a script in a debugger, its output on the terminal.
    """
    return SimpleNamespace(
        input=InputFiles(fromdict=input or {}),
        output=OutputFiles(fromdict=output),
        params=Params(fromdict=params or {}),
        threads=threads,
        wildcards=Wildcards(fromdict=wildcards),
    )
