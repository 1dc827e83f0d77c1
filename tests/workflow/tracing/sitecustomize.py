"""Note what a process really used: put on PYTHONPATH, it writes a JSON file when Python ends.

The modules loaded, the other files of the library opened, and the sections of the configuration
read, with the command line. Nothing here knows how the workflow finds the code of a command.
"""

import atexit
import importlib.abc
import importlib.machinery
import json
import os
import sys
import uuid

PACKAGES = ("squeezefilm", "verification", "reporting", "paper")

opened: set[str] = set()
sections: set[str] = set()


def watch(event: str, arguments: tuple) -> None:
    if event == "open" and isinstance(arguments[0], str) and "/workflow/" in arguments[0]:
        path = os.path.realpath(arguments[0])
        if not path.endswith((".py", ".pyc")):
            opened.add(path)


class Watching(importlib.abc.MetaPathFinder):
    """Loads the configuration as ever, then notes each section that is asked of a Config."""

    def find_spec(self, name, path, target=None):
        if name != "squeezefilm.studies.config":
            return None
        spec = importlib.machinery.PathFinder.find_spec(name, path)
        execute = spec.loader.exec_module

        def exec_module(module) -> None:
            execute(module)
            read = module.Config.__getitem__

            def getitem(config, section):
                sections.add(section)
                return read(config, section)

            module.Config.__getitem__ = getitem

        spec.loader.exec_module = exec_module
        return spec


def write() -> None:
    loaded = {
        os.path.realpath(module.__file__)
        for name, module in list(sys.modules.items())
        if name.partition(".")[0] in PACKAGES and getattr(module, "__file__", None)
    }
    main = sys.modules["__main__"]
    if loaded and getattr(main, "__file__", None):
        loaded.add(os.path.realpath(main.__file__))
        trace = {
            "arguments": sys.argv[1:],
            "modules": sorted(loaded),
            "opened": sorted(opened),
            "sections": sorted(sections),
        }
        path = os.path.join(os.environ["SQUEEZEFILM_TRACES"], f"{uuid.uuid4()}.json")
        with open(path, "w", encoding="utf-8") as handle:
            json.dump(trace, handle)


if "SQUEEZEFILM_TRACES" in os.environ:
    sys.addaudithook(watch)
    sys.meta_path.insert(0, Watching())
    atexit.register(write)
