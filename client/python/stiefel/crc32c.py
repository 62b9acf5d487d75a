"""CRC-32C (RFC 3720, appendix B.4); of much data with numpy."""
from __future__ import annotations

import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray

_POLYNOMIAL = 0x82F63B78  # reflected
_FEW = 2048  # bytes; a loop over fewer bytes is faster than numpy
_ONES = 0xFFFFFFFF

Words = NDArray[np.uint32]


def _byte_remainders() -> list[int]:
    remainders = []
    for remainder in range(256):
        for _ in range(8):
            remainder = (remainder >> 1) ^ (_POLYNOMIAL if remainder & 1 else 0)
        remainders.append(remainder)
    return remainders


_TABLE = _byte_remainders()


def crc32c(data: bytes, before: int = 0) -> int:
    """Returns the CRC-32C of `data`. `before` is the CRC-32C of the bytes that precede them:
    crc32c(a + b) == crc32c(b, crc32c(a))."""
    register = before ^ _ONES
    if len(data) >= _FEW:
        register, data = _whole_lanes(data, register)
    for byte in data:
        register = _TABLE[(register ^ byte) & 0xFF] ^ (register >> 8)
    return register ^ _ONES


def _whole_lanes(data: bytes, register: int) -> tuple[int, bytes]:
    """Returns the register after the longest part of `data` that divides into equal lanes, and the remaining bytes,
    fewer than a lane has.

    All lanes advance side by side, four bytes at a time; the first starts from `register`, the others from 0. Then
    neighbours are joined pairwise: the register after a and b is the register after a and as many zero bytes as b has,
    plus the register after b from 0.
    """
    width = 32 if len(data) < 32768 else 64
    lanes = len(data) // width
    words = np.frombuffer(data, "<u4", lanes * width // 4).reshape(lanes, -1).T.copy()
    registers = np.zeros(lanes, np.uint32)
    registers[0] = register
    low, high = _four_zero_bytes()
    for word in words:
        registers ^= word
        registers = low.take(registers & 0xFFFF) ^ high.take(registers >> 16)
    # Lanes with the register 0 in front do not change the result; they fill the number of lanes up to a power of two.
    registers = np.concatenate([np.zeros((1 << (lanes - 1).bit_length()) - lanes, np.uint32), registers])
    length = width
    while len(registers) > 1:
        registers = _append_zeros(registers[0::2], length) ^ registers[1::2]
        length *= 2
    return int(registers[0]), data[lanes * width:]


@functools.lru_cache(maxsize=None)
def _four_zero_bytes() -> tuple[Words, Words]:
    """Returns, for each register with only a lower half and each with only an upper half, the register after four zero
    bytes."""
    tables = _zeros_tables(4)
    halves = np.arange(65536, dtype=np.uint32)
    return (tables[0][halves & 0xFF] ^ tables[1][halves >> 8], tables[2][halves & 0xFF] ^ tables[3][halves >> 8])


def _append_zeros(registers: Words, count: int) -> Words:
    """Returns the registers after `count` zero bytes."""
    tables = _zeros_tables(count)
    after: Words = (tables[0][registers & 0xFF] ^ tables[1][registers >> 8 & 0xFF]
                    ^ tables[2][registers >> 16 & 0xFF] ^ tables[3][registers >> 24])
    return after


@functools.lru_cache(maxsize=None)
def _zeros_tables(count: int) -> Any:
    """Returns a table (4, 256): for each value of each of a register's four bytes alone, the register after `count`
    zero bytes. `count` is a power of two."""
    bytes_alone: Any = np.arange(256, dtype=np.uint32)[None, :] << (8 * np.arange(4, dtype=np.uint32))[:, None]
    if count == 1:
        table = np.array(_TABLE, np.uint32)
        return table[bytes_alone & 0xFF] ^ (bytes_alone >> 8)
    return _append_zeros(_append_zeros(bytes_alone, count // 2), count // 2)
