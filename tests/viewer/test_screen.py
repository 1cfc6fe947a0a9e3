"""What Rerun's own viewer says about the pages, drawn without a screen. Skips where there is no Vulkan driver."""

from __future__ import annotations

import io
from collections.abc import Iterator

import pytest
from PIL import Image

from incsvr.errors import BadInput
from tests.viewer.conftest import Run
from tests.viewer.screen import SIZE, Screen, on_screen
from tests.viewer.test_recording import record
from viewer import palette
from viewer.compare import Choice


@pytest.fixture(scope="module")
def screen(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Screen]:
    path = tmp_path_factory.mktemp("screen") / "run.rrd"
    record(run, path, Choice())
    try:
        with on_screen(path) as screen:
            yield screen
    except BadInput as error:
        if "Vulkan" not in str(error):
            raise
        pytest.skip(f"the viewer cannot draw here: {error}")


@pytest.mark.slow
def test_one_frame_is_drawn_and_every_view_is_content(screen: Screen) -> None:
    screen.show("Learning", 4)
    views = screen.views()
    assert {view.name for view in views} >= {
        "Damping over yaw rate",
        "This iteration",
        "Torque [N m]",
        "Mean absolute error [N m]",
    }
    assert [(view.name, view.reports) for view in views if view.reports] == []
    picture = Image.open(io.BytesIO(screen.picture())).convert("RGB")
    assert picture.size == SIZE
    colours = {colour for _, colour in picture.getcolors(1 << 22) or () if isinstance(colour, tuple)}
    for name in ("OLD", "SUPPORT", "FUNCTION", "TEXT", "FRAME"):
        assert any(near(colour, getattr(palette, name)) for colour in colours), f"nothing in the colour of {name}"


@pytest.mark.slow
@pytest.mark.parametrize("page", ["Before and after", "Signals", "Error", "Effects", "Health", "Channels"])
def test_every_other_page_is_content_at_the_end(screen: Screen, page: str) -> None:
    screen.show(page)
    views = screen.views()
    assert [(view.name, view.reports) for view in views if view.reports] == []
    if page == "Channels":
        assert "Depth [m]" in {view.name for view in views}


@pytest.mark.slow
def test_an_iteration_that_is_not_there_is_refused(screen: Screen) -> None:
    with pytest.raises(BadInput, match="no iteration 999"):
        screen.show("Learning", 999)


def near(one: tuple[int, ...], other: tuple[int, int, int]) -> bool:
    return max(abs(a - b) for a, b in zip(one, other, strict=True)) <= 3
