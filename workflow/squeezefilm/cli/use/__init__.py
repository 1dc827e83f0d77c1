"""Commands for one force, one model, one study of your own."""

COMMANDS = {
    "new": "begin a study of your own actuator: a commented configuration and an example scan",
    "example-scan": "write a vibrometer's table as the paper's actuator would give it, with noise",
    "simulate": "forces of a table of scenes, or of one scene given by --h0 and --hv",
    "explain": "say what each scene of a table needs and what is left out, without solving",
    "budget": "what the film equation leaves out of each force: inertia, heat, slip, rim, sliding",
    "predict": "forces by a fitted model, from its file alone",
    "working-point": "the amplitude that gives a wanted force, by a fitted model",
    "export": "write a fitted model as a C header or a Python function",
}
