"""`incsvr view LOG`: streams, channels, samples and batches are in the recording, and the viewer shows them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from incsvr.errors import BadInput
from service.cli.command_line import main
from tests.service import link
from tests.service.logs.test_whose import DIVE, written
from tests.viewer.readback import every, rows, series
from viewer.archive import is_recording
from viewer.screen import Screen


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("log")
    return written(folder, "tlog", link.parameters(), link.swum(DIVE, armed_from=0.0))


@pytest.fixture(scope="module")
def recording(log: Path) -> Path:
    path = log.with_suffix(".rrd")
    assert main(["view", str(log), "--inertia", "0.6", "--headless", "--save", str(path)]) == 0
    return path


def words(path: Path) -> str:
    return "\n".join(every(path, "TextDocument:text", "/log/words"))


def test_streams_samples_and_batches_of_a_log_are_in_the_recording(recording: Path) -> None:
    drawn = series(recording, "/log")
    rate = np.array(drawn["/log/streams/yaw_rate/measured"])
    np.testing.assert_allclose(rate[np.isfinite(rate)], DIVE.rate, atol=1e-6)
    assert "/log/channels/voltage/measured" in drawn
    batches = rows(recording, "Points2D:positions", "/log/samples")["/log/samples/batch"]
    samples = sum(len(drawn[f"/log/samples/damping/{number}"]) for number in (0, 1))
    assert samples == 50 * len(batches)
    assert f"{len(batches)} batches of 50 samples" in words(recording)


def test_without_an_inertia_the_streams_are_shown_and_it_is_asked_for(log: Path, tmp_path: Path) -> None:
    path = tmp_path / "streams.rrd"
    assert main(["view", str(log), "--headless", "--save", str(path)]) == 0
    assert not [name for name in series(path, "/log") if "samples" in name]
    assert "--inertia I [kg m²]" in words(path)


def test_a_log_is_no_recording(log: Path, recording: Path, tmp_path: Path) -> None:
    assert (is_recording(recording), is_recording(log), is_recording(tmp_path / "none.rrd")) == (True, False, True)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ([], "--headless shows nothing: give --save FILE.rrd to keep what is drawn of the log"),
        (["--save", "/dev/null/none.rrd"], "/dev/null/none.rrd: cannot be written"),
    ],
)
def test_what_cannot_be_shown_is_refused(
    log: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], sentence: str
) -> None:
    assert main(["view", str(log), "--headless", *arguments]) == 2
    assert sentence in capsys.readouterr().err


@pytest.mark.slow
def test_the_viewer_is_content_with_every_page(recording: Path) -> None:
    try:
        with Screen(recording, ("Streams", "Samples", "Channels")) as screen:
            for page in ("Streams", "Samples", "Channels"):
                screen.show(page)
                assert [(view.name, view.reports) for view in screen.views() if view.reports] == []
    except BadInput as error:
        if "Vulkan" not in str(error):
            raise
        pytest.skip(f"the viewer cannot draw here: {error}")
