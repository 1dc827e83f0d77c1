/* The film in time from a given state, by Runge–Kutta steps, one scene per work-group at a time.
 * Compiled after film_at_instant.cl, which has the equation, and with IMPLICIT krylov.cl.
 *
 * The scheme is a lower triangular Butcher table (host). Stages with a zero on the diagonal are
 * evaluated; the others (IMPLICIT) are solved by Newton's method with GMRES inside.
 */

#ifdef IMPLICIT
/* Solve y − c f(T, y) = z from the guess in y; `rates` becomes f. Returns whether the error left in
 * y is at most `tolerance` by its estimate, the preconditioned residual. An explicit stage, c = 0,
 * comes with y = z and is done at once. */
static bool solve_stage(const Grid *g, Film *film, double c, field y, matrix z, field rates,
                        double tolerance, field basis, field small, int *newton, int *krylov,
                        __local double *scratch)
{
    double beta = 0.0;
    film->stage = c;
    for (int step = 0;; step++) {
        rate(g, film, y, rates, scratch);
        FOR_EACH(i, g->count) basis[i] = y[i] - z[i] - c * rates[i];
        SYNC;
        precondition(g, film, basis);
        beta = norm(basis, g->count4, g->count, scratch);
        if (beta <= tolerance || !isfinite(beta) || step == NEWTON)
            break;
        double left;
        const double target = fmax(0.3 * tolerance, fmin(0.1 * beta, beta * beta));
        *krylov += gmres(g, film, basis, small, beta, target, KRYLOV, g->count, &left, scratch);
        *newton += 1;
        FOR_EACH(i, g->count) y[i] -= basis[i];
        SYNC;
    }
    return beta <= tolerance;
}
#endif

/* table:   Butcher's a (stages, stages), b, c.
 * rows:    per scene sizes, numbers, steps per period, tolerance of a stage and where its parts lie
 *          in values; the sizes are those of all scenes. Row, Period and Ending: transient.py.
 * state:   per scene y (nx, ny) at a period's beginning on entry, `periods` later on exit. There the
 *          gap is at rest and y = P − 1.
 * mean_overpressure: per scene (nx, ny), over the last period.
 * results: per scene and period, what is said of it.
 * endings: per scene how its march ended, at what cost. */
__kernel void march_films(const int scenes, const int periods, const int stages, matrix table,
                          __global const Row *rows, matrix values, field state,
                          field mean_overpressure, __global Period *results,
                          __global Ending *endings, field workspace, const ulong workspace_size,
                          __global int *queue, __local double *scratch)
{
    const Grid g = make_grid(rows, values);
    matrix b = table + stages * stages, nodes = b + stages;
    __local int taken;
    field space = workspace + get_group_id(0) * workspace_size;
    Film film;
    film.inverse_gap = (field4)space;
    film.power = (field4)(space + g.count);
    film.potential = (field4)(space + 2 * g.count);
    film.response = (field4)(space + 3 * g.count);
    film.overpressure = (field4)(space + 4 * g.count);
    film.work_a = space + 5 * g.count;
    film.work_b = space + 6 * g.count;
    field stage = space + 7 * g.count, known = space + 8 * g.count, rates = space + 9 * g.count;
#ifdef IMPLICIT
    field basis = rates + stages * g.count, small = basis + (KRYLOV + 1) * g.count;
#endif

    while (true) {
        if (get_local_id(0) == 0)
            taken = atomic_inc(queue);
        SYNC;
        const int scene = taken;
        SYNC;
        if (scene >= scenes)
            break;
        __global const Row *given = rows + scene;
        film.row = given;
        film.values = values;
        film.epsilon = given->epsilon;
        film.sigma = given->sigma;
        const int steps = given->steps;
        const double h = 2.0 * M_PI / steps;
        film.amplitude = (matrix4)ARRAY(&film, amplitude);
        film.slope_x = (matrix4)ARRAY(&film, slope_x);
        film.slope_y = (matrix4)ARRAY(&film, slope_y);
        film.laplacian = (matrix4)ARRAY(&film, laplacian);
        field y = state + (ulong)scene * g.count;
        field4 mean = (field4)(mean_overpressure + (ulong)scene * g.count);
        __global Period *result = results + (ulong)scene * periods;

        int status = MARCHED, newton = 0, krylov = 0, period = 0;
        for (; period < periods && status == MARCHED; period++) {
            double lowest = INFINITY, highest = -INFINITY, phase = -1.0;
            FOR_EACH(k, g.count4) mean[k] = 0.0;
            SYNC;
            for (int step = 0; step < steps; step++) {
                for (int i = 0; i < stages; i++) {
                    if (phase != (step + nodes[i]) / steps) {
                        phase = (step + nodes[i]) / steps;
                        const double slow = sin(2.0 * M_PI * given->modulations * (period + phase));
                        set_gap(&g, &film,
                                film.epsilon * (1.0 + given->depth * slow) *
                                    sin(2.0 * M_PI * phase));
                    }
                    matrix row = table + i * stages;
                    field own = rates + i * g.count;
                    FOR_EACH(k, g.count4)
                    {
                        double4 sum_of_rates = 0.0;
                        for (int j = 0; j < i; j++)
                            sum_of_rates += row[j] * ((matrix4)rates)[j * g.count4 + k];
                        ((field4)known)[k] = ((matrix4)y)[k] + h * sum_of_rates;
                    }
                    SYNC;
#ifdef IMPLICIT
                    /* First guess: the rate of the stage before. */
                    const double c = h * row[i];
                    FOR_EACH(k, g.count)
                    stage[k] = known[k] + (c != 0.0 ? c * own[k - g.count] : 0.0);
                    SYNC;
                    if (!solve_stage(&g, &film, c, stage, known, own, given->tolerance, basis, small,
                                     &newton, &krylov, scratch) &&
                        status == MARCHED)
                        status = STALLED;
                    /* The rate that fits the stage exactly: what is left of the equations in it is
                     * small, but what is left in f is not where the film is stiff. */
                    if (c != 0.0)
                        FOR_EACH(k, g.count) own[k] = (stage[k] - known[k]) / c;
                    SYNC;
#else
                    rate(&g, &film, known, own, scratch);
#endif
                    const double share = b[i] / steps;
                    FOR_EACH(k, g.count4) mean[k] += share * film.overpressure[k];
                    SYNC;
                    const double force =
                        dot_product(g.area, (field)film.overpressure, g.count4, scratch);
                    if (i == 0) {
                        lowest = fmin(lowest, force);
                        highest = fmax(highest, force);
                    }
                    if (!isfinite(force) && status == MARCHED)
                        status = NOT_PHYSICAL;
                }
                FOR_EACH(k, g.count4)
                {
                    double4 sum_of_rates = 0.0;
                    for (int j = 0; j < stages; j++)
                        sum_of_rates += b[j] * ((matrix4)rates)[j * g.count4 + k];
                    ((field4)y)[k] += h * sum_of_rates;
                }
                SYNC;
            }
            double wrong = 0.0;
            FOR_EACH(k, g.count) wrong = isfinite(y[k]) && y[k] > -1.0 ? wrong : 1.0;
            if (max_over_group(wrong, scratch) > 0.0 && status == MARCHED)
                status = NOT_PHYSICAL;
            const double force = dot_product(g.area, (field)mean, g.count4, scratch);
            if (get_local_id(0) == 0) {
                result[period].mean = status == MARCHED ? force : NAN;
                result[period].lowest = lowest;
                result[period].highest = highest;
            }
            SYNC;
        }
        if (get_local_id(0) == 0) {
            for (int k = period; k < periods; k++)
                result[k] = (Period){.mean = NAN, .lowest = NAN, .highest = NAN};
            endings[scene] = (Ending){
                .status = status, .newton_steps = newton, .krylov_iterations = krylov};
        }
        SYNC;
    }
}
