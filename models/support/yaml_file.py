"""YAML files, parsed the way DVC parses them: version 1.2, where ``1e-3`` is a number."""

from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError
from ruamel.yaml.events import AliasEvent, CollectionEndEvent, CollectionStartEvent

MOST_ALIASES = 20  # of a file; a few lines of aliases may expand without end
DEEPEST = 100  # levels of nesting


class YamlFileError(ValueError):
    """A file that is missing or is not YAML."""


def parse_yaml(text: str) -> Any:
    """Parse YAML without duplicate keys.

    Raises:
        YAMLError: it is not YAML.
        ValueError: a value is invalid, such as a date in month 99, or there are too many aliases or
            levels of nesting.
    """
    aliases = depth = 0
    for event in YAML(typ="safe").parse(text):
        aliases += isinstance(event, AliasEvent)
        depth += isinstance(event, CollectionStartEvent) - isinstance(event, CollectionEndEvent)
        if aliases > MOST_ALIASES:
            raise ValueError(f"parts repeat others; write out all but {MOST_ALIASES}")
        if depth > DEEPEST:
            raise ValueError(f"parts stand in more than {DEEPEST} others")
    return YAML(typ="safe").load(text)


def load_yaml(path: Path) -> Any:
    """Read a YAML file; see ``parse_yaml``.

    Raises:
        YamlFileError: the file is missing or is not YAML; the message does not name the file.
    """
    try:
        return parse_yaml(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise YamlFileError("there is no such file") from None
    except OSError as error:
        raise YamlFileError(f"cannot be read: {error.strerror}") from None
    except (YAMLError, ValueError, RecursionError) as error:  # such as a date in a month 99
        reason = " ".join(str(error).split())
        raise YamlFileError(f"is not YAML: {reason}") from None
