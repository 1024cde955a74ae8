"""BLAKE2 (RFC 7693) and SHA-256 (FIPS 180-4) without the rest of `hashlib`, whose OpenSSL takes
2 ms to load."""

from __future__ import annotations

import sys
from importlib import import_module

try:
    from _blake2 import blake2b
except ImportError:  # an interpreter without that module
    from hashlib import blake2b

__all__ = ["blake2b", "sha256"]


def sha256(data: bytes) -> bytes:
    """The 32 bytes of SHA-256."""
    try:
        module = import_module("_sha2" if sys.version_info >= (3, 12) else "_sha256")
    except ImportError:
        module = import_module("hashlib")
    digest: bytes = module.sha256(data).digest()
    return digest
