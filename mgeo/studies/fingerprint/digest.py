"""One digest of several parts."""

from __future__ import annotations

import hashlib


def mix(*parts: str | bytes) -> bytes:
    """SHA-256 of texts and digests, which are told apart by their lengths."""
    digest = hashlib.sha256()
    for part in parts:
        data = part.encode("utf-8", "surrogatepass") if isinstance(part, str) else part
        digest.update(len(data).to_bytes(8, "big"))
        digest.update(data)
    return digest.digest()
