"""Tables of policies, from small reports."""

import pandas as pd

from pipeline.documentation.transfer_tables import shot_quality
from pipeline.io.artifacts import write_csv


def test_shot_quality_has_medians_at_the_nearer_horizons(tmp_path):
    metrics = {"speed": 5.44, "spin": 67.3, "clearance": 0.201, "win_probability": 0.104}
    ends = {f"{name}_{end}": value for name, value in metrics.items() for end in ("low", "high")}
    one = {"set": "receive", "predictor": "oracle", "protocol": "every_tick", "returns": 25.0}
    near, far = ({**one, "horizons_ms": ms, **metrics, **ends} for ms in ("115-125", "170-180"))
    write_csv(tmp_path / "reports/shots/shot_quality/quality.csv", pd.DataFrame([near, far]))
    rows = shot_quality(tmp_path, run="shots/").splitlines()[2:]
    assert rows == [
        "| receive | oracle | every control step | 25 | 5.4 (5.4 to 5.4) | 67 (67 to 67) "
        "| 0.20 (0.20 to 0.20) | 0.10 (0.10 to 0.10) |"
    ]
