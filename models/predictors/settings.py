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
    states_per_row: Literal[1, 2, 3, 4, 5, 6, 10, 12, 15, 20, 30, 60]
    """Future states per decoder row, 1 in the paper; more make training faster."""
    uniform_motion: bool
    """Whether the network reads the ball's uniform motion: as the decoder's placeholders (zeros in
    the paper), and as the residual of each measurement from it."""

    @model_validator(mode="after")
    def _heads_share_the_width(self) -> "TransformerSettings":
        if self.width % self.heads:
            raise ValueError(f"{self.heads} heads cannot share a width of {self.width}")
        return self


class HybridSettings(TransformerSettings):
    """A transformer that corrects the forecast of a simulator; its error counts by Huber's loss."""

    kind: Literal["hybrid"]  # type: ignore[assignment]
    simulator: Annotated[str, Field(min_length=1)]
    """Name of a shipped simulator, or path of its YAML file."""


class TaeSettings(_Settings):
    """A trajectory autoencoder; the original size is 512, 128, 64, 1024, false."""

    kind: Literal["tae"]
    hidden: Width
    """Of the first layer, of encoder and decoder alike."""
    features: Width
    """Of the second."""
    latent: Width
    """Size of the code."""
    decoded: Width
    """Of the layer that joins code and features."""
    uniform_motion: bool
    """Whether the network reads the residual of each measurement from uniform motion."""


class GruTaeSettings(_Settings):
    """A recurrent trajectory autoencoder; the original size is 64, 16, 128, false."""

    kind: Literal["gru_tae"]
    recurrent: Width
    """Of the first recurrent unit."""
    latent: Width
    """Of the second, the size of the code."""
    decoded: Width
    """Of the dense layer."""
    uniform_motion: bool
    """Whether the network reads the residual of each measurement from uniform motion."""


NetworkSettings = Annotated[
    TransformerSettings | HybridSettings | TaeSettings | GruTaeSettings, Field(discriminator="kind")
]
"""Of any network, discriminated by ``kind``."""


class TrainingSettings(_Settings):
    """How networks are trained: on the mean squared error, a hybrid on Huber's loss."""

    epochs: Annotated[int, Field(ge=1, le=10_000)]
    """In each epoch, ``windows_per_episode`` new windows are drawn from every training episode."""
    windows_per_episode: Annotated[int, Field(ge=1, le=100)]
    batch: Annotated[int, Field(ge=1, le=65_536)]
    """Windows per step."""
    learning_rate: Annotated[float, Field(gt=0, le=1)]
    """Initial, or the cosine's maximum."""
    matrix_learning_rate: Annotated[float, Field(gt=0, le=1)] | None
    """Of the layers' matrices with Muon; null: Adam trains them too, as in the paper."""
    decay: Annotated[float, Field(gt=0, le=1)] | None
    """Factor of the learning rate after every epoch, as in the paper; null: a cosine schedule with
    warm-up."""
    max_gradient_norm: Annotated[float, Field(gt=0)] | None
    """Norm to which the gradient is clipped; null: not, as in the paper. A ball that hits the net
    can dominate a small batch."""
    hidden_spin: Annotated[float, Field(ge=0, le=1)]
    """Share of the windows whose spin is hidden, so that the network learns to forecast without."""
    precision: Literal["32-true", "bf16-mixed"]
    """As Lightning names it."""
    threads: Annotated[int, Field(ge=1, le=256)]
    """Of the CPU; fixed, because the last bits of the weights depend on it."""
    devices: Annotated[int, Field(ge=1, le=64)] = 1
    """Devices of one machine that share every batch: GPUs, or processes without a GPU. The last
    bits of the weights depend on it, too."""
