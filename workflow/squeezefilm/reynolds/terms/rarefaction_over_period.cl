/* A gas at any Knudsen number: the mass flux H³ρ grad P + c H² F(x) grad P, where c = 6/D and
 * x = D ρ H (rarefaction.py). With G = ∫ F dP from ambient pressure and K = H ∂G/∂H = ∫ F' dP, where
 * F' = dF/d(ln x), its second term is
 *
 *     c H² (grad G − K grad H / H) = H³ grad(c K/H) + c H² grad(G − K):
 *
 * its parts belong to the two terms of film_over_period.cl. By parts G = p F(D H) + P L − K/n, where
 * L = ∫ F' d(ln ρ) and ρⁿ = P. The integrals of F', which has no logarithm, are by Gauss' rule in √ρ.
 * All are exact for small p.
 */
#define POWERS ((int)(sizeof(((Row *)0)->slip_series) / sizeof(double)))
#define OVER_ROOT_PI 0.56418958354775629
/* Compilers would keep short arrays in memory. */
#define UNROLLED _Pragma("unroll")

/* Gauss–Legendre rule on [0, 1]. */
#define GAUSS 5
__constant double gauss_nodes[GAUSS] = {0.046910077030668004, 0.23076534494715845, 0.5,
                                        0.76923465505284155, 0.953089922969332};
__constant double gauss_weights[GAUSS] = {0.11846344252809454, 0.23931433524968324,
                                          0.28444444444444444, 0.23931433524968324,
                                          0.11846344252809454};

static double4 density_rise(const Film *film, double4 p);

/* g_k(P) − g_k(1) of either term and its derivative, at the i-th four instants: `potential` and `slope`
 * have those of a viscous gas. */
static void set_rarefied(const Film *film, double4 gap, double4 p, int k, int i, double4 *potential,
                         double4 *slope)
{
    /* What waits for the second term is where the Krylov basis will be. */
    field4 second = (field4)film->basis + 2 * i;
    if (k == 1) {
        *potential = second[0];
        *slope = second[1];
        return;
    }
#ifdef HAS_polytropic
    const double exponent = 1.0 / film->row->inverse_exponent;
#endif
    /* Functions first: they are calls, before which registers are stored. */
    const double4 at_rest = film->row->inverse_knudsen * gap, root = sqrt(at_rest);
    const double4 of_molecules = log(1.0 + 1.0 / at_rest);
    const double4 rise = density_rise(film, p), end = sqrt(1.0 + rise), way = rise / (1.0 + end);
    /* √ρ on the way and at its end, 1/√ρ, u and what the logarithm adds to F'. */
    double4 s[GAUSS + 1], over_s[GAUSS + 1], u[GAUSS + 1], growth[GAUSS + 1], free[GAUSS + 1];
    UNROLLED for (int j = 0; j <= GAUSS; j++) {
        s[j] = j < GAUSS ? 1.0 + gauss_nodes[j] * way : end;
        const double4 r = root * s[j], beyond = r + 2.0, dense = 1.0 + r * r;
        const double4 inverse = 1.0 / (beyond * dense * s[j]); /* divisions are dear */
        over_s[j] = beyond * dense * inverse;
        free[j] = OVER_ROOT_PI * beyond * s[j] * inverse;
        u[j] = (r - 2.0) * dense * s[j] * inverse;
        growth[j] = (double4)(0.0);
    }
    const double4 u_at_rest = (root - 2.0) / (root + 2.0);
    double4 slip = (double4)(0.0);
    /* All sums together, for each waits for its last addition. */
    for (int power = POWERS - 1; power > 0; power--) {
        const double factor = film->row->slip_series[power];
        slip = slip * u_at_rest + factor;
        UNROLLED for (int j = 0; j <= GAUSS; j++) growth[j] = growth[j] * u[j] + power * factor;
    }
    slip = slip * u_at_rest + film->row->slip_series[0] + OVER_ROOT_PI * of_molecules;
    double4 by_log = (double4)(0.0), by_pressure = (double4)(0.0);
    UNROLLED for (int j = 0; j <= GAUSS; j++) {
        growth[j] = 0.25 * (1.0 - u[j] * u[j]) * growth[j] - free[j];
        if (j == GAUSS)
            break;
        const double4 share = 2.0 * gauss_weights[j] * way * growth[j];
        by_log += share * over_s[j];
#ifdef HAS_polytropic
        by_pressure += exponent * share * exp((2.0 * exponent - 1.0) * log(s[j]));
#else
        by_pressure += share * s[j];
#endif
    }
    const double4 over_gap = film->row->flow[1] / gap;
    *potential += over_gap * by_pressure;
    *slope += over_gap * growth[GAUSS];
#ifdef HAS_polytropic
    const double share_of_gap = 1.0 + 1.0 / exponent;
#else
    const double share_of_gap = 2.0;
#endif
    second[0] = p * slip + (1.0 + p) * by_log - share_of_gap * by_pressure;
    second[1] = slip + by_log - growth[GAUSS];
}
