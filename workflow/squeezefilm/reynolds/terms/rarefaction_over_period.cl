/* A gas at any Knudsen number: the mass flux H³ρ grad P + c H² F(x) grad P, where c = 6/D and
 * x = D ρ H (rarefaction.py). With G = ∫ F dP from ambient pressure and K = H ∂G/∂H = ∫ F' dP, where
 * F' = dF/d(ln x), its second term is
 *
 *     c H² (grad G − K grad H / H) = H³ grad(c K/H) + c H² grad(G − K):
 *
 * its parts belong to the two terms of film_over_period.cl. By parts G = p F(D H) + (P M − K)/n, where
 * M = ∫ F' d(ln P) and ρⁿ = P. The integrals of F', which has no logarithm, are by Gauss' rule in ln P.
 * All are exact for small p.
 */
#define POWERS ((int)(sizeof(((Row *)0)->slip_series) / sizeof(double)))
#define OVER_ROOT_PI 0.56418958354775629

/* Gauss–Legendre rule on [0, 1]. */
#define GAUSS 4
__constant double gauss_nodes[GAUSS] = {0.069431844202973714, 0.33000947820757187,
                                        0.66999052179242813, 0.93056815579702629};
__constant double gauss_weights[GAUSS] = {0.17392742256872693, 0.32607257743127307,
                                          0.32607257743127307, 0.17392742256872693};

/* F' at √x. */
static double4 slip_growth(const Film *film, double4 root)
{
    const double4 u = (root - 2.0) / (root + 2.0);
    double4 slope = (double4)(0.0);
    for (int k = POWERS - 1; k > 0; k--)
        slope = slope * u + k * film->row->slip_series[k];
    return 0.25 * (1.0 - u * u) * slope - OVER_ROOT_PI / (1.0 + root * root);
}

/* F at √x. */
static double4 slip_flow(const Film *film, double4 root)
{
    const double4 u = (root - 2.0) / (root + 2.0);
    double4 sum = (double4)(0.0);
    for (int k = POWERS - 1; k >= 0; k--)
        sum = sum * u + film->row->slip_series[k];
    return OVER_ROOT_PI * log1p(1.0 / (root * root)) + sum;
}

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
    const double of_density = film->row->inverse_exponent;
    const double4 log_p = log1p(p), root = sqrt(film->row->inverse_knudsen * gap);
    double4 by_log = (double4)(0.0), by_pressure = (double4)(0.0);
    for (int j = 0; j < GAUSS; j++) {
        const double4 part = gauss_nodes[j] * log_p;
        const double4 growth =
            gauss_weights[j] * log_p * slip_growth(film, root * exp(0.5 * of_density * part));
        by_log += growth;
        by_pressure += growth * exp(part);
    }
    const double4 at_rest = slip_flow(film, root), over_gap = film->row->flow[1] / gap;
    const double4 growth = slip_growth(film, root * exp(0.5 * of_density * log_p));
    *potential += over_gap * by_pressure;
    *slope += over_gap * growth;
    second[0] = p * at_rest + of_density * ((1.0 + p) * by_log - by_pressure) - by_pressure;
    second[1] = at_rest + of_density * by_log - growth;
}
