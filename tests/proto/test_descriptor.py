"""The proto files as they are break nothing of the committed contract, and the test would see it."""
import copy
import subprocess
from pathlib import Path

import pytest

from changes import breaking
from descriptor import PROTO, committed, present, uncommitted


def test_nothing_is_broken():
    assert breaking(committed(), present()) == []


def test_there_is_a_commitment():
    assert {"stiefel/v1/simulation.proto", "stiefel/v1/common.proto"} <= {
        file.name for file in committed().file}


def file_of(files, name):
    return next(file for file in files.file if file.name == f"stiefel/v1/{name}.proto")


def sample(files):
    return next(message for message in file_of(files, "run").message_type if message.name == "Sample")


CHANGES = {
    "a field is gone": lambda files: sample(files).field.pop(1),
    "a field has another type": lambda files: setattr(sample(files).field[0], "type", 13),
    "a message is gone": lambda files: file_of(files, "summary").message_type.pop(),
    "a value is gone": lambda files: file_of(files, "common").enum_type[0].value.pop(),
    "an RPC answers once": lambda files: setattr(
        next(m for m in file_of(files, "simulation").service[0].method if m.name == "Stream"), "server_streaming", False),
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_breaking_change_is_found(change):
    files = copy.deepcopy(present())
    CHANGES[change](files)
    assert breaking(present(), files)


def test_an_addition_breaks_nothing():
    files = copy.deepcopy(present())
    sample(files).field.add(name="more", json_name="more", number=41, type=1, label=1)
    file_of(files, "run").message_type.add(name="PredictRequest")
    file_of(files, "simulation").service[0].method.add(name="Predict", input_type=".stiefel.v1.PredictRequest",
                                                       output_type=".stiefel.v1.PredictRequest")
    assert breaking(present(), files) == []
    assert len(uncommitted(present(), files)) == 3, "a release commits to the field, the message and the RPC"
    assert uncommitted(present(), present()) == []


def test_errors_are_those_of_google_rpc():
    """Names and numbers of google/rpc/status.proto and error_details.proto."""
    messages = {message.name: message for message in file_of(present(), "common").message_type}
    expected = {
        "Status": {"code": 1, "message": 2, "details": 3},
        "BadRequest": {"field_violations": 1},
        "ErrorInfo": {"reason": 1, "domain": 2, "metadata": 3},
        "QuotaFailure": {"violations": 1},
        "RetryInfo": {"retry_delay": 1},
    }
    for name, fields in expected.items():
        assert {field.name: field.number for field in messages[name].field} == fields
    quota, = (nested for nested in messages["QuotaFailure"].nested_type)
    assert {field.name: field.number for field in quota.field} == {"subject": 1, "description": 2}


@pytest.mark.parametrize("language, line", [("java", "package stiefel.v1;"), ("csharp", "namespace Stiefel.V1 {"),
                                            ("php", "namespace Stiefel\\V1"), ("ruby", "module Stiefel")])
def test_every_file_has_the_namespace_of_a_language(language, line, tmp_path):
    """Go alone needs an option for it."""
    ours = [file for file in present().file if file.package == "stiefel.v1"]
    assert len(ours) == len(list((PROTO / "stiefel/v1").glob("*.proto")))
    assert {file.options.go_package for file in ours} == {"stiefel/v1;stiefelv1"}
    subprocess.run(["protoc", f"-I{PROTO}", f"--{language}_out={tmp_path}", *(file.name for file in ours)], check=True)
    sources = [path for path in tmp_path.rglob("*") if path.is_file() and "GPBMetadata" not in path.parts]
    assert sources and all(line in path.read_text() for path in sources)


def test_the_proto_files_are_short():
    for path in Path(__file__).resolve().parents[2].glob("proto/stiefel/v1/*.proto"):
        assert len(path.read_text().splitlines()) <= 200, path.name
