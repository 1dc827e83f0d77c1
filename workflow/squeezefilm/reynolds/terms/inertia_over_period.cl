/* Inertia of the gas (inertia.py): the velocity's deficit b = V − u along x and along y, each on the
 * flux points of its axis and the nodes of the other one (spectral.py).
 *
 * In Krylov's vectors stands, for a change of b, what it is more than the settled answer to the
 * change of the pressure: beta = S δV − δu with S = 1/(1 + lag L h d/dT) (time_modes.py), so that what
 * is unknown of both hardly depends on one another. What beta adds to the balance of mass is taken
 * off its residual before that is preconditioned. */

/* Fields of a direction that the state has: gauge pressure and its slope at its flux points, velocity
 * along and across, the first's derivatives along and across, d ln(ρH)/dT, and what is in braces in
 * inertia.py; and what warm gas flows less (thermal.py) for each velocity and for each rate of it.
 * Then those of a change: of the density, of the deficit, of the velocity. */
enum { PRESSURE, SLOPE, ALONG, ACROSS, ALONG_RATE, ACROSS_RATE, FILLING, FORCES, WARM_SHARE,
       WARM_LAG, STATE_FIELDS };
enum { DENSITY, DEFICIT, VELOCITY, CHANGE_FIELDS };

static double4 density_rise(const Film *film, double4 p);
static double4 density_slope(const Film *film, double4 p);

typedef struct {
    matrix values, slope, along, nodes, divergence, across, edge, to_end, amplitude;
#ifdef HAS_outline
    matrix over_area, bend;
#endif
} Direction;

static Direction direction_of(const Film *film, int axis)
{
    Direction d;
    d.values = ON_AXIS(axis, flux_values);
    d.slope = ON_AXIS(axis, flux_slope);
    d.along = ON_AXIS(axis, flux_along);
    d.nodes = ON_AXIS(axis, flux_nodes);
    d.divergence = ON_AXIS(axis, flux_divergence);
    d.across = ON_AXIS(1 - axis, flux_across);
    d.edge = ON_AXIS(1 - axis, flux_edge);
    d.to_end = ON_AXIS(1 - axis, flux_to_end);
    d.amplitude = ON_AXIS(axis, flux_amplitude);
#ifdef HAS_outline
    d.over_area = ON_AXIS(axis, flux_over_area);
    d.bend = ON_AXIS(axis, flux_bend);
#endif
    return d;
}

static field state_field(const Grid *g, const Film *film, int axis, int which)
{
    return film->own_work + (axis * STATE_FIELDS + which) * g->count;
}

static field change_field(const Grid *g, const Film *film, int axis, int which)
{
    return film->own_work + (2 * STATE_FIELDS + axis * CHANGE_FIELDS + which) * g->count;
}

static field scratch_field(const Grid *g, const Film *film, int which)
{
    return film->own_work + (2 * STATE_FIELDS + 2 * CHANGE_FIELDS + which) * g->count;
}

/* Derivative of lag_of to the density. */
static double4 lag_slope(const Film *film, double4 gap) { return film->row->lag * gap * gap; }

/* The velocity across each direction, `which` of STATE_FIELDS or a scratch field: that along the
 * other one, carried to this one's points. */
static void velocity_across(const Grid *g, const Film *film, field along, field other, int axis,
                            field work)
{
    along_axis(g, 1 - axis, direction_of(film, 1 - axis).nodes, NODES_TO_NODES, other, work, 0);
    along_axis(g, axis, direction_of(film, axis).values, NODES_TO_NODES, work, along, 0);
}

/* Add to the derivative across a direction of a velocity along it what that has from the ends, where
 * `d.across` takes the velocity as zero: so it is where gas comes in, and where gas goes out it carries
 * its velocity along. */
static void add_carried_out(const Grid *g, const Film *film, const Direction *d, int axis,
                            matrix4 across, matrix4 velocity, field4 derivative)
{
    const int n = axis == 0 ? g->ny : g->nx, whole = axis == 0 ? g->whole_y : g->whole_x;
    const int apart = (axis == 0 ? 1 : g->ny) * g->nt4;
    matrix first_edge = d->edge, last_edge = d->edge + n, to_end = d->to_end;
    const double reversing = 1.0 / film->row->reversing;
    FOR_EACH(i, g->rows / n * g->nt4)
    {
        const int first = axis == 0 ? i / g->nt4 * g->ny * g->nt4 + i % g->nt4 : i;
        double4 carried[2];
        carried[1] = (double4)(0.0);
        for (int end = 0; end <= whole; end++) {
            const int last = first + (end ? n - 1 : 0) * apart, step = end ? -apart : apart;
            const double4 out = (end ? reversing : -reversing) * across[last];
            double4 there = (double4)(0.0);
            for (int j = 0; j < 4; j++)
                there += to_end[j] * velocity[last + j * step];
            carried[end] = there * (0.5 + 0.5 * out / sqrt(1.0 + out * out));
        }
        for (int place = 0; place < n; place++)
            derivative[first + place * apart] +=
                first_edge[place] * carried[0] + last_edge[place] * carried[1];
    }
    SYNC;
}

/* Within an outline velocities are those times |dz/dζ|, along its coordinates: (ū·∇)ū has 1/J, and each
 * derivative of a velocity adds what its direction turns by, times it (terms/outline.py). */
#ifdef HAS_outline
#define OVER_AREA(d, i) *(d).over_area[(i) / g->nt4]
#define TURNED(d, i, velocity) +(d).bend[(i) / g->nt4] * (velocity)
#else
#define OVER_AREA(d, i)
#define TURNED(d, i, velocity)
#endif

/* What gas that flows across a direction carries; in a film without angle none does. */
#if AXES > 1
#define BY_CROSSING(rate) +(rate)
#else
#define BY_CROSSING(rate)
#endif

/* Gap and density at a point of a direction. */
#define EACH_OF(d)                                                                               \
    const double4 gap = 1.0 + beyond_even(g, film, d.amplitude, row, t);                         \
    const double4 density = 1.0 + density_rise(film, p[i]);

/* Pressure, its slope and the velocity along an axis, at its flux points. */
static void set_velocity(const Grid *g, const Film *film, int axis)
{
    const Direction d = direction_of(film, axis);
    field pressure = state_field(g, film, axis, PRESSURE), slope = state_field(g, film, axis, SLOPE);
    field4 u = (field4)state_field(g, film, axis, ALONG);
    matrix4 p = (matrix4)pressure, b = (matrix4)(film->own + axis * g->count);
    along_axis(g, axis, d.values, NODES_TO_NODES, (field)film->p, pressure, 0);
    along_axis(g, axis, d.slope, NODES_TO_SLOPES, (field)film->p, slope, 0);
    add_edge_pressure(g, film, axis, pressure, slope);
    FOR_EACH_POINT(g, row, t, i)
    {
        EACH_OF(d)
        u[i] = -mobility(film, gap, density) * ((matrix4)slope)[i];
        if (film->row->has_inertia)
            u[i] -= b[i];
    }
    SYNC;
}

static void residual_inertia(const Grid *whole_grid, const Film *whole_film, field mass, field work,
                             field out)
{
    if (!whole_film->row->has_inertia)
        return;
    AS_COPIES(whole_grid, whole_film)
    const double sigma = film->sigma;
    field spare = scratch_field(g, film, 0), rate = scratch_field(g, film, 1);
    for (int axis = 0; axis < AXES; axis++) {
        const Direction d = direction_of(film, axis);
        matrix4 p = (matrix4)state_field(g, film, axis, PRESSURE);
        field u = state_field(g, film, axis, ALONG);
        field4 filling = (field4)state_field(g, film, axis, FILLING);
        set_velocity(g, film, axis);
        FOR_EACH(i, g->count4) ((field4)spare)[i] = log(1.0 + density_rise(film, p[i]));
        SYNC;
        along_t(g, g->time_derivative, spare, (field)filling, 0);
        FOR_EACH_POINT(g, row, t, i)
        {
            EACH_OF(d)
            filling[i] += rate_by(g, film, d.amplitude, row, t) / gap;
        }
        SYNC;
        along_axis(g, axis, d.along, NODES_TO_SLOPES,
                   u, state_field(g, film, axis, ALONG_RATE), 0);
#if AXES > 1
        along_axis(g, 1 - axis, d.across, NODES_TO_SLOPES,
                   u, state_field(g, film, axis, ACROSS_RATE), 0);
#endif
    }
    for (int axis = 0; axis < AXES; axis++) {
        const Direction d = direction_of(film, axis);
        matrix4 p = (matrix4)state_field(g, film, axis, PRESSURE);
        matrix4 u = (matrix4)state_field(g, film, axis, ALONG);
        matrix4 across = (matrix4)state_field(g, film, axis, ACROSS);
        matrix4 along_rate = (matrix4)state_field(g, film, axis, ALONG_RATE);
        matrix4 across_rate = (matrix4)state_field(g, film, axis, ACROSS_RATE);
        matrix4 filling = (matrix4)state_field(g, film, axis, FILLING);
        field4 forces = (field4)state_field(g, film, axis, FORCES);
        matrix4 b = (matrix4)(film->own + axis * g->count);
        field4 lagging = (field4)spare, settled = (field4)(film->own_out + axis * g->count);
        field4 flux = (field4)rate;
#if AXES > 1
        velocity_across(g, film, (field)across, state_field(g, film, 1 - axis, ALONG), axis, spare);
        add_carried_out(g, film, &d, axis, across, u, (field4)across_rate);
#endif
        along_t(g, g->time_derivative, (field)u, rate, 0);
        FOR_EACH_POINT(g, row, t, i)
        {
            EACH_OF(d)
            forces[i] = ((matrix4)rate)[i] - u[i] * filling[i] / 7.0 +
                        9.0 / 7.0 OVER_AREA(d, i) *
                            (u[i] * (along_rate[i] TURNED(d, i, u[i]))
                             BY_CROSSING(across[i] * (across_rate[i] TURNED(d, i, across[i]))));
            lagging[i] = -lag_of(film, gap, density) * forces[i];
        }
        SYNC;
        along_t(g, ARRAY(film, settling), film->own + axis * g->count, (field)settled, 0);
        along_t(g, ARRAY(film, settling_of_slow), spare, (field)settled, 1);
        FOR_EACH_POINT(g, row, t, i)
        {
            EACH_OF(d)
            flux[i] = sigma * gap * density * (b[i] - settled[i]);
        }
        SYNC;
        along_axis(g, axis, d.divergence, NODES_TO_SLOPES, rate, out, 1);
    }
}

/* δρ and δV, the latter in the place of the deficit, of a change `rise` of the pressure. */
static void driven(const Grid *whole_grid, const Film *whole_film, int axis, field rise)
{
    AS_COPIES(whole_grid, whole_film)
    const Direction d = direction_of(film, axis);
    matrix4 p = (matrix4)state_field(g, film, axis, PRESSURE);
    matrix4 slope = (matrix4)state_field(g, film, axis, SLOPE);
    field4 rises = (field4)change_field(g, film, axis, DENSITY);
    field4 drive = (field4)change_field(g, film, axis, DEFICIT);
    along_axis(g, axis, d.values, NODES_TO_NODES, rise, (field)rises, 0);
    along_axis(g, axis, d.slope, NODES_TO_SLOPES, rise, (field)drive, 0);
    FOR_EACH_POINT(g, row, t, i)
    {
        EACH_OF(d)
        rises[i] *= density_slope(film, p[i]);
        drive[i] = gap * slip_of(film) / (film->sigma * density * density) * rises[i] * slope[i] -
                   mobility(film, gap, density) * drive[i];
    }
    SYNC;
}

static void response_inertia(const Grid *whole_grid, const Film *whole_film, field mass, field work,
                             field out)
{
    if (!whole_film->row->has_inertia)
        return;
    AS_COPIES(whole_grid, whole_film)
    const double sigma = film->sigma;
    field spare = scratch_field(g, film, 0), rate = scratch_field(g, film, 1);
    field relative = scratch_field(g, film, 2), along_rate = scratch_field(g, film, 3);
    field across_rate = scratch_field(g, film, 4);
    field4 rise = (field4)rate;
    FOR_EACH_POINT(g, row, t, i)
        rise[i] = ((matrix4)mass)[i] /
                  (gap_at(g, film, row, t) * density_slope(film, film->p[i]));
    SYNC;
    for (int axis = 0; axis < AXES; axis++) {
        driven(g, film, axis, rate);
        matrix4 beta = (matrix4)(film->own_in + axis * g->count);
        field4 drive = (field4)change_field(g, film, axis, DEFICIT);
        field4 velocity = (field4)change_field(g, film, axis, VELOCITY);
        along_t(g, ARRAY(film, settling), (field)drive, (field)velocity, 0);
        FOR_EACH(i, g->count4)
        {
            velocity[i] -= beta[i];
            drive[i] -= velocity[i];
        }
        SYNC;
    }
    for (int axis = 0; axis < AXES; axis++) {
        const Direction d = direction_of(film, axis);
        matrix4 p = (matrix4)state_field(g, film, axis, PRESSURE);
        matrix4 u = (matrix4)state_field(g, film, axis, ALONG);
        matrix4 across = (matrix4)state_field(g, film, axis, ACROSS);
        matrix4 u_along = (matrix4)state_field(g, film, axis, ALONG_RATE);
        matrix4 u_across = (matrix4)state_field(g, film, axis, ACROSS_RATE);
        matrix4 filling = (matrix4)state_field(g, film, axis, FILLING);
        matrix4 forces = (matrix4)state_field(g, film, axis, FORCES);
        matrix4 warm_share = (matrix4)state_field(g, film, axis, WARM_SHARE);
        matrix4 warm_lag = (matrix4)state_field(g, film, axis, WARM_LAG);
        matrix4 b = (matrix4)(film->own + axis * g->count);
        matrix4 rises = (matrix4)change_field(g, film, axis, DENSITY);
        matrix4 deficit = (matrix4)change_field(g, film, axis, DEFICIT);
        field velocity = change_field(g, film, axis, VELOCITY);
        matrix4 v = (matrix4)velocity;
        field4 settled = (field4)(film->own_out + axis * g->count);
        FOR_EACH_POINT(g, row, t, i)
        {
            EACH_OF(d)
            ((field4)relative)[i] = rises[i] / density;
        }
        SYNC;
        field4 crossing = (field4)across_rate, lagging = (field4)spare, flux = (field4)rate;
#if AXES > 1
        velocity_across(g, film, across_rate, change_field(g, film, 1 - axis, VELOCITY), axis, spare);
        /* δ(u across) times u's derivative there, and u across times that of δu. */
        FOR_EACH(i, g->count4) crossing[i] *= u_across[i] TURNED(d, i, 2.0 * across[i]);
        SYNC;
        along_axis(g, 1 - axis, d.across, NODES_TO_SLOPES, velocity, along_rate, 0);
        add_carried_out(g, film, &d, axis, across, v, (field4)along_rate);
        FOR_EACH(i, g->count4) crossing[i] += across[i] * ((matrix4)along_rate)[i];
        SYNC;
#endif
        along_axis(g, axis, d.along, NODES_TO_SLOPES, velocity, along_rate, 0);
        along_t(g, g->time_derivative, relative, rate, 0);
        FOR_EACH(i, g->count4)
            crossing[i] = 9.0 / 7.0 OVER_AREA(d, i) *
                              (v[i] * (u_along[i] TURNED(d, i, 2.0 * u[i])) +
                               u[i] * ((matrix4)along_rate)[i] BY_CROSSING(crossing[i])) -
                          (v[i] * filling[i] + u[i] * ((matrix4)rate)[i]) / 7.0;
        SYNC;
        along_t(g, g->time_derivative, velocity, rate, 0);
        FOR_EACH_POINT(g, row, t, i)
        {
            EACH_OF(d)
            lagging[i] = -lag_of(film, gap, density) * (((matrix4)rate)[i] + crossing[i]) -
                         lag_slope(film, gap) * rises[i] * forces[i];
            crossing[i] = film->row->has_thermal
                              ? warm_share[i] * v[i] + warm_lag[i] * ((matrix4)rate)[i]
                              : (double4)(0.0);
        }
        SYNC;
        along_t(g, ARRAY(film, settling), (field)deficit, (field)settled, 0);
        along_t(g, ARRAY(film, settling_of_slow), spare, (field)settled, 1);
        FOR_EACH_POINT(g, row, t, i)
        {
            EACH_OF(d)
            flux[i] = sigma * gap *
                      (density * (deficit[i] - settled[i] + crossing[i]) + rises[i] * b[i]);
        }
        SYNC;
        along_axis(g, axis, d.divergence, NODES_TO_SLOPES, rate, out, 1);
    }
}

/* b as a step of the pressure and Krylov's solution change it; the latter has the other sign. */
static void step_inertia(const Grid *g, const Film *film, field step, double share)
{
    if (!film->row->has_inertia)
        return;
    for (int axis = 0; axis < AXES; axis++) {
        driven(g, film, axis, step);
        matrix4 beta = (matrix4)(film->own_in + axis * g->count);
        matrix4 drive = (matrix4)change_field(g, film, axis, DEFICIT);
        field velocity = change_field(g, film, axis, VELOCITY);
        field4 b = (field4)(film->own + axis * g->count);
        along_t(g, ARRAY(film, settling), (field)drive, velocity, 0);
        FOR_EACH(i, g->count4) b[i] += share * (drive[i] - ((matrix4)velocity)[i] - beta[i]);
        SYNC;
    }
}

/* b from a coarser grid. */
static void carry_inertia(const Grid *g, const Film *film, __global const Row *coarser, field coarse)
{
    if (!film->row->has_inertia)
        return;
    const int count = coarser->nx * coarser->ny * coarser->nt;
    matrix in_t = ARRAY(film, carry_t);
    carry_field(g, film, coarser, in_t, ARRAY(film, carry_flux_x), ARRAY(film, carry_y), coarse,
                film->own);
#if AXES > 1
    carry_field(g, film, coarser, in_t, ARRAY(film, carry_x), ARRAY(film, carry_flux_y),
                coarse + count, film->own + g->count);
#endif
}
