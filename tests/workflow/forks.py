"""Run Snakemake for one question after another, each in a fork of a process that has it loaded.

Most of a dry run's time is loading. Reads lines of JSON, {"folder": ..., "arguments": [...],
"environment": {...}, "output": ...}, and answers each with a line: the exit status. What is printed
goes to the file "output". The library itself is loaded by each fork anew, from its checkout.
"""

import importlib
import json
import os
import runpy
import sys
import traceback

# What Snakemake loads for a workflow, that is no part of this repository.
LOADED = (
    *("numpy", "pandas", "pydantic", "jsonschema", "nbformat", "requests", "docutils.core"),
    *("smart_open", "yte", "snakemake.cli", "snakemake.workflow", "snakemake.report"),
)


def run(folder: str, arguments: list[str], environment: dict[str, str], output: str) -> int:
    """The exit status of ``python -m snakemake`` in a folder, in this process."""
    file = os.open(output, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    for stream in (1, 2):
        os.dup2(file, stream)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.path[0] = folder
    sys.argv[1:] = arguments
    try:
        runpy.run_module("snakemake", run_name="__main__", alter_sys=True)
    except SystemExit as end:
        return int(end.code or 0)
    except BaseException:
        traceback.print_exc()
        return 1
    return 0


def main() -> None:
    """Answer until there are no more questions."""
    for name in LOADED:
        importlib.import_module(name)
    for line in sys.stdin:
        child = os.fork()
        if not child:
            status = run(**json.loads(line))
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(status)
        _, status = os.waitpid(child, 0)
        print(os.waitstatus_to_exitcode(status), flush=True)


if __name__ == "__main__":
    main()
