"""Run the command line: ``python -m squeezefilm``."""

from squeezefilm.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
