/* A gas that is not isothermal: ρ = P^(1/n), in place of the isothermal law of film_over_period.cl. */
#define GAS_LAW

static double4 density_rise(const Film *film, double4 p)
{
    return expm1(film->row->inverse_exponent * log1p(p));
}
static double4 density_slope(const Film *film, double4 p)
{
    return film->row->inverse_exponent * exp((film->row->inverse_exponent - 1.0) * log1p(p));
}
static double4 flow_potential(const Film *film, double4 p, int k)
{
    const double power = (1 - k) * film->row->inverse_exponent + 1.0;
    return expm1(power * log1p(p)) / power;
}
static double4 flow_slope(const Film *film, double4 p, int k)
{
    return exp((1 - k) * film->row->inverse_exponent * log1p(p));
}
