"""The subcommands of ``harness``, a module each, imported when called."""
