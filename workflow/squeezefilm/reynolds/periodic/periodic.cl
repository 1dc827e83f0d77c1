/* The periodic state of the film by Newton–GMRES, one scene per work-group at a time. Compiled after
 * film_over_period.cl, which has the equation, and krylov.cl. Row, Said and how an iteration ends
 * are defined by launch.py. */

/* Mean gauge pressure over film and period, in units of ambient pressure, and the largest |p|; the means
 * over the period are kept. Before that p takes a share of a step, if there is one. */
static double2 size_after(const Grid *whole_grid, const Film *whole_film, matrix4 step, double share,
                          __local double *scratch)
{
    AS_COPIES(whole_grid, whole_film)
    double4 sum = (double4)(0.0), above = (double4)(0.0), below = (double4)(0.0);
    FOR_EACH(row, g->rows)
    {
        double4 over_period = (double4)(0.0);
        for (int i = row * g->nt4; i < (row + 1) * g->nt4; i++) {
            double4 p = film->p[i];
            if (step)
                film->p[i] = p = p + share * step[i];
            over_period += p;
            /* What is no number shows in the mean. */
            above = p > above ? p : above;
            below = p < below ? p : below;
        }
        film->means[row] = sum_of(over_period) / g->nt;
        sum += g->weights[row] * over_period;
    }
    const double mean = sum_over_group(sum_of(sum), scratch) / g->nt;
    const double largest = max_over_group(max_of(larger(above, -below)), scratch);
    return (double2)(mean, largest + 0.0 * mean);
}

/* How the mean over the period has changed since film->means_before: the largest of its lowest cosine
 * moments (error_estimate.py), and the mean of its magnitude. Each item sums all of it: it is little,
 * and compilers that loop over a group's items between barriers take minutes for ten more sums. */
static double2 change_of_means(const Grid *g, const Film *film)
{
    matrix4 along_x = (matrix4)ARRAY(film, moments_x), along_y = (matrix4)ARRAY(film, moments_y);
    double4 first = (double4)(0.0), second = first, third = first;
    for (int x = 0; x < g->nx; x++) {
        double4 row = (double4)(0.0);
        for (int y = 0; y < g->ny; y++) {
            const int i = x * g->ny + y;
            const double change = g->weights[i] * (film->means[i] - film->means_before[i]);
            row += along_y[y] * (double4)(change, change, change, fabs(change));
        }
        first += along_x[x].x * row;
        second += along_x[x].y * row;
        third += along_x[x].z * row;
    }
    /* The last of the first are the sizes; of the others they are no moments. */
    const double4 moments = larger(fabs(first), larger(fabs(second), fabs(third)));
    return (double2)(greater(greater(moments.x, moments.y), moments.z), first.w);
}

/* A change of the mass as a step of p; its largest fall and rise, relative to the pressure. */
static double2 step_of(const Grid *whole_grid, const Film *whole_film, constant_vector mass, field4 step,
                       __local double *scratch)
{
    AS_COPIES(whole_grid, whole_film)
    double4 fall = (double4)(0.0), rise = (double4)(0.0);
    FOR_EACH_POINT(g, row, t, i)
    {
        const double4 p = film->p[i], pressure = 1.0 + p;
        const double4 slope = gap_at(g, film, row, t) * density_slope(film, p);
        const double4 relative =
            -in_double(((__global const JOIN(real, 4) *)mass)[i]) / (slope * pressure);
        step[i] = relative * pressure;
        /* What is no number shows in the mean of p behind the step. */
        fall = -relative > fall ? -relative : fall;
        rise = relative > rise ? relative : rise;
    }
    return (double2)(max_over_group(max_of(fall), scratch), max_over_group(max_of(rise), scratch));
}

/* The state on the coarser grid of another row as the first guess on g. */
static void carry(const Grid *g, const Film *film, __global const Row *coarser, field coarse)
{
    carry_field(g, film, coarser, ARRAY(film, carry_t), ARRAY(film, carry_x), ARRAY(film, carry_y),
                coarse, (field)film->p);
    coarse += coarser->nx * coarser->ny * coarser->nt;
    TERMS_CARRY(g, film, coarser, coarse)
}

/* The iteration's rounding error of the mass, relative to the largest gauge pressure. */
#define ROUNDING 1e-14
/* What a Newton step leaves beside what GMRES is asked for: the rounding of its linear system,
 * relative to the residual before, and what the flow's curvature adds, relative to the step times its
 * largest relative change of the pressure. With them no error of 156 films (ε 0.02–0.95, σ 0.1–3e4),
 * at tolerances from 0.1 to 1e-9, was larger than what was said to be left. Unknowns of terms' own
 * bend the equation too: four times as much is said. */
#ifdef SINGLE
#define LINEAR_ROUNDING 1e-4
#else
#define LINEAR_ROUNDING 1e-10
#endif
#define NONLINEARITY(g) ((g)->length == (g)->count ? 2.0 : 8.0)
/* The linear system of a gas that warms lacks a part of the equation. What a step leaves for that,
 * relative to its length: as much as the step before left in all, no less than half of what was
 * known there, and MOST_LACK_CHANGE times that at most; at first FIRST_LACK. In 440 films (ε 0.02–0.6,
 * σ 5–5000, Re 0.1–8) no more was left than 0.9 of what was said. */
#ifdef HAS_thermal
#define STEPS_LACK(row) ((row)->has_thermal)
#else
#define STEPS_LACK(row) 0
#endif
#define FIRST_LACK 0.2
#define MOST_LACK_CHANGE 6.0
/* Newton steps that may fail, one after the other, to take a tenth off the least residual. */
#define PATIENCE 8

/* Newton's iteration from the guess film->p, of at most most_iterations steps of Newton and Krylov
 * together. `lack` is what its steps leave relative to their lengths, known better on return. `basis` has
 * room for most_krylov + 1 vectors, `small` for the numbers of gmres. */
static Said solve(const Grid *g, Film *film, double tolerance, int most_newton, int most_krylov,
                  int most_iterations, double *lack, vector basis, field small, __local double *scratch)
{
    const double2 first = size_after(g, film, 0, 0.0, scratch);
    FOR_EACH(row, g->rows) film->means_before[row] = film->means[row];
    Said s = {.mean = first.x, .largest = first.y, .status = STALLED};
    double least = INFINITY, length = 0.0;
    int patience = PATIENCE;
    for (; s.newton_steps <= most_newton; s.newton_steps++) {
        residual(g, film, basis, scratch);
        s.residual = norm(basis, g->length4, g->nt, scratch);
        if (!isfinite(s.residual)) {
            s.status = NOT_FINITE;
            break;
        }
        /* The force answers to an error w with at most its mean, so this bounds its error. */
        const double goal = fmax(tolerance * fabs(s.mean), ROUNDING * s.largest);
        if (s.residual <= goal || s.residual == 0.0) {
            s.status = CONVERGED;
            break;
        }
        if (STEPS_LACK(film->row) && length > 0.0)
            *lack = fmax(s.residual / length, 0.5 * *lack);
        patience = s.residual < 0.9 * least ? PATIENCE : patience - 1;
        least = fmin(least, s.residual);
        if (s.newton_steps == most_newton || patience == 0)
            break;
        const int remaining = most_iterations - s.newton_steps - s.krylov_iterations;
        const int room = min(most_krylov, remaining);
        if (room <= 0) {
            s.status = OVER_LIMIT;
            break;
        }
        /* Inner accuracy after Eisenstat and Walker: no finer than Newton's own error. */
        const double bend = s.residual * s.residual;
        const double last = bend < 0.1 * goal ? 0.7 : 0.3;
        const double floor = fmax(LINEAR_ROUNDING / 10, 0.3 * *lack);
        const double target = fmax(fmax(last * goal, floor * s.residual),
                                   fmin(0.1 * s.residual, 3.0 * bend));
        double left;
        const int steps =
            gmres(g, film, basis, small, s.residual, target, room, g->nt, &left, scratch);
        matrix factors = small + (room + 1) * room;
        s.krylov_iterations += steps;
        field4 step = (field4)film->work_b;
#ifdef SINGLE
        vector nodal = film->nodal;
        combine(nodal, g->count, factors, steps, g->count4);
#else
        vector nodal = (vector)film->work_a;
        from_modal(g, basis, (vector)film->work_c, nodal);
#endif
        /* No more than 9/10 of the pressure anywhere. */
        const double2 change = step_of(g, film, nodal, step, scratch);
        const double share = change.x > 0.9 ? 0.9 / change.x : 1.0;
        film->own_in = basis + g->count;
        TERMS_STEP(g, film, film->work_b, share)
        const double2 size = size_after(g, film, (matrix4)step, share, scratch);
        s.mean = size.x;
        s.largest = size.y;
        /* A short step needs no residual behind it to be known as the last one. The basis is
         * orthonormal: the step is as long as its factors are. */
        double square = 0.0;
        for (int k = 0; k < steps; k++)
            square += factors[k] * factors[k];
        length = sqrt(square);
        const double bent = NONLINEARITY(g) * fmax(change.x, change.y);
        left += LINEAR_ROUNDING * s.residual + (bent + MOST_LACK_CHANGE * *lack) * length;
        if (share == 1.0 && left <= tolerance * fabs(s.mean)) {
            s.residual = left;
            s.newton_steps++;
            s.status = CONVERGED;
            break;
        }
    }
    return s;
}

/* Work-groups take scenes from a queue until none is left; each has a workspace of its own, and a
 * scene's result does not depend on which group takes it. A scene goes from grid to grid: each
 * state is the first guess of the next, if it was found.
 *
 * begins:  per scene its first row in rows and results; a row is the scene on a grid.
 * rows:    sizes, numbers and where the scene's parts lie; carry_t is negative on its first grid, and
 *          state on those whose state stays in the workspace.
 * values:  those parts: matrices, profiles, operators.
 * results: per row what is said of it; then, where the row says, the mean of p over the period
 *          (nx, ny) and the state, a first guess on entry if there is one: p (nx, ny, nt) and the
 *          terms' own unknowns. One array, for each that the host
 *          waits for costs it as much as a small solve.
 *
 * The hint says that the kernel computes with vectors by itself: Intel's compiler would otherwise
 * look for minutes how to put several work-items into one. */
__kernel __attribute__((vec_type_hint(double4))) void
periodic_state(const int scenes, const int most_newton, __global const int *begins,
               __global const Row *rows, matrix values, field results, __global int *queue,
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
        double lack = STEPS_LACK(rows + begins[scene]) ? FIRST_LACK : 0.0;
        field coarser = 0;
        for (int k = begins[scene]; k < begins[scene + 1]; k++) {
            __global const Row *row = rows + k;
            const int most_krylov = row->most_krylov;
            field states = workspace + get_group_id(0) * workspace_size;
            field space = states + 2 * row->largest_state;
            vector room = (vector)space;
            Grid g = make_grid(row, values, &room);
            space = (field)room;
            Film film;
            film.row = row;
            film.values = values;
            film.work_a = space;
            film.work_b = space + g.count;
            film.work_c = space + 2 * g.count;
            space += 3 * g.count;
            film.own_work = space;
            space += OWN_FIELDS * g.spacing;
            for (int term = 0; term < FLOW_TERMS; term++) {
                film.gap_power[term] = (field4)space;
                film.potential[term] = (field4)(space + g.count);
                space += 2 * g.count;
            }
            vector basis = (vector)space;
            for (int term = 0; term < FLOW_TERMS; term++) {
                film.power[term] = basis;
                film.bend[term] = basis + g.count;
                film.response[term] = basis + 2 * g.count;
                basis += 3 * g.count;
            }
            film.diffusion = basis;
            basis += g.count;
            for (int which = 0; which < PRECONDITIONERS; which++) {
                film.own_share[which] = basis;
                film.other_share[which] = basis + g.count;
                basis += 2 * g.count;
            }
#if ROW_PARTS
            film.in_time = basis;
            film.over_rest_squared = basis + g.count;
            film.decay = basis + 2 * g.count;
            film.speed = basis + 3 * g.count;
            film.second = basis + 4 * g.count;
            basis += 5 * g.count;
#else
            film.in_time = (vector)film.work_b;
#endif
            film.basis = basis;
            film.nodal = basis + (most_krylov + 1) * g.length;
#ifdef SINGLE
            field small = (field)(film.nodal + most_krylov * g.count);
#else
            field small = (field)film.nodal;
#endif
            film.diffusivity = 0.0;
            film.epsilon = row->epsilon;
            film.sigma = row->sigma;
            film.amplitude = ARRAY(&film, amplitude);
            film.slope_x = ARRAY(&film, slope_x);
            film.slope_y = ARRAY(&film, slope_y);
            film.laplacian = ARRAY(&film, laplacian);
            field state = row->state >= 0 ? results + row->state
                                          : states + (k - begins[scene]) % 2 * row->largest_state;
            film.p = (field4)state;
            film.own = state + g.count;
            film.means = results + row->means;
            film.means_before = small + (most_krylov + 4) * (most_krylov + 1);
            if (row->carry_t >= 0 && status == CONVERGED) {
                carry(&g, &film, row - 1, coarser);
            } else if (!row->guessed) {
                FOR_EACH(i, g.length4) film.p[i] = (double4)(0.0);
                SYNC;
            }
            coarser = state;
            set_gap(&g, &film);
            Said said = solve(&g, &film, row->tolerance, most_newton, most_krylov,
                              row->most_iterations, &lack, basis, small, scratch);
            status = said.status;
            const double2 change = change_of_means(&g, &film);
            said.moment = change.x;
            said.size = change.y;
            said.lowest = NAN;
            if (k + 1 == begins[scene + 1]) {
                double4 deficit = (double4)(-INFINITY);
                FOR_EACH(i, g.count4) deficit = larger(deficit, -(1.0 + film.p[i]));
                said.lowest = -max_over_group(max_of(deficit), scratch);
            }
            if (get_local_id(0) == 0)
                ((__global Said *)results)[k] = said;
            SYNC;
        }
    }
}
