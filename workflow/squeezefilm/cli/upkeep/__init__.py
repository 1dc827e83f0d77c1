"""Commands that look after an installation and its results."""

COMMANDS = {
    "doctor": "check the OpenCL device, caches, lock and versions of this installation",
    "trace": "say which run, code and device made a result",
    "unlock": "remove the lock that a killed run of the workflow left",
    "repair": "find results that are not as they were made",
}
