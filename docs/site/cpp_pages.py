"""Makes a page of every public header: each declaration of a namespace with the comment before it.

It knows the style of these headers (clang-format, `///` before what it describes) and no more of C++.
"""
from __future__ import annotations

import re
from pathlib import Path
from typing import Iterator, NamedTuple

from text import escaped, fenced, paragraphs

# A line that begins nothing of its own: a declaration without a definition, or the definition of a member.
_SKIPPED = re.compile(r"^(#|namespace |}  // namespace|class \w+;|struct \w+;|enum class \w+( : [\w:]+)?;|extern template|static_assert|using \w+::"
                      r"|inline [\w:&* ]+::\w+\()")
_NAME = re.compile(r"^(?:template .*\n)*(?:class|struct|enum class|using|concept|inline constexpr (?:const )?[\w:<>*]+|constexpr (?:const )?[\w:<>*]+) (\w+)"
                   r"|(?:^|[\s&*])(operator\S+|\w+)\(", re.MULTILINE)
_BODY = re.compile(r"^(\s*)(.*\)(?: const| noexcept| override)*(?: ?:.*)?) \{$")


class Declaration(NamedTuple):
    comment: str
    code: str

    @property
    def name(self) -> str:
        found = _NAME.search(self.code)
        return (found[1] or found[2]) if found else ""


def declarations(header: str) -> Iterator[Declaration]:
    """The declarations at the level of a namespace. Those without a comment join the one before them."""
    comment: list[str] = []
    code: list[str] = []
    depth = 0
    for line in header.splitlines():
        if not code and line.startswith("//"):
            comment.append(line.lstrip("/").removeprefix(" ") if line.startswith("///") else "")
            continue
        if not code and (not line or _SKIPPED.match(line)):
            comment = comment if line and not line.startswith(("#", "namespace", "}")) else []
            continue
        code.append(line)
        plain = re.sub(r'"(?:[^"\\]|\\.)*"|//.*', "", line)
        depth += plain.count("{") + plain.count("(") - plain.count("}") - plain.count(")")
        if depth == 0 and plain.rstrip().endswith((";", "}")):
            yield Declaration("\n".join(comment).strip(), "\n".join(code))
            comment, code = [], []


def public(code: str) -> str:
    """A declaration without its private part and without the bodies of functions."""
    kept: list[str] = []
    hidden, body = False, ""
    for line in code.splitlines():
        if body:
            body = "" if line == body else body
            continue
        if re.match(r"^ (public|private|protected):", line):
            hidden = "private" in line
        if line.startswith("}"):
            hidden = False
        if hidden:
            continue
        if (found := _BODY.match(line)) and not re.match(r"\s*(struct|class|enum|union)\b", line):
            body = found[1] + "}"
            kept.append(f"{found[1]}{found[2]};")
        else:
            kept.append(line)
    return "\n".join(kept)


def page(path: Path, name: str) -> str:
    parts = [f"# {name}\n", fenced(f'#include "{name}"', "cpp")]
    seen = ""
    for one in declarations(path.read_text(encoding="utf-8")):
        if one.comment or one.name != seen:
            if one.name and one.name != seen:
                parts.append(f"## {escaped(one.name)}\n")
            if one.comment:
                parts.append(paragraphs(one.comment))
            seen = one.name
        parts.append(fenced(public(one.code), "cpp"))
    return "\n".join(parts)


def write(folders: dict[str, Path], folder: Path) -> None:
    """`folders`: the folder of headers by the words that the first page has for it."""
    lines = ["# C++\n"]
    for words, headers in folders.items():
        include = headers.parents[len(headers.parts) - 1 - headers.parts.index("include") - 1]
        lines += [f"## {words}\n", "```{toctree}"]
        for header in sorted(headers.glob("*.h")):
            name = str(header.relative_to(include))
            target = name.removesuffix(".h").replace("/", "_")
            (folder / f"{target}.md").write_text(page(header, name), encoding="utf-8")
            lines.append(target)
        lines.append("```\n")
    (folder / "index.md").write_text("\n".join(lines), encoding="utf-8")
