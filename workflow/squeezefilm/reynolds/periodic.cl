/* The periodic state of the film by Newton–GMRES, one scene per work-group at a time. Compiled after
 * film_over_period.cl, which has the equation, and krylov.cl. */

/* Mean overpressure over film and period, in units of ambient pressure. */
static double mean_overpressure(const Grid *g, const Film *film, __local double *scratch)
{
    double4 sum = (double4)(0.0);
    FOR_EACH(row, g->rows)
    {
        double4 over_period = (double4)(0.0);
        for (int t = 0; t < g->nt4; t++)
            over_period += film->p[row * g->nt4 + t];
        sum += g->weights[row] * over_period;
    }
    return sum_over_group(sum_of(sum), scratch) / g->nt;
}

/* Largest share of a pressure step that takes at most 9/10 of the pressure anywhere. */
static double safe_share(const Grid *g, const Film *film, matrix4 step, __local double *scratch)
{
    double4 most = (double4)(0.0);
    FOR_EACH(i, g->count4) most = larger(most, -step[i] / (1.0 + film->p[i]));
    const double steepest = max_over_group(max_of(most), scratch);
    return steepest > 0.9 ? 0.9 / steepest : 1.0;
}

enum { CONVERGED = 0, STALLED = 1, NOT_FINITE = 2 };

/* Where a scene's parts lie in the arrays of its launch, in numbers from their starts. */
enum { NX, NY, NT, MOST_KRYLOV, MATRICES, PROFILE, SCHUR, STATE, LAYOUT };

/* Work-groups take scenes from a queue until none is left; each has a workspace of its own, and a
 * scene's result does not depend on which group takes it.
 *
 * layout:   per scene its grid, the most Krylov iterations of a Newton step, and its offsets.
 * matrices: per grid and aspect what make_grid reads.
 * numbers:  per scene epsilon, sigma, bearing, tolerance (of the force, relative), 1/exponent of
 *           the gas, and the flow coefficients c_0 …
 * profile:  per place amplitude, |grad|², Laplacian and (BEARING) x-slope, each (nx, ny).
 * schur:    BEARING, per scene the Schur vectors along x, their inverse and the triangle (nx, nx).
 * state:    per scene p (nx, ny, nt); the first guess on entry.
 * results:  per scene mean overpressure, norm of the last residual, largest |p|, smallest P and
 *           smallest P H.
 * counts:   per scene status, Newton steps, Krylov iterations. */
__kernel void periodic_state(const int scenes, const int most_newton, __global const long *layout,
                             matrix matrices, matrix numbers, matrix profile, matrix schur,
                             field state, field results, __global int *counts,
                             __global int *queue, field workspace, const ulong workspace_size,
                             __local double *scratch)
{
    __local int taken;

    while (true) {
        if (get_local_id(0) == 0)
            taken = atomic_inc(queue);
        SYNC;
        const int scene = taken;
        SYNC;
        if (scene >= scenes)
            break;
        __global const long *lies = layout + scene * LAYOUT;
        const int nx = lies[NX], most_krylov = lies[MOST_KRYLOV];
        Grid g = make_grid(nx, lies[NY], lies[NT], matrices + lies[MATRICES]);
        Film film;
        field space = workspace + get_group_id(0) * workspace_size;
        for (int k = 0; k < FLOW_TERMS; k++) {
            film.gap_power[k] = (field4)space;
            film.potential[k] = (field4)(space + g.count);
            film.response[k] = (field4)(space + 2 * g.count);
            space += 3 * g.count;
        }
        film.work_a = space;
        film.work_b = space + g.count;
        film.work_c = space + 2 * g.count;
        field basis = space + 3 * g.count;
        field small = basis + (most_krylov + 1) * g.count;
        matrix number = numbers + scene * (5 + FLOW_TERMS);
        film.epsilon = number[0];
        film.sigma = number[1];
        film.bearing = number[2];
        const double tolerance = number[3];
        film.inverse_exponent = number[4];
        for (int k = 0; k < FLOW_TERMS; k++)
            film.flow[k] = number[5 + k];
        film.amplitude = profile + lies[PROFILE];
        film.gradient_squared = film.amplitude + g.rows;
        film.laplacian = film.amplitude + 2 * g.rows;
        film.slope_x = film.amplitude + (PROFILE_FIELDS - 1) * g.rows;
        film.p = (field4)(state + lies[STATE]);
#ifdef BEARING
        g.modes_x = schur + lies[SCHUR];
        g.to_modes_x = g.modes_x + nx * nx;
        g.schur = g.to_modes_x + nx * nx;
#endif
        set_gap(&g, &film);

        int status = STALLED, newton = 0, krylov = 0;
        double beta = 0.0, force = mean_overpressure(&g, &film, scratch);
        for (; newton <= most_newton; newton++) {
            residual(&g, &film, basis, scratch);
            precondition(&g, &film, basis);
            beta = norm(basis, g.count4, g.nt, scratch);
            if (!isfinite(beta)) {
                status = NOT_FINITE;
                break;
            }
            /* The force answers to an error w with at most its mean, so beta bounds its error. */
            const double goal = tolerance * fabs(force);
            if (beta <= goal || beta == 0.0) {
                status = CONVERGED;
                break;
            }
            if (newton == most_newton)
                break;
            /* Inner accuracy after Eisenstat and Walker: no finer than Newton's own error. */
            const double target = fmax(0.3 * goal, fmin(0.1 * beta, beta * beta));
            krylov += gmres(&g, &film, basis, small, beta, target, most_krylov, g.nt, scratch);
            field4 step = (field4)film.work_b;
            from_modal(&g, basis, film.work_a, film.work_b);
            FOR_EACH_POINT(&g, row, t, i)
                step[i] /= -gap_at(&g, &film, row, t) * density_slope(&film, film.p[i]);
            SYNC;
            const double share = safe_share(&g, &film, step, scratch);
            FOR_EACH(i, g.count4) film.p[i] += share * step[i];
            SYNC;
            force = mean_overpressure(&g, &film, scratch);
        }
        double4 size = (double4)(0.0), deficit = (double4)(-INFINITY), thinness = deficit;
        FOR_EACH_POINT(&g, row, t, i)
        {
            const double4 p = film.p[i], pressure = 1.0 + p;
            size = larger(size, fabs(p));
            deficit = larger(deficit, -pressure);
            thinness = larger(thinness, -pressure * gap_at(&g, &film, row, t));
        }
        const double largest = max_over_group(max_of(size), scratch);
        const double lowest = -max_over_group(max_of(deficit), scratch);
        const double thinnest = -max_over_group(max_of(thinness), scratch);
        if (get_local_id(0) == 0) {
            results[5 * scene] = force;
            results[5 * scene + 1] = beta;
            results[5 * scene + 2] = largest;
            results[5 * scene + 3] = lowest;
            results[5 * scene + 4] = thinnest;
            counts[3 * scene] = status;
            counts[3 * scene + 1] = newton;
            counts[3 * scene + 2] = krylov;
        }
        SYNC;
    }
}
