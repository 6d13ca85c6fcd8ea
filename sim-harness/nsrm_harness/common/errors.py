"""The one family of errors that a person can cause and mend."""


class HarnessError(Exception):
    """Bad input or a refusal: the message says what, where and what to do.

    The command line prints it to stderr and ends with exit code 2. Anything else
    that is raised is a fault of the program.
    """


class DomainError(HarnessError):
    """A domain file that cannot be read or does not make sense."""


class EpisodeFileError(HarnessError):
    """An episode file that is missing, of another kind, or must not be overwritten."""


class EpisodeSettingsError(HarnessError):
    """Settings under which no episodes can be made."""
