"""Run the command line: ``python -m squeezefilm``."""

from squeezefilm.cli.main import main

if __name__ == "__main__":
    raise SystemExit(main())
