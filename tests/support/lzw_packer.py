"""A packer as Unix ``compress`` is one, after the description of its format and apart from the reader."""


def compress_lzw(data: bytes, widest: int = 16, clear_every: int = 0) -> bytes:
    """Pack bytes; with ``clear_every`` the table is cleared after so many codes, as ``compress`` does at times."""
    out = bytearray([0x1F, 0x9D, widest | 0x80])
    table, free, width = {bytes([value]): value for value in range(256)}, 257, 9
    codes: list[int] = []

    def flush() -> None:
        """Write the codes of one width; eight of them are full, or the file ends."""
        bits = sum(code << (place * width) for place, code in enumerate(codes))
        out.extend(bits.to_bytes(-(-len(codes) * width // 8), "little"))
        codes.clear()

    def pad() -> None:
        codes.extend([0] * (-len(codes) % 8))

    word, count = b"", 0
    for value in data:
        longer = word + bytes([value])
        if longer in table:
            word = longer
            continue
        codes.append(table[word])
        count += 1
        if clear_every and count % clear_every == 0:
            codes.append(256)
            pad()
            flush()
            table, free, width = {bytes([each]): each for each in range(256)}, 257, 9
        else:
            if free >= 1 << width and width < max(widest, 10):
                pad()
                flush()
                width += 1
            if free < 1 << widest:
                table[longer] = free
                free += 1
        word = bytes([value])
    if word:
        codes.append(table[word])
    flush()
    return bytes(out)
