"""BLAKE2 (RFC 7693), without the other digests of `hashlib`: loading OpenSSL for these takes
2 ms of every command's start."""

from __future__ import annotations

try:
    from _blake2 import blake2b
except ImportError:  # an interpreter without that module
    from hashlib import blake2b

__all__ = ["blake2b"]
