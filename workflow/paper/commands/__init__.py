"""Commands for what the paper alone has."""

COMMANDS = {
    "table": "make one of the paper's tables",
    "claims": "compare the paper's claims with the results",
    "equations": "the paper's study beside the same one with inertia",
    "uncertainty": "how far each assumption would have to move to explain a difference",
    "paper-signature": "which numerical shortcuts would give the paper's errors",
}
