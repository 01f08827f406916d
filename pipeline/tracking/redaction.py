"""What may be said of an address that has a password in it."""

import re


def without_secrets(text: str) -> str:
    """Return text without the names and passwords in its URLs."""
    text = re.sub(r"(://)[^\s'\"]*@", r"\1***@", text)
    return re.sub(r"(?i)((?:password|passwd|token|secret|key)=)[^&\s'\"]+", r"\1***", text)
