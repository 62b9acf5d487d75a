"""Only server/convert sees both the messages of the wire and the engine's types."""
from __future__ import annotations

from pathlib import Path

import pytest

from layout import CONVERSION, OTHERS, folder_may
from two_worlds import engine_beside_messages

MESSAGES = ["stiefel/v1/scene.pb.h"]
ENGINE = ["stiefel/scene.h", "stiefel/simulation.h", "stiefel/stop.h", "stiefel/price.h"]


@pytest.mark.parametrize("folder", [folder for folder in OTHERS if folder != CONVERSION])
def test_no_other_folder_may_include_both(folder: str):
    assert not any(folder_may(folder, header) for header in MESSAGES) or \
        not any(folder_may(folder, header) for header in ENGINE)


def test_no_other_file_sees_both():
    assert not (wrong := engine_beside_messages()), "\n".join(map(str, wrong))


@pytest.mark.parametrize("line", [
    '#include "stiefel/summary.h"',
    "  status.set_message(to_sentence(summary.status()));",
])
def test_a_file_that_sees_both_is_found(tmp_path: Path, line: str):
    (tmp_path / "server/calls").mkdir(parents=True)
    (tmp_path / "server/calls/a.cc").write_text(f"void answer(v1::StepResponse*);\n{line}\n")
    assert [str(wrong) for wrong in engine_beside_messages(tmp_path)] == [f"server/calls/a.cc:2: {line}"]
