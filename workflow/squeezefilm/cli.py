"""The command line: one module of ``squeezefilm.commands`` per command, loaded when called."""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Sequence

from squeezefilm import __version__
from squeezefilm.errors import InputError, RunError
from squeezefilm.runs import job, provenance

COMMANDS = {
    "new": "begin a study of your own actuator: a commented configuration and an example scan",
    "example-scan": "write a vibrometer's table as the paper's actuator would give it, with noise",
    "profile": "smooth a measured vibration profile and weigh its noise",
    "simulate": "forces of a table of scenes, or of one scene given by --h0 and --hv",
    "explain": "say what each scene of a table needs and what is left out, without solving",
    "plan": "write the scenes of a plan",
    "extrapolate": "write the scenes at which fitted models expect a wanted force",
    "gather": "put the simulated parts of a plan together",
    "limits": "the physics limit of each scene, with nothing fitted",
    "limit-table": "the physics limit all over a study's space, as polynomials",
    "fit": "fit an empirical model to forces",
    "design": "find the points at which simulations teach most about a fitted model",
    "optimal": "D-optimal designs with a certificate, and how good other plans are",
    "refine": "simulate, fit, design, until a model is good enough or cannot be",
    "refine-report": "compare what a refinement estimated with points never seen",
    "compare": "fitted models side by side: errors, a table and a map",
    "predict": "forces by a fitted model, from its file alone",
    "working-point": "the amplitude that gives a wanted force, by a fitted model",
    "export": "write a fitted model as a C header or a Python function",
    "validate": "judge a fitted model on simulated forces",
    "figure-data": "build the table that a figure is drawn from",
    "plot": "draw a figure from its table",
    "table": "make one of the paper's tables",
    "cross-section": "gap and pressure along the middle of the finger over a period",
    "uncertainty": "how far each assumption would have to move to explain a difference",
    "explorer": "write a page of HTML in which fitted models can be played with",
    "claims": "compare the paper's claims with the results",
    "work-precision": "error against run time of the solver and of other methods",
    "equal-error": "how many times less time the solver takes than other methods",
    "stability": "stiff and extreme films, each with a verdict",
    "cost": "run time and memory against the size of the problem",
    "conditioning": "how force errors move the fit and the design",
    "paper-signature": "which numerical shortcuts would give the paper's errors",
    "warm": "compile the kernels ahead of time",
    "roofline": "measure the solver's kernels beside the limits of the device",
    "left-out": "put back what scenes do not need: the same forces, at what cost",
    "trace": "say which run, code and device made a result",
    "summary": "put a finished study on one page",
    "runs": "put the runs that made a study on one page",
    "pages": "turn Markdown into pages of HTML",
    "check": "compare a finished study with its stored reference",
    "verdict": "show the table of a check; fails when anything in it failed",
    "reference": "make the reference that a study is checked against",
    "doctor": "check the OpenCL device, caches, lock and versions of this installation",
    "unlock": "remove the lock that a killed run of the workflow left",
    "repair": "find results that are not as they were made",
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; return its exit status: 0 done, 1 could not be completed, 2 bad input."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    parser = argparse.ArgumentParser(
        prog="squeezefilm",
        description="Squeeze-film forces from the Reynolds equation, and empirical models of them.",
        epilog="`squeezefilm COMMAND --help` explains a command.",
    )
    parser.add_argument("--version", action="version", version=f"squeezefilm {__version__}")
    chosen = words[0] if words else ""
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, summary in COMMANDS.items():
        subparser = subparsers.add_parser(
            name, help=summary, formatter_class=argparse.RawDescriptionHelpFormatter
        )
        if name == chosen:
            module = importlib.import_module(f"squeezefilm.commands.{name.replace('-', '_')}")
            subparser.description = module.__doc__
            module.add_arguments(subparser)
            subparser.set_defaults(run=module.run)
    options = parser.parse_args(words)
    try:
        status = int(options.run(options) or 0)
        provenance.finish(words)
        return status
    except job.Superseded as end:
        print(f"squeezefilm: {end}", file=sys.stderr)
        return 0
    except InputError as error:
        return _complain(error, status=2)
    except RunError as error:
        return _complain(error, status=1)
    except BrokenPipeError:
        return 1
    except KeyboardInterrupt:
        print("squeezefilm: interrupted", file=sys.stderr)
        return 130


def _complain(error: Exception, *, status: int) -> int:
    print(f"squeezefilm: error: {error}", file=sys.stderr)
    return status
