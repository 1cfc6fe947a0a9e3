"""How the pages are laid out; the recording carries this, so it opens right at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import rerun as rr
import rerun.blueprint as rrb

from incsvr.plant.axes import YAW, Axis
from incsvr.plant.words import words_of
from service.wire import SETS
from viewer import axes, learning
from viewer.compare import SHOWN
from viewer.frame import VEHICLE_TIME
from viewer.names import channel
from viewer.palette import Palette
from viewer.signals import CHANNELS, HINT

PAGES = ("Learning", "Before and after", "Signals", "Error", "Effects", "Health", "Channels")
"""In the order of their tabs; the last one where further channels have come."""
COLUMNS = 2
"""Plots of further channels beside each other."""
WINDOW_S = 180.0
"""Length of the signals in sight [s]."""
MARGIN_S = 40.0
"""Room beside the signals, where the legend stands [s]."""
NOTHING_FOUND: Mapping[str, str] = {}
MAX_FOUND_PLOTS = 4
"""Parameters of found effects that are drawn one above the other."""
_END = rr.TimeRangeBoundary.infinite()
PLAYBACK_SPEED = 20.0  # an iteration takes half a minute on the vehicle


def blueprint(
    palette: Palette,
    *,
    channels: Sequence[str] = (),
    found: Mapping[str, str] = NOTHING_FOUND,
    axis: Axis = YAW,
) -> rrb.Blueprint:
    """All pages as tabs, following the vehicle's time: on it every page has something to show.

    Where further channels have come, they have a page, too. What is found while no effect is in force (`found`:
    entity → title) is drawn in place of the parts. Names are those of the axis.
    """
    further: list[rrb.Container] = [_channels(channels)] if channels else []
    pages = (
        _learning(palette, axis),
        _compare(palette, axis),
        _signals(axis),
        rrb.Horizontal(_error(axis), name="Error"),
        _effects(axis, found),
        _health(axis),
    )
    return rrb.Blueprint(
        rrb.Tabs(*pages, *further, active_tab=0),
        rrb.TopPanel(state="hidden"),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=VEHICLE_TIME, play_state="following", playback_speed=PLAYBACK_SPEED),
        auto_views=False,
        auto_layout=False,
    )


def _axes_view(name: str, contents: Sequence[str], path: str, palette: Palette) -> rrb.Spatial2DView:
    """An XY plot: the whole axes in sight, their picture out of the pointer's way."""
    return rrb.Spatial2DView(
        origin="/",
        contents=[f"+ /{each}" for each in (path, *contents)],
        name=name,
        background=palette.background,
        visual_bounds=rrb.VisualBounds2D(x_range=[0, axes.WIDTH], y_range=[0, axes.HEIGHT]),
        overrides={path: rrb.EntityBehavior(interactive=False)},
    )


def _learning(palette: Palette, axis: Axis) -> rrb.Horizontal:
    words = words_of(axis)
    sets = [f"learning/{name}" for name in (*SETS, *learning.CURVES)]
    return rrb.Horizontal(
        _axes_view(f"Damping over {words.rate}", sets, "learning/axes", palette),
        rrb.Vertical(
            rrb.Horizontal(
                rrb.TextDocumentView(origin="learning/table", name="This iteration"),
                rrb.TextDocumentView(origin="learning/samples", name="Its samples"),
                column_shares=[1.35, 1.0],
            ),
            _plot("signals/yaw_rate", f"{words.rate_title} [{words.rate_unit}]"),
            _plot("signals/torque", f"{words.effort_title} [{words.effort_unit}]"),
            _error(axis),
            row_shares=[1.9, 1.0, 1.0, 1.3],
        ),
        column_shares=[1.55, 1.0],
        name="Learning",
    )


def _error(axis: Axis) -> rrb.TimeSeriesView:
    """The error curves from their beginning, over the clock that is chosen."""
    whole = rrb.TimeAxis(view_range=rr.TimeRange(start=_END, end=_END))
    name = f"Mean absolute error [{words_of(axis).effort_unit}]"
    return rrb.TimeSeriesView(
        origin="error", name=name, axis_x=whole, plot_legend=rrb.PlotLegend(rrb.Corner2D.RightTop)
    )


def _compare(palette: Palette, axis: Axis) -> rrb.Horizontal:
    return rrb.Horizontal(
        _axes_view(f"Damping over {words_of(axis).rate}", SHOWN, "learning/compare_axes", palette),
        rrb.TextDocumentView(origin="learning/compared", name="Compared"),
        column_shares=[1.55, 1.0],
        name="Before and after",
    )


def _plot(path: str, name: str) -> rrb.TimeSeriesView:
    """The last minutes of what stands below an entity, over the vehicle's time."""
    window = rr.TimeRange(
        start=rr.TimeRangeBoundary.cursor_relative(seconds=-WINDOW_S),
        end=rr.TimeRangeBoundary.cursor_relative(seconds=MARGIN_S),
    )
    legend = rrb.PlotLegend(rrb.Corner2D.RightTop)
    return rrb.TimeSeriesView(origin=path, name=name, axis_x=rrb.TimeAxis(view_range=window), plot_legend=legend)


def _signals(axis: Axis) -> rrb.Vertical:
    words = words_of(axis)
    return rrb.Vertical(
        rrb.TextDocumentView(origin=HINT, name="Signals"),
        _plot("signals/yaw_rate", f"{words.rate_title} [{words.rate_unit}]"),
        _plot("signals/torque", f"{words.effort_title} [{words.effort_unit}]"),
        _plot("signals/damping", f"Damping {words.moment} [{words.effort_unit}]"),
        _plot("signals/residual", f"Residual [{words.effort_unit}]"),
        _plot("signals/rejected", "Rejected samples, since start"),
        row_shares=[0.3, 1, 1, 1, 1, 0.8],
        name="Signals",
    )


def _channels(names: Sequence[str]) -> rrb.Grid:
    plots = [_plot(f"{CHANNELS}/{name}", channel(name)) for name in names]
    return rrb.Grid(*plots, grid_columns=min(COLUMNS, len(plots)), name="Channels")


def _effects(axis: Axis, found: Mapping[str, str]) -> rrb.Horizontal:
    words = words_of(axis)
    plots: list[rrb.TimeSeriesView] = [
        _plot("effects/torque", f"{words.effort_title}, with the effects [{words.effort_unit}]"),
        _plot("effects/parts", f"What each part takes of the predicted {words.effort} [{words.effort_unit}]"),
    ]
    if found:
        plots = [_plot(path, title) for path, title in list(found.items())[:MAX_FOUND_PLOTS]]
    return rrb.Horizontal(
        rrb.TextDocumentView(origin="effects/ledger", name="Traced effects"),
        rrb.Vertical(*plots),
        column_shares=[1.0, 1.8],
        name="Effects",
    )


def _health(axis: Axis) -> rrb.Horizontal:
    return rrb.Horizontal(
        rrb.TextDocumentView(origin="signals/health/now", name="Health"),
        rrb.Vertical(
            rrb.StateTimelineView(origin="signals/health/level", name="Level"),
            rrb.TimeSeriesView(
                origin="signals/health/learned",
                name=f"Learned share of the {words_of(axis).rate} range",
                axis_x=rrb.TimeAxis(view_range=rr.TimeRange(start=_END, end=_END)),
                axis_y=rrb.ScalarAxis(range=(0.0, 1.05)),
            ),
            row_shares=[0.5, 1.0],
        ),
        column_shares=[1.0, 1.4],
        name="Health",
    )
