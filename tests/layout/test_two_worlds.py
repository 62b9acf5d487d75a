"""Only server/convert sees both the messages of the wire and the engine's types."""
from __future__ import annotations

from pathlib import Path

import pytest

from layout import CONVERSION, OTHERS, folder_may
from two_worlds import engine_beside_messages, engine_names

MESSAGES = ["stiefel/v1/scene.pb.h"]
ENGINE = ["stiefel/scene.h", "stiefel/simulation.h", "stiefel/stop.h", "stiefel/price.h"]


def test_the_conversion_may_include_both():
    assert all(folder_may(CONVERSION, header) for header in [*MESSAGES, "stiefel/scene.h"])


@pytest.mark.parametrize("folder", [folder for folder in OTHERS if folder != CONVERSION])
def test_no_other_folder_may_include_both(folder: str):
    assert not any(folder_may(folder, header) for header in MESSAGES) or \
        not any(folder_may(folder, header) for header in ENGINE)


def test_no_other_file_sees_both():
    assert not (wrong := engine_beside_messages()), "\n".join(map(str, wrong))


def test_the_names_of_the_engine_are_found():
    assert {"Scene", "Simulation", "Summary", "Violations", "Stopped", "diagnose", "to_sentence"} <= engine_names()
    assert len(engine_names()) > 60


@pytest.mark.parametrize("line", [
    '#include "stiefel/summary.h"',
    "  status.set_message(to_sentence(summary.status()));",
])
def test_a_file_that_sees_both_is_found(tmp_path: Path, line: str):
    (tmp_path / "server/calls").mkdir(parents=True)
    (tmp_path / "server/calls/a.cc").write_text(f"void answer(v1::StepResponse*);\n{line}\n")
    assert [str(wrong) for wrong in engine_beside_messages(tmp_path)] == [f"server/calls/a.cc:2: {line}"]


@pytest.mark.parametrize("line", ["// A Scene of a Summary.", "  v1::Scene scene = request.scene();"])
def test_what_a_call_may_say(tmp_path: Path, line: str):
    (tmp_path / "server/calls").mkdir(parents=True)
    (tmp_path / "server/calls/a.cc").write_text(f"void answer(v1::StepResponse*);\n{line}\n")
    assert engine_beside_messages(tmp_path) == []
