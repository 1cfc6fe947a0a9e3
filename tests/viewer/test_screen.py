"""What Rerun's own viewer says about the pages, drawn without a screen. Skips where there is no Vulkan driver."""

from __future__ import annotations

import io
from collections.abc import Iterator

import pytest
from PIL import Image

from incsvr.errors import BadInput
from tests.viewer.conftest import Run
from tests.viewer.test_recording import record
from viewer.compare import Choice
from viewer.palette import DARK
from viewer.screen import SIZE, Screen


@pytest.fixture(scope="module")
def screen(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Screen]:
    path = tmp_path_factory.mktemp("screen") / "run.rrd"
    record(run, path, Choice())
    try:
        with Screen(path) as screen:
            yield screen
    except BadInput as error:
        if "Vulkan" not in str(error):
            raise
        pytest.skip(f"the viewer cannot draw here: {error}")


def test_one_frame_is_drawn_and_every_view_is_content(screen: Screen) -> None:
    screen.show("Learning", 4)
    views = screen.views()
    assert {view.name for view in views} >= {"Damping over yaw rate", "This iteration", "The last 60 s", "Error"}
    assert [(view.name, view.reports) for view in views if view.reports] == []
    picture = Image.open(io.BytesIO(screen.picture())).convert("RGB")
    assert picture.size == SIZE
    colours = {colour for _, colour in picture.getcolors(1 << 22) or () if isinstance(colour, tuple)}
    for name in ("old", "support", "function", "text", "frame", "before"):
        assert any(near(colour, getattr(DARK, name)) for colour in colours), f"nothing in the colour of {name}"


@pytest.mark.parametrize("page", ["Before and after", "Signals", "Effects", "Health"])
def test_every_other_page_is_content_at_the_end(screen: Screen, page: str) -> None:
    screen.show(page)
    assert [(view.name, view.reports) for view in screen.views() if view.reports] == []


def test_an_iteration_that_is_not_there_is_refused(screen: Screen) -> None:
    with pytest.raises(BadInput, match="no iteration 999"):
        screen.show("Learning", 999)


def near(one: tuple[int, ...], other: tuple[int, int, int]) -> bool:
    return max(abs(a - b) for a, b in zip(one, other, strict=True)) <= 3
