"""`incsvr view LOG`: a log's streams, channels, damping samples and batches, before anything is learned."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from rerun.components import MarkerShape

from incsvr.plant.axes import YAW
from incsvr.plant.words import AxisWords, words_of
from incsvr.signals.samples import Samples
from service.logs.picture import LogPicture
from viewer.axes import Axes, Entry
from viewer.frame import Floats
from viewer.learning import DAMPING, HEIGHT, RATE, WIDTH, log_axes, symmetric
from viewer.marks import shape, style
from viewer.names import channel
from viewer.pages import axes_view, tabs
from viewer.palette import LIGHT, Colour, Palette
from viewer.pauses import Pauses
from viewer.recorder import Recorder

STREAMS, SAMPLES, CHANNELS = "log/streams", "log/samples", "log/channels"
CALLED = {YAW.rate: "{rate_title}", YAW.effort: "{effort_title}"}
"""The streams that are learned from, and what they are called: templates of `AxisWords`."""
OWN = {YAW.rate: "{rate_title} [{rate_unit}]", YAW.effort: "{effort_title} [{effort_unit}]"}
"""The titles of their plots: likewise templates."""
_END = rr.TimeRangeBoundary.infinite()
OUTER = (0.005, 0.995)
"""Part of the samples that the axes show whole: a few wild ones must not press all others flat."""
HINT = (
    "One batch after the other is learned, from left to right. **Samples** shows each batch over the {rate}: move the "
    "time to see the next one."
)


def blueprint(picture: LogPicture, palette: Palette) -> rrb.Blueprint:
    """Tabs of the streams, the samples and the channels; those that the log has."""
    words = words_of(picture.axis)
    shown = [_plot(f"{STREAMS}/{name}", words.fill(title)) for name, title in OWN.items()]
    pages: list[rrb.Container] = []
    if picture.samples is not None:
        shown += [_plot(f"{SAMPLES}/damping", f"Damping samples [{words.effort_unit}]")]
        entities = [f"{SAMPLES}/{name}" for name in ("axes", "all", "batch")]
        axes = axes_view(f"Damping over {words.rate}", entities, (WIDTH, HEIGHT), f"{SAMPLES}/axes", palette)
        pages.append(rrb.Horizontal(axes, _words_view(), column_shares=[1.55, 1.0], name="Samples"))
    pages.insert(0, rrb.Vertical(_words_view(), *shown, row_shares=[1.0, *[1.0] * len(shown)], name="Streams"))
    if channels := _channels(picture):
        plots = [_plot(f"{CHANNELS}/{name}", channel(name, picture.units.get(name, ""))) for name in channels]
        pages.append(rrb.Grid(*plots, grid_columns=min(2, len(plots)), name="Channels"))
    return tabs(pages)


def draw(recorder: Recorder, picture: LogPicture, palette: Palette) -> None:
    """Logs everything, each value at its stamp."""
    recorder.log("log/words", _words(picture), static=True)
    for name, (stamps, values) in picture.streams.items():
        own = name in OWN
        path = f"{STREAMS}/{name}/measured" if own else f"{CHANNELS}/{name}/measured"
        colour = LIGHT.before if name == YAW.effort else LIGHT.old
        title = words_of(picture.axis).fill(CALLED[name]) if own else channel(name, picture.units.get(name, ""))
        _line(recorder, path, title, colour, stamps, values)
    if picture.samples is not None:
        _samples(recorder, picture.samples, picture.batch, palette)


def _words(picture: LogPicture) -> rr.TextDocument:
    lines = [f"# {picture.name}", "", *(f"- {remark}" for remark in picture.remarks)]
    if picture.samples is not None:
        whole = len(picture.samples) // picture.batch
        lines += ["", f"{whole} batches of {picture.batch} samples. {words_of(picture.axis).fill(HINT)}"]
    return rr.TextDocument("\n".join(lines), media_type="text/markdown")


def _line(recorder: Recorder, path: str, title: str, colour: Colour, stamps: Floats, values: Floats) -> None:
    """A stream as a line that ends at pauses."""
    recorder.line(path, colour, title, 1.4)
    recorder.series(path, *Pauses().broken(stamps, values))


def _samples(recorder: Recorder, samples: Samples, batch: int, palette: Palette) -> None:
    """The samples over time, each batch in the colour of the one before the last, and over the yaw rate."""
    ends = range(batch, len(samples) + 1, batch)
    for number, colour in enumerate((LIGHT.support, LIGHT.outlier)):
        path = f"{SAMPLES}/damping/{number}"
        taken = (np.arange(len(samples)) // batch % 2 == number) & (np.arange(len(samples)) < batch * len(ends))
        name = ("Batches 1, 3, 5 …", "Batches 2, 4, 6 …")[number]
        recorder.dots(path, colour, name, MarkerShape.Circle, 2.5)
        recorder.series(path, samples.time[taken], samples.damping[taken])
    at = np.column_stack((samples.yaw_rate, samples.damping))
    axes = _axes(at, palette, recorder.words)
    seen = at[np.abs(at[:, 1]) <= axes.y.high]
    recorder.set_clocks(vehicle=float(samples.time[0]))
    log_axes(recorder, f"{SAMPLES}/axes", axes, palette, [f"{SAMPLES}/all", f"{SAMPLES}/batch"])
    recorder.log(f"{SAMPLES}/all", *style("disc", palette.old, order=10.0), static=True)
    recorder.log(f"{SAMPLES}/batch", *style("square", palette.new, order=20.0), static=True)
    recorder.log(f"{SAMPLES}/all", *shape("disc", seen, axes))
    for end in ends:
        recorder.set_clocks(iteration=end // batch, vehicle=float(samples.time[end - 1]))
        newest = at[end - batch : end]
        recorder.log(f"{SAMPLES}/batch", *shape("square", newest[np.abs(newest[:, 1]) <= axes.y.high], axes))


def _axes(at: Floats, palette: Palette, words: AxisWords) -> Axes:
    """The axes around nearly all of the samples (n, 2) [rad/s, N m]."""
    reach = np.abs(at[:, 0]).max(), np.abs(np.quantile(at[:, 1], OUTER)).max()
    legend = ((Entry("disc", palette.old, "All samples"), Entry("square", palette.new, "The newest batch")),)
    x, y = symmetric(float(reach[0]), words.fill(RATE)), symmetric(float(reach[1]), words.fill(DAMPING))
    return Axes(x, y, WIDTH, HEIGHT, legend=legend, font=32)


def _plot(path: str, name: str) -> rrb.TimeSeriesView:
    """All of what stands below an entity, over the log's time."""
    whole = rrb.TimeAxis(view_range=rr.TimeRange(start=_END, end=_END))
    return rrb.TimeSeriesView(origin=path, name=name, axis_x=whole, plot_legend=rrb.PlotLegend(rrb.Corner2D.RightTop))


def _words_view() -> rrb.TextDocumentView:
    return rrb.TextDocumentView(origin="log/words", name="This log")


def _channels(picture: LogPicture) -> Sequence[str]:
    return [name for name in picture.streams if name not in OWN]
