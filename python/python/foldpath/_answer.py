"""Answers to long questions."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any, TypeVar, Union

Told = TypeVar("Told", bound="Answer")


class Answer:
    """An answer: its outcome in a word, and why it is not the one that was hoped for."""

    __slots__ = ("_outcome", "_reason", "_text")
    _outcome: str
    _reason: str | None
    # The JSON, or what makes it when it is asked for: it takes about as long as a small plan.
    _text: Union[str, Callable[[], str]]

    def __init__(self, outcome: str, reason: str | None, text: Union[str, Callable[[], str]]) -> None:
        self._outcome = outcome
        self._reason = reason
        self._text = text

    @classmethod
    def _of(cls: type[Told], text: str, *more: Any) -> Told:
        """Make an answer of its JSON."""
        told = json.loads(text)
        return cls(told["outcome"], told["reason"], text, *more)

    @property
    def outcome(self) -> str:
        """The outcome, in a word."""
        return self._outcome

    @property
    def reason(self) -> str | None:
        """Why the outcome is not the best one, in a sentence."""
        return self._reason

    def _json(self) -> str:
        return self._text if isinstance(self._text, str) else self._text()

    def to_dict(self) -> dict[str, Any]:
        """Return the object of the command's ``--json``."""
        told: dict[str, Any] = json.loads(self._json())
        return told

    def __repr__(self) -> str:
        reason = f": {self.reason}" if self.reason else ""
        return f"<foldpath.{type(self).__name__} {self.outcome}{reason}>"
