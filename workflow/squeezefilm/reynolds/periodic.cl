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

/* Largest |p|. */
static double largest_overpressure(const Grid *g, const Film *film, __local double *scratch)
{
    double4 size = (double4)(0.0);
    FOR_EACH(i, g->count4) size = larger(size, fabs(film->p[i]));
    return max_over_group(max_of(size), scratch);
}

/* Largest share of a pressure step that takes at most 9/10 of the pressure anywhere. */
static double safe_share(const Grid *g, const Film *film, matrix4 step, __local double *scratch)
{
    double4 most = (double4)(0.0);
    FOR_EACH(i, g->count4) most = larger(most, -step[i] / (1.0 + film->p[i]));
    const double steepest = max_over_group(max_of(most), scratch);
    return steepest > 0.9 ? 0.9 / steepest : 1.0;
}

/* The state on a coarser grid (nx, ny, nt), interpolated to g by the matrices m, with two fields of
 * g's size to work in. */
static void carry(const Grid *g, int nx, int ny, int nt, matrix m, field coarse, field fine,
                  field work_a, field work_b)
{
    matrix along_t = m, along_x = along_t + nt * g->nt, along_y = along_x + g->nx * nx;
    multiply(coarse, nx * ny, nt, (matrix4)along_t, (field4)work_a, g->nt4, 1, 0);
    multiply(along_x, g->nx, nx, (matrix4)work_a, (field4)work_b, ny * g->nt4, 1, 0);
    multiply(along_y, g->ny, ny, (matrix4)work_b, (field4)fine, g->nt4, g->nx, 0);
}

/* The iteration's rounding error of the mass, relative to the largest overpressure. */
#define ROUNDING 1e-14

enum { CONVERGED = 0, STALLED = 1, NOT_FINITE = 2 };

/* What is said of a scene on a grid, beside its state. */
typedef struct {
    double force, left;
    int status, newton, krylov;
} Solved;

/* Newton's iteration from the guess film->p. `basis` has room for most_krylov + 1 fields, `small`
 * for the numbers of gmres. */
static Solved solve(const Grid *g, Film *film, double tolerance, int most_newton, int most_krylov,
                    field basis, field small, __local double *scratch)
{
    Solved s = {mean_overpressure(g, film, scratch), 0.0, STALLED, 0, 0};
    for (; s.newton <= most_newton; s.newton++) {
        residual(g, film, basis, scratch);
        precondition(g, film, basis);
        s.left = norm(basis, g->count4, g->nt, scratch);
        if (!isfinite(s.left)) {
            s.status = NOT_FINITE;
            break;
        }
        /* The force answers to an error w with at most its mean, so this bounds its error. */
        const double goal = fmax(tolerance * fabs(s.force),
                                 ROUNDING * largest_overpressure(g, film, scratch));
        if (s.left <= goal || s.left == 0.0) {
            s.status = CONVERGED;
            break;
        }
        if (s.newton == most_newton)
            break;
        /* Inner accuracy after Eisenstat and Walker: no finer than Newton's own error. */
        const double target = fmax(0.3 * goal, fmin(0.1 * s.left, s.left * s.left));
        s.krylov += gmres(g, film, basis, small, s.left, target, most_krylov, g->nt, scratch);
        field4 step = (field4)film->work_b;
        from_modal(g, basis, film->work_a, film->work_b);
        FOR_EACH_POINT(g, row, t, i)
            step[i] /= -gap_at(g, film, row, t) * density_slope(film, film->p[i]);
        SYNC;
        const double share = safe_share(g, film, step, scratch);
        FOR_EACH(i, g->count4) film->p[i] += share * step[i];
        SYNC;
        s.force = mean_overpressure(g, film, scratch);
    }
    return s;
}

/* What a row of the layout has: a grid, the most Krylov iterations of a Newton step, and where a
 * scene's parts lie in the arrays of its launch, in numbers from their starts. */
enum { NX, NY, NT, MOST_KRYLOV, MATRICES, CARRY, PROFILE, SCHUR, STATE, LAYOUT };

/* What a row of the results has. */
enum { MEAN, RESIDUAL, LARGEST, LOWEST, THINNEST, STATUS, NEWTON, KRYLOV, NUMBERS };

/* Work-groups take scenes from a queue until none is left; each has a workspace of its own, and a
 * scene's result does not depend on which group takes it. A scene goes from grid to grid: each
 * state is the first guess of the next, if it was found.
 *
 * begins:   per scene its first row in layout, numbers and results; a row is the scene on a grid.
 * layout:   where its parts lie.
 * matrices: per grid and aspect what make_grid reads, and what carry reads; CARRY is negative on a
 *           scene's first grid.
 * numbers:  per row epsilon, sigma, bearing, tolerance (of the force, relative), 1/exponent of
 *           the gas, and the flow coefficients c_0 …
 * profile:  per place amplitude, |grad|², Laplacian and (BEARING) x-slope, each (nx, ny).
 * schur:    BEARING, per row the Schur vectors along x, their inverse and the triangle (nx, nx).
 * results:  per row mean overpressure, norm of the last residual, largest |p|, smallest P, smallest
 *           P H, status, Newton steps and Krylov iterations; then, where layout says, per row p
 *           (nx, ny, nt), the first guess on entry. One array, for each that the host waits for
 *           costs it as much as a small solve. */
__kernel void periodic_state(const int scenes, const int most_newton, __global const int *begins,
                             __global const long *layout, matrix matrices, matrix numbers,
                             matrix profile, matrix schur, field results, __global int *queue,
                             field workspace, const ulong workspace_size, __local double *scratch)
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
        int status = CONVERGED;
        for (int row = begins[scene]; row < begins[scene + 1]; row++) {
            __global const long *entry = layout + row * LAYOUT;
            const int most_krylov = entry[MOST_KRYLOV];
            Grid g = make_grid(entry[NX], entry[NY], entry[NT], matrices + entry[MATRICES]);
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
            matrix number = numbers + row * (5 + FLOW_TERMS);
            film.epsilon = number[0];
            film.sigma = number[1];
            film.bearing = number[2];
            const double tolerance = number[3];
            film.inverse_exponent = number[4];
            for (int k = 0; k < FLOW_TERMS; k++)
                film.flow[k] = number[5 + k];
            film.amplitude = profile + entry[PROFILE];
            film.gradient_squared = film.amplitude + g.rows;
            film.laplacian = film.amplitude + 2 * g.rows;
            film.slope_x = film.amplitude + (PROFILE_FIELDS - 1) * g.rows;
            film.p = (field4)(results + entry[STATE]);
#ifdef BEARING
            g.modes_x = schur + entry[SCHUR];
            g.to_modes_x = g.modes_x + g.nx * g.nx;
            g.schur = g.to_modes_x + g.nx * g.nx;
#endif
            if (entry[CARRY] >= 0 && status == CONVERGED) {
                __global const long *before = entry - LAYOUT;
                carry(&g, before[NX], before[NY], before[NT], matrices + entry[CARRY],
                      results + before[STATE], (field)film.p, film.work_a, film.work_b);
            } else if (entry[CARRY] >= 0) {
                FOR_EACH(i, g.count4) film.p[i] = (double4)(0.0);
                SYNC;
            }
            set_gap(&g, &film);
            const Solved solved =
                solve(&g, &film, tolerance, most_newton, most_krylov, basis, small, scratch);
            status = solved.status;
            double4 deficit = (double4)(-INFINITY), thinness = deficit;
            FOR_EACH_POINT(&g, place, t, i)
            {
                const double4 p = film.p[i], density = 1.0 + density_rise(&film, p);
                deficit = larger(deficit, -(1.0 + p));
                thinness = larger(thinness, -density * gap_at(&g, &film, place, t));
            }
            const double largest = largest_overpressure(&g, &film, scratch);
            const double lowest = -max_over_group(max_of(deficit), scratch);
            const double thinnest = -max_over_group(max_of(thinness), scratch);
            if (get_local_id(0) == 0) {
                field result = results + row * NUMBERS;
                result[MEAN] = solved.force;
                result[RESIDUAL] = solved.left;
                result[LARGEST] = largest;
                result[LOWEST] = lowest;
                result[THINNEST] = thinnest;
                result[STATUS] = status;
                result[NEWTON] = solved.newton;
                result[KRYLOV] = solved.krylov;
            }
            SYNC;
        }
    }
}
