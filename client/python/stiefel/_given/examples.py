"""The scenes that come with the package, by name."""
from __future__ import annotations

import difflib
import json
from pathlib import Path
from typing import Any, Iterator, Mapping

_FOLDER = Path(__file__).parents[1] / "_examples"


class Examples(Mapping[str, Any]):
    """Scenes by name, in SI units: `stiefel.examples["toutatis"]`. Each look-up returns a new dict, which may be changed.

    A name may stand for a scene in every call, as in `stiefel.simulate("toutatis")`. There is a scene for every system,
    by the system's name; "toutatis", an asteroid with an epoch, whose moments are relative to the smallest; "envisat"
    and "tumbling_spacecraft"; "tradeoff", with a tolerance; "rigid_body_8", in eight dimensions. "frames" is no scene but
    the arguments of `Client.geodesics`.
    """

    def __getitem__(self, name: str) -> Any:
        if name not in self:
            raise KeyError(f"no example {name!r}{near(name)}")
        return json.loads((_FOLDER / f"{name}.json").read_text(encoding="utf-8"))

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and name.isidentifier() and (_FOLDER / f"{name}.json").is_file()

    def __iter__(self) -> Iterator[str]:
        return iter(sorted(path.stem for path in _FOLDER.glob("*.json")))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self)

    def __repr__(self) -> str:
        return f"<stiefel.examples: {', '.join(self)}>"


examples = Examples()


def near(name: object) -> str:
    """Returns "; did you mean toutatis?" for a name that is near that of an example, else the names of all."""
    found = difflib.get_close_matches(str(name).lower(), examples, n=3) if isinstance(name, str) else []
    return f"; did you mean {' or '.join(found)}?" if found else f"; the examples are {', '.join(examples)}"
