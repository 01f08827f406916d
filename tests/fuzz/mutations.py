"""What happens to the bytes of a file: each mutation follows from a random generator alone."""

import re
from collections.abc import Callable

import numpy as np

Random = np.random.Generator

NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
IN_PLACE_OF_NUMBERS = [
    b"nan", b"NaN", b".nan", b"inf", b"-inf", b"Infinity", b"1e400", b"-1e308", b"1e30", b"-1",
    b"0", b"-0.0", b"9" * 400, b"9" * 5000, b"0x7f", b"1_000", b"null", b"true", b"~", b'""',
    b'"7"', b"[]", b"{}", b"[1, 2]", b"7 7", b"", b"\xff", b"\x00", b"*a", b"&a 1",
    b"!!float x", b"2026-99-99",
]  # fmt: skip
WORDS = [0, 1, 2**31 - 1, 2**31, 2**32 - 1, 2**62, 2**63 - 1, 2**64 - 1]


def mutated(content: bytes, random: Random) -> bytes:
    """Return ``content`` after one to three mutations."""
    for _ in range(random.integers(1, 4)):
        content = MUTATIONS[random.integers(len(MUTATIONS))](content, random)
    return content


def _flip_bits(content: bytes, random: Random) -> bytes:
    changed = bytearray(content)
    for place in random.integers(len(content), size=random.integers(1, 9)) if content else []:
        changed[place] ^= 1 << int(random.integers(8))
    return bytes(changed)


def _truncate(content: bytes, random: Random) -> bytes:
    return content[: random.integers(len(content) + 1)]


def _insert(content: bytes, random: Random) -> bytes:
    place = random.integers(len(content) + 1)
    return content[:place] + random.bytes(int(random.integers(1, 17))) + content[place:]


def _remove(content: bytes, random: Random) -> bytes:
    first, last = sorted(random.integers(len(content) + 1, size=2))
    return content[:first] + content[min(last, first + 64) :]


def _repeat(content: bytes, random: Random) -> bytes:
    first, last = sorted(random.integers(len(content) + 1, size=2))
    return content[:last] + content[first:]


def _overwrite_word(content: bytes, random: Random) -> bytes:
    """Write a number of eight bytes, as binary formats keep lengths and offsets."""
    word = int(random.choice(np.array(WORDS, dtype=np.uint64))).to_bytes(8, "little")
    place = int(random.integers(len(content) + 1))
    return content[:place] + word + content[place + 8 :]


def _swap_lines(content: bytes, random: Random) -> bytes:
    lines = content.splitlines(keepends=True)
    if len(lines) > 1:
        one, other = random.integers(len(lines), size=2)
        lines[one], lines[other] = lines[other], lines[one]
    return b"".join(lines)


def _replace_number(content: bytes, random: Random) -> bytes:
    found = list(NUMBER.finditer(content))
    if not found:
        return content
    place = found[random.integers(len(found))]
    value = IN_PLACE_OF_NUMBERS[random.integers(len(IN_PLACE_OF_NUMBERS))]
    return content[: place.start()] + value + content[place.end() :]


MUTATIONS: list[Callable[[bytes, Random], bytes]] = [
    _flip_bits, _truncate, _insert, _remove, _repeat, _overwrite_word, _swap_lines, _replace_number,
    _replace_number, _replace_number,
]  # fmt: skip
