"""Settings of the gap workflow: every threshold once, with its meaning and unit.

``GapSettings`` is handed down from ``diagnose``; no step imports a threshold of another. Constants
in the modules are numerics (steps of differences, guards against rounding) or definitions (units of
terms, what a kick is). The defaults are those of every result in ``reports/``.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from scipy.stats import norm

from rallygap.models.ball.simulator import Simulator


@dataclass(frozen=True)
class FieldSettings:
    """The smooth position-dependent camera error."""

    sizes: tuple[float, float] = (2e-4, 0.05)  # m, standard deviations of a coordinate
    tried_sizes: int = 26
    length: float = 0.8  # m, over which errors are correlated
    variance_share: float = 0.99  # of the field, in its first functions
    nodes: int = 80  # places that represent the measured ones
    places: int = 4000  # measured places that nodes are taken from
    inner_places: float = 0.98  # share of them that are near enough to be nodes


@dataclass(frozen=True)
class FitSettings:
    """Fitting shots: nuisance parameters, noise, and values of chosen hypotheses."""

    # Outliers of positions: a normal as wide as a ball's diameter and more, and a small share.
    outlier_share: float = 0.02
    outlier_spread: float = 0.1  # m
    max_noise_to_outlier_spread: float = 0.3  # in larger noise, outliers spread more

    camera_field: FieldSettings = FieldSettings()

    # Nuisance parameters of one shot (Levenberg-Marquardt).
    max_kicks: int = 2  # bounces of a shot that may scatter
    first_horizon: float = 0.12  # s, so short that a ball bounces where it did
    # Noise (m), horizon (s) and iterations of the stages (graduated non-convexity).
    stages: tuple[tuple[float, float, int], ...] = (
        (0.03, 0.12, 3),
        (0.03, np.inf, 3),
        (0.01, np.inf, 2),
    )
    first_damping: float = 1e-3
    cost_converged: float = 0.1  # change of -2 log likelihood; what remains is linear
    max_iterations: int = 10
    spin_prior: float = 300.0  # rad/s, a component of a spin without a label
    noise_quantile: float = 0.9  # of residuals, which gives the first guess of the noise
    min_noise: float = 1e-4  # m
    far_worse: float = 2.0  # times the median cost of shots, from which another start is tried
    far_residuals: float = 2.0  # typical residual, in the noise, from which the noise shrinks first

    # Noise of all shots (restricted likelihood).
    significant_direction: float = 2.5  # standard errors; such values are fitted before the noise
    noise_shots: int = 40  # shots that the noise of positions is estimated from
    bounce_shots: int = 70  # shots that label errors and scatter are estimated from
    noise_rounds: int = 2
    noise_converged: float = 0.03  # relative change of the noise of positions
    # Standard deviations of a shot's misfit from which its weight falls, and is least.
    misfit_range: tuple[float, float] = (5.0, 15.0)
    min_shot_weight: float = 1e-4
    min_misfit: float = 1e-6  # a degree of freedom, where shots fit exactly
    max_spin: float = 1500.0  # rad/s; a fit beyond it ended in a wrong minimum
    max_plausible_kick: float = 0.5  # of the normal speed, likewise
    # Bounds of the noise: m, m, s, s; shares of the spin; shares of the normal speed.
    noise_bounds: Mapping[str, tuple[float, float]] = field(
        default_factory=lambda: MappingProxyType(
            {
                "white": (1e-5, 0.1),
                "slow": (1e-5, 0.1),
                "slow_time": (0.01, 0.5),
                "timing": (1e-6, 5e-3),
                "label": (1e-3, 1.0),
                "label_arc": (1e-3, 1.0),
                "label_common": (1e-3, 1.0),
                "scatter": (1e-3, 0.5),
            }
        )
    )
    # Least sizes that a search starts from: near zero, logarithms of sizes change nothing.
    noise_starts: Mapping[str, float] = field(
        default_factory=lambda: MappingProxyType(
            {"slow": 3e-4, "timing": 1e-4, "label_arc": 5e-3, "label_common": 5e-3, "scatter": 3e-3}
        )
    )

    # Values of chosen hypotheses (Gauss-Newton).
    refit_steps: int = 6  # from scratch
    refit_steps_nearby: int = 3  # from a simulator nearby: the next linearisation takes another
    step_converged: float = 0.2  # standard errors
    step_far: float = 3.0  # standard errors; after such a step the noise is estimated again
    value_prior: float = 1 / 6  # of a value's range, its standard deviation before the shots
    step_fractions: tuple[float, ...] = (1.0, 0.25, 0.05)  # of a step, which are tried
    cost_tolerance: float = 1.01  # times the cost: single shots know no slow errors
    nearby_iterations: int = 3  # of shots whose nuisance parameters followed the step


@dataclass(frozen=True)
class InferenceSettings:
    """Score tests, and sets of hypotheses."""

    detectable: float = 5.8  # standard errors, the minimum detectable effect
    folds: int = 5  # of cross-validation
    noise_degrees: float = 8.0  # degrees of freedom that the noise as estimated counts as
    min_detectable_sample_size: float = 4.0  # effective shots behind a minimum detectable effect
    min_information: float = 1e-7  # share of a hypothesis's information left given the others
    beam_width: int = 150  # sets of one size that the search keeps
    beam_work: int = 750  # columns in all these sets together
    max_variance_inflation: float = 100.0  # of a value by the others of its set
    bound_tolerance: float = 3.0  # standard errors that an estimate may lie beyond its bounds


@dataclass(frozen=True)
class LocateSettings:
    """Where the gap arises, and against what it grows."""

    horizons: tuple[float, ...] = tuple(np.linspace(0.025, 0.6, 24).tolist())  # s
    min_shots: int = 5  # at a horizon
    min_share: float = 0.25  # at a horizon, of the shots at the horizon that has most
    trend_share: float = 2 / 3  # of these, at the horizon at which trends are tested
    known_spin: float = 1e-3  # rad/s that a spin without a label may shift in a prediction
    min_inlier: float = 0.5  # probability that a sample is no outlier
    min_shot_weight: float = 0.5
    # Priors of the free departure of each shot.
    acceleration_prior: float = 30.0  # m/s^2
    height_prior: float = 0.1  # m
    kick_prior: float = 1.0  # of the normal speed
    min_axis_spin: float = 20.0  # rad/s; a smaller spin has no axis
    min_bin_shots: int = 4
    typical_bin_shots: int = 6
    max_bins: int = 5
    permutations: int = 2000


@dataclass(frozen=True)
class NameSettings:
    """Causes: search, label signs, unexplained structure."""

    growth: int = 5  # causes by which an explanation may grow about one fit
    min_sample_size: float = 2.5  # effective shots behind a cause: no name rests on one or two
    # Of twice the log likelihood, which a missing effect must gain beyond a wrong value.
    listed_advantage: float = 1e-3
    max_rounds: int = 8  # of explaining and refitting
    first_shots: int = 70  # that causes are searched on first
    min_spin: float = 1.0  # rad/s, least typical spin
    extrapolation_error: float = 0.01  # of a gain, where causes are far off
    lift_start: float = 0.1  # C_M; without labels only its product with the spin shows
    dead_restitution: float = 0.3  # up to which balls bounce again and again within a shot
    bounce_start: tuple[float, float] = (0.9, 0.25)  # restitution, friction, in place of a dead one
    min_flipped_labels: int = 3  # shots: no cause rests on one or two
    sign_flips: int = 20_000  # random signs of shots; p-values are at least 6 / sign_flips
    # Share of information left given the catalogue, of a direction of terms and of one term.
    min_direction_information: float = 1e-4
    min_term_information: float = 1e-3
    # Sparse formula: thresholds in standard deviations, ridge, share of what all terms explain.
    formula_thresholds: tuple[float, ...] = tuple(np.geomspace(30.0, 3.0, 12).tolist())
    formula_ridge: float = 0.05
    formula_share: float = 0.8


@dataclass(frozen=True)
class NetSettings:
    """The net, by the shots that touch it."""

    min_samples: int = 6  # of the arc before a contact and of the arc after
    min_contacts: int = 9  # with the face of the net, a third of them held out
    latest: float = 0.03  # s after the arc after starts, until when the arc before may meet it
    largest_error: float = 0.2  # of a velocity, as a share of the speed towards the net
    degrees: float = 4.0  # of freedom of the scatter of contacts
    horizon: float = 0.1  # s after the contact, until when predictions are judged


@dataclass(frozen=True)
class VerifySettings:
    """Errors of predictions on held-out shots, and limitations of the shots."""

    held_out: int = 3  # one shot in so many is held out; also the least number of shots
    few_shots: int = 20  # below, small effects are not detected
    one_way_share: float = 0.9  # of the shots in one direction; above it, a limitation is listed
    horizons: tuple[float, ...] = (0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4)  # s
    min_shots: int = 3  # with samples at a horizon, or that land
    min_inlier: float = 0.5  # probability that a sample is no outlier
    # Share of the nominal simulator's prediction error. A cause is harmful if held-out predictions
    # with it are significantly worse than without it, by more than this.
    worse: float = 0.02
    min_worth: float = 0.02  # of the largest worth; below it, a cause is minor
    max_unexplained: float = 0.1  # of the gap; above it, the verdict is unknown
    min_checked: int = 10  # held-out shots of a check
    min_bounces: int = 40  # of the check of bounces; fewer do not tell scatter from other causes
    # Measured over expected sizes of a model that fits (verdict.py, Check).
    allowed: Mapping[str, tuple[float, float]] = field(
        default_factory=lambda: MappingProxyType(
            {
                "residuals": (0.7, 1.4),
                "prediction": (0.75, 1.33),
                "landing": (0.67, 1.5),
                "labels": (0.0, 0.5),
                "bounces": (0.0, 0.03),  # real tables: .006 to .03
            }
        )
    )
    landing_horizon: float = 0.2  # s after the last sample, until when predictions may land
    replicates: int = 3  # simulated, for the noise floor
    bootstrap_draws: int = 2000


@dataclass(frozen=True)
class GapSettings:
    """All settings of one diagnosis.

    Attributes:
        level: probability of a false cause in a set without any gap. The penalty of a cause, the
            tolerance between alternatives, flipped labels, and the tests of causes, lift,
            position-dependent camera error, variations and unexplained structure follow it.
        confidence: of intervals.
        observed_samples: first samples of a shot that a prediction observes.
        horizon_window: s about a horizon in which errors are averaged.
        fit: of shots.
        inference: of tests.
        locate: where and in which phase.
        name: of causes.
        net: its law.
        verify: of the amended simulator.
    """

    level: float = 0.003
    confidence: float = 0.95
    observed_samples: int = 12
    horizon_window: float = 0.0125
    fit: FitSettings = field(default_factory=FitSettings)
    inference: InferenceSettings = field(default_factory=InferenceSettings)
    locate: LocateSettings = field(default_factory=LocateSettings)
    name: NameSettings = field(default_factory=NameSettings)
    net: NetSettings = field(default_factory=NetSettings)
    verify: VerifySettings = field(default_factory=VerifySettings)

    @property
    def normal_quantile(self) -> float:
        """Standard errors of half an interval, to two digits: 1.96 at 95 %."""
        return round(float(norm.isf((1 - self.confidence) / 2)), 2)

    def penalty(self, candidates: int) -> float:
        """Return what each of a set's members must gain in twice the log likelihood.

        It is the squared critical value of the largest of so many two-sided tests at ``level``.
        """
        return float(norm.isf(self.level / (2 * max(candidates, 1))) ** 2)

    @property
    def critical_value(self) -> float:
        """Standard errors of one one-sided test at ``level``."""
        return float(norm.isf(self.level))

    @property
    def tolerance(self) -> float:
        """Difference of gains up to which two sets explain about as well: one test at ``level``."""
        return self.critical_value**2

    def decisive_gain(self, labels: int) -> float:
        """Return what flipping one of so many labels must gain in twice the log likelihood.

        If a label is right, its likelihood ratio exceeds k with probability 1 / k at most. So the
        probability that any right label is called flipped is at most ``level``.
        """
        return float(2 * np.log(labels / self.level))


DEFAULTS = GapSettings()


@dataclass(frozen=True)
class Question:
    """What is asked of shots.

    Attributes:
        simulator: the nominal one, which the shots may contradict.
        settings: of the workflow.
        withheld: effects of the catalogue that are not in question.
    """

    simulator: Simulator
    settings: GapSettings = DEFAULTS
    withheld: tuple[str, ...] = ()
