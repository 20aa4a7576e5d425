"""The base class of the package's own errors.

The package raises such an error for every request that it cannot meet.
"""


class DubinsStudyError(Exception):
    """A request that cannot be met.

    The message names the file or field, its value, what was expected and what to do. Any other
    exception that leaves the package is a bug.
    """
