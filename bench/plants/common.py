"""The bench of the plants: measuring and saving. It also passes on hysteresis, dynamics and signals.

A plant file makes one Bench(name, fs, over), states its truth, and calls bench.record(...) for every CSV. The analog
system is simulated at fs*over; u_V is what the user logged (the DAC word or the generator voltage at the sample
instant), y_um what the converter gave.
"""

import json, os, sys, zlib
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter
from dynamics import *
from hysteresis import *
from signals import *


class Bench:
    def __init__(self, name, fs, over, analog, range, t_fmt="%.8g"):
        self.name, self.fs, self.over, self.analog, self.t_fmt = name, fs, over, analog, t_fmt
        self.range = range
        self.out = sys.argv[1]
        self.seed = int(sys.argv[2]) if len(sys.argv) > 2 else 1
        os.makedirs(self.out, exist_ok=True)
        key = zlib.crc32(name.encode())
        self.rng = np.random.default_rng([self.seed, key, 1])
        self._jit = np.random.default_rng([self.seed, key, 2])
        self.Ts, self.T = 1.0 / fs, 1.0 / (fs * over)
        self.truth, self.rec, self.clean = {}, {}, {}

    def jit(self, value, rel):
        """seed 1 is the nominal plant; another seed moves the value by up to rel of itself"""
        k = 1 + rel * self._jit.uniform(-1, 1)
        return value if self.seed == 1 else float(value * k)

    def day2(self, gain=0.005, creep=0.2, offset=0.05):
        """another day: gain by 60..100 % of `gain`, creep by 50..100 % of `creep`, offset by 40..100 % of `offset`
        (of stroke), either sign"""
        s = lambda a, lo: float(a * self._jit.uniform(lo, 1) * self._jit.choice([-1, 1]))
        return dict(gain=1 + s(gain, 0.6), creep=1 + s(creep, 0.5), offset=s(offset, 0.4))

    def _fine(self, u, seconds, hist):
        """logged u, fine u with the past in front, number of fine samples of the past"""
        n = int(round(seconds * self.fs))
        m = n * self.over
        T = self.T
        kind = hist.get("kind", "rest")
        p = int(round(hist.get("sec", 0.5) * self.fs)) * self.over
        if callable(u):
            if self.analog:
                f = u(np.arange(m) * T)
            else:
                f = np.repeat(u(np.arange(n) * self.Ts), self.over)
        else:
            u = np.asarray(u, float)[:n]
            if self.analog:
                f = CubicSpline(np.arange(n) * self.Ts, u)(np.minimum(np.arange(m) * T, (n - 1) * self.Ts))
            else:
                f = np.repeat(u, self.over)
        if kind == "rest":
            past = np.full(p, hist.get("level", 0.0))
        elif kind == "run":
            past = (
                u((np.arange(p) - p) * T)
                if self.analog
                else np.repeat(u((np.arange(p // self.over) - p // self.over) * self.Ts), self.over)
            )
        elif kind == "after":  # full-stroke cycles of an earlier run, then back to `level` and a wait
            lo, hi, hz, cyc, end, wait = (hist[k] for k in ("lo", "hi", "hz", "cycles", "level", "wait"))
            c = np.arange(int(cyc / hz / T)) * T
            a = lo + (hi - lo) * 0.5 * (1 - np.cos(2 * np.pi * hz * c))
            a = np.r_[a[0] * np.ones(100), a]
            k = int(0.25 / hz / T)
            past = np.r_[
                a,
                a[-1] + (end - a[-1]) * 0.5 * (1 - np.cos(np.pi * np.arange(1, k + 1) / k)),
                np.full(int(wait / T), end),
            ]
        elif kind == "decay":  # an oscillation that dies away about `level`: the ceramic is depolarised there
            c = np.arange(p) * T
            x = 1 - c / c[-1]
            past = hist["level"] + hist["amp"] * x * np.sin(2 * np.pi * hist["hz"] * c)
            past = np.r_[past, np.full(int(hist["wait"] / T), hist["level"])]
        elif kind == "path":
            past = np.repeat(hist["u"], self.over)
        return f, past

    def record(
        self,
        name,
        u,
        seconds,
        plant,
        train,
        stroke,
        day=None,
        hist=None,
        noise=2e-4,
        pink=0.0,
        hum=0.0,
        bits=16,
        span=1.5,
        drift=None,
        u_range=None,
        u_bits=None,
        u_noise=0.0,
        skew=0,
        ref=None,
        note=None,
        offset=0.0,
        noise_given=None,
    ):
        """plant(u_fine, **parameters) -> displacement (um, fine); train, day: its parameters on the two days
        (`offset` is taken out).
        noise, pink, hum: rms (hum: amplitude) as parts of stroke; span: converter range in strokes; skew: fine steps
        y is read after u"""
        hist = hist or {}
        p = dict(day if day is not None else train)
        off = offset + p.pop("offset", 0.0) * stroke
        base = {k: v for k, v in train.items() if k != "offset"}
        f, past = self._fine(u, seconds, hist)
        if u_bits and not self.analog:
            q = u_range / 2**u_bits
            f = np.round(f / q) * q
            past = np.round(past / q) * q
        cut = slice(len(past) + skew, len(past) + skew + len(f), self.over)
        full = np.r_[past, f, np.full(skew, f[-1])]
        y = plant(full, **p)[cut]
        n = len(y)
        t = np.arange(n) * self.Ts
        rng = self.rng
        d = stroke * drift(t, rng) if drift else 0.0
        clean = y + off + d
        e = noise * stroke * rng.standard_normal(n) if noise_given is None else noise_given[:n]
        if pink:
            w = rng.standard_normal(n)
            e = e + pink * stroke * _pink(w)
        if hum:
            e = e + stroke * _hum(t, hum, rng)
        lsb = span * stroke / 2**bits
        meas = np.round((clean + e) / lsb) * lsb
        logged = f[:: self.over].copy()
        if u_noise:
            logged += u_noise * rng.standard_normal(n)
        if u_bits and (self.analog or u_noise):
            q = u_range / 2**u_bits
            logged = np.round(logged / q) * q
        body = np.c_[t, logged, meas]
        path = os.path.join(self.out, name + ".csv")
        np.savetxt(path, body, delimiter=",", header="t_s,u_V,y_um", comments="", fmt=(self.t_fmt, "%.6g", "%.7g"))
        sd = meas.std()
        rms = np.sqrt(np.mean((meas - clean) ** 2))
        pc = lambda x: float("%.4g" % (100 * x / sd))
        r = dict(
            samples=n,
            seconds=round(n * self.Ts, 6),
            noise_rms_um=float("%.4g" % rms),
            std_y_um=float("%.5g" % sd),
            floor_nrmse_percent=pc(rms),
            history=hist.get("kind", "rest"),
        )
        if day is not None:
            r["day"] = {k: (float("%.5g" % v) if np.isscalar(v) else v) for k, v in day.items()}
        if note:
            r["note"] = note
        if name.startswith("test"):
            a = meas - plant(full, **base)[cut]
            r["day_nrmse_percent"] = pc(a.std())
            # the past unknown, three guesses: u[0] for ever, reached from rest at 0, from the top of the
            # range, or from its bottom
            r["past_guess_nrmse_percent"] = {}
            p0 = max(len(past) // 2, 2000)
            k = len(past) + p0
            for how, v in (("rest", None), ("from_top", self.range[1]), ("from_bottom", self.range[0])):
                g = (
                    np.full(p0, f[0])
                    if v is None
                    else np.interp(
                        np.arange(p0), [0, p0 // 3, p0 * 2 // 3, p0], [self.range[0], self.range[1], v, f[0]]
                    )
                )
                b = np.r_[g, np.full(len(past), f[0]), f, np.full(skew, f[-1])]
                a = meas - plant(b, **base)[k + skew : k + skew + len(f) : self.over]
                r["past_guess_nrmse_percent"][how] = pc(a.std())
        if ref is not None:
            a = ref(full, **base)[cut]
            X = np.c_[a, np.ones(n)]
            c = np.linalg.lstsq(X, meas, rcond=None)[0]
            r["hammerstein_nrmse_percent"] = pc((meas - X @ c).std())
        if np.ptp(meas) > span * stroke:
            print(self.name, name, "leaves the converter: %.2f of span" % (np.ptp(meas) / span / stroke))
        if os.path.getsize(path) > 8e6:
            raise SystemExit(path + " is larger than 8 MB")
        self.rec[name + ".csv"] = r
        self.clean[name] = clean
        return r

    def finish(self, **truth):
        save(self, not self.analog, truth)


def rounded(x):
    """numbers of a truth with six digits, for JSON"""
    if isinstance(x, dict):
        return {k: rounded(v) for k, v in x.items()}
    if isinstance(x, (list, tuple, np.ndarray)):
        return [rounded(v) for v in x]
    if isinstance(x, (float, np.floating)):
        return float("%.6g" % x)
    return int(x) if isinstance(x, np.integer) else x


def save(bench, held, truth):
    """truth.json and truth_y.npz of a bench or rig"""
    j = dict(name=bench.name, seed=bench.seed, fs_Hz=bench.fs, u_held_by_DAC=held, range_V=list(bench.range))
    json.dump(dict(j, truth=rounded(truth), records=bench.rec), open(os.path.join(bench.out, "truth.json"), "w"), indent=1)
    np.savez_compressed(os.path.join(bench.out, "truth_y.npz"), **bench.clean)


def _pink(w):
    """unit rms, about 1/f"""
    b = [0.049922035, -0.095993537, 0.050612699, -0.004408786]
    a = [1, -2.494956002, 2.017265875, -0.522189400]
    x = lfilter(b, a, w)
    return x / x.std()


def _hum(t, amp, rng):
    f = 50 * (1 + 3e-4 * rng.uniform(-1, 1))
    ph = rng.uniform(0, 2 * np.pi, 3)
    wob = 1 + 0.05 * np.sin(2 * np.pi * 0.21 * t + ph[2])
    return amp * (
        wob * np.sin(2 * np.pi * f * t + ph[0])
        + 0.28 * np.sin(6 * np.pi * f * t + ph[1])
        + 0.1 * np.sin(4 * np.pi * f * t + ph[2])
    )
