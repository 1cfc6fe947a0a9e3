"""The picture of the experiment's runs (Fig. 4)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from incsvr.errors import BadInput
from service.recordings.recording_csv import write
from simulator import leng
from viewer.experiment import draw
from viewer.palette import LIGHT


@pytest.mark.slow
def test_the_runs_are_drawn_with_the_line_between_them(tmp_path: Path) -> None:
    for name in leng.RUNS:
        write(tmp_path / f"{name}.csv", leng.recording(name, 3120))
    draw(tmp_path, tmp_path / "experiment.png")
    picture = np.asarray(Image.open(tmp_path / "experiment.png").convert("RGB"))
    dark = (picture == np.array(LIGHT.text)).all(axis=2)
    # The dashed line between validation and training: uprights of the text's colour, much longer than a letter, in
    # both columns of plots.
    uprights = np.flatnonzero(dark.sum(axis=0) > 0.3 * picture.shape[0])
    assert (uprights < picture.shape[1] / 2).any()
    assert (uprights > picture.shape[1] / 2).any()


def test_a_run_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"V1\.csv: there is no such run; `make demo` makes it"):
        draw(tmp_path, tmp_path / "experiment.png")
