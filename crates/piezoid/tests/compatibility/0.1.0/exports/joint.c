/* joint.c: see joint.h */
#include "joint.h"

#if JOINT_SET != 0x713F4687u
#error "joint.h is of another export than this file: export again"
#endif

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF /* the same bits on every machine */
#endif

/* Elementary functions with bit-identical results on every machine */

/* The size of v. */
static double joint_magnitude(double v)
{
    double size = v;
    if (v < 0.0) {
        size = -v;
    }
    return size;
}

/* Which way v points: 1, -1, or 0. */
static double joint_way(double v)
{
    double points = 0.0;
    if (v > 0.0) {
        points = 1.0;
    }
    if (v < 0.0) {
        points = -1.0;
    }
    return points;
}

/* v, clipped to low..high; if low > high, the result is low. */
static double joint_clamp(double v, double low, double high)
{
    double held = v;
    if (held > high) {
        held = high;
    }
    if (held < low) {
        held = low;
    }
    return held;
}

/* Preisach: relays on a triangular grid: asymmetric loops of any shape, minor loops, wiping-out */

static const double joint_hysteresis_levels[17] = {
    -37.333333333333336, -32.666666666666664, -28.0, -23.333333333333332, -18.666666666666664, -14.0,
    -9.333333333333332, -4.666666666666664, 0.0, 4.666666666666671, 9.333333333333336, 14.0, 18.66666666666667,
    23.333333333333336, 28.0, 32.66666666666667, 37.33333333333334,
};
static const double joint_hysteresis_nodes[289] = {
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.16473082607869716, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5626590161374923, 0.1956017530265955, 0.0, 0.0, 0.0, 0.0,
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.2575884343200427, 0.6546946366024926,
    0.22762818977553007, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.304585652576818,
    1.4405579933578707, 0.7517283426739108, 0.2624183184800439, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    0.0, 0.0, 0.0, 3.7342890841116216, 2.597438295207318, 1.6273058039138883, 0.849573212666094, 0.2933905743881767,
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 5.536852788456054, 4.133428664638142,
    2.879153359618929, 1.8003025206481145, 0.9290654935727318, 0.31514803186278867, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    0.0, 0.0, 0.0, 0.0, 0.0, 7.654176548821375, 6.008860013080991, 4.487475912570638, 3.1156415303379505,
    1.9278864502939002, 0.980961879143079, 0.3270977057379654, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    9.998847731978488, 8.150460746569289, 6.396329983565117, 4.761039454672048, 3.280287011851768, 2.013511179160864,
    1.0169034715641088, 0.33948864062679296, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 12.518147641557917,
    10.512110029716787, 8.569502856903503, 6.7145228684722, 4.9835602986605325, 3.434139049268693,
    2.1165547096235517, 1.0843109072441999, 0.37355805818934307, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    15.191616024025459, 13.071871709640806, 10.985583219375867, 8.958284714391176, 7.027241269258582,
    5.24431463958333, 3.645106338472301, 2.2752470598894226, 1.184277938271626, 0.4096979693757388, 0.0, 0.0, 0.0,
    0.0, 0.0, 0.0, 0.0, 18.049424158781022, 15.852966146798538, 13.661022589234037, 11.501800601394033,
    9.414167726641374, 7.4406685727429585, 5.595890427266683, 3.9149184683061335, 2.455010821377421,
    1.2736339702514363, 0.4378571821325905, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 21.15294202695694, 18.908360587323163,
    16.639871099246392, 14.377685060007721, 12.162118168789608, 10.022102136804033, 7.955650158451679,
    5.987910589092635, 4.179315661469649, 2.6016206621881235, 1.33924992777342, 0.45714515698397956, 0.0, 0.0, 0.0,
    0.0, 0.0, 24.53618994058488, 22.26467896901095, 19.94215764631421, 17.59846231268345, 15.271174243154228,
    12.97976768253402, 10.709500093601742, 8.476611191371319, 6.342012803770369, 4.386386157623402,
    2.707608691615225, 1.3842129226646305, 0.46975512566972405, 0.0, 0.0, 0.0, 0.0, 28.20990125265315,
    25.926982772322827, 23.56870489115801, 21.16234679302027, 18.74085026273386, 16.316009901483557,
    13.862492999876466, 11.387883666719869, 8.950757112811035, 6.637082081473403, 4.555466576275775,
    2.7969897134331623, 1.4258512265709755, 0.48428590281871237, 0.0, 0.0, 0.0, 32.18538275563503,
    29.902464275304713, 27.524280812474323, 25.07388143004115, 22.578171970250445, 20.04078801906671,
    17.426551200647598, 14.73421578624193, 12.018153373886348, 9.366807855745906, 6.897134738819316,
    4.7117018476885555, 2.8860913955560887, 1.4711108557828163, 0.49936911370906, 0.0, 0.0,
};
static const double joint_hysteresis_diagonal[16] = {
    0.06283510666850861, 0.07837753560702439, 0.09465246543947058, 0.11388426757896448, 0.13144654355241941,
    0.14380618736446044, 0.14902486214829053, 0.15150648266943356, 0.16466305272367407, 0.18854579581136693,
    0.21050574196300226, 0.22612677243197474, 0.23501616010200294, 0.2407016353750263, 0.2477776859701948,
    0.25524746532312903,
};
static const double joint_hysteresis_diagonal_below[17] = {
    0.0, 0.06283510666850861, 0.14121264227553298, 0.23586510771500357, 0.34974937529396805, 0.48119591884638746,
    0.625002106210848, 0.7740269683591385, 0.9255334510285721, 1.090196503752246, 1.278742299563613,
    1.4892480415266154, 1.71537481395859, 1.950390974060593, 2.191092609435619, 2.438870295405814,
    2.6941177607289433,
};
static const double joint_hysteresis_breaks[29] = {
    -37.33333333333334, -37.333333333333336, -32.66666666666667, -32.666666666666664, -28.0, -23.333333333333336,
    -23.333333333333332, -18.66666666666667, -18.666666666666664, -14.0, -9.333333333333336, -9.333333333333332,
    -4.666666666666671, -4.666666666666664, -0.0, 4.666666666666664, 4.666666666666671, 9.333333333333332,
    9.333333333333336, 14.0, 18.666666666666664, 18.66666666666667, 23.333333333333332, 23.333333333333336, 28.0,
    32.666666666666664, 32.66666666666667, 37.333333333333336, 37.33333333333334,
};
static const double joint_hysteresis_virgin[84] = {
    -14.364574951846425, -14.364574951846425, -14.364574951846425, -14.364574951846425, -13.175989381679878,
    -12.018821364847591, -12.018821364847591, -12.018821364847591, -12.01882136484759, -12.01882136484759,
    -10.785368842368426, -9.600044227309793, -9.600044227309793, -8.36739587321382, -7.202451075435603,
    -7.202451075435603, -7.202451075435603, -7.202451075435601, -7.202451075435601, -6.0252461812005045,
    -4.936966924871254, -4.936966924871254, -4.936966924871253, -4.936966924871252, -4.936966924871252,
    -3.875454005785625, -2.9273074895319997, -2.9273074895319997, -2.0550516936363765, -1.325104981789455,
    -1.325104981789455, -1.3251049817894545, -1.3251049817894538, -1.3251049817894538, -0.7415680554188154,
    -0.3212508029828308, -0.3212508029828308, -0.32125080298283026, -0.3212508029828298, -0.3212508029828298,
    -0.08031270074570745, 0.0, 0.0, 0.08360184325926745, 0.3344073730370698, 0.3344073730370698, 0.3344073730370703,
    0.3344073730370708, 0.3344073730370708, 0.7983085767288702, 1.445189921186862, 1.445189921186862,
    1.4451899211868626, 1.4451899211868633, 1.4451899211868633, 2.297295166285225, 3.325059272731559,
    3.325059272731559, 4.50358949794726, 5.84282624043474, 5.84282624043474, 5.842826240434741, 5.842826240434745,
    5.842826240434745, 7.29154725359254, 8.889759850917708, 8.889759850917708, 8.88975985091771, 8.88975985091771,
    8.88975985091771, 10.57051254789834, 12.39199338616451, 12.39199338616451, 14.271680999887462, 16.28419659621254,
    16.28419659621254, 16.284196596212542, 16.284196596212542, 16.284196596212542, 18.335749214034255,
    20.51492556451755, 20.51492556451755, 20.51492556451756, 20.51492556451756,
};
static const double joint_hysteresis_reversible_starts[16] = {
    -36.91828045486959, -32.3144783351532, -27.71067621543681, -23.10687409572042, -18.477846027692735,
    -13.837808700964711, -9.206923376218974, -4.596341961863753, 0.0, 4.595663286491018, 9.206061221071792,
    13.83600782533069, 18.471319972924544, 23.091599306457987, 27.68059458327075, 32.269589860083514,
};
static const double joint_hysteresis_reversible_slopes[16] = {
    0.9865290256535113, 0.9865290256535127, 0.986529025653512, 0.991934586005932, 0.9942937128702914,
    0.992332569588372, 0.9879817316475471, 0.9849304203993762, 0.98478498996236, 0.9879424145530235,
    0.9921314151983359, 0.9932811744843961, 0.9900598571857381, 0.9833561307455925, 0.983356130745591,
    0.983356130745591,
};
static const double joint_hysteresis_at_once = 0.0;

/* Number of stored reversals. Input and sum are stored alternately, the oldest first. */
static double joint_stored(const joint_hysteresis_state *x)
{
    double n = 0.0;
    /* A NaN counts as 0. */
    if (x->count > 0.0) {
        n = joint_clamp(x->count, 0.0, (double)(64));
    }
    return n;
}

/* 1 if the move to u is a reversal, else 0. */
static double joint_turns(const joint_hysteresis_state *x, double u)
{
    const int n = (int)(joint_stored(x));
    double so_far = x->last;
    if (n > 0) {
        so_far = x->last - x->reversal[2 * (n - 1)];
    }
    double round = 0.0;
    if (((so_far > 0.0) && (u < x->last)) || ((so_far < 0.0) && (u > x->last))) {
        round = 1.0;
    }
    return round;
}

/* How many of n reversals remain after the input moves to u (wiping-out). Reversal n may be the present input, which is not stored. */
static double joint_kept(const joint_hysteresis_state *x, int n, double u)
{
    int left = n;
    int closes = 1;
    while ((left > 0) && (closes > 0)) {
        int older = 0;
        if (left > 1) {
            older = left - 2;
        }
        double limit = x->last;
        if (older < (int)(joint_stored(x))) {
            limit = x->reversal[2 * older];
        }
        /* The first reversal is compared with its own value of the opposite sign. */
        if (left == 1) {
            limit = -limit;
        }
        if (((u > x->last) && (u >= limit)) || ((u < x->last) && (u <= limit))) {
            left = older;
        } else {
            closes = 0;
        }
    }
    return (double)(left);
}

/* Makes room for two reversals: removes the two neighbouring reversals whose removal changes the smallest area of the Preisach plane. */
static void joint_forget(joint_hysteresis_state *x)
{
    double fewest = -1.0;
    int chosen = 1;
    for (int i = 1; i < 63; i++) {
        double after = x->last;
        if ((i + 2) < 64) {
            after = x->reversal[2 * (i + 2)];
        }
        const double relays = joint_magnitude((x->reversal[2 * i] - after) * (x->reversal[2 * (i + 1)] - x->reversal[2
            * (i - 1)]));
        if ((relays < fewest) || (fewest < 0.0)) {
            fewest = relays;
            chosen = i;
        }
    }
    for (int i = 2 * chosen; i < 2 * 62; i++) {
        x->reversal[i] = x->reversal[i + 4];
    }
    x->count = (double)(62);
}

/* Remembers where the input is. */
static void joint_remember(joint_hysteresis_state *x)
{
    if ((int)(joint_stored(x)) == 64) {
        joint_forget(x);
    }
    const int i = 2 * (int)(joint_stored(x));
    x->reversal[i] = x->last;
    x->reversal[i + 1] = x->sum;
    x->count = x->count + 1.0;
}

/* The index of the interval that contains u, between the edges first and last; the outermost one if u lies outside. */
static double joint_row(int first, int last, double u)
{
    int below = first;
    int above = last;
    while (above > (below + 1)) {
        const int middle = (below + above) / 2;
        if (joint_hysteresis_levels[middle] <= u) {
            below = middle;
        } else {
            above = middle;
        }
    }
    return (double)(below);
}

/* The index of the interval that contains u, between the edges first and last; the outermost one if u lies outside. */
static double joint_piece(int first, int last, double u)
{
    int below = first;
    int above = last;
    while (above > (below + 1)) {
        const int middle = (below + above) / 2;
        if (joint_hysteresis_breaks[middle] <= u) {
            below = middle;
        } else {
            above = middle;
        }
    }
    return (double)(below);
}

/* The fraction of the interval low..high that lies below v (0 to 1), and its slope. */
static double joint_share_below(double v, double v_slope, double low, double high, double *also)
{
    double share = (v - low) / (high - low);
    double slope = v_slope / (high - low);
    if (share > 1.0) {
        share = 1.0;
        slope = 0.0;
    }
    if (share < 0.0) {
        share = 0.0;
        slope = 0.0;
    }
    *also = slope;
    return share;
}

/* Everett's function at M = l_i, for m at a share b of the way from l_j to l_j+1, and its slope. */
static double joint_everett_at(int i, int j, double b, double b_slope, double *also)
{
    const int k = i * 17 + j;
    *also = b_slope * joint_hysteresis_nodes[k + 1] - b_slope * joint_hysteresis_nodes[k];
    return b * joint_hysteresis_nodes[k + 1] + (1.0 - b) * joint_hysteresis_nodes[k];
}

/* Everett's function: the sum of the weights of the relays that switch between low and high, and its slope. */
static double joint_everett(double low, double high, double low_slope, double high_slope, double *also)
{
    const int i = (int)(joint_row(0, 16, high));
    const int j = (int)(joint_row(0, 16, low));
    double a_slope = 0.0;
    const double a = joint_share_below(high, high_slope, joint_hysteresis_levels[i], joint_hysteresis_levels[i + 1],
        &a_slope);
    double b_slope = 0.0;
    const double b = joint_share_below(low, low_slope, joint_hysteresis_levels[j], joint_hysteresis_levels[j + 1],
        &b_slope);
    double sum = joint_hysteresis_diagonal[i] * (a - b) * (a - b);
    double slope = joint_hysteresis_diagonal[i] * (a_slope - b_slope) * (a - b) + joint_hysteresis_diagonal[i] * (a - b)
        * (a_slope - b_slope);
    if (i != j) {
        double before_slope = 0.0;
        const double before = joint_everett_at(i, j, b, b_slope, &before_slope);
        double after_slope = 0.0;
        const double after = joint_everett_at(i + 1, j, b, b_slope, &after_slope);
        const double c = 1.0 - b;
        sum = (1.0 - a) * before + a * after + (joint_hysteresis_diagonal_below[i] - joint_hysteresis_diagonal_below[j
            + 1]);
        sum = sum + joint_hysteresis_diagonal[i] * a * a + joint_hysteresis_diagonal[j] * c * c;
        slope = -a_slope * before + (1.0 - a) * before_slope + (a_slope * after + a * after_slope);
        slope = slope + (joint_hysteresis_diagonal[i] * a_slope * a + joint_hysteresis_diagonal[i] * a * a_slope);
        slope = slope + (joint_hysteresis_diagonal[j] * (-b_slope) * c + joint_hysteresis_diagonal[j] * c * (-b_slope));
    }
    *also = slope;
    return sum;
}

/* The weights of the relays that turn from rest to u, negative for negative u, and the slope. */
static double joint_since_rest(double u, double *also)
{
    const int i = (int)(joint_piece(0, 28, u));
    double s_slope = 0.0;
    const double s = joint_share_below(u, 1.0, joint_hysteresis_breaks[i], joint_hysteresis_breaks[i + 1], &s_slope);
    /* At the start of a piece, halfway, and at its end. */
    const double start = joint_hysteresis_virgin[3 * i];
    const double middle = joint_hysteresis_virgin[3 * i + 1];
    const double stop = joint_hysteresis_virgin[3 * i + 2];
    const double rise = 4.0 * middle - 3.0 * start - stop;
    const double bend = start + stop - 2.0 * middle;
    const double steep = rise + 2.0 * s * bend;
    *also = s_slope * steep + s * (2.0 * s_slope * bend);
    return start + s * steep;
}

/* The part of z that follows u without memory, and its slope. */
static double joint_reversible(double u, double *also)
{
    const int i = (int)(joint_row(0, 16, u));
    const double slope = joint_hysteresis_reversible_slopes[i];
    *also = joint_hysteresis_at_once + slope;
    return joint_hysteresis_at_once * u + (joint_hysteresis_reversible_starts[i] + slope * (u
        - joint_hysteresis_levels[i]));
}

/* The weighted sum at u and its slope, on the branch that began at the reversal with this number; if that one is not stored, it is the present input. */
static double joint_on_branch(const joint_hysteresis_state *x, int reversals, double u, double *also)
{
    double sum = 0.0;
    double slope = 0.0;
    if (reversals == 0) {
        double rises = 0.0;
        const double turned = joint_since_rest(u, &rises);
        sum = turned;
        slope = rises;
    } else {
        double begun = x->last;
        double start = x->sum;
        const int i = 2 * (reversals - 1);
        if (reversals <= (int)(joint_stored(x))) {
            begun = x->reversal[i];
            start = x->reversal[i + 1];
        }
        /* While u falls, the lower limit moves and the weights of the switched relays are subtracted. */
        double up = 0.0;
        double low = u;
        double high = begun;
        if (u >= begun) {
            up = 1.0;
            low = begun;
            high = u;
        }
        double rises = 0.0;
        const double turned = joint_everett(low, high, 1.0 - up, up, &rises);
        sum = start - turned;
        slope = -rises;
        if (up > 0.0) {
            sum = start + turned;
            slope = rises;
        }
    }
    *also = slope;
    return sum;
}

static double joint_hysteresis(joint_hysteresis_state *x, double u)
{
    if (u != x->last) {
        if (joint_turns(x, u) > 0.0) {
            joint_remember(x);
        }
        x->count = joint_kept(x, (int)(joint_stored(x)), u);
        double slope = 0.0;
        const double sum = joint_on_branch(x, (int)(joint_stored(x)), u, &slope);
        x->last = u;
        x->sum = sum;
    }
    double rises = 0.0;
    const double curve = joint_reversible(u, &rises);
    return curve + x->sum;
}

/* The driver: an amplifier with a lag and a slew limit */

static const double joint_driver_twice_substeps = 8.0;
static const double joint_driver_h = 0.000125;
static const double joint_driver_slew = 60975.60975609757;
static const double joint_driver_near = 0.0;

/* The voltage after a substep of u, from v. */
static double joint_driven(double v, double u)
{
    const double away = u - v;
    const double points = joint_way(away);
    double after = 0.0;
    /* Closer to u than `near`, the lag needs less than the slew limit. */
    if (joint_magnitude(away) > joint_driver_near) {
        const double limited = (joint_magnitude(away) - joint_driver_near) / joint_driver_slew;
        if (limited >= joint_driver_h) {
            after = v + points * joint_driver_slew * joint_driver_h;
        } else {
            after = u;
        }
    } else {
        after = u;
    }
    return after;
}

/* z in the sample of u: the mean over its substeps. */
static double joint_hidden(joint_hysteresis_state *x, joint_driver_state *d, double u)
{
    double twice = 0.0;
    for (int k = 0; k < 4; k++) {
        d->v = joint_driven(d->v, u);
        const double after = joint_hysteresis(x, d->v);
        twice = twice + (d->z + after);
        d->z = after;
    }
    return twice / joint_driver_twice_substeps;
}

/* The input between low and high that the next sample answers with z, by trials between the ends: inverse quadratic interpolation where it stays well inside, else bisection. */
static double joint_hidden_inverse(const joint_hysteresis_state *x, const joint_driver_state *d, double z, double low,
    double high)
{
    /* a is the newest input; b lies on the other side of the requested z. */
    double a = low;
    double a_off = 0.0;
    double b = high;
    double b_off = 0.0;
    double u = low;
    int trial = 0;
    int searching = 1;
    while (searching > 0) {
        joint_hysteresis_state tried = *x;
        joint_driver_state behind = *d;
        const double off = joint_hidden(&tried, &behind, u) - z;
        if (trial == 0) {
            a_off = off;
            u = high;
        } else if (trial == 1) {
            b_off = off;
            u = a + 0.5 * (b - a);
            /* If z is out of reach between low and high, the nearer end is returned. */
            if (((a_off <= b_off) && (a_off >= 0.0)) || ((a_off > b_off) && (a_off <= 0.0))) {
                u = low;
                searching = 0;
            } else if (((a_off <= b_off) && (b_off <= 0.0)) || ((a_off > b_off) && (b_off >= 0.0))) {
                u = high;
                searching = 0;
            } else {
                /* all stays as it is */
            }
        } else {
            /* c is the one before. */
            double c = a;
            double c_off = a_off;
            if (((off < 0.0) && (a_off >= 0.0)) || ((off >= 0.0) && (a_off < 0.0))) {
                c = b;
                c_off = b_off;
                b = a;
                b_off = a_off;
            }
            a = u;
            a_off = off;
            double nearest = b;
            double nearest_off = b_off;
            if (joint_magnitude(a_off) < joint_magnitude(b_off)) {
                nearest = a;
                nearest_off = a_off;
            }
            const double close = (2.220446049250313e-16 * joint_magnitude(nearest) + 2.2250738585072014e-308)
                / joint_magnitude(b - a);
            if ((nearest_off == 0.0) || (close > 0.25)) {
                u = nearest;
                searching = 0;
            } else if (trial > 120) {
                searching = 0;
            } else {
                double share = 0.5;
                if (c_off != b_off) {
                    const double xi = (a - b) / (c - b);
                    const double phi = (a_off - b_off) / (c_off - b_off);
                    if (((phi * phi) < xi) && (((1.0 - phi) * (1.0 - phi)) < (1.0 - xi))) {
                        share = a_off / (b_off - a_off) * c_off / (b_off - c_off) + (c - a) / (b - a) * a_off / (c_off
                            - a_off) * b_off / (c_off - b_off);
                    }
                }
                u = a + joint_clamp(share, close, 1.0 - close) * (b - a);
            }
        }
        trial = trial + 1;
    }
    return u;
}

/* The linear block: a difference equation */

static const double joint_linear_a[2] = {
    1.7065322671700334, -0.9694108297276529,
};
static const double joint_linear_b[4] = {
    0.0, 5.826392817635888, -3.2405626123298754, 3.63851052392369,
};

static double joint_linear(joint_linear_state *x, double u)
{
    /* The oldest first. */
    double sum = joint_linear_b[0] * u;
    sum = sum + joint_linear_b[3] * x->inputs[2];
    sum = sum + joint_linear_b[2] * x->inputs[1];
    sum = sum + joint_linear_b[1] * x->inputs[0];
    x->inputs[2] = x->inputs[1];
    x->inputs[1] = x->inputs[0];
    x->inputs[0] = u;
    sum = sum + joint_linear_a[1] * x->outputs[1];
    sum = sum + joint_linear_a[0] * x->outputs[0];
    x->outputs[1] = x->outputs[0];
    x->outputs[0] = sum;
    return sum;
}

/* The model: hysteresis, creep, linear dynamics, offset */

static const double joint_state_offset = -0.45558761528294767;
static const double joint_state_farthest = 280.0;

/* One sample of the input that was taken. */
static double joint_unguarded(joint_state *s, double u)
{
    const double z = joint_hidden(&s->hysteresis, &s->driver, u);
    const double crept = z;
    return joint_linear(&s->linear, crept) + joint_state_offset;
}

/* One sample: the input u to the displacement. What is no number, or too far out, is not taken: the last input stays. */
double joint_step(joint_state *s, double u)
{
    if ((u >= (-joint_state_farthest)) && (u <= joint_state_farthest)) {
        s->taken = u;
    }
    const double taken = s->taken;
    return joint_unguarded(s, taken);
}

/* The inverse of the linear block: an FIR filter */

static const double joint_preview_taps[48] = {
    0.37712104730122775, -0.7089598959089225, 0.3057221554105729, 0.12724310259203142, 0.0839544540108856,
    -0.13910234421224305, -0.06519759956882942, 0.006575386120461346, 0.07575477774875704, 0.01475475269031498,
    -0.020688427167393175, -0.03546560677850855, 0.005049629640521799, 0.014982703338222117, 0.013682033539599184,
    -0.008918076406813238, -0.0072790642244927265, -0.003975308563117389, 0.0071379763567355784,
    0.0022052208509077322, 0.0005996938927681767, -0.0044758713796203276, 0.0002207506171735087,
    0.00010805655685953264, 0.0024939389129023724, -0.0010182934180589488, 1.924495052214718e-5,
    -0.0013417095686371458, 0.0010797205778307628, -0.00023485977495991722, 0.0007686188078424511,
    -0.0009120583780887788, 0.00034614195521755865, -0.0004803689536572328, 0.000758040636492984,
    -0.0003572039843347596, 0.0002709039945501297, -0.0006754558379390498, 0.000369071076448251,
    2.657690861585698e-5, 0.0006173384256041513, -0.0005014445147753474, -0.0005518078771941432,
    -0.00027721467350685144, 0.0007089754158229659, 0.002092821336949093, -0.0035602611036687193,
    0.001543699460009731,
};

static double joint_preview(joint_preview_state *x, double u)
{
    double sum = -0.0;
    double newer = u;
    for (int k = 0; k < 23; k++) {
        const double old = x->past[2 * k];
        const double older = x->past[2 * k + 1];
        sum = sum + joint_preview_taps[2 * k + 1] * old;
        sum = sum + joint_preview_taps[2 * k + 2] * older;
        x->past[2 * k] = newer;
        x->past[2 * k + 1] = old;
        newer = older;
    }
    sum = sum + joint_preview_taps[47] * x->past[46];
    x->past[46] = newer;
    return joint_preview_taps[0] * u + sum;
}

/* The feed-forward: the inverses of linear dynamics, creep and hysteresis */

static const double joint_ff_state_low = -30.8;
static const double joint_ff_state_high = 30.8;
static const double joint_ff_state_at_rest = -0.019241269498987818;

/* One sample: requested displacement r to actuator input u. */
double joint_ff_step(joint_ff_state *s, double r)
{
    /* If the reference is not measurable, the last one that was is used. */
    double last = s->preview.past[0];
    if (joint_magnitude(r) <= 1e18) {
        last = r;
    }
    const double shaped = joint_preview(&s->preview, last) - joint_ff_state_at_rest;
    const double from = joint_ff_state_low;
    const double to = joint_ff_state_high;
    const double z = shaped;
    const double u = joint_hidden_inverse(&s->hysteresis, &s->driver, z, from, to);
    /* The state is updated as that of the actuator. */
    (void)joint_hidden(&s->hysteresis, &s->driver, u);
    return u;
}

void joint_reset(joint_state *s)
{
    s->hysteresis.count = 0.0;
    s->hysteresis.last = 0.0;
    s->hysteresis.sum = 0.0;
    for (int k = 0; k < 128; k++) {
        s->hysteresis.reversal[k] = 0.0;
    }
    for (int k = 0; k < 2; k++) {
        s->linear.outputs[k] = 0.0;
    }
    for (int k = 0; k < 3; k++) {
        s->linear.inputs[k] = 0.0;
    }
    s->driver.v = 0.0;
    s->driver.z = 0.0;
    s->taken = 0.0;
}

double joint_plan(const joint_state *s, double u, joint_state *next)
{
    *next = *s;
    return joint_step(next, u);
}

void joint_save(const joint_state *s, double saved[JOINT_SAVED])
{
    saved[0] = 6969.0;
    saved[1] = 1067.0;
    saved[2] = s->hysteresis.count;
    saved[3] = s->hysteresis.last;
    saved[4] = s->hysteresis.sum;
    for (int k = 0; k < 128; k++) {
        saved[5 + k] = s->hysteresis.reversal[k];
    }
    for (int k = 0; k < 2; k++) {
        saved[133 + k] = s->linear.outputs[k];
    }
    for (int k = 0; k < 3; k++) {
        saved[135 + k] = s->linear.inputs[k];
    }
    saved[138] = s->driver.v;
    saved[139] = s->driver.z;
    saved[140] = s->taken;
}

int joint_restore(joint_state *s, const double saved[], int n)
{
    int fits = 0;
    if ((n == JOINT_SAVED) && (saved[0] == 6969.0) && (saved[1] == 1067.0)) {
        fits = 1;
        for (int k = 2; k < n; k++) {
            if (!((saved[k] >= -1.7976931348623157e308) && (saved[k] <= 1.7976931348623157e308))) {
                fits = 0;
            }
        }
    }
    if (fits == 1) {
        s->hysteresis.count = saved[2];
        s->hysteresis.last = saved[3];
        s->hysteresis.sum = saved[4];
        for (int k = 0; k < 128; k++) {
            s->hysteresis.reversal[k] = saved[5 + k];
        }
        for (int k = 0; k < 2; k++) {
            s->linear.outputs[k] = saved[133 + k];
        }
        for (int k = 0; k < 3; k++) {
            s->linear.inputs[k] = saved[135 + k];
        }
        s->driver.v = saved[138];
        s->driver.z = saved[139];
        s->taken = saved[140];
    }
    return fits;
}

void joint_ff_reset(joint_ff_state *s)
{
    for (int k = 0; k < 47; k++) {
        s->preview.past[k] = -0.45558761528294767;
    }
    s->hysteresis.count = 0.0;
    s->hysteresis.last = 0.0;
    s->hysteresis.sum = 0.0;
    for (int k = 0; k < 128; k++) {
        s->hysteresis.reversal[k] = 0.0;
    }
    s->driver.v = 0.0;
    s->driver.z = 0.0;
}

double joint_ff_plan(const joint_ff_state *s, double r, joint_ff_state *next)
{
    *next = *s;
    return joint_ff_step(next, r);
}

void joint_ff_save(const joint_ff_state *s, double saved[JOINT_FF_SAVED])
{
    saved[0] = 9952.0;
    saved[1] = 25065.0;
    for (int k = 0; k < 47; k++) {
        saved[2 + k] = s->preview.past[k];
    }
    saved[49] = s->hysteresis.count;
    saved[50] = s->hysteresis.last;
    saved[51] = s->hysteresis.sum;
    for (int k = 0; k < 128; k++) {
        saved[52 + k] = s->hysteresis.reversal[k];
    }
    saved[180] = s->driver.v;
    saved[181] = s->driver.z;
}

int joint_ff_restore(joint_ff_state *s, const double saved[], int n)
{
    int fits = 0;
    if ((n == JOINT_FF_SAVED) && (saved[0] == 9952.0) && (saved[1] == 25065.0)) {
        fits = 1;
        for (int k = 2; k < n; k++) {
            if (!((saved[k] >= -1.7976931348623157e308) && (saved[k] <= 1.7976931348623157e308))) {
                fits = 0;
            }
        }
    }
    if (fits == 1) {
        for (int k = 0; k < 47; k++) {
            s->preview.past[k] = saved[2 + k];
        }
        s->hysteresis.count = saved[49];
        s->hysteresis.last = saved[50];
        s->hysteresis.sum = saved[51];
        for (int k = 0; k < 128; k++) {
            s->hysteresis.reversal[k] = saved[52 + k];
        }
        s->driver.v = saved[180];
        s->driver.z = saved[181];
    }
    return fits;
}
