"""Bets on the better of two forecasts: how often they are won by chance, however long they run."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.compensation.bets import evidence, final_log_wealth, score, wealth

ROUNDS = 500


def walks(drift: float, deviation: float, seed: int, runs: int = 1000) -> np.ndarray:
    return np.random.default_rng(seed).normal(drift, deviation, (runs, ROUNDS))


def test_a_forecast_that_is_right_is_seldom_beaten_however_often_one_looks() -> None:
    """Of a wrong shift δ in units of the noise, g is normal with mean −δ²/2 and variance δ²."""
    for shift in (0.1, 0.5, 1.0, 3.0):
        won = np.array([evidence(score(gains)) for gains in walks(-0.5 * shift**2, shift, 1)])
        assert np.mean(won >= np.log(20.0)) <= 0.05
        assert np.mean(won >= np.log(200.0)) <= 0.01


def test_noise_that_the_models_think_half_as_large_wins_no_bets() -> None:
    won = np.array([evidence(score(gains)) for gains in walks(-0.5, 2.0, 2)])
    assert np.mean(won >= np.log(20.0)) <= 0.05


def test_one_block_full_of_outliers_is_one_bet() -> None:
    gains = walks(-0.02, 0.2, 3, 1)[0]
    spiked = gains.copy()
    spiked[100] = 1e6
    assert np.max(np.abs(wealth(score(spiked)) - wealth(score(gains)))) < np.log(2.0)


def test_an_effect_that_shows_in_every_block_is_found_within_twenty() -> None:
    found = [int(np.argmax(wealth(score(gains)) > np.log(1000.0))) for gains in walks(4.0, 2.0, 4)]
    assert 5 < np.quantile(found, 0.95) < 20


@pytest.mark.slow
def test_bets_that_go_on_from_what_was_won_before_keep_their_level() -> None:
    """Trials of 100 blocks, one after the other, on a right forecast."""
    for shift in (0.1, 0.3, 1.0):
        won = []
        for gains in walks(-0.5 * shift**2, shift, 5):
            earlier, most = 0.0, 0.0
            for trial in np.split(score(gains), 5):
                most = max(most, earlier + evidence(trial))
                earlier += final_log_wealth(trial)
            won.append(most)
        assert np.mean(np.array(won) >= np.log(20.0)) <= 0.05


def test_bets_that_go_on_win_what_one_long_bet_wins() -> None:
    first, second = np.split(score(walks(0.5, 1.0, 7, 1)[0]), 2)
    both = final_log_wealth(first) + final_log_wealth(second)
    assert both > 0.5 * final_log_wealth(np.concatenate([first, second])) > np.log(20.0)


def test_without_data_there_is_no_evidence() -> None:
    assert evidence(np.empty(0)) == 0.0
