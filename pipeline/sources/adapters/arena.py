"""The arena: a simulated environment with a ball cannon and players."""

import numpy as np
import pandas as pd

from rallygap.models.arena.recording import ArenaRecording
from rallygap.models.arena.session import recordings
from rallygap.models.arena.settings import ArenaSettings
from rallygap.models.arena.truth import draw_truth
from rallygap.pipeline.io.schemas import POINTS, POSITION_COLUMNS, SPIN_COLUMNS, STATE_COLUMNS
from rallygap.pipeline.io.source_manifest import Description, PathKind
from rallygap.pipeline.runtime.parallel import parallel
from rallygap.pipeline.sources.source import RawTable, SourceContext, SourceData

KINDS: dict[str, PathKind] = {
    "cannon": "cannon",
    "amateur": "rally",
    "club": "rally",
    "semi_pro": "rally",
    "pro": "rally",
}
POINT_COLUMNS = list(POINTS.columns)[1:]


class Arena:
    """Shots of the cannon and games of four levels, under physics that the seed draws."""

    name = "arena"

    def read(self, context: SourceContext) -> SourceData:
        """Simulate the sessions of the settings; the same seed gives the same recordings.

        Raises:
            InputError: the cluster does not answer, or its scheduler is lost.
        """
        settings, seed = context.settings.arena, context.seed
        truth = draw_truth(seed, settings.physics)
        tables = map(_table, recordings(settings, truth, seed, parallel))
        return SourceData(_describe(settings), tables, truth={"seed": seed, **truth.to_dict()})


def _table(recording: ArenaRecording) -> RawTable:
    numbers = np.arange(1, len(recording.times) + 1)
    samples = np.column_stack([numbers, recording.times, recording.positions, recording.spins])
    rows = pd.DataFrame(samples, columns=["row", "t", *POSITION_COLUMNS, *SPIN_COLUMNS])
    contacts = recording.contacts
    states = np.column_stack([contacts.times, contacts.states])
    true_contacts = pd.DataFrame(states, columns=["t", *STATE_COLUMNS])
    true_contacts.insert(1, "kind", contacts.kinds.astype(object))
    extra_tables = {"true_contacts": true_contacts}
    if recording.points:
        points = [[getattr(point, name) for name in POINT_COLUMNS] for point in recording.points]
        extra_tables["points"] = pd.DataFrame(points, columns=POINT_COLUMNS)
    return RawTable(recording.name, rows, extra_tables=extra_tables)


def _describe(settings: ArenaSettings) -> Description:
    return Description(
        name=Arena.name,
        kind=KINDS,
        spin="per_sample",
        licence="MIT",
        stated_rate_hz=settings.rate_hz,
        note="Synthetic: simulated under physics drawn by the seed, not measured. Errors on it say "
        "how well a predictor knows that physics, and nothing about real balls.",
    )


source = Arena()
