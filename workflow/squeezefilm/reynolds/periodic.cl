/* The periodic state of the Reynolds equation by Newton–GMRES, one scene per work-group at a time.
 *
 * Unknown: the overpressure p = P − 1, zero on the rim. With v = H^(3/2) p (1 + p/2) the equation
 *
 *     div(H³ P grad P) = σ d(HP)/dT + Λ d(HP)/dX
 *
 * needs second derivatives only (Liouville's transformation):
 *
 *     H^(3/2) (Δv − q v) − σ d(Hp)/dT − Λ d(Hp)/dX = σ dH/dT + Λ dH/dX,   q = Δ(H^(3/2)) / H^(3/2).
 *
 * Newton's correction is sought as a mass perturbation w = H δp: v then changes by H^(1/2) P w and
 * the stiff time term keeps a constant coefficient. GMRES is preconditioned from the left by the
 * inverse of mean(H²P) Δ − σ d/dT, diagonal in the eigenvectors of the second derivatives times
 * the real Fourier basis; its vectors are stored in that basis ("modal"), where the time term is
 * diagonal too, so that its residual norm estimates the error in w itself.
 */

/* Sizes and the matrices that all scenes of a batch share. */
typedef struct {
    int nx, ny, nt, rows, count, nt4, row4, count4;
    matrix laplace_x, laplace_y, modes_x, modes_y, to_modes_x, to_modes_y;
    matrix eigenvalues_x, eigenvalues_y, weights_x, weights_y;
    matrix fourier, fourier_transposed, time_derivative, sine, cosine;
#ifdef BEARING
    matrix derivative_x;
#endif
} Grid;

/* One scene: its numbers and profile, and the fields of the state that is being improved. */
typedef struct {
    double epsilon, sigma, bearing, diffusivity;
    matrix amplitude, gradient_squared, laplacian, slope_x;
    field p, gap_power, potential, half_power_pressure, work_a, work_b, work_c;
} Film;

static Grid make_grid(int nx, int ny, int nt, matrix m)
{
    Grid g;
    g.nx = nx; g.ny = ny; g.nt = nt;
    g.rows = nx * ny; g.count = nx * ny * nt;
    g.nt4 = nt / 4; g.row4 = ny * nt / 4; g.count4 = g.count / 4;
    g.laplace_x = m; m += nx * nx;
    g.modes_x = m; m += nx * nx;
    g.to_modes_x = m; m += nx * nx;
    g.laplace_y = m; m += ny * ny;
    g.modes_y = m; m += ny * ny;
    g.to_modes_y = m; m += ny * ny;
    g.fourier = m; m += nt * nt;
    g.fourier_transposed = m; m += nt * nt;
    g.time_derivative = m; m += nt * nt;
    g.eigenvalues_x = m; m += nx;
    g.eigenvalues_y = m; m += ny;
    g.weights_x = m; m += nx;
    g.weights_y = m; m += ny;
    g.sine = m; m += nt;
    g.cosine = m; m += nt;
#ifdef BEARING
    g.derivative_x = m;
#endif
    return g;
}

static void along_x(const Grid *g, matrix a, field in, field out, int add)
{
    multiply(a, 0, g->nx, g->nx, (matrix4)in, 0, (field4)out, 0, g->row4, 1, add);
}

static void along_y(const Grid *g, matrix a, field in, field out, int add)
{
    multiply(a, 0, g->ny, g->ny, (matrix4)in, g->row4, (field4)out, g->row4, g->nt4, g->nx, add);
}

/* out[row][:] = in[row][:] times `transposed` (nt, nt). */
static void along_t(const Grid *g, matrix transposed, field in, field out, int add)
{
    multiply(in, 0, g->rows, g->nt, (matrix4)transposed, 0, (field4)out, 0, g->nt4, 1, add);
}

static void laplacian(const Grid *g, field in, field out)
{
    along_x(g, g->laplace_x, in, out, 0);
    along_y(g, g->laplace_y, in, out, 1);
}

/* modal = (to_modes_x ⊗ to_modes_y ⊗ fourier) values; `values` is overwritten. */
static void to_modal(const Grid *g, field values, field modal)
{
    along_t(g, g->fourier_transposed, values, modal, 0);
    along_x(g, g->to_modes_x, modal, values, 0);
    along_y(g, g->to_modes_y, values, modal, 0);
}

/* values = (modes_x ⊗ modes_y ⊗ fourier') modal, by way of `work`. */
static void from_modal(const Grid *g, field modal, field work, field values)
{
    along_x(g, g->modes_x, modal, values, 0);
    along_y(g, g->modes_y, values, work, 0);
    along_t(g, g->fourier, work, values, 0);
}

/* H and what depends on it alone: H^(3/2) and the potential q. */
static void set_gap(const Grid *g, Film *film)
{
    FOR_EACH_POINT(g, row, t, i)
    {
        const double excursion = film->epsilon * g->sine[t];
        const double gap = 1.0 + excursion * film->amplitude[row];
        film->gap_power[i] = gap * sqrt(gap);
        film->potential[i] = excursion * (1.5 * film->laplacian[row] +
                                          0.75 * excursion * film->gradient_squared[row] / gap) / gap;
    }
    SYNC;
}

static double gap_at(const Grid *g, const Film *film, int row, int t)
{
    return 1.0 + film->epsilon * g->sine[t] * film->amplitude[row];
}

/* Residual of the equation at the state p, in modal coefficients. Also sets H^(1/2) P and the
 * mean of H² P for the Jacobian at this state. */
static void residual(const Grid *g, Film *film, field modal, __local double *scratch)
{
    field v = film->work_a, r = film->work_b, mass = film->work_c;
    double diffusivity = 0.0;
    FOR_EACH_POINT(g, row, t, i)
    {
        const double gap = gap_at(g, film, row, t), p = film->p[i];
        v[i] = film->gap_power[i] * p * (1.0 + 0.5 * p);
        mass[i] = gap * p;
        film->half_power_pressure[i] = sqrt(gap) * (1.0 + p);
        diffusivity += gap * gap * (1.0 + p);
    }
    film->diffusivity = sum_over_group(diffusivity, scratch) / g->count;
    SYNC;
    laplacian(g, v, r);
    FOR_EACH_POINT(g, row, t, i)
    {
        r[i] = film->gap_power[i] * (r[i] - film->potential[i] * v[i]) -
               film->sigma * film->epsilon * film->amplitude[row] * g->cosine[t];
#ifdef BEARING
        r[i] -= film->bearing * film->epsilon * film->slope_x[row] * g->sine[t];
#endif
    }
    SYNC;
    along_t(g, g->time_derivative, mass, v, 0);
    FOR_EACH(i, g->count) r[i] -= film->sigma * v[i];
    SYNC;
#ifdef BEARING
    along_x(g, g->derivative_x, mass, v, 0);
    FOR_EACH(i, g->count) r[i] -= film->bearing * v[i];
    SYNC;
#endif
    to_modal(g, r, modal);
}

/* Solve (mean(H²P) Δ − σ d/dT) w = modal, in place; with `rate`, first add the time term
 * −σ d(rate)/dT, which is diagonal here. Harmonic k couples cosine c and sine s:
 * d/dT (c cos kT + s sin kT) = k s cos kT − k c sin kT. */
static void precondition(const Grid *g, const Film *film, matrix rate, field modal, int add_rate)
{
    FOR_EACH(row, g->rows)
    {
        const double diffusion =
            film->diffusivity * (g->eigenvalues_x[row / g->ny] + g->eigenvalues_y[row % g->ny]);
        const double inverse = 1.0 / diffusion;
        field m = modal + row * g->nt;
        matrix w = rate + row * g->nt;
        m[0] *= inverse;
        m[g->nt - 1] *= inverse;
        for (int harmonic = 1; harmonic < g->nt / 2; harmonic++) {
            const int c = 2 * harmonic - 1, s = 2 * harmonic;
            const double speed = film->sigma * harmonic;
            const double scale = 1.0 / (diffusion * diffusion + speed * speed);
            double mc = m[c], ms = m[s];
            if (add_rate) {
                mc -= speed * w[s];
                ms += speed * w[c];
            }
            m[c] = scale * (diffusion * mc + speed * ms);
            m[s] = scale * (diffusion * ms - speed * mc);
        }
    }
    SYNC;
}

/* out = preconditioned Jacobian times w, both modal. */
static void apply_jacobian(const Grid *g, const Film *film, field w, field out)
{
    field v = film->work_a, r = film->work_b;
    from_modal(g, w, r, v);
#ifdef BEARING
    along_x(g, g->derivative_x, v, film->work_c, 0);
#endif
    FOR_EACH(i, g->count) v[i] *= film->half_power_pressure[i];
    SYNC;
    laplacian(g, v, r);
    FOR_EACH(i, g->count)
    {
        r[i] = film->gap_power[i] * (r[i] - film->potential[i] * v[i]);
#ifdef BEARING
        r[i] -= film->bearing * film->work_c[i];
#endif
    }
    SYNC;
    to_modal(g, r, out);
    precondition(g, film, w, out, 1);
}

static double norm(const Grid *g, field a, __local double *scratch)
{
    return sqrt(dot_product((matrix4)a, (matrix4)a, g->count4, scratch) / g->nt);
}

/* GMRES with modified Gram–Schmidt and Givens rotations for (Jacobian) w = −residual, all
 * preconditioned. On entry basis[0] holds the preconditioned residual of norm `beta`; on exit it
 * holds w. Stops at the norm `target` or after `most` steps; an unfinished correction is still a
 * good Newton step. Returns the number of steps. */
static int gmres(const Grid *g, const Film *film, field basis, field small, double beta,
                 double target, int most, __local double *scratch)
{
    const int lead = most + 1;
    field hessenberg = small, right = hessenberg + lead * most, cosines = right + lead,
          sines = cosines + most;
    const double scale = -1.0 / beta;
    FOR_EACH(i, g->count) basis[i] *= scale;
    SYNC;
    double left = beta;
    int steps = 0;
    if (get_local_id(0) == 0)
        right[0] = beta;
    while (steps < most && left > target) {
        field next = basis + (steps + 1) * g->count;
        apply_jacobian(g, film, basis + steps * g->count, next);
        field column = hessenberg + steps * lead;
        for (int j = 0; j <= steps; j++) {
            field4 old = (field4)(basis + j * g->count), new = (field4)next;
            const double overlap = dot_product(old, new, g->count4, scratch) / g->nt;
            FOR_EACH(i, g->count4) new[i] -= overlap * old[i];
            if (get_local_id(0) == 0)
                column[j] = overlap;
            SYNC;
        }
        const double length = norm(g, next, scratch);
        if (length > 0.0) {
            const double inverse = 1.0 / length;
            FOR_EACH(i, g->count) next[i] *= inverse;
        }
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

/* Mean overpressure over film and period, in units of ambient pressure. */
static double mean_overpressure(const Grid *g, const Film *film, __local double *scratch)
{
    double sum = 0.0;
    FOR_EACH(row, g->rows)
    {
        double over_period = 0.0;
        for (int t = 0; t < g->nt; t++)
            over_period += film->p[row * g->nt + t];
        sum += g->weights_x[row / g->ny] * g->weights_y[row % g->ny] * over_period;
    }
    return sum_over_group(sum, scratch) / g->nt;
}

/* Largest share of the step δp = w/H that takes at most 9/10 of the pressure anywhere. */
static double safe_share(const Grid *g, const Film *film, field w, __local double *scratch)
{
    double steepest = 0.0;
    FOR_EACH_POINT(g, row, t, i)
        steepest = fmax(steepest, -w[i] / (gap_at(g, film, row, t) * (1.0 + film->p[i])));
    steepest = max_over_group(steepest, scratch);
    return steepest > 0.9 ? 0.9 / steepest : 1.0;
}

enum { CONVERGED = 0, STALLED = 1, NOT_FINITE = 2 };

/* Work-groups take scenes from a queue until none is left; each has a workspace of its own, and a
 * scene's result does not depend on which group takes it.
 *
 * numbers: per scene epsilon, sigma, bearing, tolerance (of the force, relative).
 * profile: per scene amplitude, |grad|², Laplacian and (BEARING) x-slope, each (nx, ny).
 * state:   per scene p (nx, ny, nt); the first guess on entry.
 * results: per scene mean overpressure, norm of the last residual, largest |p|, smallest P.
 * counts:  per scene status, Newton steps, Krylov iterations. */
__kernel void periodic_state(const int scenes, const int nx, const int ny, const int nt,
                             const int most_newton, const int most_krylov,
                             matrix matrices, matrix numbers, matrix profile, field state,
                             field results, __global int *counts, field workspace,
                             const ulong workspace_size, __global int *queue,
                             __local double *scratch)
{
    const Grid g = make_grid(nx, ny, nt, matrices);
    __local int taken;
    field space = workspace + get_group_id(0) * workspace_size;
    Film film;
    film.gap_power = space;
    film.potential = space + g.count;
    film.half_power_pressure = space + 2 * g.count;
    film.work_a = space + 3 * g.count;
    film.work_b = space + 4 * g.count;
    film.work_c = space + 5 * g.count;
    field basis = space + 6 * g.count;
    field small = basis + (most_krylov + 1) * g.count;

    while (true) {
        if (get_local_id(0) == 0)
            taken = atomic_inc(queue);
        SYNC;
        const int scene = taken;
        SYNC;
        if (scene >= scenes)
            break;
        film.epsilon = numbers[4 * scene];
        film.sigma = numbers[4 * scene + 1];
        film.bearing = numbers[4 * scene + 2];
        const double tolerance = numbers[4 * scene + 3];
        matrix s = profile + (ulong)scene * PROFILE_FIELDS * g.rows;
        film.amplitude = s;
        film.gradient_squared = s + g.rows;
        film.laplacian = s + 2 * g.rows;
        film.slope_x = s + (PROFILE_FIELDS - 1) * g.rows;
        film.p = state + (ulong)scene * g.count;
        set_gap(&g, &film);

        int status = STALLED, newton = 0, krylov = 0;
        double beta = 0.0, force = mean_overpressure(&g, &film, scratch);
        for (; newton <= most_newton; newton++) {
            residual(&g, &film, basis, scratch);
            precondition(&g, &film, basis, basis, 0);
            beta = norm(&g, basis, scratch);
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
            krylov += gmres(&g, &film, basis, small, beta, target, most_krylov, scratch);
            field w = film.work_b;
            from_modal(&g, basis, film.work_a, w);
            const double share = safe_share(&g, &film, w, scratch);
            FOR_EACH_POINT(&g, row, t, i) film.p[i] += share * w[i] / gap_at(&g, &film, row, t);
            SYNC;
            force = mean_overpressure(&g, &film, scratch);
        }
        double most = 0.0, deficit = -INFINITY;
        FOR_EACH(i, g.count)
        {
            most = fmax(most, fabs(film.p[i]));
            deficit = fmax(deficit, -1.0 - film.p[i]);
        }
        most = max_over_group(most, scratch);
        deficit = max_over_group(deficit, scratch);
        if (get_local_id(0) == 0) {
            results[4 * scene] = force;
            results[4 * scene + 1] = beta;
            results[4 * scene + 2] = most;
            results[4 * scene + 3] = -deficit;
            counts[3 * scene] = status;
            counts[3 * scene + 1] = newton;
            counts[3 * scene + 2] = krylov;
        }
        SYNC;
    }
}
