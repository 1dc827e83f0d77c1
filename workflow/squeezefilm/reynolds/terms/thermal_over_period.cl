/* Thermal effects (thermal.py): what the gas' rise of temperature moves. Newton's steps take the rise of
 * a change with a lag as at rest, and in the flow the gas as warm as it is: a step leaves about a
 * twentieth of itself, where waves are not too steep. */

#define THERMAL_FIELDS 10

/* J at a node of an outline (terms/outline.py), by which what the gap holds is multiplied; and 1/J at the
 * points of velocities along an axis, by which their square is. */
#ifdef HAS_outline
#define TIMES_AREA(row) *(1.0 + ARRAY(film, stretch)[row])
#define OVER_AREA_ON(axis, i) *ON_AXIS(axis, flux_over_area)[(i) / g->nt4]
#else
#define TIMES_AREA(row)
#define OVER_AREA_ON(axis, i)
#endif

/* The square of a velocity across an axis; in a film without angle there is none. */
#if AXES > 1
#define PLUS_ACROSS(square) +(square)
#else
#define PLUS_ACROSS(square)
#endif

/* out += factor · S in over one row, with the skew S = root d/dT root. */
static void add_skew(const Grid *g, matrix root, matrix in, double factor, field4 out)
{
    matrix4 rate = (matrix4)g->time_derivative;
    for (int t = 0; t < g->nt4; t++) {
        double4 sum = (double4)(0.0);
        for (int j = 0; j < g->nt; j++)
            sum += root[j] * in[j] * rate[j * g->nt4 + t];
        out[t] += factor * ((matrix4)root)[t] * sum;
    }
}

/* Square of the residual, relative, that is left of a row's temperature. */
#define WARMED 1e-22

/* The rise by compression, (1 + c d/dT) warmth = (heating H²/12) dp/dT with c = thermal_lag P H², and
 * what a jump of temperature at the walls makes of both.
 * Over √c this is (1 + S) y = b with the skew S = √c d/dT √c, solved row by row by conjugate
 * gradients on (1 − S)(1 + S) y = (1 − S) b. The other four fields are room. */
static void warm(const Grid *g, const Film *film, field warmth, field root, field residue,
                 field along, field turned)
{
    const int n = g->nt4;
    along_t(g, g->time_derivative, (field)film->p, warmth, 0);
    FOR_EACH(row, g->rows)
    {
        const int first = row * g->nt;
        field4 y = (field4)(warmth + first), r = (field4)(residue + first);
        field4 c = (field4)(root + first), d = (field4)(along + first);
        field4 q = (field4)(turned + first);
        double4 sum = (double4)(0.0);
        for (int t = 0; t < n; t++) {
            const double4 gap = gap_at(g, film, row, t);
            const double4 density = 1.0 + film->p[row * n + t];
            c[t] = sqrt(film->row->thermal_lag * gap * (density * gap + film->row->jump_lags));
            d[t] = film->row->heating / 12.0 * gap * (gap + film->row->jump_warms / density) * y[t] /
                   c[t];
            r[t] = d[t];
            y[t] = (double4)(0.0);
        }
        add_skew(g, root + first, along + first, -1.0, r);
        for (int t = 0; t < n; t++) {
            d[t] = r[t];
            sum += r[t] * r[t];
        }
        double left = sum_of(sum);
        const double enough = WARMED * left;
        for (int step = 0; step < 2 * g->nt && left > enough; step++) {
            sum = (double4)(0.0);
            for (int t = 0; t < n; t++)
                q[t] = (double4)(0.0);
            add_skew(g, root + first, along + first, 1.0, q);
            for (int t = 0; t < n; t++)
                sum += d[t] * d[t] + q[t] * q[t];
            const double share = left / sum_of(sum);
            for (int t = 0; t < n; t++) {
                y[t] += share * d[t];
                r[t] -= share * d[t];
            }
            add_skew(g, root + first, turned + first, share, r);
            sum = (double4)(0.0);
            for (int t = 0; t < n; t++)
                sum += r[t] * r[t];
            const double before = left;
            left = sum_of(sum);
            for (int t = 0; t < n; t++)
                d[t] = r[t] + left / before * d[t];
        }
        for (int t = 0; t < n; t++)
            y[t] *= c[t];
    }
    SYNC;
}

/* Velocities along each axis at its points, and on the nodes. */
static void set_velocities(const Grid *g, const Film *film, field u, field nodal, field pressure)
{
    for (int axis = 0; axis < AXES; axis++, u += g->count, nodal += g->count) {
        matrix amplitude = ON_AXIS(axis, flux_amplitude);
        field4 u4 = (field4)u;
        along_axis(g, axis, ON_AXIS(axis, flux_values), NODES_TO_NODES, (field)film->p, pressure, 0);
        along_axis(g, axis, ON_AXIS(axis, flux_slope), NODES_TO_SLOPES, (field)film->p, u, 0);
        add_edge_pressure(g, film, axis, pressure, u);
        FOR_EACH_POINT(g, row, t, i)
        {
            const double4 gap = 1.0 + beyond_even(g, film, amplitude, row, t);
            const double4 density = 1.0 + ((matrix4)pressure)[i];
            u4[i] *= -mobility(film, gap, density);
            if (film->row->has_inertia) /* what it falls short by it */
                u4[i] -= ((matrix4)(film->own + axis * g->count))[i];
        }
        SYNC;
        along_axis(g, axis, ON_AXIS(axis, flux_nodes), NODES_TO_NODES, u, nodal, 0);
    }
}

static void residual_thermal(const Grid *g, const Film *film, field mass, field work, field out)
{
    if (!film->row->has_thermal)
        return;
    field warmth = film->own_work + (OWN_FIELDS - THERMAL_FIELDS) * g->count;
    field velocity = warmth + g->count, nodal = velocity + 2 * g->count;
    field first = nodal + 2 * g->count, second = first + g->count;
    field third = second + g->count, fourth = third + g->count;
    field4 rise = (field4)(fourth + g->count);
    const double sigma = film->sigma, kappa = film->row->viscosity_exponent;
    /* τ_b over the square of the speed. */
    const double cooling = film->row->heating * sigma / 20.0;
    warm(g, film, warmth, first, second, third, fourth);
    set_velocities(g, film, velocity, nodal, first);
    matrix4 along = (matrix4)nodal, across = along + g->count4;
    FOR_EACH_POINT(g, row, t, i)
    {
        const double4 square = along[i] * along[i] PLUS_ACROSS(across[i] * across[i]);
        rise[i] = ((matrix4)warmth)[i] TIMES_AREA(row) - cooling * square;
        ((field4)first)[i] = gap_at(g, film, row, t) * (1.0 + film->p[i]) * rise[i];
    }
    SYNC;
    along_t(g, g->time_derivative, first, second, 0);
    subtract(out, -sigma, second, g->count4);
    for (int axis = 0; axis < AXES; axis++) {
        field u = velocity + axis * g->count;
        matrix amplitude = ON_AXIS(axis, flux_amplitude), values = ON_AXIS(axis, flux_values);
        field4 pressure = (field4)first, warmer = (field4)second, cooler = (field4)third;
        field4 share = (field4)state_field(g, film, axis, WARM_SHARE);
        field4 lag = (field4)state_field(g, film, axis, WARM_LAG);
        along_axis(g, axis, values, NODES_TO_NODES, (field)film->p, first, 0);
        along_axis(g, axis, values, NODES_TO_NODES, warmth, second, 0);
#if AXES > 1
        along_axis(g, axis, values, NODES_TO_NODES, nodal + (1 - axis) * g->count, third, 0);
#endif
        FOR_EACH(i, g->count4)
        {
            const double4 own = ((matrix4)u)[i];
            cooler[i] = cooling OVER_AREA_ON(axis, i) *
                        (own * own PLUS_ACROSS(cooler[i] * cooler[i]));
            ((field4)fourth)[i] = warmer[i] - cooler[i];
        }
        SYNC;
        along_t(g, g->time_derivative, fourth, work, 0);
        along_t(g, g->time_derivative, u, fourth, 0);
        FOR_EACH_POINT(g, row, t, i)
        {
            const double4 gap = 1.0 + beyond_even(g, film, amplitude, row, t);
            const double4 density = 1.0 + pressure[i];
            const double4 own = ((matrix4)u)[i], hot = warmer[i], cold = cooler[i];
            const double4 lighter = 6.0 / 5.0 * hot - 9.0 / 14.0 * cold;
            const double4 thicker = 3.0 / 5.0 * hot - 3.0 / 7.0 * cold;
            const double4 lags = lag_of(film, gap, density);
            share[i] = lighter + kappa * thicker - lags * ((matrix4)work)[i] / 7.0;
            lag[i] = -9.0 / 7.0 * lags * (hot - cold);
            pressure[i] =
                sigma * gap * density * (share[i] * own + lag[i] * ((matrix4)fourth)[i]);
        }
        SYNC;
        along_axis(g, axis, ON_AXIS(axis, flux_divergence), NODES_TO_SLOPES, first, out, 1);
    }
}

/* −σ d/dT of the mass that warm gas lacks: of a change the film's modes in time know what itself warms
 * (time_modes.py). */
static void response_thermal(const Grid *g, const Film *film, field mass, field work, field out)
{
    if (!film->row->has_thermal)
        return;
    field lacking = film->own_work + (OWN_FIELDS - 2) * g->count;
    matrix4 rise = (matrix4)(lacking + g->count);
    FOR_EACH(i, g->count4) ((field4)lacking)[i] = rise[i] * ((matrix4)mass)[i];
    SYNC;
    along_t(g, g->time_derivative, lacking, work, 0);
    subtract(out, -film->sigma, work, g->count4);
}
