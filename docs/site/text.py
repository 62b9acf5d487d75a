"""Text for a page in Markdown."""
from __future__ import annotations

import re


def escaped(plain: str) -> str:
    """Plain text in which words in backticks are code, as Markdown: no other character has a meaning."""
    parts = re.split(r"(`[^`]+`)", plain)
    return "".join(part if part.startswith("`") else re.sub(r"([\\*_<>\[\]|#$])", r"\\\1", part) for part in parts)


def fenced(code: str, language: str = "text") -> str:
    return f"```{language}\n{code.rstrip()}\n```\n"
