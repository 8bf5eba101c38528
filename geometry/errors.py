"""The root of every error that stops a job."""


class JobError(Exception):
    """Something in the input stops the job: the message says what, where and what to do.

    Each noun has its own: ``BoardError``, ``RecipeError``, ``ProgramError``. The command line prints the message
    and exits with 2; nothing else in the house may print one as a traceback.
    """
