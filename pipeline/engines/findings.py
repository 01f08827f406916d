"""What an audit found, with what is read of a scene and compared with another engine."""

from dataclasses import dataclass
from typing import Any

from rallygap.models.audit.audit import Audit
from rallygap.models.audit.traps import Trap
from rallygap.pipeline.engines.audit_text import audit_content, effects_table, outcome, sentence
from rallygap.pipeline.engines.comparison import Comparison
from rallygap.pipeline.engines.scene_audit import SceneAudit
from rallygap.pipeline.web.items import page_table


@dataclass(frozen=True)
class AuditFindings:
    """An audit and what belongs to it.

    Attributes:
        name: of the engine.
        audit: of the engine.
        traps: in it.
        scene: what its file says, where it is a scene.
        comparison: with another engine, if there is one.
    """

    name: str
    audit: Audit
    traps: tuple[Trap, ...]
    scene: SceneAudit | None
    comparison: Comparison | None

    @property
    def lines(self) -> list[str]:
        """What the terminal shows."""
        notes = self.scene.notes if self.scene else ()
        return [
            *outcome(self.name, self.audit, self.traps),
            *(f"Note: {one}" for one in notes),
            *self._compared,
        ]

    @property
    def content(self) -> dict[str, Any]:
        """The content of ``audit.json``."""
        content = audit_content(self.name, self.audit, self.traps)
        if self.scene:
            content |= self.scene.content()
        if self.comparison:
            content["against"] = self.comparison.content()
        return content

    @property
    def page(self) -> dict[str, Any]:
        """What the page shows, but for its figures."""
        scene, comparison = self.scene, self.comparison
        return {
            "name": self.name,
            "traps": [sentence(one) for one in self.traps],
            "outcome": [*outcome(self.name, self.audit, ()), *self._compared],
            "effects": page_table(effects_table(self.audit)),
            "says": page_table(scene.says_and_does(self.audit)) if scene else None,
            "variants": page_table(scene.variants_table()) if scene else None,
            "notes": scene.notes if scene else (),
            "against": page_table(comparison.table(self.audit)) if comparison else None,
        }

    @property
    def _compared(self) -> list[str]:
        return self.comparison.sentences(self.audit) if self.comparison else []
