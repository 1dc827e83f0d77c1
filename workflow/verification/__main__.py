"""Run one of this package's commands: ``python -m verification``, installed or not."""

from squeezefilm.cli.main import main

if __name__ == "__main__":
    raise SystemExit(main(packages=("verification.commands",)))
