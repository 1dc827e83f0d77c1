/* Inertia of the gas (inertia.py): the velocity's deficit b = V − u along x and along y, each on the
 * flux points of its axis and the nodes of the other one (spectral.py).
 *
 * In Krylov's vectors stands, for a change of b, what it is more than the settled answer to the
 * change of the pressure: beta = S δV − δu with S = 1/(1 + lag L h d/dT) (time_modes.py), so that what
 * is unknown of both hardly depends on one another. What beta adds to the balance of mass is taken
 * off its residual before that is preconditioned. */

/* Fields of a direction that the state has: gauge pressure and its slope at its flux points, velocity
 * along and across, the first's derivatives along and across, d ln(ρH)/dT, what is in braces in
 * inertia.py, and the shares of a velocity that gas carries out at both ends across. */
enum { PRESSURE, SLOPE, ALONG, ACROSS, ALONG_RATE, ACROSS_RATE, FILLING, FORCES, CARRIED_SHARES,
       STATE_FIELDS };
#define SPARE_FIELDS 3
/* Of the linear system: what each part of a change is taken by, set at each state. Its drive has the
 * density's rise and the pressure's slope; d ln(ρH)/dT the former; minus the lagging forces the
 * velocity, that across, its derivatives across and along, the rates of filling and of the velocity, and the
 * density's rise; the flux the deficit, the density's rise and, of a warm gas, velocity and its rate. Then
 * the fields of a change. */
enum { DRIVE_BY_RISE, DRIVE_BY_SLOPE, FILLING_BY_RISE,
       FORCE_BY_VELOCITY, FORCE_BY_CROSSING, FORCE_BY_ACROSS_RATE, FORCE_BY_ALONG_RATE,
       FORCE_BY_FILLING, FORCE_BY_RATE, FORCE_BY_RISE,
       FLUX_BY_DEFICIT, FLUX_BY_RISE, FLUX_BY_VELOCITY, FLUX_BY_RATE, CARRIED_OUT,
       RISE, DEFICIT, VELOCITY, LINEAR_FIELDS };
/* And of no direction: the pressure's rise by a mass; room. */
enum { RISE_BY_MASS, PRESSURE_RISE, CROSSING, ACROSS_CHANGE, ALONG_CHANGE, FILLING_CHANGE,
       VELOCITY_CHANGE, LAGGING, COMMON_FIELDS };

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
    return film->own_work + (axis * STATE_FIELDS + which) * g->spacing;
}

static field spare_field(const Grid *g, const Film *film, int which)
{
    return film->own_work + (2 * STATE_FIELDS + which) * g->spacing;
}

static vector common_field(const Grid *g, const Film *film, int which)
{
    return (vector)spare_field(g, film, SPARE_FIELDS) + which * g->spacing;
}

static vector linear_field(const Grid *g, const Film *film, int axis, int which)
{
    return common_field(g, film, COMMON_FIELDS + axis * LINEAR_FIELDS + which);
}

/* Derivative of lag_of to the density. */
static double4 lag_slope(const Film *film, double4 gap) { return film->row->lag * gap * gap; }

/* Shares of a velocity along a direction that gas carries out across it, at either end: for each of two
 * ends those of all places along. */
static void set_carried_shares(const Grid *g, const Film *film, int axis, matrix4 across, field4 shares)
{
    const int n = axis == 0 ? g->ny : g->nx, apart = (axis == 0 ? 1 : g->ny) * g->nt4;
    const int places = g->count4 / n;
    const double reversing = 1.0 / film->row->reversing;
    FOR_EACH(i, 2 * places)
    {
        const int end = i / places, place = i % places;
        const int first = axis == 0 ? place / g->nt4 * g->ny * g->nt4 + place % g->nt4 : place;
        const double4 out = (end ? reversing : -reversing) * across[first + (end ? n - 1 : 0) * apart];
        shares[i] = 0.5 + 0.5 * out / sqrt(1.0 + out * out);
    }
    SYNC;
}

/* The velocity across each direction: that along the other one, carried to this one's points.
 *
 * And add to the derivative across a direction of a velocity along it what that has from the ends, where
 * the matrix across takes the velocity as zero: so it is where gas comes in, and where gas goes out it
 * carries its velocity along. */
#define CROSSING_VELOCITIES(type)                                                                   \
    OF_BOTH_TYPES void velocity_across(const Grid *g, __global type *along,                        \
                                       __global const type *other, int axis,                       \
                                       __global const type *nodes, __global const type *values,    \
                                       __global type *work)                                        \
    {                                                                                              \
        along_axis(g, 1 - axis, nodes, NODES_TO_NODES, other, work, 0);                            \
        along_axis(g, axis, values, NODES_TO_NODES, work, along, 0);                               \
    }                                                                                              \
    OF_BOTH_TYPES void add_carried_out(const Grid *g, int axis, __global const type *edge,         \
                                       __global const type *to_end, __global const type *shares,   \
                                       __global const type *velocity, __global type *derivative)   \
    {                                                                                              \
        const int n = axis == 0 ? g->ny : g->nx, whole = axis == 0 ? g->whole_y : g->whole_x;      \
        const int apart = (axis == 0 ? 1 : g->ny) * g->nt4, places = g->count4 / n;                \
        __global const JOIN(type, 4) *v = (__global const JOIN(type, 4) *)velocity;                \
        FOR_EACH(i, places)                                                                        \
        {                                                                                          \
            const int first = axis == 0 ? i / g->nt4 * g->ny * g->nt4 + i % g->nt4 : i;            \
            JOIN(type, 4) carried[2];                                                              \
            carried[1] = (JOIN(type, 4))(0);                                                       \
            for (int end = 0; end <= whole; end++) {                                               \
                const int last = first + (end ? n - 1 : 0) * apart, step = end ? -apart : apart;   \
                JOIN(type, 4) there = (JOIN(type, 4))(0);                                          \
                for (int j = 0; j < 4; j++)                                                        \
                    there += to_end[j] * v[last + j * step];                                       \
                carried[end] =                                                                     \
                    there * ((__global const JOIN(type, 4) *)shares)[end * places + i];            \
            }                                                                                      \
            for (int place = 0; place < n; place++)                                                \
                ((__global JOIN(type, 4) *)derivative)[first + place * apart] +=                   \
                    edge[place] * carried[0] + edge[n + place] * carried[1];                       \
        }                                                                                          \
        SYNC;                                                                                      \
    }
CROSSING_VELOCITIES(double)
#ifdef SINGLE
CROSSING_VELOCITIES(float)
#endif

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

/* The state's velocity across a direction. */
static void set_velocity_across(const Grid *g, const Film *film, int axis, field work)
{
    velocity_across(g, state_field(g, film, axis, ACROSS),
                    (matrix)state_field(g, film, 1 - axis, ALONG), axis,
                    direction_of(film, 1 - axis).nodes, direction_of(film, axis).values, work);
}

/* What a change is taken by in a direction, at the state; a warm gas adds its own (thermal.py). */
static void set_linear(const Grid *whole_grid, const Film *whole_film, int axis)
{
    AS_COPIES(whole_grid, whole_film)
    const Direction d = direction_of(film, axis);
    matrix4 p = (matrix4)state_field(g, film, axis, PRESSURE);
    matrix4 slope = (matrix4)state_field(g, film, axis, SLOPE);
    matrix4 u = (matrix4)state_field(g, film, axis, ALONG);
    matrix4 across = (matrix4)state_field(g, film, axis, ACROSS);
    matrix4 along_rate = (matrix4)state_field(g, film, axis, ALONG_RATE);
    matrix4 across_rate = (matrix4)state_field(g, film, axis, ACROSS_RATE);
    matrix4 filling = (matrix4)state_field(g, film, axis, FILLING);
    matrix4 forces = (matrix4)state_field(g, film, axis, FORCES);
    matrix4 b = (matrix4)(film->own + axis * g->count);
    matrix4 shares = (matrix4)state_field(g, film, axis, CARRIED_SHARES);
    vector by = linear_field(g, film, axis, 0);
    const int spacing4 = g->spacing / 4;
    const double over_sigma = 1.0 / film->sigma;
    FOR_EACH_POINT(g, row, t, i)
    {
        EACH_OF(d)
        const double4 rise = density_slope(film, p[i]), flow = mobility(film, gap, density);
        const double4 lag = lag_of(film, gap, density), flux = film->sigma * gap;
        const double4 carried = 9.0 / 7.0 OVER_AREA(d, i) * lag;
        const double4 over_density = 1.0 / density, filled = lag * over_density * u[i] / 7.0;
        const double4 jump = gap * slip_of(film) * over_density * over_density * over_sigma;
        store4(jump * rise * slope[i], DRIVE_BY_RISE * spacing4 + i, by);
        store4(-flow, DRIVE_BY_SLOPE * spacing4 + i, by);
        store4(gap * rise, FILLING_BY_RISE * spacing4 + i, by);
        store4(lag * filling[i] / 7.0 - carried * (along_rate[i] TURNED(d, i, 2.0 * u[i])),
               FORCE_BY_VELOCITY * spacing4 + i, by);
        store4(-carried * u[i], FORCE_BY_ALONG_RATE * spacing4 + i, by);
#if AXES > 1
        /* δ(u across) times u's derivative there, and u across times that of δu. */
        store4(-carried * (across_rate[i] TURNED(d, i, 2.0 * across[i])),
               FORCE_BY_CROSSING * spacing4 + i, by);
        store4(-carried * across[i], FORCE_BY_ACROSS_RATE * spacing4 + i, by);
#endif
        store4(filled / gap, FORCE_BY_FILLING * spacing4 + i, by);
        store4(-lag, FORCE_BY_RATE * spacing4 + i, by);
        store4(-rise * (lag_slope(film, gap) * forces[i] + filled * filling[i]),
               FORCE_BY_RISE * spacing4 + i, by);
        store4(flux * density, FLUX_BY_DEFICIT * spacing4 + i, by);
        store4(flux * rise * b[i], FLUX_BY_RISE * spacing4 + i, by);
    }
#if AXES > 1
    FOR_EACH(i, 2 * g->count4 / (axis == 0 ? g->ny : g->nx))
        store4(shares[i], CARRIED_OUT * spacing4 + i, by);
#endif
    SYNC;
}

static void residual_inertia(const Grid *whole_grid, const Film *whole_film, field mass, field work,
                             field out)
{
    if (!whole_film->row->has_inertia)
        return;
    AS_COPIES(whole_grid, whole_film)
    const double sigma = film->sigma;
    field spare = spare_field(g, film, 0), rate = spare_field(g, film, 1);
    field settled = spare_field(g, film, 2);
    for (int axis = 0; axis < AXES; axis++) {
        const Direction d = direction_of(film, axis);
        matrix4 p = (matrix4)state_field(g, film, axis, PRESSURE);
        field u = state_field(g, film, axis, ALONG);
        field4 filling = (field4)state_field(g, film, axis, FILLING);
        set_velocity(g, film, axis);
        FOR_EACH_POINT(g, row, t, i)
        {
            const double4 beyond = beyond_even(g, film, d.amplitude, row, t);
            ((field4)spare)[i] = beyond + (1.0 + beyond) * density_rise(film, p[i]);
        }
        SYNC;
        along_t(g, g->time_derivative, spare, (field)filling, 0);
        FOR_EACH(i, g->count4) filling[i] /= 1.0 + ((matrix4)spare)[i];
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
        field4 lagging = (field4)spare, flux = (field4)rate;
        vector left = film->own_out + axis * g->count;
#if AXES > 1
        field shares = state_field(g, film, axis, CARRIED_SHARES);
        set_velocity_across(g, film, axis, spare);
        set_carried_shares(g, film, axis, across, (field4)shares);
        add_carried_out(g, axis, d.edge, d.to_end, (matrix)shares, (matrix)u, (field)across_rate);
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
        along_t(g, ARRAY(film, settling), film->own + axis * g->count, settled, 0);
        along_t(g, ARRAY(film, settling_of_slow), spare, settled, 1);
        FOR_EACH_POINT(g, row, t, i)
        {
            EACH_OF(d)
            flux[i] = sigma * gap * density * (b[i] - ((matrix4)settled)[i]);
            store4(((matrix4)settled)[i], i, left);
        }
        SYNC;
        along_axis(g, axis, d.divergence, NODES_TO_SLOPES, rate, out, 1);
        set_linear(g, film, axis);
    }
    vector rise = common_field(g, film, RISE_BY_MASS);
    FOR_EACH_POINT(g, row, t, i)
        store4(1.0 / (gap_at(g, film, row, t) * density_slope(film, film->p[i])), i, rise);
    SYNC;
}

/* δρ but for its slope, δV in the place of the deficit and δu of a change `rise` of the pressure and one
 * of what is more than settled, times a sign. */
static void driven(const Grid *g, const Film *film, int axis, constant_vector rise, real sign)
{
    vector rises = linear_field(g, film, axis, RISE), drive = linear_field(g, film, axis, DEFICIT);
    vector velocity = linear_field(g, film, axis, VELOCITY);
    along_axis(g, axis, g->linear.flux[axis].values, NODES_TO_NODES, rise, rises, 0);
    along_axis(g, axis, g->linear.flux[axis].slope, NODES_TO_SLOPES, rise, drive, 0);
    __global const lanes *by_rise = (__global const lanes *)linear_field(g, film, axis, DRIVE_BY_RISE);
    __global const lanes *by_slope = (__global const lanes *)linear_field(g, film, axis, DRIVE_BY_SLOPE);
    __global const lanes *beta = (__global const lanes *)(film->own_in + axis * g->count);
    FOR_EACH(i, g->count / LANES)
    {
        ((__global lanes *)drive)[i] = by_rise[i] * ((__global const lanes *)rises)[i] +
                                       by_slope[i] * ((__global const lanes *)drive)[i];
        ((__global lanes *)velocity)[i] = sign * beta[i];
    }
    SYNC;
    along_t(g, g->linear.settling, drive, velocity, 1);
    FOR_EACH(i, g->count / LANES)
        ((__global lanes *)drive)[i] -= ((__global const lanes *)velocity)[i];
    SYNC;
}

/* Minus what lags by a change's forces, and the change's rate of velocity. */
static void set_lagging(const Grid *whole_grid, const Film *whole_film, int axis)
{
    AS_COPIES(whole_grid, whole_film)
    const int spacing = g->spacing / LANES;
    __global const lanes *by = (__global const lanes *)linear_field(g, film, axis, 0);
    __global const lanes *rise = by + RISE * spacing, *velocity = by + VELOCITY * spacing;
    __global lanes *common = (__global lanes *)common_field(g, film, 0);
    FOR_EACH(i, g->count / LANES)
    {
        lanes lagging = by[FORCE_BY_VELOCITY * spacing + i] * velocity[i] +
                        by[FORCE_BY_ALONG_RATE * spacing + i] * common[ALONG_CHANGE * spacing + i];
#if AXES > 1
        lagging += by[FORCE_BY_CROSSING * spacing + i] * common[CROSSING * spacing + i] +
                   by[FORCE_BY_ACROSS_RATE * spacing + i] * common[ACROSS_CHANGE * spacing + i];
#endif
        lagging += by[FORCE_BY_FILLING * spacing + i] * common[FILLING_CHANGE * spacing + i] +
                   by[FORCE_BY_RATE * spacing + i] * common[VELOCITY_CHANGE * spacing + i];
        common[LAGGING * spacing + i] = lagging + by[FORCE_BY_RISE * spacing + i] * rise[i];
    }
    SYNC;
}

/* The flux of a change, in the place of what lags. */
static void set_flux(const Grid *whole_grid, const Film *whole_film, int axis, constant_vector settled)
{
    AS_COPIES(whole_grid, whole_film)
    const int spacing = g->spacing / LANES;
    __global const lanes *by = (__global const lanes *)linear_field(g, film, axis, 0);
    __global const lanes *rise = by + RISE * spacing, *deficit = by + DEFICIT * spacing;
    __global const lanes *velocity = by + VELOCITY * spacing, *left = (__global const lanes *)settled;
    __global lanes *flux = (__global lanes *)common_field(g, film, LAGGING);
    __global const lanes *rate = (__global const lanes *)common_field(g, film, VELOCITY_CHANGE);
    FOR_EACH(i, g->count / LANES)
        flux[i] = by[FLUX_BY_DEFICIT * spacing + i] * (deficit[i] - left[i]) +
                  by[FLUX_BY_RISE * spacing + i] * rise[i];
    if (film->row->has_thermal)
        FOR_EACH(i, g->count / LANES)
            flux[i] += by[FLUX_BY_VELOCITY * spacing + i] * velocity[i] +
                       by[FLUX_BY_RATE * spacing + i] * rate[i];
    SYNC;
}

static void response_inertia(const Grid *g, const Film *film, vector mass, vector work, vector out)
{
    if (!film->row->has_inertia)
        return;
    vector rise = common_field(g, film, PRESSURE_RISE), lagging = common_field(g, film, LAGGING);
    __global const lanes *by_mass = (__global const lanes *)common_field(g, film, RISE_BY_MASS);
    FOR_EACH(i, g->count / LANES)
        ((__global lanes *)rise)[i] = by_mass[i] * ((__global const lanes *)mass)[i];
    SYNC;
    for (int axis = 0; axis < AXES; axis++)
        driven(g, film, axis, rise, -1);
    for (int axis = 0; axis < AXES; axis++) {
        const Fluxes d = g->linear.flux[axis];
        vector velocity = linear_field(g, film, axis, VELOCITY);
        vector settled = film->own_out + axis * g->count;
#if AXES > 1
        const Fluxes other = g->linear.flux[1 - axis];
        vector across_rate = common_field(g, film, ACROSS_CHANGE);
        velocity_across(g, common_field(g, film, CROSSING), linear_field(g, film, 1 - axis, VELOCITY),
                        axis, other.nodes, d.values, work);
        along_axis(g, 1 - axis, other.across, NODES_TO_SLOPES, velocity, across_rate, 0);
        add_carried_out(g, axis, other.edge, other.to_end, linear_field(g, film, axis, CARRIED_OUT),
                        velocity, across_rate);
#endif
        along_axis(g, axis, d.along, NODES_TO_SLOPES, velocity, common_field(g, film, ALONG_CHANGE), 0);
        __global const lanes *by_rise =
            (__global const lanes *)linear_field(g, film, axis, FILLING_BY_RISE);
        __global const lanes *rises = (__global const lanes *)linear_field(g, film, axis, RISE);
        FOR_EACH(i, g->count / LANES) ((__global lanes *)work)[i] = by_rise[i] * rises[i];
        SYNC;
        along_t(g, g->linear.time_derivative, work, common_field(g, film, FILLING_CHANGE), 0);
        along_t(g, g->linear.time_derivative, velocity, common_field(g, film, VELOCITY_CHANGE), 0);
        set_lagging(g, film, axis);
        along_t(g, g->linear.settling, linear_field(g, film, axis, DEFICIT), settled, 0);
        along_t(g, g->linear.settling_of_slow, lagging, settled, 1);
        set_flux(g, film, axis, settled);
        along_axis(g, axis, d.divergence, NODES_TO_SLOPES, lagging, out, 1);
    }
}

/* b as a step of the pressure and Krylov's solution change it; the latter has the other sign. */
static void step_inertia(const Grid *g, const Film *film, field step, double share)
{
    if (!film->row->has_inertia)
        return;
    vector rise = common_field(g, film, PRESSURE_RISE);
    FOR_EACH(i, g->count4) store4(((matrix4)step)[i], i, rise);
    SYNC;
    for (int axis = 0; axis < AXES; axis++) {
        driven(g, film, axis, rise, 1);
        __global const JOIN(real, 4) *deficit =
            (__global const JOIN(real, 4) *)linear_field(g, film, axis, DEFICIT);
        field4 b = (field4)(film->own + axis * g->count);
        FOR_EACH(i, g->count4) b[i] += share * in_double(deficit[i]);
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
