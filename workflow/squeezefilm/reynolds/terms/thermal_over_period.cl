/* Thermal effects (thermal.py): what the gas' rise of temperature moves. Newton's steps take the rise of
 * a change with a lag as at rest, and in the flow the gas as warm as it is: a step leaves about a
 * twentieth of itself, where waves are not too steep. */

#define THERMAL_FIELDS 8

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

/* Values of as many rows of the grid as a register holds. */
typedef __global JOIN(double, DOUBLE_LANES) *rows_together;

/* Solve matrix · values = values in place for so many systems, by elimination; the matrices (n, n)
 * are overwritten. No pivot is searched for: but for a factor of each row and column a matrix is 1 and a
 * skew part. */
static void eliminate(rows_together matrix_rows, rows_together values, int n)
{
    for (int k = 0; k < n; k++) {
        rows_together pivot_row = matrix_rows + k * n;
        const JOIN(double, DOUBLE_LANES) over_pivot = 1.0 / pivot_row[k];
        values[k] *= over_pivot;
        for (int j = k + 1; j < n; j++)
            pivot_row[j] *= over_pivot;
        for (int i = k + 1; i < n; i++) {
            rows_together row = matrix_rows + i * n;
            const JOIN(double, DOUBLE_LANES) factor = row[k];
            for (int j = k + 1; j < n; j++)
                row[j] -= factor * pivot_row[j];
            values[i] -= factor * values[k];
        }
    }
    for (int k = n - 1; k > 0; k--)
        for (int i = 0; i < k; i++)
            values[i] -= matrix_rows[i * n + k] * values[k];
}

/* The rise by compression, (1 + c d/dT) warmth = (heating H²/12) dp/dT with c = thermal_lag P H², and
 * what a jump of temperature at the walls makes of both; `lags` is room for c. By as many items as there
 * is room for matrices where Krylov's vectors will stand (launch.py). */
static void warm(const Grid *g, const Film *film, field warmth, field lags)
{
    along_t(g, g->time_derivative, (field)film->p, warmth, 0);
    FOR_EACH_POINT(g, row, t, i)
    {
        const double4 gap = gap_at(g, film, row, t), density = 1.0 + film->p[i];
        ((field4)lags)[i] =
            film->row->thermal_lag * gap * (density * gap + film->row->jump_lags);
        ((field4)warmth)[i] *=
            film->row->heating / 12.0 * gap * (gap + film->row->jump_warms / density);
    }
    SYNC;
    const int n = g->nt, size = DOUBLE_LANES * n * (n + 1);
    const long room = film->row->most_krylov * g->length * sizeof(real) / sizeof(double);
    const int item = get_local_id(0), items = min((long)WORK_ITEMS, room / size);
    field values = (field)(film->basis + g->length) + item * size;
    rows_together systems = (rows_together)values, matrix_rows = systems + n;
    const int first = item < items ? DOUBLE_LANES * item : g->rows;
    for (int row = first; row < g->rows; row += DOUBLE_LANES * items) {
        const int together = min(DOUBLE_LANES, g->rows - row);
        for (int i = 0; i < n; i++) {
            for (int k = 0; k < DOUBLE_LANES; k++) {
                const int at = (row + min(k, together - 1)) * n + i;
                values[i * DOUBLE_LANES + k] = warmth[at];
                ((field)(matrix_rows + i * n))[k] = lags[at];
            }
            const JOIN(double, DOUBLE_LANES) lag = matrix_rows[i * n];
            /* d/dT is skew. */
            for (int j = 0; j < n; j++)
                matrix_rows[i * n + j] = (i == j) - g->time_derivative[i * n + j] * lag;
        }
        eliminate(matrix_rows, systems, n);
        for (int k = 0; k < together; k++)
            for (int i = 0; i < n; i++)
                warmth[(row + k) * n + i] = values[i * DOUBLE_LANES + k];
    }
    SYNC;
}

/* The state's velocities of a film without inertia; with it they are set (inertia_over_period.cl). */
static void set_velocities(const Grid *g, const Film *film, field work)
{
    if (film->row->has_inertia)
        return;
    for (int axis = 0; axis < AXES; axis++)
        set_velocity(g, film, axis);
#if AXES > 1
    for (int axis = 0; axis < AXES; axis++)
        set_velocity_across(g, film, axis, work);
#endif
}

/* σ times what warm gas lacks for each mass. */
static vector lacking_by_mass(const Grid *g, const Film *film)
{
    return (vector)(film->own_work + (OWN_FIELDS - 1) * g->spacing);
}

static void residual_thermal(const Grid *g, const Film *film, field mass, field work, field out)
{
    if (!film->row->has_thermal)
        return;
    field warmth = film->own_work + (OWN_FIELDS - THERMAL_FIELDS) * g->spacing;
    field nodal = warmth + g->spacing, first = nodal + 2 * g->spacing, second = first + g->spacing;
    field third = second + g->spacing, fourth = third + g->spacing;
    vector by_mass = lacking_by_mass(g, film);
    const double sigma = film->sigma, kappa = film->row->viscosity_exponent;
    /* τ_b over the square of the speed. */
    const double cooling = film->row->heating * sigma / 20.0;
    warm(g, film, warmth, first);
    set_velocities(g, film, work);
    for (int axis = 0; axis < AXES; axis++)
        along_axis(g, axis, ON_AXIS(axis, flux_nodes), NODES_TO_NODES,
                   state_field(g, film, axis, ALONG), nodal + axis * g->spacing, 0);
    matrix4 nodal_x = (matrix4)nodal, nodal_y = nodal_x + g->spacing / 4;
    FOR_EACH_POINT(g, row, t, i)
    {
        const double4 square = nodal_x[i] * nodal_x[i] PLUS_ACROSS(nodal_y[i] * nodal_y[i]);
        const double4 rise = ((matrix4)warmth)[i] TIMES_AREA(row) - cooling * square;
        store4(sigma * rise, i, by_mass);
        ((field4)first)[i] = gap_at(g, film, row, t) * (1.0 + film->p[i]) * rise;
    }
    SYNC;
    along_t(g, g->time_derivative, first, second, 0);
    subtract(out, -sigma, second, g->count4);
    for (int axis = 0; axis < AXES; axis++) {
        matrix amplitude = ON_AXIS(axis, flux_amplitude);
        matrix4 pressure = (matrix4)state_field(g, film, axis, PRESSURE);
        matrix4 along = (matrix4)state_field(g, film, axis, ALONG);
        matrix4 across = (matrix4)state_field(g, film, axis, ACROSS);
        vector by_velocity = linear_field(g, film, axis, FLUX_BY_VELOCITY);
        vector by_rate = linear_field(g, film, axis, FLUX_BY_RATE);
        field4 flux = (field4)first, warmer = (field4)second, rises = (field4)third;
        along_axis(g, axis, ON_AXIS(axis, flux_values), NODES_TO_NODES, warmth, second, 0);
        FOR_EACH(i, g->count4)
            rises[i] = warmer[i] - cooling OVER_AREA_ON(axis, i) *
                                       (along[i] * along[i] PLUS_ACROSS(across[i] * across[i]));
        SYNC;
        along_t(g, g->time_derivative, third, work, 0);
        along_t(g, g->time_derivative, (field)along, fourth, 0);
        FOR_EACH_POINT(g, row, t, i)
        {
            const double4 gap = 1.0 + beyond_even(g, film, amplitude, row, t);
            const double4 density = 1.0 + pressure[i], lags = lag_of(film, gap, density);
            const double4 hot = warmer[i], cold = hot - rises[i];
            const double4 lighter = 6.0 / 5.0 * hot - 9.0 / 14.0 * cold;
            const double4 thicker = 3.0 / 5.0 * hot - 3.0 / 7.0 * cold;
            const double4 share = lighter + kappa * thicker - lags * ((matrix4)work)[i] / 7.0;
            const double4 lag = -9.0 / 7.0 * lags * rises[i], flow = sigma * gap * density;
            flux[i] = flow * (share * along[i] + lag * ((matrix4)fourth)[i]);
            store4(flow * share, i, by_velocity);
            store4(flow * lag, i, by_rate);
        }
        SYNC;
        along_axis(g, axis, ON_AXIS(axis, flux_divergence), NODES_TO_SLOPES, first, out, 1);
    }
}

/* −σ d/dT of the mass that warm gas lacks: of a change the film's modes in time know what itself warms
 * (time_modes.py). */
static void response_thermal(const Grid *g, const Film *film, vector mass, vector work, vector out)
{
    if (!film->row->has_thermal)
        return;
    __global const lanes *by_mass = (__global const lanes *)lacking_by_mass(g, film);
    FOR_EACH(i, g->count / LANES)
        ((__global lanes *)work)[i] = by_mass[i] * ((__global const lanes *)mass)[i];
    SYNC;
    along_t(g, g->linear.time_derivative, work, out, 1);
}
