/* A gas at any Knudsen number: the mass flux W(x) H³ρ grad P, where x = D ρ H, in place of the powers
 * of film_over_period.cl. Of what depends on P alone in the integral over the pressure,
 *
 *     g = ∫ ρ W dP from ambient pressure,   h = H ∂g/∂H = ∫ ρ dW/d(ln x) dP,
 *
 * the flux is H³ (grad g − h grad H / H), which is a sum of two terms as they are there:
 *
 *     −½ grad(H³ (g + h)) + ½ H² grad(H (3 g + h)).
 *
 * The integrals are by Gauss' rule in ln P, exact for small p.
 */
#define GAP_EXPONENT(k) (2 * (k))

#define POWERS ((int)(sizeof(((Row *)0)->flow_series) / sizeof(double)))

/* Gauss–Legendre rule on [0, 1]. */
#define GAUSS 5
__constant double gauss_nodes[GAUSS] = {0.046910077030668004, 0.23076534494715845, 0.5,
                                        0.76923465505284155, 0.953089922969332};
__constant double gauss_weights[GAUSS] = {0.11846344252809454, 0.23931433524968324,
                                          0.28444444444444444, 0.23931433524968324,
                                          0.11846344252809454};

/* a W + b dW/d(ln x), as of flow_factor in rarefaction.py. */
static double4 flow_of(const Film *film, double4 log_x, double a, double b)
{
    const double4 root = exp(0.5 * log_x), inverse = 1.0 / (root * root);
    const double4 u = (root - 2.0) / (root + 2.0);
    double4 sum = (double4)(0.0), slope = (double4)(0.0);
    for (int k = POWERS - 1; k >= 0; k--) {
        slope = slope * u + sum;
        sum = sum * u + film->row->flow_series[k];
    }
    const double of_free = 0.5 * M_2_SQRTPI;
    const double4 factor = 1.0 + 6.0 * inverse * (of_free * log1p(inverse) + sum);
    const double4 growth = 0.25 * slope * (1.0 - u * u) - of_free * inverse / (1.0 + inverse);
    return (a - b) * factor + b * (1.0 + 6.0 * inverse * growth);
}

/* g_k(P) − g_k(1) of either term, and its derivative. */
static double4 flow_potential(const Film *film, double4 gap, double4 p, int k)
{
    const double of_density = film->row->inverse_exponent;
    const double4 log_p = log1p(p), log_x = log(film->row->inverse_knudsen * gap);
    double4 sum = (double4)(0.0);
    for (int j = 0; j < GAUSS; j++) {
        const double4 part = gauss_nodes[j] * log_p;
        sum += gauss_weights[j] * exp((1.0 + of_density) * part) *
               flow_of(film, log_x + of_density * part, 1 + 2 * k, 1.0);
    }
    return (k == 0 ? gap * gap * gap : gap) * log_p * sum;
}
static double4 flow_slope(const Film *film, double4 gap, double4 p, int k)
{
    const double4 log_density = film->row->inverse_exponent * log1p(p);
    const double4 log_x = log(film->row->inverse_knudsen * gap) + log_density;
    return (k == 0 ? gap * gap * gap : gap) * exp(log_density) *
           flow_of(film, log_x, 1 + 2 * k, 1.0);
}
