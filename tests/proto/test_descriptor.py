"""The proto files as they are break nothing of the committed contract."""
import subprocess

import pytest

from changes import breaking
from descriptor import PROTO, committed, present


def test_nothing_is_broken():
    assert breaking(committed(), present()) == []


def file_of(files, name):
    return next(file for file in files.file if file.name == f"stiefel/v1/{name}.proto")


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
