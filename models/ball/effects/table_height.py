"""The table's surface is not where the frame says."""

from rallygap.models.ball.effect import Effect, Parameter

effect = Effect(
    name="table_height",
    title="the surface lies higher or lower",
    equation="surface at z = h",
    acts="contact",
    parameters=(
        Parameter("h", unit="m", bounds=(-0.2, 0.2), observed="1-3 mm; one public set 22 mm"),
    ),
)


@effect.adds("table_height")
def table_height(h: float) -> float:
    return h
