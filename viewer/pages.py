"""How the pages are laid out; the recording carries this, so it opens right at once."""

from __future__ import annotations

from collections.abc import Sequence

import rerun as rr
import rerun.blueprint as rrb

from incsvr.plant.axes import YAW, Axis
from incsvr.plant.words import AxisWords, words_of
from service.wire import SETS
from viewer import learning, palette, thrust, xy_plot
from viewer.compare import SHOWN
from viewer.frame import VEHICLE_TIME
from viewer.names import channel

PAGES = ("Learning", "Before and after", "Signals", "Error", "Effects", "Health", "Channels")
"""In the order of their tabs; the last one where further channels have come."""
CHANNELS = "signals/channel"
"""Where further channels are logged."""
_END = rr.TimeRangeBoundary.infinite()
PLAYBACK_SPEED = 20.0  # an iteration takes half a minute on the vehicle


def blueprint(*, channels: Sequence[str] = (), axis: Axis = YAW) -> rrb.Blueprint:
    """All pages as tabs, following the vehicle's time: on it every page has something to show.

    Where further channels have come, they have a page, too. Names are those of the axis.
    """
    words = words_of(axis)
    unit = words.effort_unit
    residuals = [
        _plot("signals/damping", f"Damping {words.moment} [{unit}]"),
        _plot("signals/residual", f"Residual [{unit}]"),
        _plot("signals/rejected", "Rejected samples, since start"),
    ]
    pages: list[rrb.Container] = [
        _learning(words),
        _compare(words),
        rrb.Vertical(*_streams(words), *residuals, row_shares=[1, 1, 1, 1, 0.8], name="Signals"),
        rrb.Horizontal(_error(words), name="Error"),
        _effects(words),
        _health(words),
    ]
    if channels:
        plots = [_plot(f"{CHANNELS}/{name}", channel(name)) for name in channels]
        pages.append(rrb.Grid(*plots, grid_columns=min(2, len(plots)), name="Channels"))
    return rrb.Blueprint(
        rrb.Tabs(*pages, active_tab=0),
        rrb.TopPanel(state="hidden"),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=VEHICLE_TIME, play_state="following", playback_speed=PLAYBACK_SPEED),
        auto_views=False,
        auto_layout=False,
    )


def _axes_view(name: str, contents: Sequence[str], path: str) -> rrb.Spatial2DView:
    """An XY plot: the whole axes in sight, their picture out of the pointer's way."""
    return rrb.Spatial2DView(
        origin="/",
        contents=[f"+ /{each}" for each in (path, *contents)],
        name=name,
        background=palette.BACKGROUND,
        visual_bounds=rrb.VisualBounds2D(x_range=[0, xy_plot.WIDTH], y_range=[0, xy_plot.HEIGHT]),
        overrides={path: rrb.EntityBehavior(interactive=False)},
    )


def _learning(words: AxisWords) -> rrb.Horizontal:
    sets = [f"learning/{name}" for name in (*SETS, *learning.CURVES)]
    tables = [_text("learning/table", "This iteration"), _text("learning/samples", "Its samples")]
    return rrb.Horizontal(
        _axes_view(f"Damping over {words.rate}", sets, "learning/axes"),
        rrb.Vertical(
            rrb.Horizontal(*tables, column_shares=[1.35, 1.0]),
            *_streams(words),
            _error(words),
            row_shares=[1.9, 1.0, 1.0, 1.3],
        ),
        column_shares=[1.55, 1.0],
        name="Learning",
    )


def _compare(words: AxisWords) -> rrb.Horizontal:
    curves = _axes_view(f"Damping over {words.rate}", SHOWN, "learning/compare_axes")
    compared = _text("learning/compared", "Compared")
    return rrb.Horizontal(curves, compared, column_shares=[1.55, 1.0], name="Before and after")


def _plot(path: str, name: str, whole: bool = False) -> rrb.TimeSeriesView:
    """What stands below an entity over the chosen clock: the last three minutes beside the legend, or the whole."""
    window = [_END, _END] if whole else [rr.TimeRangeBoundary.cursor_relative(seconds=end) for end in (-180.0, 40.0)]
    axis = rrb.TimeAxis(view_range=rr.TimeRange(start=window[0], end=window[1]))
    return rrb.TimeSeriesView(origin=path, name=name, axis_x=axis, plot_legend=rrb.PlotLegend(rrb.Corner2D.RightTop))


def _text(path: str, name: str) -> rrb.TextDocumentView:
    return rrb.TextDocumentView(origin=path, name=name)


def _streams(words: AxisWords) -> list[rrb.TimeSeriesView]:
    return [
        _plot("signals/yaw_rate", f"{words.rate_title} [{words.rate_unit}]"),
        _plot("signals/torque", f"{words.effort_title} [{words.effort_unit}]"),
    ]


def _error(words: AxisWords) -> rrb.TimeSeriesView:
    return _plot("error", f"Mean absolute error [{words.effort_unit}]", whole=True)


def _effects(words: AxisWords) -> rrb.Horizontal:
    plots = rrb.Vertical(
        _plot("effects/torque", f"{words.effort_title}, with the effects [{words.effort_unit}]"),
        _plot("effects/parts", f"What each part takes of the predicted {words.effort} [{words.effort_unit}]"),
    )
    curve = _axes_view("Thrust over command", thrust.SHOWN, "effects/thrust/axes")
    ledger = _text("effects/ledger", "Traced effects")
    return rrb.Horizontal(ledger, curve, plots, column_shares=[1.0, 1.2, 0.8], name="Effects")


def _health(words: AxisWords) -> rrb.Horizontal:
    level = rrb.StateTimelineView(origin="signals/health/level", name="Level")
    learned = _plot("signals/health/learned", f"Learned share of the {words.rate} range", whole=True)
    history = rrb.Vertical(level, learned, row_shares=[0.5, 1.0])
    return rrb.Horizontal(_text("signals/health/now", "Health"), history, column_shares=[1.0, 1.4], name="Health")
