"""The settings of learned predictors and of their training."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

Layers = Annotated[int, Field(ge=1, le=24)]
Width = Annotated[int, Field(ge=8, le=4096, multiple_of=2)]


class _Settings(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class TransformerSettings(_Settings):
    """The paper's network; the paper's size is 512, 1024, 8, 3, 2, 1, false."""

    kind: Literal["transformer"]
    width: Width
    """Of the layers: the paper's d_model."""
    expanded: Width
    """Channels inside a convolution block: the paper's d_ff."""
    heads: Annotated[int, Field(ge=1, le=64)]
    """Of every attention; they share the width."""
    encoder_layers: Layers
    decoder_layers: Layers
    states_a_row: Literal[1, 2, 3, 4, 5, 6, 10, 12, 15, 20, 30, 60]
    """Future states that one row of the decoder stands for: the paper's is 1."""
    uniform_motion: bool
    """Whether it is told the ball's uniform motion: where that leads, which the decoder reads where
    the future will stand (the paper's reads zeros), and how far each measurement is off it."""

    @model_validator(mode="after")
    def _heads_share_the_width(self) -> "TransformerSettings":
        if self.width % self.heads:
            raise ValueError(f"{self.heads} heads cannot share a width of {self.width}")
        return self


class TaeSettings(_Settings):
    """A trajectory autoencoder; its authors' size is 512, 128, 64, 1024, false."""

    kind: Literal["tae"]
    hidden: Width
    """Of the first layer, of encoder and decoder alike."""
    features: Width
    """Of the second."""
    latent: Width
    """Numbers of the code."""
    decoded: Width
    """Of the layer that joins code and features."""
    uniform_motion: bool
    """Whether it is told how far each measurement is off the ball's uniform motion."""


class GruTaeSettings(_Settings):
    """A recurrent trajectory autoencoder; its authors' size is 64, 16, 128, false."""

    kind: Literal["gru_tae"]
    recurrent: Width
    """Of the first recurrent unit."""
    latent: Width
    """Of the second: numbers of the code."""
    decoded: Width
    """Of the dense layer."""
    uniform_motion: bool
    """Whether it is told how far each measurement is off the ball's uniform motion."""


NetworkSettings = Annotated[
    TransformerSettings | TaeSettings | GruTaeSettings, Field(discriminator="kind")
]
"""Of any network that learns, told apart by its kind."""


class TrainingSettings(_Settings):
    """How networks are trained, on the mean squared error of normalised states."""

    epochs: Annotated[int, Field(ge=1, le=10_000)]
    """In one epoch every training episode gives ``windows_an_episode`` windows, drawn anew."""
    windows_an_episode: Annotated[int, Field(ge=1, le=100)]
    batch: Annotated[int, Field(ge=1, le=65_536)]
    """Windows a step."""
    learning_rate: Annotated[float, Field(gt=0, le=1)]
    """Of the first epoch."""
    matrix_learning_rate: Annotated[float, Field(gt=0, le=1)] | None
    """Of the layers' matrices under Muon, which takes fewer steps than Adam; without one (null)
    Adam trains them like all else, as in the paper."""
    decay: Annotated[float, Field(gt=0, le=1)] | None
    """Factor of the learning rate after every epoch, as in the paper; without one (null) it rises
    over the first steps and then falls to zero along half a cosine."""
    longest_gradient: Annotated[float, Field(gt=0)] | None
    """Norm to which a step's gradient is cut; the paper's is not (null). A ball that hits the net
    would throw a small batch far off."""
    hidden_spin: Annotated[float, Field(ge=0, le=1)]
    """Share of the windows whose spin is hidden from the network, which so learns to do without."""
    precision: Literal["32-true", "bf16-mixed"]
    """Of the arithmetic, as Lightning names it."""
    threads: Annotated[int, Field(ge=1, le=256)]
    """Of the processor. A fixed number, because weights depend on it in their last bits."""
    devices: Annotated[int, Field(ge=1, le=64)] = 1
    """Of one machine that share every batch: GPUs where there are some, else processes with so many
    threads each. Weights depend on it in their last bits, too."""
