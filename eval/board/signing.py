"""Ed25519 signatures of lines of the board, by the package `cryptography` (extra `board`)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from rss_gym.eval.board.season import write_private
from rss_gym.eval.reading.plain import RecordError, read_file
from rss_gym.params import ParamsError

OWN = ("signature",)  # fields that the signature does not cover


def _library() -> Any:
    try:
        from cryptography.hazmat.primitives.asymmetric import ed25519
    except ImportError as error:
        raise ParamsError("the board signs what it flies: pip install -e '.[board]'") from error
    return ed25519


def private_key(path: Path) -> bytes:
    """The 32 bytes of the key in a file, which is made if there is none and which only its owner may read."""
    if not path.exists():
        write_private(path, _library().Ed25519PrivateKey.generate().private_bytes_raw().hex().encode())
    try:
        key = bytes.fromhex(read_file(path, 64).decode("ascii"))
        _library().Ed25519PrivateKey.from_private_bytes(key)
    except ValueError as error:
        raise RecordError(f"{path} is no key of the board, 64 hex digits: {error}") from error
    return key


def public_key(key: bytes) -> str:
    """The public key that belongs to a private one, hexadecimal."""
    return str(_library().Ed25519PrivateKey.from_private_bytes(key).public_key().public_bytes_raw().hex())


def signed(content: dict[str, Any], key: bytes) -> dict[str, Any]:
    """The content with `public_key` and `signature`, both hexadecimal."""
    private = _library().Ed25519PrivateKey.from_private_bytes(key)
    whole = content | {"public_key": public_key(key)}
    return whole | {"signature": private.sign(_message(whole)).hex()}


def check_signature(content: dict[str, Any], public_key: str, where: str) -> None:
    """Refuse content that is not what the owner of the key has signed.

    Raises
    ------
    RecordError
    """
    from cryptography.exceptions import InvalidSignature

    try:
        if content["public_key"] != public_key:
            raise ValueError("another key")
        public = _library().Ed25519PublicKey.from_public_bytes(bytes.fromhex(public_key))
        public.verify(bytes.fromhex(content["signature"]), _message(content))
    except (InvalidSignature, KeyError, TypeError, ValueError) as error:
        raise RecordError(
            f"{where}: the signature is not that of key {public_key[:12]}... over this line ({type(error).__name__})"
        ) from error


def _message(content: dict[str, Any]) -> bytes:
    bare = {name: value for name, value in content.items() if name not in OWN}
    return json.dumps(bare, sort_keys=True, separators=(",", ":"), allow_nan=False).encode()
