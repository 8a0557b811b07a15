"""Shared numpy helpers of the plants: hysteresis, lags, modes, signals, measuring, saving. numpy and scipy only;
nothing
of any library.

A plant file makes one Bench(name, fs, over), states its truth, and calls bench.record(...) for every CSV. The analog
system is simulated
at fs*over; u_V is what the user logged (the DAC word or the generator voltage at the sample instant), y_um what the
converter gave.
"""

import json, os, sys, zlib
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import butter, cont2discrete, lfilter, sosfilt


# ---------------------------------------------------------------- hysteresis
def _segments(v):
    """indices of the turning points of a path without equal neighbours, first and last included"""
    d = np.sign(np.diff(v))
    return np.r_[0, np.flatnonzero(d[1:] != d[:-1]) + 1, len(v) - 1]


def _unique(u):
    keep = np.r_[True, np.diff(u) != 0]
    return u[keep], np.cumsum(keep) - 1


def plays(u, r, value, start=0.0, up=None, down=None, chunk=20000):
    """(generalised) plays; value(S) maps the states (n, len(r)) to z (n,). The past: rest at `start`, from the state
    of rest at 0.
    up, down: edges of the play, up(u) - r while rising, down(u) + r while falling (identity when None)"""
    up = up or (lambda x: x)
    down = down or up
    v, back = _unique(np.asarray(u, float))
    z = np.empty(len(v))
    s = np.zeros(len(r))
    s = np.clip(s, up(start) - r, down(start) + r)
    s = np.clip(s, up(v[0]) - r, down(v[0]) + r)
    z[0] = value(s[None])[0]
    if len(v) > 1:
        turn = _segments(v)
        for a, b in zip(turn[:-1], turn[1:]):
            rising = v[b] > v[a]
            for i in range(a + 1, b + 1, chunk):
                x = v[i : min(i + chunk, b + 1), None]
                S = np.maximum(s, up(x) - r) if rising else np.minimum(s, down(x) + r)
                z[i : i + len(x)] = value(S)
                s = S[-1]
    return z[back]


def everett_table(density, lo, hi, n=500):
    """E(a, b): integral of density(a, b) over the triangle b <= beta <= alpha <= a, on an (n+1)^2 grid, bilinear
    between"""
    h = (hi - lo) / n
    c = lo + h * (np.arange(n) + 0.5)
    A, Bt = np.meshgrid(c, c, indexing="ij")
    p = np.where(A > Bt, density(A, np.minimum(A, Bt)), 0.0) * h * h
    p[np.arange(n), np.arange(n)] = 0.5 * density(c, c) * h * h
    # E(a_i, b_j) = sum over alpha cells < i and beta cells >= j
    t = np.zeros((n + 1, n + 1))
    t[1:, :n] = np.cumsum(np.cumsum(p, 0)[:, ::-1], 1)[:, ::-1]
    t = np.where(np.arange(n + 1)[:, None] >= np.arange(n + 1)[None], t, 0.0)
    t = t + t.T

    def E(a, b):
        x = np.clip((np.asarray(a, float) - lo) / h, 0, n - 1e-9)
        y = np.clip((np.asarray(b, float) - lo) / h, 0, n - 1e-9)
        i = x.astype(int)
        j = y.astype(int)
        x = x - i
        y = y - j
        return (1 - x) * ((1 - y) * t[i, j] + y * t[i, j + 1]) + x * ((1 - y) * t[i + 1, j] + y * t[i + 1, j + 1])

    return E


def preisach(u, E, lo, past=()):
    """Preisach operator by its Everett function; saturated at lo, then the extremes in `past`, then u"""
    v, back = _unique(np.r_[lo, np.asarray(past, float), np.maximum(np.asarray(u, float), lo)])
    z = np.zeros(len(v))
    st = []
    turn = _segments(v) if len(v) > 1 else [0]
    for a, b in zip(turn[:-1], turn[1:]):
        st.append((v[a], z[a]))
        i = a + 1
        rising = v[b] > v[a]
        while True:
            m, zm = st[-1]
            x = v[i : b + 1]
            if len(st) < 2 or (not rising and len(st) == 2):
                k = len(x)
            else:
                M = st[-2][0]
                k = int(np.searchsorted(x, M)) if rising else int(np.searchsorted(-x, -M))
            y = x[:k]
            z[i : i + k] = zm + E(y, np.full(k, m)) if rising else zm - E(np.full(k, m), y)
            i += k
            if i > b:
                break
            st.pop()
            st.pop()
    return z[back][1 + len(past) :]


def loop(hyst, lo, hi, n=4000):
    """stroke, lowest value and width (percent of stroke, at mid voltage) of the closed loop lo..hi of a
    rate-independent operator"""
    c = 0.5 * (1 - np.cos(2 * np.pi * np.arange(3 * n + 1) / n))
    u = lo + (hi - lo) * c
    z = hyst(u)[2 * n :]
    uu = u[2 * n :]
    h = n // 2
    mid = 0.5 * (lo + hi)
    w = np.interp(mid, uu[: h + 1], z[: h + 1]) - np.interp(mid, uu[h:][::-1], z[h:][::-1])
    return np.ptp(z), z.min(), abs(w) / np.ptp(z) * 100


# ---------------------------------------------------------------- linear parts, exact for an input held over the fine
# step
def _steady(b, a, z):
    b, a = np.atleast_1d(b), np.atleast_1d(a)
    return lfilter(b, a, z - z[0]) + z[0] * b.sum() / a.sum()


def lag(z, tau, T):
    e = -np.expm1(-T / tau)
    return z[0] + lfilter([e], [1, e - 1], z - z[0])


def lag2(z, f, zeta, T):
    """second-order low pass or mode of unit static gain; started at rest"""
    w = 2 * np.pi * f
    b, a, _ = cont2discrete(([w * w], [1, 2 * zeta * w, w * w]), T)
    return z[0] + lfilter(b[0], a, z - z[0])


def modes(z, table, T, residual=0.0):
    """sum of share * mode + residual * z; table: (f_Hz, zeta, share)"""
    y = residual * z
    for f, zeta, share in table:
        y = y + share * lag2(z, f, zeta, T)
    return y


def creep_log(z, g, T, lo=1e-3, hi=1e2, n=40):
    """g of the step more per decade of time, from lo to hi seconds"""
    taus = np.logspace(np.log10(lo), np.log10(hi), n)
    gap = np.log10(taus[1] / taus[0])
    return z + g * gap * sum(lag(z, t, T) for t in taus)


def creep_lags(z, taus, gains, T):
    return z + sum(g * lag(z, t, T) for t, g in zip(taus, gains))


def delay(z, n):
    return np.r_[np.full(n, z[0]), z[:-n]] if n else z


# ---------------------------------------------------------------- signals: functions of t (s) or arrays at fs
def tri(t, f):
    """triangle -1..1, from -1 upward at t = 0"""
    x = np.mod(f * t, 1.0)
    return 1 - 4 * np.abs(x - 0.5)


def ramp01(t, t0, t1):
    return np.clip((t - t0) / (t1 - t0), 0, 1)


def multisine(t, period, freqs, rng, amp=None):
    """random phases; each frequency is rounded to a line of the period; scaled to peak 1 over one period of 4096*4
    points"""
    k = np.unique(np.round(np.asarray(freqs) * period).astype(int))
    k = k[k > 0]
    a = np.ones(len(k)) if amp is None else amp(k / period)
    ph = rng.uniform(0, 2 * np.pi, len(k))

    def x(tt):
        y = np.zeros(len(tt))
        for kk, aa, p in zip(k, a, ph):
            y += aa * np.cos(2 * np.pi * kk / period * tt + p)
        return y

    top = np.abs(x(np.arange(16384) * period / 16384)).max()
    return x(t) / top


def random_walk(rng, n, smooth, taper=0):
    x = np.cumsum(rng.standard_normal(n))
    x -= np.linspace(x[0], x[-1], n)
    b = np.ones(smooth) / smooth
    x = lfilter(b, 1, lfilter(b, 1, x))
    return x / np.abs(x).max()


def noise_band(rng, n, fs, f, order=4):
    x = sosfilt(butter(order, f, fs=fs, output="sos"), rng.standard_normal(n + 2000))[2000:]
    return x / np.abs(x).max()


def zigzag(rng, seconds, fs, lo, hi, leg=(0.01, 0.1), start=0.0, hold=0.0, smooth=True, min_swing=0.03):
    """random turning points joined by straight or cosine legs of random duration; with probability `hold` a pause
    follows"""
    n = int(seconds * fs)
    out = []
    v = start
    m = 0
    while m < n:
        w = rng.uniform(lo, hi) if rng.random() < 0.5 else np.clip(v + rng.normal(0, 0.2) * (hi - lo), lo, hi)
        if abs(w - v) < min_swing * (hi - lo):
            continue
        k = max(2, int(np.exp(rng.uniform(np.log(leg[0]), np.log(leg[1]))) * fs))
        x = np.arange(1, k + 1) / k
        out.append(v + (w - v) * (0.5 - 0.5 * np.cos(np.pi * x) if smooth else x))
        m += k
        v = w
        if rng.random() < hold:
            k = int(rng.uniform(0.3, 1.5) * leg[1] * fs)
            out.append(np.full(k, v))
            m += k
    return np.concatenate(out)[:n]


def steps(rng, seconds, fs, lo, hi, hold=(0.005, 0.1)):
    n = int(seconds * fs)
    out = []
    m = 0
    while m < n:
        k = max(1, int(np.exp(rng.uniform(*np.log(hold))) * fs))
        out.append(np.full(k, rng.uniform(lo, hi)))
        m += k
    return np.concatenate(out)[:n]


def prbs(n, bits=11, clock=1):
    reg = [1] * bits
    tap = {7: 6, 9: 5, 10: 7, 11: 9, 12: None}[bits]
    seq = []
    for _ in range(2**bits - 1):
        seq.append(reg[-1])
        reg = [reg[-1] ^ reg[tap - 1]] + reg[:-1]
    s = np.repeat(2.0 * np.array(seq) - 1, clock)
    return np.tile(s, n // len(s) + 1)[:n]


# ---------------------------------------------------------------- the bench
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
        rd = lambda x: (
            float("%.6g" % x)
            if isinstance(x, (float, np.floating))
            else [rd(i) for i in x]
            if isinstance(x, (list, tuple, np.ndarray))
            else {k: rd(v) for k, v in x.items()}
            if isinstance(x, dict)
            else int(x)
            if isinstance(x, np.integer)
            else x
        )
        j = dict(
            name=self.name,
            seed=self.seed,
            fs_Hz=self.fs,
            u_held_by_DAC=not self.analog,
            range_V=list(self.range),
            truth=rd(truth),
            records=self.rec,
        )
        json.dump(j, open(os.path.join(self.out, "truth.json"), "w"), indent=1)
        np.savez_compressed(os.path.join(self.out, "truth_y.npz"), **self.clean)


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
