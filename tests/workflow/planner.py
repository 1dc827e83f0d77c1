"""Ask Snakemake, for one edit after another, which files it would make anew.

Reads lines of JSON, {"edits": {path: text}, "arguments": [...]}, and answers each with a line: the
rows of Snakemake's summary. Every question is a fork of one process that has Snakemake loaded, for
most of a dry run's time is loading; the library itself is loaded by each fork anew.
"""

import contextlib
import csv
import importlib
import io
import json
import os
import sys
import tempfile
from pathlib import Path


def ask(arguments: list[str]) -> list[dict[str, str]]:
    """The rows of ``snakemake --detailed-summary``."""
    with tempfile.TemporaryDirectory() as folder:
        output, messages = Path(folder, "output"), Path(folder, "messages")
        child = os.fork()
        if not child:
            with output.open("w") as out, messages.open("w") as err:
                os.dup2(out.fileno(), 1)
                os.dup2(err.fileno(), 2)
                from snakemake.cli import main

                status = 1
                with contextlib.suppress(BaseException):
                    try:
                        main(["--detailed-summary", "--nolock", *arguments])
                        status = 0
                    except SystemExit as end:
                        status = int(end.code or 0)
                sys.stdout.flush()
                sys.stderr.flush()
            os._exit(status)
        _, status = os.waitpid(child, 0)
        if status:
            return [{"error": messages.read_text() + output.read_text()}]
        return list(csv.DictReader(io.StringIO(output.read_text()), delimiter="\t"))


def main() -> None:
    """Answer until there are no more questions."""
    for name in ("numpy", "pandas", "yaml", "jsonschema", "snakemake.cli", "snakemake.workflow"):
        importlib.import_module(name)
    for line in sys.stdin:
        question = json.loads(line)
        before = {}
        for name, text in question["edits"].items():
            path = Path(name)
            before[path] = path.read_bytes()
            path.write_text(text, encoding="utf-8")
        answer = ask(question["arguments"])
        for path, content in before.items():
            path.write_bytes(content)
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
