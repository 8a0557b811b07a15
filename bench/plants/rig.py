"""The rig of plants p22 to p27: one Rig writes train_*.csv, small_*.csv, test_*.csv (t_s,u_V,y_um), truth.json,
truth_y.npz.

The rig is simulated at fs*over. u_V is what was logged at the sample instant, y_um what the converter gave.
"""
import os, sys, zlib
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import cont2discrete, lfilter
from common import save


class Rig:
    def __init__(self, name, fs, over, held, range):
        self.out, self.seed = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 1
        os.makedirs(self.out, exist_ok=True)
        self.name, self.fs, self.over, self.held, self.range = name, fs, over, held, range
        self.T, self.Ts = 1 / (fs * over), 1 / fs
        k = zlib.crc32(name.encode())
        self.rng, self._j = np.random.default_rng([self.seed, k, 11]), np.random.default_rng([self.seed, k, 12])
        self.rec, self.clean = {}, {}

    def jit(self, v, rel):
        """seed 1 is nominal, another seed moves v by up to rel of itself"""
        k = 1 + rel * self._j.uniform(-1, 1)
        return v if self.seed == 1 else float(v * k)

    def _sample(self, u, t0, n):
        """n*over fine samples of u from t0 on"""
        if callable(u):
            if self.held:
                return np.repeat(u(t0 + np.arange(n) * self.Ts), self.over)
            return u(t0 + np.arange(n * self.over) * self.T)
        u = np.asarray(u, float)[:n]
        if self.held:
            return np.repeat(u, self.over)
        t = np.arange(len(u)) * self.Ts
        return CubicSpline(t, u)(np.minimum(np.arange(len(u) * self.over) * self.T, t[-1]))

    def _past(self, u, kind, level, sec, wait, hz):
        n = int(round(sec * self.fs))
        if kind == "run":
            return self._sample(u, -n * self.Ts, n)
        if kind == "rest":
            return np.full(n * self.over, float(level))
        # "after": two full cycles of the range, then a ramp to `level` and a wait
        lo, hi = self.range
        knots, vals, at = [0.0], [float(lo)], 0.0
        for v in (hi, lo, hi, lo, level):
            at += 0.5 / hz if v != level else 0.3 / hz
            knots.append(at); vals.append(float(v))
        t = np.arange(int(round((at + wait) * self.fs))) * self.Ts
        return np.repeat(np.interp(t, knots, vals), self.over)

    def record(self, name, u, seconds, plant, stroke, hist="after", level=0.0, sec=1.0, wait=0.5, cyc_hz=5.0,
               white=2e-4, pink=0.0, hum=0.0, lsb=None, drift=None, offset=0.0, u_lsb=None, read=0, note=None):
        """white, pink: rms as parts of stroke; hum: amplitude; lsb: um; read: fine samples y is read after u;
        drift(t, rng): part of stroke, is in the noise-free y"""
        n = int(round(seconds * self.fs))
        f = self._sample(u, 0.0, n)
        past = self._past(u, hist, level, sec, wait, cyc_hz)
        if u_lsb and self.held:
            f, past = np.round(f / u_lsb) * u_lsb, np.round(past / u_lsb) * u_lsb
        extra = int(np.ceil(read / self.over)) * self.over
        def run(p):
            x = np.r_[p, f, np.full(extra, f[-1])]
            return plant(x)[len(p) + read:len(p) + read + len(f):self.over]
        t, rng = np.arange(n) * self.Ts, self.rng
        clean = run(past) + offset * stroke + (stroke * drift(t, rng) if drift else 0.0)
        e = white * rng.standard_normal(n)
        if pink:
            e = e + pink * flicker(n, rng)
        if hum:
            f0, p = 50 * (1 + 4e-4 * rng.uniform(-1, 1)), rng.uniform(0, 6.28, 3)
            e = e + hum * sum(a * np.sin(2 * np.pi * k * f0 * t + q) for a, k, q in zip((1, .2, .35), (1, 2, 3), p))
        meas = clean + stroke * e
        if lsb:
            meas = np.round(meas / lsb) * lsb
        logged = f[::self.over].copy()
        if u_lsb:
            logged = np.round(logged / u_lsb) * u_lsb
        np.savetxt(os.path.join(self.out, name + ".csv"), np.c_[t, logged, meas], delimiter=",", header="t_s,u_V,y_um",
                   comments="", fmt=("%.8g", "%.7g", "%.7g"))
        rms, sd, pp = np.sqrt(np.mean((meas - clean) ** 2)), meas.std(), np.ptp(clean)
        pc = lambda x: float("%.4g" % (100 * x / sd))
        r = dict(samples=n, seconds=round(n * self.Ts, 6), noise_rms_um=float("%.4g" % rms),
                 std_y_um=float("%.5g" % sd), pp_y_um=float("%.5g" % pp),
                 floor_nrmse_percent=pc(rms), floor_pp_percent=float("%.4g" % (100 * rms / pp)),
                 u_min_V=float("%.5g" % logged.min()), u_max_V=float("%.5g" % logged.max()), history=hist)
        if note:
            r["note"] = note
        if name.startswith("test"):
            # the true plant, offset and drift taken out: what is left is the noise (and the drift)
            r["day_nrmse_percent"] = pc((meas - run(past)).std())
            g, p0 = {}, max(len(past) // 2 // self.over, 1000) * self.over
            for how, v in (("rest", None), ("from_top", self.range[1]), ("from_bottom", self.range[0])):
                h = np.full(p0, f[0]) if v is None else np.interp(
                    np.arange(p0), [0, p0 // 3, p0 * 2 // 3, p0], [self.range[0], self.range[1], v, f[0]])
                if self.held:
                    h = np.repeat(h[::self.over], self.over)
                g[how] = pc((meas - run(np.r_[h, np.full(p0, f[0])])).std())
            r["past_guess_nrmse_percent"] = g
        self.rec[name + ".csv"], self.clean[name] = r, clean

    def finish(self, **truth):
        save(self, self.held, truth)


# ---------------------------------------------------------------- noise, lags, modes, creep
def flicker(n, rng):
    """unit rms, about 1/f down to one period of the record"""
    F = np.fft.rfft(rng.standard_normal(n)); k = np.arange(len(F)); k[0] = 1
    x = np.fft.irfft(F / np.sqrt(k), n); x -= x.mean()
    return x / x.std()


def lag(x, tau, T):
    a = np.exp(-T / tau)
    return lfilter([1 - a], [1, -a], x - x[0]) + x[0]


def second(x, hz, zeta, T):
    w = 2 * np.pi * hz
    (b,), a, _ = cont2discrete(([w * w], [1, 2 * zeta * w, w * w]), T)
    return lfilter(b, a, x - x[0]) + x[0]


def modal(x, modes, T):
    """modes: (Hz, damping, share of the static gain); what the shares leave to 1 follows at once"""
    y = (1 - sum(m[2] for m in modes)) * x
    for hz, z, s in modes:
        y = y + s * second(x, hz, z, T)
    return y


def log_creep(x, per_decade, T, t_from=1e-3, t_to=200.0, per=3):
    """relaxations spread evenly in log time: what they add, not x itself"""
    n = int(np.log10(t_to / t_from) * per) + 1
    return per_decade / per * sum(lag(x, tau, T) for tau in np.logspace(np.log10(t_from), np.log10(t_to), n))


# ---------------------------------------------------------------- Preisach by Everett table
class Everett:
    """Preisach operator of any density on [lo,hi]; state: stack of turning points, starts at the bottom."""
    def __init__(self, lo, hi, density, n=300):
        self.lo, self.hi, self.n = lo, hi, n
        c = lo + (np.arange(n) + 0.5) * (hi - lo) / n
        A, Bt = np.meshgrid(c, c, indexing="ij")                # A: switching up, Bt: switching down
        D = np.where(A > Bt, density(A, Bt), 0.0) + np.where(A == Bt, 0.5 * density(A, Bt), 0.0)
        D /= D.sum()
        S = np.zeros((n + 1, n + 1)); S[1:, 1:] = D.cumsum(0).cumsum(1)     # over alpha<a, beta<b
        # F[a,b] = sum of cells with alpha<a and beta>b  (alpha>beta holds by itself)
        self.F = (S[:, -1:] - S).tolist()
        for i in range(n + 1):                                   # below the diagonal: nothing switches
            for k in range(i, n + 1):
                self.F[i][k] = 0.0
        self.scale = n / (hi - lo)
        self.reset()

    def reset(self):
        self.st, self.u, self.f, self.up = [(self.lo, 0.0)], self.lo, 0.0, True

    def tri(self, a, b):
        x, y, m = (a - self.lo) * self.scale, (b - self.lo) * self.scale, self.n - 1
        i, k = min(max(int(x), 0), m), min(max(int(y), 0), m)
        x -= i; y -= k
        P, Q = self.F[i], self.F[i + 1]
        return (1 - x) * ((1 - y) * P[k] + y * P[k + 1]) + x * ((1 - y) * Q[k] + y * Q[k + 1])

    def step(self, u):
        u = self.lo if u < self.lo else self.hi if u > self.hi else u
        if u == self.u:
            return self.f
        st = self.st
        if (u > self.u) != self.up:
            st.append((self.u, self.f)); self.up = not self.up
        if self.up:
            while len(st) > 2 and u >= st[-2][0]:
                del st[-2:]
            self.f = st[-1][1] + self.tri(u, st[-1][0])
        else:
            while len(st) > 2 and u <= st[-2][0]:
                del st[-2:]
            if len(st) == 2 and u <= st[0][0]:
                self.reset(); return 0.0
            self.f = st[-1][1] - self.tri(st[-1][0], u)
        self.u = u
        return self.f

    def __call__(self, u):
        self.reset()
        s = self.step
        return np.array([s(v) for v in u.tolist()])


def loop(run, lo, hi, n=4000):
    """closed slow loop: size, bottom, width at mid voltage in percent; run(u) -> z"""
    c = 0.5 * (1 - np.cos(2 * np.pi * np.arange(3 * n) / n))
    z = run(lo + (hi - lo) * c)[-n:]
    x = c[-n:]; h = n // 2
    up = np.interp(0.5, x[:h], z[:h]); dn = np.interp(0.5, x[h:][::-1], z[h:][::-1])
    return np.ptp(z), z.min(), float(100 * abs(dn - up) / np.ptp(z))


# ---------------------------------------------------------------- command signals (functions of t)
def poly(vertices, slopes, periodic=True):
    """straight lines through the vertices at the given slope(s), V/s"""
    v = np.asarray(vertices, float); s = np.broadcast_to(slopes, len(v) - 1)
    t = np.r_[0, np.cumsum(np.abs(np.diff(v)) / s)]
    return lambda x: np.interp(np.mod(x, t[-1]) if periodic else x, t, v)


def path(rng, f_lo, f_hi, lo, hi, seconds, n=60, tilt=1.0):
    """random-phase sines between f_lo and f_hi, amplitudes ~ f^-tilt, scaled to fill lo..hi"""
    f = np.exp(rng.uniform(np.log(f_lo), np.log(f_hi), n)); p = rng.uniform(0, 2 * np.pi, n)
    a = f ** -tilt * np.sqrt(f)
    raw = lambda t: sum(q * np.sin(2 * np.pi * g * t + r) for q, g, r in zip(a, f, p))
    y = raw(np.linspace(0, seconds, int(seconds * f_hi * 40)))
    m, h = (y.max() + y.min()) / 2, np.ptp(y) / 2
    return lambda t: (lo + hi) / 2 + (hi - lo) / 2 * np.clip((raw(t) - m) / h, -1, 1)


def soft(u, level, rise=0.15):
    """stands at `level` until t = 0, is u after `rise`"""
    def g(t):
        e = np.clip(t / rise, 0, 1); e = e * e * (3 - 2 * e)
        return level + e * (u(t) - level)
    return g


def stairs(rng, seconds, fs, lo, hi, hold, big, start):
    """random levels held for random times; steps of at most `big`"""
    out, v = [np.full(int(0.05 * fs), float(start))], start
    n = len(out[0])
    while n < seconds * fs:
        a, b = max(lo, v - big), min(hi, v + big)
        v = rng.uniform(a, b); m = int(rng.uniform(*hold) * fs)
        out.append(np.full(m, v)); n += m
    return np.concatenate(out)[:int(round(seconds * fs))]
