/* The film in time from a given state, by Runge–Kutta steps, one scene per work-group at a time.
 *
 * Unknown: the mass excess y = HP − 1 at the inner nodes. In the mass the equation is a rate,
 *
 *     dy/dT = f(T, y) = [div(H³ P grad P) − Λ d(HP)/dX] / σ,
 *
 * with no dH/dT in it: a surface that starts with a jump of velocity gives no jump of the rate,
 * every stage knows the rim exactly by p = (y − (H − 1)) / H = 0 there, and in w = δy the operator
 * varies like H²P only. Counting from 1 keeps the digits of small films.
 * As in periodic.cl, with v = H^(3/2) p (1 + p/2): div(H³ P grad P) = H^(3/2) (Δv − q v).
 *
 * The scheme is a lower triangular Butcher table (host). Stages with a zero on the diagonal are
 * evaluated; the others (IMPLICIT) are solved by Newton's method, with GMRES inside that is
 * preconditioned by the inverse of 1 − c D Δ / σ, D = mean of H²P, diagonal in the modal basis.
 * A field is stored [x][y], so that both derivatives are products with contiguous rows.
 */

typedef struct {
    int nx, ny, ny4, count, count4;
    matrix laplace_x, laplace_y, area;
#ifdef BEARING
    matrix derivative_x;
#endif
#ifdef IMPLICIT
    matrix modes_x, to_modes_x, modes_y, to_modes_y, eigenvalues;
#endif
} Grid;

typedef struct {
    double epsilon, sigma, bearing, excursion, diffusivity;
    matrix4 amplitude, gradient_squared, laplacian, slope_x;
    field4 overpressure, inverse_gap, power, potential, response;
    field work_a, work_b;
} Film;

/* Matrices that act along y are stored transposed, to be multiplied from the right. */
static Grid make_grid(int nx, int ny, matrix m)
{
    Grid g;
    g.nx = nx; g.ny = ny; g.ny4 = ny / 4;
    g.count = nx * ny; g.count4 = g.count / 4;
    g.laplace_x = m; m += nx * nx;
    g.laplace_y = m; m += ny * ny;
    g.area = m; m += g.count;
#ifdef BEARING
    g.derivative_x = m; m += nx * nx;
#endif
#ifdef IMPLICIT
    g.modes_x = m; m += nx * nx;
    g.to_modes_x = m; m += nx * nx;
    g.modes_y = m; m += ny * ny;
    g.to_modes_y = m; m += ny * ny;
    g.eigenvalues = m;
#endif
    return g;
}

static void along_x(const Grid *g, matrix a, field in, field out, int add)
{
    multiply(a, g->nx, g->nx, (matrix4)in, (field4)out, 0, g->ny4, 1, add);
}

static void along_y(const Grid *g, matrix transposed, field in, field out, int add)
{
    multiply(in, g->nx, g->ny, (matrix4)transposed, (field4)out, 0, g->ny4, 1, add);
}

static double sum4(double4 a) { return a.x + a.y + a.z + a.w; }

/* The gap H = 1 + excursion · s, and what depends on it alone. Each work-item reads only what it has
 * written itself, so that no barrier is needed, which a caller could not make conditional. */
static void set_gap(const Grid *g, Film *film, double excursion)
{
    film->excursion = excursion;
    FOR_EACH(i, g->count4)
    {
        const double4 gap = 1.0 + excursion * film->amplitude[i], inverse = 1.0 / gap;
        film->inverse_gap[i] = inverse;
        film->power[i] = gap * sqrt(gap);
        film->potential[i] =
            1.5 * excursion * inverse *
            (film->laplacian[i] + 0.5 * excursion * inverse * film->gradient_squared[i]);
    }
}

/* out = f(T, y) for the gap as set, and the overpressure. IMPLICIT: sets the Jacobian too. */
static void rate(const Grid *g, Film *film, field y, field out, __local double *scratch)
{
    matrix4 mass = (matrix4)y;
    field4 v = (field4)film->work_a, r = (field4)out;
    double4 diffusivity = 0.0;
    FOR_EACH(i, g->count4)
    {
        const double4 p =
            (mass[i] - film->excursion * film->amplitude[i]) * film->inverse_gap[i];
        v[i] = film->power[i] * p * (1.0 + 0.5 * p);
        film->overpressure[i] = p;
#ifdef IMPLICIT
        film->response[i] = film->power[i] * film->inverse_gap[i] * (1.0 + p);
        diffusivity += film->response[i] * film->power[i];
#endif
    }
    SYNC;
    along_x(g, g->laplace_x, film->work_a, out, 0);
    along_y(g, g->laplace_y, film->work_a, out, 1);
    const double inverse_sigma = 1.0 / film->sigma;
    FOR_EACH(i, g->count4)
        r[i] = inverse_sigma * film->power[i] * (r[i] - film->potential[i] * v[i]);
    SYNC;
#ifdef BEARING
    field4 moved = (field4)film->work_b;
    FOR_EACH(i, g->count4) moved[i] = mass[i] - film->excursion * film->amplitude[i];
    SYNC;
    along_x(g, g->derivative_x, film->work_b, film->work_a, 0);
    const double speed = film->bearing * inverse_sigma;
    FOR_EACH(i, g->count4) r[i] -= speed * (v[i] + film->excursion * film->slope_x[i]);
    SYNC;
#endif
#ifdef IMPLICIT
    film->diffusivity = sum_over_group(sum4(diffusivity), scratch) / g->count;
#endif
}

#ifdef IMPLICIT
/* Solve (1 − c D Δ / σ) w = r in place. */
static void precondition(const Grid *g, const Film *film, double c, field r)
{
    along_x(g, g->to_modes_x, r, film->work_a, 0);
    along_y(g, g->to_modes_y, film->work_a, r, 0);
    const double scale = c * film->diffusivity / film->sigma;
    FOR_EACH(i, g->count) r[i] /= 1.0 - scale * g->eigenvalues[i];
    SYNC;
    along_x(g, g->modes_x, r, film->work_a, 0);
    along_y(g, g->modes_y, film->work_a, r, 0);
}

/* out = preconditioned (1 − c df/dy) w. */
static void apply_jacobian(const Grid *g, const Film *film, double c, field w, field out)
{
    field4 v = (field4)film->work_a, r = (field4)out;
    matrix4 from = (matrix4)w;
    FOR_EACH(i, g->count4) v[i] = film->response[i] * from[i];
    SYNC;
    along_x(g, g->laplace_x, film->work_a, out, 0);
    along_y(g, g->laplace_y, film->work_a, out, 1);
    const double scale = c / film->sigma;
    FOR_EACH(i, g->count4)
        r[i] = from[i] - scale * film->power[i] * (r[i] - film->potential[i] * v[i]);
    SYNC;
#ifdef BEARING
    along_x(g, g->derivative_x, w, film->work_a, 0);
    FOR_EACH(i, g->count4) r[i] += scale * film->bearing * v[i];
    SYNC;
#endif
    precondition(g, film, c, out);
}

static double norm(const Grid *g, field a, __local double *scratch)
{
    return sqrt(dot_product((matrix4)a, (matrix4)a, g->count4, scratch) / g->count);
}

/* GMRES for (Jacobian) w = residual, both preconditioned: basis[0] holds the residual of norm
 * `beta` on entry and w on exit. Stops at the norm `target` or after KRYLOV steps. */
static int gmres(const Grid *g, const Film *film, double c, field basis, field small, double beta,
                 double target, __local double *scratch)
{
    const int lead = KRYLOV + 1;
    field hessenberg = small, right = hessenberg + lead * KRYLOV, cosines = right + lead,
          sines = cosines + KRYLOV;
    FOR_EACH(i, g->count) basis[i] *= 1.0 / beta;
    if (get_local_id(0) == 0)
        right[0] = beta;
    SYNC;
    double left = beta;
    int steps = 0;
    while (steps < KRYLOV && left > target) {
        field next = basis + (steps + 1) * g->count, column = hessenberg + steps * lead;
        apply_jacobian(g, film, c, basis + steps * g->count, next);
        field4 new = (field4)next;
        for (int j = 0; j <= steps; j++) {
            matrix4 old = (matrix4)(basis + j * g->count);
            const double overlap = dot_product(old, new, g->count4, scratch) / g->count;
            FOR_EACH(i, g->count4) new[i] -= overlap * old[i];
            if (get_local_id(0) == 0)
                column[j] = overlap;
            SYNC;
        }
        const double length = norm(g, next, scratch);
        FOR_EACH(i, g->count4) new[i] *= length > 0.0 ? 1.0 / length : 0.0;
        if (get_local_id(0) == 0) {
            for (int j = 0; j < steps; j++) {
                const double upper = column[j], lower = column[j + 1];
                column[j] = cosines[j] * upper + sines[j] * lower;
                column[j + 1] = cosines[j] * lower - sines[j] * upper;
            }
            const double diagonal = hypot(column[steps], length);
            cosines[steps] = column[steps] / diagonal;
            sines[steps] = length / diagonal;
            column[steps] = diagonal;
            right[steps + 1] = -sines[steps] * right[steps];
            right[steps] *= cosines[steps];
        }
        SYNC;
        left = fabs(right[steps + 1]);
        steps++;
        if (!(length > 0.0) || !isfinite(left))
            break;
    }
    if (get_local_id(0) == 0)
        for (int j = steps - 1; j >= 0; j--) {
            for (int k = j + 1; k < steps; k++)
                right[j] -= hessenberg[k * lead + j] * right[k];
            right[j] /= hessenberg[j * lead + j];
        }
    SYNC;
    FOR_EACH(i, g->count)
    {
        double sum = 0.0;
        for (int j = 0; j < steps; j++)
            sum += right[j] * basis[j * g->count + i];
        basis[i] = sum;
    }
    SYNC;
    return steps;
}

/* Solve y − c f(T, y) = z from the guess in y; `rates` becomes f. Returns whether the error left in
 * y is at most `tolerance` by its estimate, the preconditioned residual. An explicit stage, c = 0,
 * comes with y = z and is done at once. */
static bool solve_stage(const Grid *g, Film *film, double c, field y, matrix z, field rates,
                        double tolerance, field basis, field small, int *newton, int *krylov,
                        __local double *scratch)
{
    double beta = 0.0;
    for (int step = 0;; step++) {
        rate(g, film, y, rates, scratch);
        FOR_EACH(i, g->count) basis[i] = y[i] - z[i] - c * rates[i];
        SYNC;
        precondition(g, film, c, basis);
        beta = norm(g, basis, scratch);
        if (beta <= tolerance || !isfinite(beta) || step == NEWTON)
            break;
        const double target = fmax(0.3 * tolerance, fmin(0.1 * beta, beta * beta));
        *krylov += gmres(g, film, c, basis, small, beta, target, scratch);
        *newton += 1;
        FOR_EACH(i, g->count) y[i] -= basis[i];
        SYNC;
    }
    return beta <= tolerance;
}
#endif

/* Surface excursion at T = 2π (period + phase): ε sin T, raised over the first `ramp` periods. */
static double excursion_at(double epsilon, int period, double phase, double ramp)
{
    const double share = period + phase < ramp ? sin(M_PI_2 * (period + phase) / ramp) : 1.0;
    return epsilon * share * share * sin(2.0 * M_PI * phase);
}

enum { MARCHED = 0, STALLED = 1, NOT_PHYSICAL = 2 };

/* table:   Butcher's a (stages, stages), b, c.
 * numbers: per scene epsilon, sigma, bearing, steps per period, tolerance of a stage.
 * profile: per scene amplitude, |grad|², Laplacian and (BEARING) x-slope, each (nx, ny).
 * state:   per scene y (nx, ny) at T = 2π first_period on entry, `periods` later on exit. There
 *          the gap is at rest and y = P − 1.
 * mean_overpressure: per scene (nx, ny), over the last period.
 * results: per scene and period mean, smallest and largest mean overpressure of the film.
 * counts:  per scene status, Newton steps, Krylov iterations. */
__kernel void march_films(const int scenes, const int nx, const int ny, const int periods,
                          const int first_period, const double ramp, const int stages,
                          matrix table, matrix matrices, matrix numbers, matrix profile,
                          field state, field mean_overpressure, field results,
                          __global int *counts, field workspace, const ulong workspace_size,
                          __global int *queue, __local double *scratch)
{
    const Grid g = make_grid(nx, ny, matrices);
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
        matrix number = numbers + scene * 5;
        film.epsilon = number[0];
        film.sigma = number[1];
        film.bearing = number[2];
        const int steps = (int)number[3];
        const double h = 2.0 * M_PI / steps;
        matrix4 s = (matrix4)(profile + (ulong)scene * PROFILE_FIELDS * g.count);
        film.amplitude = s;
        film.gradient_squared = s + g.count4;
        film.laplacian = s + 2 * g.count4;
        film.slope_x = s + (PROFILE_FIELDS - 1) * g.count4;
        field y = state + (ulong)scene * g.count;
        field4 mean = (field4)(mean_overpressure + (ulong)scene * g.count);
        field result = results + (ulong)scene * periods * 3;

        int status = MARCHED, newton = 0, krylov = 0, period = 0;
        for (; period < periods && status == MARCHED; period++) {
            double lowest = INFINITY, highest = -INFINITY, phase = -1.0;
            FOR_EACH(k, g.count4) mean[k] = 0.0;
            SYNC;
            for (int step = 0; step < steps; step++) {
                for (int i = 0; i < stages; i++) {
                    if (phase != (step + nodes[i]) / steps) {
                        phase = (step + nodes[i]) / steps;
                        set_gap(&g, &film,
                                excursion_at(film.epsilon, first_period + period, phase, ramp));
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
                    if (!solve_stage(&g, &film, c, stage, known, own, number[4], basis, small,
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
                        dot_product((matrix4)g.area, film.overpressure, g.count4, scratch);
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
            const double force = dot_product((matrix4)g.area, mean, g.count4, scratch);
            if (get_local_id(0) == 0) {
                result[3 * period] = status == MARCHED ? force : NAN;
                result[3 * period + 1] = lowest;
                result[3 * period + 2] = highest;
            }
            SYNC;
        }
        if (get_local_id(0) == 0) {
            for (int k = 3 * period; k < 3 * periods; k++)
                result[k] = NAN;
            counts[3 * scene] = status;
            counts[3 * scene + 1] = newton;
            counts[3 * scene + 2] = krylov;
        }
        SYNC;
    }
}
