"""The exception of the package."""

from __future__ import annotations


class FoldpathError(ValueError):
    """Bad input or usage, in the words of the command line.

    ``file``, ``line`` and ``column`` say where, if it is about a file; ``hint`` says how to correct it, if that is known.
    """

    file: str
    line: int | None
    column: int | None
    hint: str | None

    def __init__(
        self,
        message: str,
        file: str = "",
        line: int | None = None,
        column: int | None = None,
        hint: str | None = None,
    ) -> None:
        super().__init__(message)
        self.file = file
        self.line = line
        self.column = column
        self.hint = hint

    def __reduce__(self) -> tuple[type[FoldpathError], tuple[object, ...]]:
        return FoldpathError, (str(self), self.file, self.line, self.column, self.hint)
