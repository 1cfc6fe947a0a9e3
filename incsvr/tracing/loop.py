"""Whether the torque answers the rate: by what the plain model lacks of the torque in each block."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from incsvr.model.fitting import Fit
from incsvr.signals.settings import MEASURED, TorqueKind
from incsvr.tracing.answering import Loop, answers, of_this_gyro, standing_time
from incsvr.tracing.run import Run
from incsvr.tracing.thresholds import OTHER_GYRO_CORRELATION
from incsvr.tracing.unseen import Judge


def loop_of(
    runs: Sequence[Run],
    fitted: Judge,
    plain: Fit,
    torque: TorqueKind | None,
    least: float = 0.03,  # correlation with which the torque follows the surprise
) -> Loop:
    """The relation of the torque to the rate.

    Args:
        fitted: judges by the recordings that `plain` was fitted to.
        torque: whether it was commanded or measured; None where nobody says.
    """
    if standing_time(runs) > fitted.scale:
        return Loop.OPEN
    answer = answer_left(fitted, plain)
    if answer < least:
        return Loop.OPEN
    if torque == MEASURED or of_this_gyro(runs):
        return Loop.CLOSED
    return Loop.OTHER_GYRO if answer > OTHER_GYRO_CORRELATION else Loop.OPEN


def answer_left(fitted: Judge, model: Fit, samples: Sequence[int] = (2, 4)) -> float:
    """The correlation of the torque with what a model lacked before, 0 if chance explains it.

    Args:
        samples: of the velocity in a block, each tried: over few its noise hides the water, over many the answer is
            within the block.
    """
    found = []
    for count in samples:
        short = replace(fitted, block=count * fitted.sample, step=min(fitted.step, 0.5 * fitted.sample))
        lacking, efforts = short.torque(model), short.efforts()
        starts = np.concatenate([[0], np.cumsum([each.size for each in lacking])]).astype(np.intp)
        found.append(answers(-np.concatenate(lacking), np.concatenate(efforts), starts))
    return max(found)
