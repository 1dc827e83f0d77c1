"""The scripts of the workflow's rules: each reads files, calls the library and writes files."""
