"""The base class of all errors that a user can cause and fix."""


class HarnessError(Exception):
    """Bad input or a refusal; the message says what was wrong, where, and what to do.

    The command line prints it to stderr and exits with code 2. Any other exception is a bug in the
    program.
    """


class DomainError(HarnessError):
    """A domain file that cannot be read or is invalid."""


class EpisodeFileError(HarnessError):
    """An episode file that is missing, of the wrong kind, or must not be overwritten."""


class EpisodeSettingsError(HarnessError):
    """Settings with which no episodes can be made."""
