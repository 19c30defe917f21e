"""Documents as editors write them."""

import pytest

from wucht.errors import InputError
from wucht.files.catalogue import load_machine
from wucht.files.documents import read_toml


def test_a_byte_order_mark_is_no_part_of_a_file(tmp_path):
    """Windows editors put one before UTF-8 text."""
    path = tmp_path / "machine.toml"
    path.write_bytes(b'\xef\xbb\xbftitle = "\xc3\x9cbung"\r\n[machine]\r\nuse = "drozdetskaya-2020/table-5.1"\r\n')
    assert read_toml(path)["title"] == "\u00dcbung"
    assert load_machine(str(path)).values["u"] == load_machine("drozdetskaya-2020/table-5.1").values["u"]


@pytest.mark.parametrize("encoding", ["utf-16", "latin-1"])
def test_another_encoding_is_refused_with_a_remedy(tmp_path, encoding):
    path = tmp_path / "machine.toml"
    path.write_text('title = "\u00dcbung"', encoding=encoding)
    with pytest.raises(InputError, match="it is not UTF-8 text; save it as UTF-8"):
        read_toml(path)
