"""The command line: a module per command, by who types it."""
