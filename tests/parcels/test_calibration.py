"""Quantile regression and the conformal step against what they promise."""

import numpy as np

from viewgain.parcels import FEATURES, QUANTITIES, calibrated, calibration


def test_the_shipped_calibration_orders_its_quantiles_and_widens_with_the_shadow() -> None:
    plain = np.zeros((len(QUANTITIES), len(FEATURES)))
    plain[:, 0], plain[:, 4], plain[:, 5], plain[:, 6] = 1.0, 0.6, 0.02, 0.01
    shadowed = plain.copy()
    shadowed[:, 1] = 1.5
    short, long = calibration().quantiles(plain), calibration().quantiles(shadowed)
    assert np.all(np.diff(short, axis=1) >= 0)
    volume = QUANTITIES.index("upright_volume")
    assert long[volume, 2] / long[volume, 0] > short[volume, 2] / short[volume, 0]


def test_what_is_learnt_covers_nine_in_ten_of_what_it_never_saw() -> None:
    """Noise that grows with a feature: fitted and made conformal on 600 draws, tried on 2,000 more."""
    rng = np.random.default_rng(0)

    def drawn(count: int) -> tuple[np.ndarray, np.ndarray]:
        features = np.zeros((count, len(QUANTITIES), len(FEATURES)))
        features[..., 0], features[..., 1] = 1.0, rng.uniform(0, 2, (count, 1))
        return features, 0.2 * features[..., 1] + (0.05 + 0.2 * features[..., 1]) * rng.gumbel(size=(count, len(QUANTITIES)))

    features, log_ratio = drawn(600)
    learnt = calibrated(features, log_ratio, np.arange(600) % 3 == 0)
    fresh, truth = drawn(2000)
    low, high = (np.einsum("qf,nqf->nq", learnt.weights[:, k], fresh) for k in (0, 2))
    inside = ((low <= truth) & (truth <= high)).mean(axis=0)
    assert np.all((inside > 0.84) & (inside < 0.96))
