"""The license texts in the wheel."""
import sys
from pathlib import Path

import pytest

WHEEL = Path(__file__).parents[3] / "client" / "python" / "wheel"
sys.path.insert(0, str(WHEEL))
import bundle  # noqa: E402

LIBRARY = Path("/usr/lib/x86_64-linux-gnu/libquadmath.so.0")


@pytest.fixture(autouse=True)
def _debian():
    if not (bundle.COMMON_LICENSES / "LGPL-2.1").exists():
        pytest.skip("this is not Debian")


def test_the_texts_to_which_a_copyright_file_points_are_known():
    text = "License is in `/usr/share/common-licenses/GPL-2'. Or /usr/share/common-licenses/Apache-2.0.\n"
    assert bundle.common_licenses(text) == {"GPL-2", "Apache-2.0"}
    assert {"LGPL", "LGPL-2", "LGPL-2.1", "LGPL-3"} <= bundle.common_licenses("/usr/share/common-licenses/LGPL.")
    assert bundle.common_licenses("/usr/share/common-licenses/nothing") == set()


@pytest.mark.skipif(not LIBRARY.exists(), reason=f"there is no {LIBRARY}")
def test_the_license_of_libquadmath_is_copied_as_a_text(tmp_path):
    bundle.write_licenses([LIBRARY], tmp_path)
    assert (tmp_path / "libquadmath0.copyright").exists()
    assert "GNU LESSER GENERAL PUBLIC LICENSE" in (tmp_path / "LGPL-2.1").read_text()
    assert not any(file.is_symlink() for file in tmp_path.iterdir())
