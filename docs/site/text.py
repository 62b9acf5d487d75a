"""Text for a page in Markdown."""
from __future__ import annotations

import re


def escaped(plain: str) -> str:
    """Plain text in which words in backticks are code, as Markdown: no other character has a meaning."""
    parts = re.split(r"(`[^`]+`)", plain)
    return "".join(part if part.startswith("`") else re.sub(r"([\\*_<>\[\]|#$])", r"\\\1", part) for part in parts)


def paragraphs(plain: str) -> str:
    """Plain text as Markdown: paragraphs that are indented are code, and nothing in the others but backticks has a meaning."""
    return "\n".join(fenced(part) if part.startswith("    ") else escaped(part) + "\n"
                     for part in re.split(r"\n[ \t]*\n", plain.strip("\n")))


def fenced(code: str, language: str = "text") -> str:
    return f"```{language}\n{code.rstrip()}\n```\n"
