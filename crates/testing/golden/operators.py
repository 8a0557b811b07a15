"""Writes operators.json: hysteresis operators run by their definitions, for tests/golden_operators.rs.

Each row has an operator with its parameters as a model file holds them, an input, z, and how near to it the operator
must come, relative to the largest |z|. A row with a `driver` is the operator behind it.
"""

import json
from pathlib import Path

import numpy as np
from operator_equations import asymmetric_bouc_wen, baber_noori, bouc_wen, dahl, duhem, jiles_atherton, tellinen
from operator_learned import gaussian_process, narx, neural, rate_scheduled, two_branch
from operator_plays import behind_a_driver, generalised_play, kp, maxwell_slip, play, preisach, rate_play, stop

random = np.random.default_rng(20250301)

# Sums and splines, except for rounding; equations, except for the solver.
SUM, EQUATION = 1e-13, 1e-9
# Rules of integration that are part of a definition, against the equation that they approximate:
# - Baber-Noori, steps of the range / 64, of the second order; and a thousand steps per sample;
# - Jiles-Atherton, Runge's and Kutta's steps of an eighth of a or k, of the first order where h begins to move; and
#   steps of a twentieth of k;
# - Tellinen, tables of integrals.
MIDPOINTS, FINE_MIDPOINTS, RUNGE_KUTTA, FINE_RUNGE_KUTTA, TABULATED = 5e-5, 3e-8, 3e-5, 1e-7, 3e-6


def wander(low, high, n):
    """Loops in loops from rest, with steps of all sizes and some samples held."""
    t = np.arange(n)
    u = 0.5 * (low + high) + 0.5 * (high - low) * (0.55 * np.sin(0.31 * t) + 0.45 * np.sin(0.083 * t + 0.5))
    u[20:24] = u[19]
    u[40] = 0.9 * low + 0.1 * high
    return u


def rounded(values):
    return np.round(values, 6)


def sweep(n):
    """From slow to fast, with a dip that is no reversal, a peak that is held, and a rest at the end."""
    t = np.arange(n)
    u = 28.0 * np.sin(3.0 * (np.exp(0.018 * t) - 1.0)) + 0.2 * np.sin(2.1 * t)
    u[11] = u[10] - 0.8
    u[22:28] = 29.0
    u[-25:] = u[-26]
    return u


knots = np.linspace(-30.0, 30.0, 7)
loop = lambda way, width=3.0: (knots + 0.1 * knots**2 / 30.0 + way * width * (1.0 - knots**2 / 900.0)).tolist()
pair = lambda width: {"ascending": {"u": knots.tolist(), "z": loop(-1.0, width)},
                      "descending": {"u": knots.tolist(), "z": loop(1.0, width)}}
bipolar, unipolar = rounded(wander(-30.0, 30.0, 120)), rounded(wander(0.0, 100.0, 120))
inner, beyond = rounded(0.8 * bipolar), rounded(1.25 * bipolar)
above = rounded(wander(-10.0, 112.0, 120))
levels = (-30.0 + 10.0 * (np.arange(6) + 0.5)).tolist()
thresholds, six = [0.5, 2.0, 5.0, 11.0, 20.0], [0.7, 0.1, 0.2, 0.05, 0.1, 0.3]
relays = {"operator": "preisach", "range": [-30.0, 30.0], "levels": [-34.0, -22.5, -15.0, -4.0, 3.0, 6.5, 18.0, 31.0],
          "slope": 0.3}
unipolar_relays = {"operator": "preisach", "range": [0.0, 32.0], "levels": [2.0, 7.0, 11.5, 20.0, 24.0, 30.0],
                   "slope": 0.1}
on_relays = lambda u: np.round(u * 8.0) / 8.0
wearing = {"operator": "bouc-wen-baber-noori", "range": [-30.0, 30.0], "beta": 0.05, "gamma_over_beta": 0.25,
           "strength_loss": 1e-4, "stiffness_loss": 2e-4, "pinch": 0.4, "pinch_width": 0.4, "weights": [1.4, 0.5]}
domains = {"operator": "jiles-atherton", "range": [-30.0, 30.0], "weights": [0.7, 0.1, 0.4]}
network = {"operator": "neural", "range": [-30.0, 30.0], "thresholds": thresholds, "slopes": [3.0, 5.0],
           "inputs": [0.0, -1.5], "biases": [1.5, -0.4]}
process = {"operator": "gaussian-process", "range": [-30.0, 30.0], "thresholds": thresholds, "memory": [3.0, 12.0],
           "length_input": 0.8, "length_plays": 1.3}
terms = {"operator": "narx", "range": [-30.0, 30.0], "reversible": [1, 2, 3], "moved": [0, 1, 2], "travelled": [1, 2],
         "rate": 0.05, "rate_slope": 0.3, "rate_bend": 0.2, "rise": 0.3, "rise_slope": -0.6, "rise_bend": 0.2,
         "weights": [1.2, 0.05, -0.05, 0.4, 0.05, -0.1, 0.05, -0.03]}
widths = {30.0: 2.0, 120.0: 4.0, 300.0: 7.0}  # by frequency
schedule = {"operator": "rate-scheduled", "reading": "held",
            "pairs": [{"frequency_hz": hz, "branches": pair(width)} for hz, width in widths.items()]}
cases = [
    (play, bipolar, SUM, {"operator": "prandtl-ishlinskii", "range": [-30.0, 30.0], "thresholds": thresholds,
                          "weights": six}),
    (play, unipolar, SUM, {"operator": "prandtl-ishlinskii", "range": [0.0, 100.0],
                           "thresholds": [float(r) for r in range(1, 40, 2)],
                           "weights": random.uniform(0.0, 0.1, 21).tolist()}),
    (stop, bipolar, SUM, {"operator": "stop", "range": [-30.0, 30.0], "thresholds": thresholds,
                          "weights": [1.2, 0.1, 0.2, 0.05, 0.1, 0.3]}),
    (kp, bipolar, SUM, {"operator": "krasnoselskii-pokrovskii", "range": [-30.0, 30.0], "levels": levels, "ridge": 7.0,
                        "weights": random.uniform(0.0, 1.0, 21).tolist()}),
    (bouc_wen, bipolar, EQUATION, {"operator": "bouc-wen", "range": [-30.0, 30.0], "beta": 0.02,
                                   "gamma_over_beta": 0.25, "weights": [1.4, 0.5]}),
    (bouc_wen, unipolar, EQUATION, {"operator": "bouc-wen", "range": [0.0, 100.0], "beta": 0.05,
                                    "gamma_over_beta": -0.6, "weights": [1.4, 0.5]}),
    (bouc_wen, bipolar, EQUATION, {"operator": "bouc-wen", "range": [-30.0, 30.0], "beta": 0.1,
                                   "gamma_over_beta": 1.7, "weights": [1.4, 0.5]}),
    (dahl, bipolar, EQUATION, {"operator": "dahl", "range": [-30.0, 30.0], "breakaway": 20.0, "exponent": 1.0,
                               "weights": [1.4, 0.5]}),
    (dahl, bipolar, EQUATION, {"operator": "dahl", "range": [-30.0, 30.0], "breakaway": 15.0, "exponent": 2.3,
                               "weights": [1.4, 0.5]}),
    (duhem, bipolar, EQUATION, {"operator": "duhem", "range": [-30.0, 30.0], "degree": 3, "alpha": 0.05,
                                "weights": [1.1, 0.1, -0.1, 0.4, 0.05, -0.1]}),
    (duhem, unipolar, EQUATION, {"operator": "duhem", "range": [0.0, 100.0], "degree": 4, "alpha": 0.2,
                                 "weights": [1.1, 0.1, -0.1, 0.2, 0.4, 0.05, -0.1, 0.3]}),
    (tellinen, inner, TABULATED, {"operator": "tellinen", **pair(3.0)}),
    (generalised_play, beyond, SUM, {
        "operator": "generalised-prandtl-ishlinskii", "range": [-30.0, 30.0], "thresholds": thresholds,
        "dead_zones": [-17.0, -4.0, 9.0], "ascending_quadratic": 0.2, "ascending_cubic": -0.3,
        "descending_quadratic": -0.1, "descending_cubic": 0.2, "weights": six + [0.1, -0.2, 0.3]}),
    (generalised_play, above, SUM, {
        "operator": "generalised-prandtl-ishlinskii", "range": [0.0, 100.0], "thresholds": thresholds,
        "dead_zones": [], "ascending_quadratic": -0.2, "ascending_cubic": 0.1,
        "descending_quadratic": 0.1, "descending_cubic": -0.2, "weights": six}),
    (rate_play, beyond, SUM, {"operator": "rate-dependent-prandtl-ishlinskii", "range": [-30.0, 30.0],
                              "thresholds": thresholds, "growth": 1.5, "rate": 3000.0, "weights": six}),
    (maxwell_slip, beyond, EQUATION, {"operator": "maxwell-slip", "range": [-30.0, 30.0], "thresholds": thresholds,
                                      "rise": 0.6, "rate": 6000.0, "attraction": 2e-3, "weights": six}),
    (maxwell_slip, unipolar, EQUATION, {"operator": "maxwell-slip", "range": [0.0, 100.0], "thresholds": thresholds,
                                        "rise": -0.4, "rate": 9000.0, "attraction": 5e-4, "weights": six}),
    (preisach, on_relays(beyond), SUM, {**relays, "reversible": random.uniform(0.0, 3.0, 7).tolist(),
                                        "weights": random.uniform(0.0, 1.0, 28).tolist()}),
    (preisach, on_relays(0.36 * unipolar - 1.0), SUM, {
        **unipolar_relays, "reversible": random.uniform(0.0, 3.0, 5).tolist(),
        "weights": random.uniform(0.0, 1.0, 15).tolist()}),
    (asymmetric_bouc_wen, beyond, EQUATION, {
        "operator": "asymmetric-bouc-wen", "range": [-30.0, 30.0], "beta": 0.05, "gamma_over_beta": 0.25,
        "loading_skew": 0.4, "unloading_skew": -0.3, "weights": [1.4, 0.5]}),
    (asymmetric_bouc_wen, unipolar, EQUATION, {
        "operator": "asymmetric-bouc-wen", "range": [0.0, 100.0], "beta": 0.02, "gamma_over_beta": -0.5,
        "loading_skew": -0.6, "unloading_skew": 0.2, "weights": [1.4, 0.5]}),
    (baber_noori, beyond, MIDPOINTS, wearing),
    # The range only sets the steps: of so small a range there are a thousand per sample.
    (baber_noori, beyond, FINE_MIDPOINTS, {**wearing, "range": [-0.01, 0.01]}),
    (jiles_atherton, beyond, RUNGE_KUTTA, {**domains, "a": 12.0, "k": 9.0, "coupling": 0.4}),
    (jiles_atherton, beyond, RUNGE_KUTTA, {**domains, "a": 2.0, "k": 9.0, "coupling": 0.9}),
    (jiles_atherton, beyond, FINE_RUNGE_KUTTA, {**domains, "a": 15.0, "k": 200.0, "coupling": 0.9}),
    (two_branch, beyond, SUM, {"operator": "two-branch", "reading": "held", **pair(3.0)}),
    (two_branch, beyond, SUM, {"operator": "two-branch", "reading": "printed", **pair(3.0)}),
    (rate_scheduled, rounded(sweep(200)), SUM, schedule),
    (narx, beyond, EQUATION, terms),
    (neural, beyond, SUM, {**network, "weights": six + random.uniform(-0.2, 0.2, 12).tolist()}),
    (neural, above, SUM, {**network, "range": [0.0, 100.0], "weights": six + random.uniform(-0.2, 0.2, 12).tolist()}),
    (gaussian_process, beyond, SUM, {**process, "points": random.uniform(-1.0, 1.0, (8, 3)).tolist(),
                                     "weights": six + random.uniform(-0.1, 0.1, 8).tolist()}),
    (gaussian_process, above, SUM, {**process, "range": [0.0, 100.0],
                                    "points": random.uniform(-1.0, 1.0, (8, 3)).tolist(),
                                    "weights": six + random.uniform(-0.1, 0.1, 8).tolist()}),
    (behind_a_driver, beyond, EQUATION, {"operator": "prandtl-ishlinskii", "range": [-30.0, 30.0],
                                         "thresholds": thresholds, "weights": six,
                                         "driver": {"lag_s": 1e-4, "slew": 12000.0}}),
]


def row(model, u, tolerance, doc):
    z = np.asarray(model(u, doc)).tolist()
    params = {name: value for name, value in doc.items() if name not in ["operator", "driver"]}
    driver = {"driver": doc["driver"]} if "driver" in doc else {}
    return {"operator": doc["operator"], **driver, "params": params, "tolerance": tolerance, "u": u.tolist(), "z": z}


if __name__ == "__main__":
    text = "[\n" + ",\n".join("  " + json.dumps(row(*case)) for case in cases) + "\n]\n"
    Path(__file__).with_suffix(".json").write_text(text)
