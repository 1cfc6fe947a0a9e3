"""The model of a whole vehicle as one Python file that needs NumPy alone and simulates as `incsvr` does."""

from __future__ import annotations

from incsvr.plant.axes import AXES, VELOCITIES
from incsvr.plant.terms import Term
from incsvr.vehicle import Vehicle
from incsvr.vehicle.simulation import MAX_STEP_DAMPING, MAX_SUBSTEPS
from service.export.remarks import doubts
from service.export.template import filled


def python_module(vehicle: Vehicle) -> str:
    """The file's text."""
    names, structure = list(AXES), vehicle.structure
    return filled(
        "python",
        name=vehicle.name.replace("\\", "\\\\").replace('"', '\\"'),
        doubts=[f"# {each}" for each in doubts(vehicle)],
        axes=repr(names),
        rows=structure.rows,
        mass=vehicle.mass_matrix.tolist(),
        lags={names.index(axis): parameter.value for axis, parameter in vehicle.lags.items()},
        fastest=vehicle.fastest.tolist(),
        decay=vehicle.decay,
        terms=[
            f"    f[{term.row}] += {p.value!r} * {_expression(term)}  # {term.name} [{term.unit}]"
            for term, p in vehicle.terms.items()
        ],
        max_decay=MAX_STEP_DAMPING,
        max_substeps=MAX_SUBSTEPS,
    )


def _expression(term: Term) -> str:
    """φ in the names of the module."""
    own = f"u[{term.row}]"
    of = [f"u[{VELOCITIES.index(name)}]" for name in term.of if name in VELOCITIES]
    match term.kind:
        case "linear":
            return own
        case "quadratic":
            return f"{own} * abs({own})"
        case "cross":
            return of[0]
        case "cross_size":
            return f"abs({of[0]}) * {of[1]}"
        case "product":
            return f"{of[0]} * {of[1]}"
        case "square":
            return f"{of[0]} ** 2"
        case "effort":
            return f"-w[{list(AXES).index(term.of[0])}]"
        case "inflow":
            return f"w[{term.row}] * abs({of[0]})"
        case "reverse":
            return f"min(w[{term.row}], 0.0)"
        case "weight":
            down = {"surge": "-np.sin(pitch)", "sway": "np.cos(pitch) * np.sin(roll)"}
            return f"-({down.get(term.axis, 'np.cos(pitch) * np.cos(roll)')})"
        case "righting":
            return "np.cos(pitch) * np.sin(roll)" if term.axis == "roll" else "np.sin(pitch)"
        case _:
            return "1.0"
